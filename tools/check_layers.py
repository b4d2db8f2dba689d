#!/usr/bin/env python3
"""Fails when an #include goes against the layer graph, or docs/architecture.md shows another graph."""

import pathlib
import re
import sys

# module -> modules it may include, besides itself. The graph is a DAG: only names defined above.
MODULES = {
    "math": [],
    "camera": ["math"],
    "robot": ["math"],
    "runtime": ["math"],
    "observability": ["math", "camera"],
    "features": ["math", "camera"],
    "control": ["math", "robot", "observability"],
    "active": ["math", "camera", "robot", "features", "observability"],
    "servo": ["math", "camera", "robot", "features", "observability", "control", "active"],
    "plan": ["math", "camera", "robot", "features", "observability", "active"],
    "vision": ["math", "camera", "features"],
    "messaging": ["math", "camera", "robot", "features", "observability", "control", "active", "servo",
                  "runtime"],
    "config": ["math", "camera", "robot", "features", "observability", "control", "active", "servo",
               "plan", "vision"],
    "replay": ["math", "camera", "robot", "features", "observability", "control", "active", "servo",
               "messaging", "config"],
    "report": ["math", "camera", "robot", "runtime", "observability", "features", "control", "active",
               "servo", "messaging", "config"],
}

# third-party prefix -> the only modules that may include it. Eigen and the standard are free.
THIRD_PARTY = {
    "visp3/": ["features", "vision"],
    "opencv2/": ["vision", "report"],
    "kdl/": ["robot"],
    "urdf": ["robot"],
    "console_bridge/": ["robot"],
    "tinyxml2": ["robot"],
    "assimp/": ["robot"],
    "yaml-cpp/": ["config"],
    "lcm/": ["messaging"],
    "vantage_msgs/": ["messaging"],
    "bot_core/": ["messaging"],
    "drake/": ["messaging"],
    "GL/": [],
    "EGL/": [],
}

ROW = re.compile(r"^\| `([a-z]+)` \|.*\| ([^|]*) \|$", re.MULTILINE)
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]', re.MULTILINE)


def differences(root: pathlib.Path):
    page = "docs/architecture.md"
    shown = {name: [m for m in uses.split(", ") if m != "Eigen"]
             for name, uses in ROW.findall((root / page).read_text()) if name != "sim"}
    for module in sorted(set(MODULES) | set(shown)):
        if module not in shown or module not in MODULES:
            yield f"{page}: {module} is {'not shown' if module in MODULES else 'no module'}"
        elif sorted(shown[module]) != sorted(MODULES[module]):
            yield f"{page}: {module} may use {', '.join(MODULES[module])}"


def violations(root: pathlib.Path):
    yield from differences(root)
    names = list(MODULES)
    for module, allowed in MODULES.items():
        for name in allowed:
            if names.index(name) >= names.index(module):
                yield f"tools/check_layers.py: {module} may not depend on {name}, defined after it"
        folders = [root / "include" / "vantage" / module, root / "src" / module]
        for file in (f for d in folders for f in sorted(d.rglob("*")) if f.suffix in {".h", ".cpp"}):
            for header in INCLUDE.findall(file.read_text()):
                parts = header.split("/")
                if parts[0] == "vantage" and parts[1] not in [module, *allowed]:
                    yield f"{file.relative_to(root)}: {module} may not include {header}"
                if parts[0] == "sim":
                    yield f"{file.relative_to(root)}: the simulator is not for {module}"
                for prefix, owners in THIRD_PARTY.items():
                    if header.startswith(prefix) and module not in owners:
                        yield f"{file.relative_to(root)}: {prefix} is for {owners or 'sim/'} only"
    for folder in (root / "include" / "vantage", root / "src"):
        for child in sorted(folder.iterdir()):
            if child.is_dir() and child.name not in MODULES and child.name != "apps":
                yield f"{child.relative_to(root)}: not a module of tools/check_layers.py"


if __name__ == "__main__":
    found = list(violations(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")))
    print("\n".join(found))
    sys.exit(1 if found else 0)

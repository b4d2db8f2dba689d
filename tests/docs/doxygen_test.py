#!/usr/bin/env python3
"""The public headers are documented: doxygen has nothing to warn of.

Two kinds of declarations may go without words of their own: accessors without arguments, and moves; and the
overloads that follow a documented one.
Exit code 77 where doxygen is not installed.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
WARNING = re.compile(r"^(?P<file>\S+?):(?P<line>\d+): warning: (?P<text>.*)$")
SILENT = (
    re.compile(r"\(\) (const|noexcept|const noexcept|const noexcept=0) \(function\) "),
    re.compile(r"Member (\w+)\(\1 &&|operator=\("),
)


def follows_overload(file, line, text):
    name = re.search(r"Member (\w+)\(", text)
    before = pathlib.Path(file).read_text().splitlines()[line - 2]
    return name and f" {name[1]}(" in before and before.rstrip().endswith(";")


def faults(output):
    for line in output.splitlines():
        warning = WARNING.match(line)
        if not warning:
            if "arning:" in line or "rror:" in line:
                yield line
            continue
        text = warning["text"]
        if text.endswith("is not documented."):
            if any(pattern.search(text) for pattern in SILENT):
                continue
            if follows_overload(warning["file"], int(warning["line"]), text):
                continue
        yield line.replace(f"{ROOT}/", "")


if shutil.which("doxygen") is None:
    print("doxygen is not installed: sudo apt-get install doxygen")
    sys.exit(77)
with tempfile.TemporaryDirectory() as folder:
    changes = f"\nOUTPUT_DIRECTORY = {folder}\nGENERATE_HTML = NO\nGENERATE_XML = YES\nXML_PROGRAMLISTING = NO\n"
    configuration = (ROOT / "docs/Doxyfile").read_text() + changes
    run = subprocess.run(["doxygen", "-"], input=configuration, cwd=ROOT, capture_output=True, text=True, check=False)
    pages = len(list(pathlib.Path(folder).rglob("*.xml")))
found = list(faults(run.stderr))
print("\n".join(found) or f"{pages} pages without a warning")
# A run that read nothing has nothing to warn of.
sys.exit(1 if found or run.returncode != 0 or pages < 100 else 0)

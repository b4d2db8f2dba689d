#!/usr/bin/env python3
"""Every link of a Markdown page leads to a file of the tree, and to a heading of it where it names one. Every page is
named by docs/index.md, and every picture is shown by some page."""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINK = re.compile(r"\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def anchors(page):
    headings = re.findall(r"^#+ (.*)$", FENCE.sub("", page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken(page):
    for link in LINK.findall(FENCE.sub("", page.read_text())):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if not target.exists():
            yield f"{page.relative_to(ROOT)}: {link}: no such file"
        elif anchor and anchor not in anchors(target):
            yield f"{page.relative_to(ROOT)}: {link}: no such heading"


pages = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
found = [line for page in pages for line in broken(page)]
named = set(re.findall(r"\(([\w-]+\.md)", (ROOT / "docs/index.md").read_text()))
found += [f"docs/index.md: does not name {page.name}"
          for page in sorted((ROOT / "docs").glob("*.md")) if page.name not in named | {"index.md"}]
shown = {name for page in pages for name in re.findall(r"pictures/([\w-]+\.png)\)", page.read_text())}
found += [f"docs/pictures/{picture.name}: no page shows it"
          for picture in sorted((ROOT / "docs/pictures").glob("*.png")) if picture.name not in shown]
print("\n".join(found) or f"{len(pages)} pages good")
sys.exit(1 if found else 0)

#!/usr/bin/env python3
"""Follows the links between our pages: each file and each heading that a link names exists, and docs/README.md names each
page of docs/. Sections of released versions in CHANGELOG.md are left out: they are not edited any more (version.py).
Exit 1 and a line for each fault.
"""

import pathlib
import re
import subprocess
import sys

LINK = re.compile(r"\]\(([^)\s]+)\)")


def without_code(markdown):
    markdown = re.sub(r"^```.*?^```", lambda m: "\n" * m[0].count("\n"), markdown, flags=re.S | re.M)
    return re.sub(r"`[^`\n]*`", "", markdown)


def anchors(markdown):
    """As a forge makes them of headings."""
    out, seen = set(), {}
    for heading in re.findall(r"^#+\s+(.*)$", re.sub(r"^```.*?^```", "", markdown, flags=re.S | re.M), re.M):
        text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower()
        name = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
        number = seen.get(name, 0)
        seen[name] = number + 1
        out.add(f"{name}-{number}" if number else name)
    return out | set(re.findall(r'<a (?:id|name)="([^"]+)"', markdown))


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    listed = subprocess.run(["git", "-C", root, "ls-files", "*.md"], capture_output=True, text=True, check=True).stdout
    pages = {root / name: (root / name).read_text(encoding="utf-8")
             for name in listed.split() if not name.startswith("tests/data/") and (root / name).is_file()}
    changelog = root / "CHANGELOG.md"
    pages[changelog] = re.split(r"^## \[\d", pages[changelog], maxsplit=1, flags=re.M)[0]
    faults = links = 0
    for page, markdown in pages.items():
        for number, line in enumerate(without_code(markdown).split("\n"), 1):
            for target in LINK.findall(line):
                if re.match(r"[a-z]+:", target):
                    continue
                links += 1
                name, _, anchor = target.partition("#")
                file = (page.parent / name).resolve() if name else page
                if not file.exists():
                    why = "there is no such file"
                elif anchor and anchor not in anchors(pages.get(file, "")):
                    why = "there is no such heading"
                else:
                    continue
                print(f"{page.relative_to(root)}:{number}: {target}: {why}")
                faults += 1
    index = root / "docs/README.md"
    for page in pages:
        if page.parent == index.parent and page != index and f"]({page.name})" not in pages.get(index, ""):
            print(f"docs/README.md: no link to {page.name}")
            faults += 1
    print(f"{faults} faults in {links} links" if faults else f"{links} links lead somewhere")
    return 1 if faults or not links else 0


if __name__ == "__main__":
    sys.exit(main())

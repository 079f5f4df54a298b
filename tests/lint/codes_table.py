#!/usr/bin/env python3
"""Holds the table of codes in plugins/README.md to base/codes.

Usage: codes_table.py ROOT [--write]     --write brings the table up to date instead of complaining.
"""

import pathlib
import re
import sys

TEXT = r'((?:"(?:\\.|[^"\\])*"\s*)+)'
ROW = re.compile(r"^X\(\s*(\w+),\s*(\d+),\s*(\w+),\s*" + TEXT + r",\s*" + TEXT + r"\)", re.M)
BEGIN, END = "<!-- codes: begin -->\n", "<!-- codes: end -->\n"
MOST = 1700  # from here on the codes are not the plugins'


def plain(literals):
    """The text of adjacent C string literals."""
    parts = re.findall(r'"((?:\\.|[^"\\])*)"', literals)
    return re.sub(r"\\(.)", r"\1", "".join(parts)).replace("|", r"\|")


def table(root):
    rows = []
    for file in sorted((root / "base" / "codes").glob("*.def")):
        text = file.read_text(encoding="utf-8")
        found = ROW.findall(text)
        if len(found) != text.count("\nX(") + text.startswith("X("):
            raise SystemExit(f"{file}: a line that is not X(name, number, severity, \"...\", \"...\")")
        rows += found
    rows = sorted((row for row in rows if int(row[1]) < MOST), key=lambda row: int(row[1]))
    lines = ["| code | name | severity | what happened | what to do |", "|---|---|---|---|---|"]
    lines += [f"| {number} | {name} | {severity} | {plain(summary)} | {plain(hint)} |"
              for name, number, severity, summary, hint in rows]
    return "\n".join(lines) + "\n"


def main():
    root = pathlib.Path(sys.argv[1])
    readme = root / "plugins" / "README.md"
    text = readme.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    wanted = before + BEGIN + table(root) + END + after
    if wanted == text:
        print("plugins/README.md shows every code")
        return 0
    if "--write" in sys.argv[2:]:
        readme.write_text(wanted, encoding="utf-8")
        return 0
    print("plugins/README.md: the table of codes is not what base/codes says; "
          "run tests/lint/codes_table.py . --write")
    return 1


if __name__ == "__main__":
    sys.exit(main())

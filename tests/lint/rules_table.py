#!/usr/bin/env python3
"""Holds governance/RULES.md to base/rules: every rule of lint, doctor and check, for people to read.

Usage: rules_table.py ROOT [--write]     --write brings the page up to date instead of complaining.
"""

import pathlib
import re
import sys

TEXT = r'((?:"(?:\\.|[^"\\])*"\s*)+)'
ROW = re.compile(r"^X\(\s*(\w+),\s*(\w+),\s*" + TEXT + r",\s*" + TEXT + r"\)", re.M)
HEAD = """# Rules

What `governance lint`, `permissions lint` and `doctor` say, by ids that never change; `ddssec explain ID`
says the same. Errors stop `sign` and end a command with 1; warnings and notes do not. This page is
made from base/rules by `tests/lint/rules_table.py . --write`.
"""
WORDS = {"informational": "note"}


def plain(literals):
    """The text of adjacent C string literals."""
    parts = re.findall(r'"((?:\\.|[^"\\])*)"', literals)
    text = re.sub(r"\\(.)", r"\1", "".join(parts))
    return text.replace("|", r"\|").replace("*", r"\*").replace("<", "&lt;")


def page(root):
    out = HEAD
    for file in sorted((root / "base" / "rules").glob("*.def")):
        text = file.read_text(encoding="utf-8")
        rows = ROW.findall(text)
        if len(rows) != text.count("\nX(") + text.startswith("X("):
            raise SystemExit(f"{file}: a line that is not X(id, severity, \"...\", \"...\")")
        if not rows:
            continue
        out += f"\n## {file.stem}\n\n| id | severity | what it is about | what to do |\n|---|---|---|---|\n"
        out += "".join(f"| {name} | {WORDS.get(severity, severity)} | {plain(title)} | {plain(hint)} |\n"
                       for name, severity, title, hint in sorted(rows))
    return out


def main():
    root = pathlib.Path(sys.argv[1])
    file, wanted = root / "governance" / "RULES.md", page(root)
    if file.exists() and file.read_text(encoding="utf-8") == wanted:
        print("governance/RULES.md shows every rule")
        return 0
    if "--write" in sys.argv[2:]:
        file.write_text(wanted, encoding="utf-8")
        return 0
    print("governance/RULES.md is not what base/rules says; run tests/lint/rules_table.py . --write")
    return 1


if __name__ == "__main__":
    sys.exit(main())

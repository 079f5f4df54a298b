#!/usr/bin/env python3
"""Holds docs/codes.md to base/codes, and docs/rules.md to base/rules.

Usage: generated_pages.py ROOT [--write]     --write brings the pages up to date instead of complaining.
"""

import pathlib
import re
import sys

LITERALS = r'((?:"(?:\\.|[^"\\])*"\s*)+)'
CODE = re.compile(rf"^X\(\s*(\w+),\s*(\d+),\s*(\w+),\s*{LITERALS},\s*{LITERALS}\)", re.M)
RULE = re.compile(rf"^X\(\s*(\w+),\s*(\w+),\s*{LITERALS},\s*{LITERALS}\)", re.M)

CODES = """# Codes

Every refusal and event of ddssec has a code that never changes. Messages end with its name and number, and
`ddssec explain 1142` (a number, a name or a sentence) says what to do. The severity is the usual one; an event can have
another. This page is made from `base/codes` by `tests/lint/generated_pages.py . --write`.
"""
CODES_ORDER = ("base", "pki", "governance", "authentication", "access_control", "cryptography", "host", "rtps", "cli", "tool")
RULES = """# Rules

What `governance lint`, `permissions lint`, `doctor`, `check` and `inspect` report, by ids that never change;
`ddssec explain ID` says the same. Errors stop `sign` and end a command with exit code 1; warnings and notes do not.
This page is made from `base/rules` by `tests/lint/generated_pages.py . --write`.
"""
RULES_ORDER = ("governance", "permissions", "doctor", "capture")
TITLES = {"governance": "`governance lint`", "permissions": "`permissions lint`",
          "doctor": "`doctor`, `check` and `keystore verify`", "capture": "`inspect`"}


def plain(literals):
    """The text of adjacent C string literals, for a table's cell."""
    text = re.sub(r"\\(.)", r"\1", "".join(re.findall(r'"((?:\\.|[^"\\])*)"', literals)))
    return text.replace("|", r"\|").replace("*", r"\*").replace("<", "&lt;")


def rows_of(file, row):
    text = file.read_text(encoding="utf-8")
    rows = row.findall(text)
    if len(rows) != len(re.findall(r"^X\(", text, re.M)):
        raise SystemExit(f"{file}: a line is not of the form {row.pattern}")
    return rows


def title_of(file):
    """Its first line, "// 1000-1099: what these are about."."""
    numbers, subject = re.match(r"// (\d+-\d+): (.*?)[.;]", file.read_text(encoding="utf-8")).groups()
    return f"{numbers}: {subject}"


def check_complete(folder, order):
    files = {file.stem for file in folder.glob("*.def")} - {"all"}
    if files != set(order):
        raise SystemExit(f"{folder}: the order in generated_pages.py does not name {sorted(files ^ set(order))}")


def codes_page(root):
    folder, out = root / "base" / "codes", CODES
    check_complete(folder, CODES_ORDER)
    for stem in CODES_ORDER:
        file = folder / f"{stem}.def"
        out += f"\n## {title_of(file)}\n\n| code | name | severity | what happened | what to do |\n|---|---|---|---|---|\n"
        rows = sorted(rows_of(file, CODE), key=lambda row: int(row[1]))
        out += "".join(f"| {number} | {name} | {severity} | {plain(summary)} | {plain(hint)} |\n"
                       for name, number, severity, summary, hint in rows)
    return out


def rules_page(root):
    folder, out = root / "base" / "rules", RULES
    check_complete(folder, RULES_ORDER)
    for stem in RULES_ORDER:
        out += f"\n## {TITLES[stem]}\n\n| id | severity | what it is about | what to do |\n|---|---|---|---|\n"
        out += "".join(f"| {name} | {severity.replace('informational', 'note')} | {plain(title)} | {plain(hint)} |\n"
                       for name, severity, title, hint in sorted(rows_of(folder / f"{stem}.def", RULE)))
    return out


def main():
    root, stale = pathlib.Path(sys.argv[1]), []
    for name, page in (("codes.md", codes_page(root)), ("rules.md", rules_page(root))):
        file = root / "docs" / name
        if file.exists() and file.read_text(encoding="utf-8") == page:
            continue
        if "--write" in sys.argv[2:]:
            file.write_text(page, encoding="utf-8")
        else:
            stale.append(name)
    for name in stale:
        print(f"docs/{name} is not what its table in base/ says; run tests/lint/generated_pages.py . --write")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Every code of base/codes (but the embedded participant's) and every rule of base/rules is
expected by name in some test.

Counts in the tests' C++ files: Code::NAME unless it is what the test itself fails with or does not
want, EXPECT_CODE(..., NAME), EXPECT_REFUSED(..., NAME), and HasSubstr("NAME") for what is only logged;
in the Python tests of the command line tool: refused("NAME" and "error[NAME]". A
rule counts as Rule::ID in C++ and as "ID" in Python.
Exit 1 and a line for each code or rule that no test expects.
"""

import pathlib
import re
import sys

NOT_THE_PLUGINS = {"all.def", "rtps.def"}
ROW = re.compile(r"^X\(\s*(\w+),", re.M)
EXPECTED = re.compile(r"\bCode::(\w+)|\bHasSubstr\(\"(\w+)\"\)|"
                      r"\b(?:EXPECT|ASSERT)_(?:CODE|REFUSED)\([^;]*?,\s*(\w+)\s*\)\s*(?:<<|;)", re.S)
REFUSED_BY_TOOL = re.compile(r'\brefused\(\s*"(\w+)"|"(?:error|warning)\[(\w+)\]"')
RULE = re.compile(r'\bRule::(\w+)|"([A-Z]+\d{3})"')
NOT_EXPECTED = re.compile(r"//[^\n]*|\bfail\(Code::\w+|\bError\(Code::\w+|\b\w+_NE\([^;]*;")


def expected_by_tests(root):
    names = set()
    for folder in ("unit", "attack", "vectors"):
        for file in (root / "tests" / folder).rglob("*_test.cpp"):
            code = NOT_EXPECTED.sub("", file.read_text(encoding="utf-8"))
            names |= {a or b or c for a, b, c in EXPECTED.findall(code)}
    for file in (root / "tests" / "cli").glob("*_test.py"):
        names |= {a or b for a, b in REFUSED_BY_TOOL.findall(file.read_text(encoding="utf-8"))}
    return names


def rules_missing(root):
    """Lines for the rules that no test expects."""
    tests = [*(root / "tests").rglob("*_test.cpp"), *(root / "tests").rglob("*_test.py")]
    known = {a or b for file in tests for a, b in RULE.findall(file.read_text(encoding="utf-8"))}
    return [f"base/rules/{file.name}: no test expects {name}"
            for file in sorted((root / "base" / "rules").glob("*.def"))
            for name in ROW.findall(file.read_text(encoding="utf-8")) if name not in known]


def main():
    root = pathlib.Path(sys.argv[1])
    known = expected_by_tests(root)
    missing, count = rules_missing(root), 0
    for file in sorted((root / "base" / "codes").glob("*.def")):
        if file.name in NOT_THE_PLUGINS:
            continue
        names = ROW.findall(file.read_text(encoding="utf-8"))
        count += len(names)
        missing += [f"base/codes/{file.name}: no test expects {name}"
                    for name in names if name not in known]
    print("\n".join(missing) if missing else f"each of {count} codes is expected by a test")
    return 1 if missing or not count else 0


if __name__ == "__main__":
    sys.exit(main())

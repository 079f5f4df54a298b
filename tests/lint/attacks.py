#!/usr/bin/env python3
"""Holds docs/attacks.md to the tests: every `Suite.Case` named there must exist."""

import pathlib
import re
import sys


def main():
    root = pathlib.Path(sys.argv[1])
    named = set(re.findall(r"`([A-Z]\w+\.\w+)`", (root / "docs/attacks.md").read_text(encoding="utf-8")))
    existing = set()
    for file in (root / "tests").rglob("*_test.cpp"):
        text = file.read_text(encoding="utf-8")
        existing |= {f"{suite}.{case}" for suite, case in
                     re.findall(r"\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)", text)}
    missing = sorted(named - existing)
    for name in missing:
        print(f"docs/attacks.md names {name}, and there is no such test")
    print(f"{len(named)} tests are named, {len(missing)} of them missing")
    return 1 if missing or not named else 0


if __name__ == "__main__":
    sys.exit(main())

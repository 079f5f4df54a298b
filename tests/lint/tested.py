#!/usr/bin/env python3
"""Each source of the libraries has a test file of its name: what pki/crl.cpp does is in tests/unit/pki/crl_test.cpp.

Usage: tested.py SOURCE_FOLDER

tested_exceptions.txt names the sources without one, beside what tests them. It may only become shorter: an entry whose
source has a test file, or no longer exists, is refused too. The sources of cli/ are tested by transcripts (tests/cli).
"""

import pathlib
import sys

MAX_EXCEPTIONS = 56  # lower it with each line that goes
FOLDERS = ("base", "governance", "idl", "pki", "plugins", "rtps", "secured", "wire")


# Tests of these folders that need the set-up of another one, beside rtps_security for rtps/security and so on.
ALSO_IN = {
    "governance": ("governance_compare",),
    "rtps/dcps": ("rtps_durability", "rtps_filter"),
    "rtps/discovery": ("rtps_filter",),
    "rtps/keeper": ("rtps_durability", "rtps_security"),
    "rtps/observer": ("rtps_security",),
    "rtps/participant": ("rtps_security",),
}


def test_folders(source, tests):
    """The names of the folders where a test of the source may be."""
    if source.parts[0] == "plugins":
        return {source.parts[1]}
    own = "_".join(source.parts[:-1])
    return {own if any(test.parent.name == own for test in tests) else source.parts[0],
            *ALSO_IN.get(source.parent.as_posix(), ())}


def has_test(source, tests):
    """True if a folder for the source has its test: another rtps_... may have one of a source with the same name."""
    folders = test_folders(source, tests)
    return any(test.name == f"{source.stem}_test.cpp" and test.parent.name in folders for test in tests)


def main():
    root = pathlib.Path(sys.argv[1])
    lines = (root / "tests/lint/tested_exceptions.txt").read_text(encoding="utf-8").splitlines()
    exceptions = [line.split("#")[0].strip() for line in lines if line.split("#")[0].strip()]
    sources = [file.relative_to(root) for folder in FOLDERS for file in sorted((root / folder).rglob("*.cpp"))]
    tests = [*(root / "tests/unit").rglob("*_test.cpp"), *(root / "tests/vectors").rglob("*_test.cpp")]
    untested = [source.as_posix() for source in sources if not has_test(source, tests)]
    found = [f"{name}: write {pathlib.Path(name).stem}_test.cpp" for name in untested if name not in exceptions]
    found += [f"tested_exceptions.txt: {name} has a test, or is gone: delete the line"
              for name in exceptions if name not in untested]
    if len(exceptions) != MAX_EXCEPTIONS:
        found.append(f"tested_exceptions.txt has {len(exceptions)} entries, and MAX_EXCEPTIONS is {MAX_EXCEPTIONS}: "
                     "write tests, and lower it")
    print("\n".join(found) or f"{len(sources) - len(untested)} of {len(sources)} sources have a test file of their name")
    return 1 if found or not sources else 0


if __name__ == "__main__":
    sys.exit(main())

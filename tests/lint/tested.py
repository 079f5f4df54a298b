#!/usr/bin/env python3
"""Each source of the libraries has a test file of its name: what pki/crl.cpp does is in tests/unit/pki/crl_test.cpp.

Usage: tested.py SOURCE_FOLDER

The test file, or a header of tests/ that it includes, uses a type, a function or a constant of the source's header. If
it cannot, because only a larger part uses them, tested_through.txt names the function or class that the test calls
instead. tested_exceptions.txt names the sources without a test file, beside what tests them. Both lists may only become
shorter: an entry that is not needed is refused too. A test file with the name of no source begins with a comment that
says what it is about. The sources of cli/ are tested by transcripts (tests/cli).
"""

import pathlib
import re
import sys

MAX_EXCEPTIONS = 54  # lower it with each line that goes
MAX_THROUGH = 113  # this, too
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


def tests_of(source, tests):
    """The tests of the source: a folder of another part may have a test of a source with the same name."""
    folders = test_folders(source, tests)
    return [test for test in tests if test.name == f"{source.stem}_test.cpp" and test.parent.name in folders]


def code_of(text):
    """The text without comments, literals and includes."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/|#include[^\n]*", "", text, flags=re.S)
    return re.sub(r'"(\\.|[^"\\\n])*"', '""', text)


def declared_in(header):
    """The types, free functions, constants and macros of the header."""
    if not header.exists():
        return set()
    text = code_of(header.read_text(encoding="utf-8"))
    return {name for pattern in (r"\b(?:class|struct|enum)\s+(?:class\s+)?(?:\[\[\w+\]\]\s*)?(\w+)\s*(?:final\s*)?[:{]",
                                 r"\busing\s+(\w+)\s*=", r"\b(k[A-Z]\w*)\b\s*[={[]", r"#define\s+(\w+)",
                                 # At the beginning of a line, so no member.
                                 r"^(?!namespace|using|class|struct|enum|template|public|private|protected|return)"
                                 r"[A-Za-z][^\n;{}=]*?\b(\w+)\(")
            for name in re.findall(pattern, text, re.M)}


def words_of(root, file, seen):
    """The identifiers of a test file, and of the headers of tests/ that it includes."""
    text = file.read_text(encoding="utf-8")
    words = set(re.findall(r"\b[A-Za-z_]\w*", code_of(text)))
    for name in re.findall(r'#include "([^"]+)"', text):
        for header in (root / name, file.parent / name):
            if header.exists() and root / "tests" in header.parents and header not in seen:
                seen.add(header)
                words |= words_of(root, header, seen)
    return words


def entries(root, name):
    """The lines of a list without their comments."""
    lines = (root / "tests/lint" / name).read_text(encoding="utf-8").splitlines()
    return [line.split("#")[0].strip() for line in lines if line.split("#")[0].strip()]


def bad_tests(root, sources, tests):
    """A line for each source whose tests neither use it nor what tested_through.txt names for it."""
    through = dict(line.split(": ") for line in entries(root, "tested_through.txt"))
    needed = set()
    for source in sources:
        own = tests_of(source, tests)
        words = set().union(*(words_of(root, test, set()) for test in own))
        if not own or words & declared_in((root / source).with_suffix(".hpp")):
            continue
        needed.add(source.as_posix())
        if source.as_posix() not in through:
            yield f"{source}: its test uses nothing of its header: name the test for what it tests"
        elif through[source.as_posix()] not in words:
            yield f"tested_through.txt: the test of {source} does not use {through[source.as_posix()]}"
    for name in through.keys() - needed:
        yield f"tested_through.txt: the test of {name} uses it, or is gone: delete the line"
    if len(through) != MAX_THROUGH:
        yield f"tested_through.txt has {len(through)} entries, and MAX_THROUGH is {MAX_THROUGH}"


def silent_tests(root):
    """A line for each test file of a situation that does not begin with a comment."""
    names = {f"{file.stem}_test.cpp" for folder in (*FOLDERS, "cli", "programs") for file in (root / folder).rglob("*.?pp")}
    return [f"{file.relative_to(root)}: begin with a comment that says what it is about"
            for file in sorted((root / "tests").rglob("*_test.cpp"))
            if file.name not in names and not file.read_text(encoding="utf-8").startswith("//")]


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    exceptions = entries(root, "tested_exceptions.txt")
    sources = [file.relative_to(root) for folder in FOLDERS for file in sorted((root / folder).rglob("*.cpp"))]
    tests = [*(root / "tests/unit").rglob("*_test.cpp"), *(root / "tests/vectors").rglob("*_test.cpp")]
    untested = [source.as_posix() for source in sources if not tests_of(source, tests)]
    found = [f"{name}: write {pathlib.Path(name).stem}_test.cpp" for name in untested if name not in exceptions]
    found += [f"tested_exceptions.txt: {name} has a test, or is gone: delete the line"
              for name in exceptions if name not in untested]
    if len(exceptions) != MAX_EXCEPTIONS:
        found.append(f"tested_exceptions.txt has {len(exceptions)} entries, and MAX_EXCEPTIONS is {MAX_EXCEPTIONS}: "
                     "write tests, and lower it")
    found += [*bad_tests(root, sources, tests), *silent_tests(root)]
    print("\n".join(found) or f"of {len(sources)} sources, {len(sources) - len(untested) - MAX_THROUGH} are named by the "
          f"test file of their name, {MAX_THROUGH} are tested through another part, {len(untested)} have no such file")
    return 1 if found or not sources else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Finds what the house style forbids and a machine can see. Exit 1 and a line each otherwise.
Tests have the same limit of lines and comments with words, and nothing else of this list."""

import itertools
import pathlib
import re
import sys

SOURCES = ["base", "idl", "pki", "governance", "plugins", "rtps", "secured", "cli", "programs",
           "examples", "wire"]
TEST_SUFFIXES = (".cpp", ".hpp", ".c", ".h", ".py", ".sh")
MOST_LINES = 500

RULES = [
    (re.compile(r"\bmemcmp\s*\("), "memcmp: secrets and MACs are compared by constant_time_equal",
     lambda name: True),
    (re.compile(r"\b[A-Z][A-Z0-9_]*_free\s*\("), "a free by hand: use the handle types",
     lambda name: not name.startswith(("base/", "pki/"))),
    (re.compile(r"\breinterpret_cast\b"), "reinterpret_cast outside the C ABI and the transports",
     lambda name: not name.startswith(("plugins/cyclonedds/", "rtps/transport/", "base/bytes.hpp",
                                       "pki/", "plugins/cryptography/"))),
    (re.compile(r"\b(TODO|FIXME|XXX)\b"), "a left-over mark", lambda name: True),
    (re.compile(r"(?<!std::)\bget_[a-z]"), "get_ says nothing: name what it is",
     lambda name: not name.startswith("plugins/cyclonedds/")),
    (re.compile(r"\bk(Most|Longest|Largest|Greatest|Highest|Deepest|Newest|"
                r"Least|Fewest|Smallest|Shortest|Lowest|Oldest)([A-Z]|\b)"),
     "a bound is called kMax or kMin", lambda name: True),
    (re.compile(r"[Ff]arewell"), "the term is dispose announcement", lambda name: True),
    (re.compile(r"\bthrow\b"), "we throw nothing", lambda name: True),
    (re.compile(r"\bstd::j?thread\s*[({]|\bpthread_create\b|\bstd::async\b"),
     "a thread that takes the host's signals: use start_background_thread",
     lambda name: not name.startswith("base/background_thread.")),
    (re.compile(r"\b(PKCS7_(verify|dataDecode|dataVerify|signatureVerify)|CMS_(verify|SignerInfo_verify\w*))\s*\("),
     "OpenSSL reads a signature unguarded: use pki/openssl_guards.hpp",
     lambda name: name != "pki/openssl_guards.cpp"),
    (re.compile(r"\bX509_check_purpose\s*\("),
     "OpenSSL reads extensions that check_distribution_points may not have seen",
     lambda name: name != "pki/certificate.cpp"),
]


def code_only(line):
    return re.sub(r'"(\\.|[^"\\])*"', '""', line).split("//")[0]


def too_long(name, lines):
    return [f"{name}: {len(lines)} lines; is it one thing?"] if len(lines) > MOST_LINES else []


def doc_comments(name, lines):
    """/// documents a declaration of a header. In a source, // says why."""
    return [f"{name}:{number}: /// in a source: write //" for number, line in enumerate(lines, 1)
            if name.endswith(".cpp") and re.match(r'[^"]*///', line)]


def empty_comments(name, lines):
    """A line for each comment of /// without a word: an edit of many files can leave such a rest of one."""
    for number, line in enumerate(lines):
        begins = is_doc_line(line) and (number == 0 or not is_doc_line(lines[number - 1]))
        block = itertools.takewhile(is_doc_line, lines[number:]) if begins else ()
        if begins and not any(re.search("[A-Za-z]{2}", each) for each in block):
            yield f"{name}:{number + 1}: a /// comment without a word"


def is_doc_line(line):
    return line.lstrip().startswith("///")


def bare_classes(name, lines):
    """A line for each class and struct of a header without a comment of its own. Specialisations need none."""
    for number, line in enumerate(lines):
        kind = re.match(r"(?:class|struct) (\w+)(?!::)\b(?!<)[^;]*\{", line) if name.endswith(".hpp") else None
        before = number - 1
        while kind and lines[before].startswith(("template", "  requires")):
            before -= 1
        if kind and not lines[before].startswith("///"):
            yield f"{name}:{number + 1}: no /// comment for the type {kind[1]}"


def lines_of(file):
    return file.read_text(encoding="utf-8").splitlines()


def test_faults(root):
    """The number of files of tests, and a line for each fault. What others wrote is below tests/data."""
    tests, data = root / "tests", root / "tests" / "data"
    files = [p for p in sorted(tests.rglob("*")) if p.suffix in TEST_SUFFIXES and data not in p.parents]
    named = [(p.relative_to(root).as_posix(), lines_of(p)) for p in files]
    return len(files), [line for name, lines in named
                        for line in too_long(name, lines) + list(empty_comments(name, lines))]


def unclear_names(root):
    """A line for each test of GoogleTest whose name is not Condition_Outcome, or is no sentence in a list of tests:
    there "Ocsp.OfAnotherCa_IsRefused" stands alone."""
    pattern = re.compile(r"^(?:TEST|TEST_F|TEST_P|TYPED_TEST)\((\w+),\s*(\w+)\)", re.M)
    tests = [(f"{file.relative_to(root).as_posix()}: {suite}.{name}", name)
             for file in sorted((root / "tests").rglob("*_test.cpp"))
             for suite, name in pattern.findall(file.read_text(encoding="utf-8"))]
    return ([f"{test}: name the condition and the outcome, with _ between" for test, name in tests if "_" not in name]
            + [f"{test}: begin with what it is about, not with By, Of, For or That" for test, name in tests
               if re.match(r"(By|Of|For|That)(?![a-z])", name)])


def unclear_python_names(root):
    """A line for each test in Python whose name is no sentence in small letters."""
    data = root / "tests" / "data"
    return [f"{file.relative_to(root).as_posix()}: {name}: write the name as a sentence: test_a_key_that_does_not_fit_is_refused"
            for file in sorted((root / "tests").rglob("*.py")) if data not in file.parents
            for name in re.findall(r"^ +def (test_\w*[A-Z]\w*)\(", file.read_text(encoding="utf-8"), re.M)]


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    files = [p for folder in SOURCES for p in sorted((root / folder).rglob("*"))
             if p.suffix in (".cpp", ".hpp", ".c", ".h")]
    tests, found = test_faults(root)
    found += unclear_names(root) + unclear_python_names(root)
    for file in files:
        name = file.relative_to(root).as_posix()
        lines = lines_of(file)
        found += too_long(name, lines) + doc_comments(name, lines)
        found += list(bare_classes(name, lines)) + list(empty_comments(name, lines))
        for number, line in enumerate(lines, 1):
            for pattern, why, applies in RULES:
                if applies(name) and pattern.search(code_only(line)):
                    found.append(f"{name}:{number}: {why}")
    print("\n".join(found) if found else f"{len(files)} files and {tests} tests have the shape they should")
    return 1 if found or not files or not tests else 0


if __name__ == "__main__":
    sys.exit(main())

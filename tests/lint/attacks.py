#!/usr/bin/env python3
"""Holds the pages docs/attacks/*.md to the tests: each test named there exists and runs against the host of its line.
The tables of docs/attacks.md, which name each attack with its hosts and whether a part is open, are made from the pages.
Tests that tests/sim/README.md names for the findings that the simulation does not reach exist, too.

Usage: attacks.py ROOT [--write]     --write brings the tables up to date instead of complaining.
"""

import fnmatch
import pathlib
import re
import sys

# Folders of tests/ whose tests run against each host.
FOLDERS = {
    "Plugins": ("attack/access_control", "attack/authentication", "attack/cryptography", "unit/access_control", "unit/authentication",
               "unit/base", "unit/cryptography", "unit/governance", "unit/governance_compare", "unit/governance_doctor", "unit/pki",
               "unit/spi", "vectors"),
    "Cyclone DDS": ("attack/cyclonedds", "unit/cyclonedds"),
    "Embedded": ("attack/rtps", "unit/rtps", "unit/rtps_durability", "unit/rtps_filter", "unit/rtps_security", "unit/secured", "unit/wire"),
    "Tool": ("unit/cli",),
    "Open": ("",),
}
# Entries of ctest that run real processes, by the beginning of their names.
ENTRIES = {"Plugins": (), "Cyclone DDS": ("interop.", "ros2."), "Embedded": ("interop_rtps.",), "Tool": ("cli.",),
           "Open": ("interop.", "interop_rtps.")}


def tests_by_folder(root):
    """{Suite.Case: folders below tests/ that define it}"""
    out = {}
    for file in (root / "tests").rglob("*_test.cpp"):
        folder = file.parent.relative_to(root / "tests").as_posix()
        for suite, case in re.findall(r"\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)", file.read_text(encoding="utf-8")):
            out.setdefault(f"{suite}.{case}", set()).add(folder)
    return out


def ctest_entries(root):
    """Names given to add_test, also by functions that take it first or after the folder's prefix."""
    transcripts = {"cli." + file.stem.removesuffix("_test") for file in (root / "tests/cli").glob("*_test.py")}
    text = "\n".join(file.read_text(encoding="utf-8") for file in (root / "tests").rglob("CMakeLists.txt"))
    return transcripts | set(re.findall(r"(?:NAME\s+|ddssec_interop_test\()([\w.]+)", text)) | {
        name.replace("${which}", which) for name in re.findall(r"NAME\s+([\w.${}]+)", text) for which in ("chosen", "all")}


def lines_by_host(text):
    """Each bullet with its continuation lines: (host, text)."""
    for bullet in re.findall(r"^- (.+(?:\n  .+)*)", text, re.MULTILINE):
        host = re.match(r"(Plugins|Cyclone DDS|Embedded|Tool|Open)[:,]", bullet)
        yield (host.group(1) if host else None), bullet


def anchor(heading):
    """What a link to `heading` ends with, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.replace("`", "").lower()).replace(" ", "-")


def table_of(page):
    """A row for each attack of the page: where tests show the defence, and what is open."""
    out = "| attack | tests against | open |\n|---|---|---|\n"
    for heading, body in re.findall(r"^## (.+)\n((?:(?!## ).*\n?)*)", page.read_text(encoding="utf-8"), re.MULTILINE):
        hosts = [host for host, _ in lines_by_host(body) if host]
        defended = [host for host in FOLDERS if host in hosts and host != "Open"]
        is_open = "–" if "Open" not in hosts else "a part" if defended else "all"
        out += f"| [{heading}](attacks/{page.name}#{anchor(heading)}) | {', '.join(defended) or '–'} | {is_open} |\n"
    return out


def with_tables(root, index):
    """The text of the index with the table of each page between its marks, and a fault for each page without marks."""
    found = []
    for page in sorted((root / "docs/attacks").glob("*.md")):
        begin, end = f"<!-- {page.name} -->\n", f"<!-- end of {page.name} -->\n"
        if begin not in index or end not in index:
            found.append(f"docs/attacks.md lacks the lines {begin.strip()} and {end.strip()}")
            continue
        before, _, rest = index.partition(begin)
        index = before + begin + "\n" + table_of(page) + "\n" + end + rest.partition(end)[2]
    return index, found


def missing_in_simulation(root, tests):
    """The names in tests/sim/README.md, which may end in "*", that no test has."""
    text = (root / "tests/sim/README.md").read_text(encoding="utf-8")
    for name in re.findall(r"`([A-Z]\w+\.\w*\*?)`", text):
        if not any(fnmatch.fnmatchcase(test, name) for test in tests):
            yield f"{name} in tests/sim/README.md does not exist"


def faults(root, write):
    tests, entries = tests_by_folder(root), ctest_entries(root)
    pages = sorted((root / "docs/attacks").glob("*.md"))
    if not pages:
        yield "there are no pages"
    file = root / "docs/attacks.md"
    index = file.read_text(encoding="utf-8")
    expected, missing_marks = with_tables(root, index)
    yield from missing_marks
    if expected != index and write:
        file.write_text(expected, encoding="utf-8")
    elif expected != index:
        yield "docs/attacks.md is not what the pages say; run tests/lint/attacks.py . --write"
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    for host, bullet in lines_by_host(text):
        if host is None:
            yield f"a line names no host: {bullet[:60]}"
            continue
        names = re.findall(r"`([A-Z]\w+\.\w+)`", bullet)
        for name in names:
            if not any(folder.startswith(FOLDERS[host]) for folder in tests.get(name, ())):
                yield f"{name} does not exist in a test folder of the host {host}"
        runs = re.findall(r"`((?:interop|interop_rtps|ros2|cli)\.\w+)`", bullet)
        for name in runs:
            if name not in entries or not name.startswith(ENTRIES[host]):
                yield f"{name} is no test entry of the host {host}"
        if host != "Open" and not names and not runs and " rows in " not in bullet:
            yield f"a line names no test: {bullet[:60]}"
    yield from missing_in_simulation(root, tests)


def main():
    found = list(faults(pathlib.Path(sys.argv[1]), "--write" in sys.argv[2:]))
    for fault in found:
        print(f"docs/attacks/: {fault}")
    print(f"{len(found)} faults")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Each file has a copyright holder and a licence in REUSE.toml, LICENSES/ has the text of each licence and no other, and test
data of others keep a licence text of their own. The same rules as `reuse lint` (https://reuse.software, version 3.3), which
Debian 12 has only for an older format. Exit 1 and a line for each fault."""

import pathlib
import re
import subprocess
import sys
import tomllib

# REUSE asks nothing of these.
NOT_ASKED = re.compile(r"(^|/)(LICEN[CS]E|COPYING)([-.][^/]*)?$|^LICENSES/|^REUSE\.toml$|\.license$")
LICENCE_TEXT = re.compile(r"^(LICEN[CS]E|COPYING|Copyright)")


def pattern_of(glob):
    """`**` is anything, `*` anything without a slash."""
    out, at = "", 0
    while at < len(glob):
        if glob.startswith("**", at):
            out, at = out + ".*", at + 2
        else:
            out, at = out + ("[^/]*" if glob[at] == "*" else re.escape(glob[at])), at + 1
    return re.compile(out + r"\Z", re.DOTALL)


def as_list(value):
    return value if isinstance(value, list) else [value]


def licences_of(table):
    """The names in a licence expression."""
    return set(re.findall(r"[\w.+-]+", str(table.get("SPDX-License-Identifier", "")))) - {"OR", "AND", "WITH"}


def faults_of_files(names, tables):
    used = set()
    for name in names:
        fitting = [number for number, table in enumerate(tables) if any(glob.match(name) for glob in table["patterns"])]
        if not fitting:
            yield f"{name}: REUSE.toml has no table for it"
        used.update(fitting)
    for number, table in enumerate(tables):
        if number not in used:
            yield f"REUSE.toml: {table['path']} fits no file"
        if not licences_of(table) or not all(as_list(table.get("SPDX-FileCopyrightText", ""))):
            yield f"REUSE.toml: {table['path']} lacks a licence or a copyright holder"


def faults_of_texts(root, tables):
    named = set().union(*map(licences_of, tables))
    there = {file.stem for file in (root / "LICENSES").glob("*.txt") if file.stat().st_size > 0}
    yield from (f"LICENSES/{name}.txt is missing" for name in sorted(named - there))
    yield from (f"LICENSES/{name}.txt is the licence of no file" for name in sorted(there - named))
    if (root / "LICENSE").read_bytes() != (root / "LICENSES/Apache-2.0.txt").read_bytes():
        yield "LICENSE and LICENSES/Apache-2.0.txt differ"


def faults_of_data(root, names, tables):
    """Test data of others: README.md says `Origin:`."""
    for readme in sorted((root / "tests/data").glob("*/README.md")):
        if not re.search(r"^Origin:", readme.read_text(encoding="utf-8"), re.MULTILINE):
            continue
        folder = readme.parent.relative_to(root).as_posix()
        if not any(f"{folder}/**" in as_list(table["path"]) for table in tables):
            yield f"{folder}: from another project, and REUSE.toml has no table for it"
        inside = [pathlib.PurePath(name).name for name in names if name.startswith(folder + "/")]
        if not any(LICENCE_TEXT.match(name) for name in inside):
            yield f"{folder}: from another project, without the text of its licence"


def faults(root):
    with open(root / "REUSE.toml", "rb") as file:
        tables = tomllib.load(file)["annotations"]
    for table in tables:
        table["patterns"] = [pattern_of(glob) for glob in as_list(table["path"])]
    listed = subprocess.run(["git", "-C", root, "ls-files", "-z"], capture_output=True, text=True, check=True).stdout
    names = [name for name in listed.split("\0") if name and (root / name).is_file()]
    asked = [name for name in names
             if not NOT_ASKED.search(name) and not (root / name).is_symlink() and (root / name).stat().st_size > 0]
    yield from faults_of_files(asked, tables)
    yield from faults_of_texts(root, tables)
    yield from faults_of_data(root, names, tables)


def main():
    found = list(faults(pathlib.Path(sys.argv[1]).resolve()))
    print("\n".join(found) if found else "each file has a licence, and each licence its text")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

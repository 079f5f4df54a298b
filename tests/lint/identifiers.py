#!/usr/bin/env python3
"""Each identifier `a::b` that a page names in backticks exists in the sources, so that a rename does not forget the pages.

`A::b` exists if a header of ours has a namespace A with the word b, or a class, struct or enumeration A with b in its
body, comments aside. `A::b::c` is looked up by pairs. The codes and rules of base/*.def are those of `Code` and `Rule`.
Names of std and placeholders (`Code::NAME`) are not looked up. CHANGELOG.md names what was, and is left out.

A word with underscores in backticks (`delivers_in_process`) is a word of a tracked file that is no page, or a part of its
path, or one of OF_OTHERS, or of a target that CMake names. docs/history.md and docs/cpp-names.md have former names, and are left out there.

Exit 1 and a line for each identifier that does not exist.
"""

import pathlib
import re
import subprocess
import sys

LEFT_OUT = ("CHANGELOG.md", "tests/data/")
SPAN = re.compile(r"`([^`\n]+)`")
NAME = re.compile(r"[A-Za-z_]\w*(?:::[A-Za-z_]\w*)+")
WORD = re.compile(r"(?<![\w./:-])[a-z]+(?:_[a-z0-9]+)+(?![\w/:-])")
OF_OTHERS = {"and_then", "generate_policy", "libdds_security", "shmem_enabled"}
OF_CMAKE = re.compile(r"(test|rtps)_\w+")
RENAMES = "docs/cpp-names.md"  # tests/lint/api_names.py checks its new names
FORMER = ("docs/history.md", RENAMES)
NOT_ASKED = ("CHANGELOG.md", "tests/data/", "LICENSES/", "tests/lint/api_names.txt")
PLACEHOLDERS = {"NAME", "ID"}
SCOPE = re.compile(r"\b(namespace|class|struct|enum)\s+(?:class\s+)?(?:\[\[\w+\]\]\s*)?([A-Za-z_][\w:]*)[^;{}()]*\{")
TABLES = {"Code": "base/codes", "tool_code": "base/codes", "Rule": "base/rules"}


def without_comments(text):
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S)


def body_from(text, brace):
    """The text between the brace at this place and its partner."""
    depth = 0
    for found in re.finditer(r"[{}]", text[brace:]):
        depth += 1 if found[0] == "{" else -1
        if depth == 0:
            return text[brace:brace + found.start()]
    return text[brace:]


def scopes(root, headers):
    """{name of a namespace or type: the words within it, in all headers}"""
    out = {}
    for name in headers:
        text = without_comments((root / name).read_text(encoding="utf-8"))
        for found in SCOPE.finditer(text):
            words = set(re.findall(r"\w+", body_from(text, found.end() - 1)))
            parts = found[2].split("::")
            for at, part in enumerate(parts):
                out.setdefault(part, set()).update(words | set(parts[at + 1:]))
    for scope, folder in TABLES.items():
        for table in (root / folder).glob("*.def"):
            out.setdefault(scope, set()).update(re.findall(r"^X\(\s*(\w+)", table.read_text(encoding="utf-8"), re.M))
    return out


def missing(known, name):
    """The first pair of the name that does not exist, or None."""
    parts = name.split("::")
    if parts[0] == "std":
        return None
    for scope, member in zip(parts, parts[1:]):
        if member not in PLACEHOLDERS and member not in known.get(scope, ()):
            return f"{scope}::{member}"
    return None


def words_of(root, listed):
    """The words of all tracked files that are no pages, and of their paths."""
    out = set(OF_OTHERS)
    for name in listed:
        if not name.endswith(".md") and not name.startswith(NOT_ASKED) and (root / name).is_file():
            out.update(re.findall(r"\w+", name), re.findall(r"\w+", (root / name).read_text(encoding="utf-8", errors="replace")))
    return out


def main():
    root = pathlib.Path(sys.argv[1])
    listed = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True, check=True).stdout.split()
    tracked = [name for name in listed if not name.startswith(LEFT_OUT) and (root / name).is_file()]
    known = scopes(root, [name for name in tracked if name.endswith((".hpp", ".h"))])
    words = words_of(root, listed)
    looked, faults = 0, 0
    for page in (name for name in tracked if name.endswith(".md")):
        for number, line in enumerate((root / page).read_text(encoding="utf-8").split("\n"), 1):
            for name in (name for span in SPAN.findall(line) for name in NAME.findall(span) if page != RENAMES):
                looked += 1
                if wrong := missing(known, name):
                    print(f"{page}:{number}: no header has {wrong}" + (f" (in {name})" if wrong != name else ""))
                    faults += 1
            for word in (word for span in SPAN.findall(line) for word in WORD.findall(span) if page not in FORMER):
                looked += 1
                if word not in words and not OF_CMAKE.fullmatch(word):
                    print(f"{page}:{number}: no source has {word}")
                    faults += 1
    print(f"{faults} of {looked} identifiers do not exist" if faults else f"{looked} identifiers exist")
    return 1 if faults or not looked else 0


if __name__ == "__main__":
    sys.exit(main())

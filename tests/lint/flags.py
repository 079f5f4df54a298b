#!/usr/bin/env python3
"""A bool member of a header reads as a condition: is_open, has_room, wraps_plain_builtin. Its name begins with is_, has_
or the like, or its first or second word is a verb such as "wraps"; nothing but bools and functions has such a name. The
others stand in flags_exceptions.txt: names of the specifications, of documents and of JSON, and those that were not
renamed yet. That list may only shrink. Exit 1 and a line for each fault."""

import pathlib
import re
import sys

FOLDERS = ("base", "wire", "pki", "governance", "plugins", "rtps", "secured", "cli")
EXCEPTIONS = "tests/lint/flags_exceptions.txt"
MAX_EXCEPTIONS = 106  # lower it with each name that goes
MEMBER = re.compile(r"^\s+(?:mutable |const )*bool (\w+(?:\s*=\s*\w+)?(?:, \w+(?:\s*=\s*\w+)?)*);")
CONDITION = re.compile(r"(is|are|was|were|has|have|had|can|may|must|does|do|did)_")
NO_FLAG = re.compile(r"\b(?:\w*Handle|string_view|string|Guid|Bytes|BytesView|size_t|u?int\d+_t)&? ((?:is|has)_\w+)\s*[;,)={]")
ENUMERATORS = re.compile(r"\benum class [^{;]*\{([^}]*)\}")
PLURALS = {"choices", "escapes", "keys", "lines", "permissions", "process", "properties", "samples", "stars", "topics",
           "is", "unauthenticated"}


def is_verb(word):
    return word.endswith("s") and word not in PLURALS


def flags_in(text):
    for line in text.splitlines():
        member = MEMBER.match(re.sub(r"\{\w*\};$", ";", line.split("//")[0].rstrip()))
        if member:
            yield from (part.split("=")[0].strip() for part in member[1].split(","))


def reads_as_condition(name):
    return bool(CONDITION.match(name)) or any(is_verb(word) for word in name.rstrip("_").split("_")[:2])


def named_like_flags(text):
    """Enumerators, and members or parameters of other types, that are named like a bool."""
    yield from NO_FLAG.findall(text)
    for enumerators in ENUMERATORS.findall(text):
        yield from re.findall(r"\b(?:is|has)_\w+", re.sub(r"//.*", "", enumerators))


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    lines = [line for line in (root / EXCEPTIONS).read_text(encoding="utf-8").splitlines() if line and line[0] != "#"]
    excepted = {(name, flag) for name, _, flags in (line.partition(":") for line in lines) for flag in flags.split()}
    headers = [p for folder in FOLDERS for p in sorted((root / folder).rglob("*.hpp"))]
    unclear = {(p.relative_to(root).as_posix(), flag) for p in headers for flag in flags_in(p.read_text(encoding="utf-8"))
               if not reads_as_condition(flag)}
    found = [f"{name}: {flag}: name the condition (is_, has_, ...)" for name, flag in sorted(unclear - excepted)]
    found += [f"{EXCEPTIONS}: {name}: {flag} needs no exception" for name, flag in sorted(excepted - unclear)]
    found += [f"{p.relative_to(root).as_posix()}: {name} is named like a bool"
              for p in headers for name in named_like_flags(p.read_text(encoding="utf-8"))]
    if len(excepted) != MAX_EXCEPTIONS:
        found.append(f"{EXCEPTIONS} has {len(excepted)} names, and MAX_EXCEPTIONS is {MAX_EXCEPTIONS}: lower it")
    print("\n".join(found) if found else f"the flags of {len(headers)} headers read as conditions, but for {len(excepted)}")
    return 1 if found or not headers else 0


if __name__ == "__main__":
    sys.exit(main())

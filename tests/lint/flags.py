#!/usr/bin/env python3
"""A bool member of a header reads as a condition: is_open, has_room, wraps_plain_builtin. Its name begins with is_, has_
or the like, or its first or second word is a verb such as "wraps". The others stand in flags_exceptions.txt: names of the
specifications, of documents and of JSON, and those that were not renamed yet. That list may only shrink.

In headers and sources, is_ and has_ begin only names of bools, of predicates, and of functions that return a bool and
change nothing: a method is const. conditions_exceptions.txt has those that were not renamed yet, and may only shrink.
Exit 1 and a line for each fault."""

import pathlib
import re
import sys

FOLDERS = ("base", "wire", "pki", "governance", "plugins", "rtps", "secured", "cli")
EXCEPTIONS = "tests/lint/flags_exceptions.txt"
MAX_EXCEPTIONS = 102  # lower it with each name that goes
MEMBER = re.compile(r"^\s+(?:mutable |const )*bool (\w+(?:\s*=\s*\w+)?(?:, \w+(?:\s*=\s*\w+)?)*);")
CONDITION = re.compile(r"(is|are|was|were|has|have|had|can|may|must|does|do|did)_")
CONDITIONS = "tests/lint/conditions_exceptions.txt"
DECLARED = re.compile(r"(?P<type>[^\n;{}()]*?[\w>][&*]*)\s+(?P<name>(?:is|has)_\w+)\s*(?P<after>[(;={,)\[:])")
NO_TYPE = {"return", "else", "case", "not", "and", "or", "new", "typename"}
# A bool, its C forms, or what returns one.
CONDITION_TYPE = re.compile(r"\b(bool|auto|atomic_bool|atomic_flag|DDS_Security_boolean|int|\w*Predicate)$|\bbool\b.*>$|\bIs[A-Z]\w*$"
                            r"|\b(Rollback|Guard)$")
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


def plain(text):
    """Without comments and literals."""
    return re.sub(r'"(?:\\.|[^"\\\n])*"', '""', re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S))


def is_changing(text, declared):
    """True for the declaration of a method, in a class of a header, that is not const."""
    start = text.rfind("\n", 0, declared.start("name")) + 1
    depth, end = 0, declared.end() - 1
    while end < len(text):
        depth += {"(": 1, ")": -1}.get(text[end], 0)
        end += 1
        if depth == 0:
            break
    qualifiers = re.split(r"[;{]", text[end:end + 80])[0]
    return (text[start:start + 1] == " " and "const" not in qualifiers
            and not re.search(r"\b(static|friend)\b", text[start:declared.start("name")]))


def named_like_flags(text, is_header):
    """Names like that of a bool: of enumerators, of what has another type, and of methods that are not const."""
    text = plain(text)
    for declared in DECLARED.finditer(text):
        kind = re.sub(r"[&*]+$", "", declared["type"].rstrip())
        words = re.findall(r"\w+", kind)
        if not words or words[-1] in NO_TYPE or declared["type"].rstrip().endswith("&&"):
            continue
        if not CONDITION_TYPE.search(kind) or declared["after"] == "(" and is_header and is_changing(text, declared):
            yield declared["name"]
    for enumerators in ENUMERATORS.findall(text):
        yield from re.findall(r"\b(?:is|has)_\w+", enumerators)


def listed(path):
    """The (file, name) pairs of a list of exceptions."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line and line[0] != "#"]
    return {(name, flag) for name, _, flags in (line.partition(":") for line in lines) for flag in flags.split()}


def faults_of_conditions(root):
    files = [p for folder in (*FOLDERS, "programs") for p in sorted((root / folder).rglob("*.[ch]pp"))]
    unfit = {(p.relative_to(root).as_posix(), name) for p in files
             for name in named_like_flags(p.read_text(encoding="utf-8"), p.suffix == ".hpp")}
    excepted = listed(root / CONDITIONS)
    yield from (f"{file}: {name} is named like a condition, but is no bool, or changes its object" for file, name in sorted(unfit - excepted))
    yield from (f"{CONDITIONS}: {file}: {name} needs no exception" for file, name in sorted(excepted - unfit))


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    excepted = listed(root / EXCEPTIONS)
    headers = [p for folder in FOLDERS for p in sorted((root / folder).rglob("*.hpp"))]
    unclear = {(p.relative_to(root).as_posix(), flag) for p in headers for flag in flags_in(p.read_text(encoding="utf-8"))
               if not reads_as_condition(flag)}
    found = [f"{name}: {flag}: name the condition (is_, has_, ...)" for name, flag in sorted(unclear - excepted)]
    found += [f"{EXCEPTIONS}: {name}: {flag} needs no exception" for name, flag in sorted(excepted - unclear)]
    found += faults_of_conditions(root)
    if len(excepted) != MAX_EXCEPTIONS:
        found.append(f"{EXCEPTIONS} has {len(excepted)} names, and MAX_EXCEPTIONS is {MAX_EXCEPTIONS}: lower it")
    print("\n".join(found) if found else f"the flags of {len(headers)} headers read as conditions, but for {len(excepted)}")
    return 1 if found or not headers else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Holds events about peers to saying who proved what they report. Exit 1 and a line each otherwise.

An Event is "claimed" unless its proof is named, and shares its places with whatever strangers send.
In rtps/ only rtps/security/peer_event makes events about others; elsewhere an event with a
subject or a GUID names its proof.
"""

import pathlib
import re
import sys

DECIDES = ("rtps/security/peer_event.hpp", "rtps/security/peer_event.cpp")
EVENT = re.compile(r"\bEvent(?:\s+\w+)?\s*[({]")
PARAMETER = re.compile(r"^\s*(?:const\s+)?[\w:<>]+\s*[&*]?\s+[&*]?\w+(?:\s*=.*)?\s*$", re.S)


def without_comments(text):
    return re.sub(r"//[^\n]*", lambda m: " " * len(m[0]), text)


def arguments(text, start):
    """The top-level arguments of the call whose bracket opens before `start`."""
    out, depth, begin, quoted, at = [], 0, start, False, start
    while at < len(text):
        c = text[at]
        if quoted:
            at += c == "\\"
            quoted = c != '"'
        elif c == '"':
            quoted = True
        elif c in "([{":
            depth += 1
        elif c in ")]}" and depth:
            depth -= 1
        elif c in ")]}":
            return out + [text[begin:at]]
        elif c == "," and not depth:
            out.append(text[begin:at])
            begin = at + 1
        at += 1
    return out


def complaints(name, text):
    text = without_comments(text)
    for found in EVENT.finditer(text):
        given = arguments(text, found.end())
        if len(given) < 2:
            continue  # about ourselves
        if any(PARAMETER.match(one) for one in given):
            continue  # a function that returns one
        line = text.count("\n", 0, found.start()) + 1
        if name.startswith("rtps/"):
            yield f"{name}:{line}: an event about a peer: raise() of the core decides its proof"
        elif not any("PeerProof::" in one or re.search(r"\bproof\b", one) for one in given):
            yield f"{name}:{line}: an event about a peer without a word on its proof"


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    files = [p for folder in ("plugins", "rtps", "secured")
             for p in sorted((root / folder).rglob("*")) if p.suffix in (".cpp", ".hpp")]
    found = [one for file in files if (name := file.relative_to(root).as_posix()) not in DECIDES
             for one in complaints(name, file.read_text(encoding="utf-8"))]
    print("\n".join(found) if found else f"{len(files)} files say who proved what events report")
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main())

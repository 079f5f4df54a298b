#!/usr/bin/env python3
"""In a braced list no DDSSEC_TRY stands behind an element that owns something.

It returns from the middle of the list, and what is made of an aggregate or an array by then g++ 12 does not
destroy: it leaks, and a key would not be wiped. Where all that stands before owns nothing, the type is named
here. Exit 1 and a line for each other place.
"""

import pathlib
import re
import sys

FOLDERS = ("base", "pki", "governance", "plugins", "rtps", "secured", "cli", "programs", "idl", "examples", "tests")
# Views, numbers and ids, at least in front of what may fail.
OWN_NOTHING = {"Announced", "Credentials", "Duration", "Embedded", "GroupRequest", "Guid",
               "HandshakeFinal", "HandshakeReply", "HandshakeRequest", "Locator", "MultipartSigned", "Passphrase",
               "RosElement", "RosPermissionsOptions", "SecurityInfo", "SendStart", "Settings", "Time", "Transcript",
               "Validity"}
BLANKED = re.compile(r"//[^\n]*|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])'")


def closing(text, at):
    depth = 0
    for i in range(at, len(text)):
        depth += (text[i] in "{([") - (text[i] in "})]")
        if depth == 0:
            return i
    return len(text)


def elements(body):
    """What stands between the commas of a list; nothing if it is a block of statements. Blocks in it
    (bodies of lambdas) are left out."""
    out, element, i = [], "", 0
    while i < len(body):
        if body[i] == ";":
            return []
        if body[i] == ",":
            out.append(element)
            element = ""
        elif body[i] in "{([":
            end = closing(body, i)
            element += body[i] + " ".join(elements(body[i + 1:end])) + "}"
            i = end
        else:
            element += body[i]
        i += 1
    return [*out, element]


def offences(text):
    text = BLANKED.sub(lambda match: " " * len(match[0]), text)
    for opening in re.finditer(r"\{", text):
        body = text[opening.end():closing(text, opening.start())]
        if "DDSSEC_TRY(" not in body or not any("DDSSEC_TRY(" in element for element in elements(body)[1:]):
            continue
        words = re.findall(r"\w+", text[max(0, opening.start() - 80):opening.start()])[-2:]
        if not OWN_NOTHING & set(words):
            yield text.count("\n", 0, opening.start()) + 1


def main():
    root = pathlib.Path(sys.argv[1])
    count, bad = 0, []
    for file in sorted(path for folder in FOLDERS for path in (root / folder).rglob("*.[ch]pp")):
        count += 1
        bad += [f"{file.relative_to(root)}:{line}: DDSSEC_TRY behind an element that may own something"
                for line in offences(file.read_text(encoding="utf-8"))]
    print("\n".join(bad) or f"{count} files return from no list that owns something")
    return 1 if bad else 0


sys.exit(main())

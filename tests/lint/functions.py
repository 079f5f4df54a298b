#!/usr/bin/env python3
"""Measures functions: at most 60 lines and 5 parameters. Exit 1 and a line for each that has more.

A lambda counts for the function around it. The adapters of Cyclone DDS have the parameters that its C ABI prescribes.
"""

import pathlib
import re
import sys

MAX_LINES, MAX_PARAMETERS = 60, 5
FOLDERS = ("base", "idl", "pki", "governance", "plugins", "rtps", "secured", "cli", "programs", "examples", "wire")
PRESCRIBED = re.compile(r"plugins/cyclonedds/\w+_adapter\.cpp")
# More than 5 parameters: the list may not grow.
KNOWN = {"add_flag", "denied_error", "check_payload", "make_room", "read", "continue_sample", "open", "receiver_macs",
         "check_not_exposed_by_shared_memory", "add_meetings", "add_peer", "put_extended", "next_crl"}
CONTROL = re.compile(r"\b(if|for|while|switch|catch|else|do|return|namespace|class|struct|union|enum|requires|try|extern)\b")


def blanked(text):
    pattern = r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:\\\n|[^\n])*'
    return re.sub(pattern, lambda m: "\n" * m[0].count("\n") or " ", text, flags=re.S | re.M)


def closing(text, at):
    depth = 0
    for i in range(at, len(text)):
        depth += (text[i] in "{([") - (text[i] in "})]")
        if depth == 0:
            return i
    return len(text) - 1


def parameters(head):
    """The text between the first parentheses that follow a name, or None if there are none."""
    found = re.search(r"([\w~]+|operator\s*[^\s\w(]+|operator\s*\(\s*\))\s*\(", head)
    if not found:
        return None
    opening = found.end() - 1
    return found[1], head[opening + 1:closing(head, opening)]


def count(text):
    depth, number = 0, 1 if text.strip() and text.strip() != "void" else 0
    for char in text:
        depth += (char in "<({[") - (char in ">)}]")
        number += char == "," and depth == 0
    return number


def functions(text, start=0, end=None):
    end = len(text) if end is None else end
    begin = i = start
    while i < end:
        if text[i] in ";}":
            begin = i + 1
        elif text[i] == "(":
            i = closing(text, i)
        elif text[i] == "{":
            close = closing(text, i)
            head = re.sub(r"\b(public|private|protected)\s*:", "", text[begin:i]).strip()
            found = None if re.match(r"(?:\[\[.*?\]\]\s*)?(?:inline\s+)?" + CONTROL.pattern, head) else parameters(head)
            if re.match(r"(template\s*<.*>\s*)?(namespace|class|struct|union|extern)\b", head, re.S) and (not found or "(" not in head):
                yield from functions(text, i + 1, close)
            elif found:
                yield found[0], count(found[1]), text.count("\n", begin, i), text.count("\n", i, close) - 1, i
            i = close
            begin = i + 1
        i += 1


def main():
    root = pathlib.Path(sys.argv[1])
    faults = total = 0
    lengths = []
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.[ch]*")):
            if path.suffix not in (".cpp", ".hpp", ".c", ".h"):
                continue
            text = blanked(path.read_text(encoding="utf-8"))
            for name, arguments, _, lines, at in functions(text):
                total += 1
                lengths.append(lines)
                file = path.relative_to(root).as_posix()
                place = f"{file}:{text.count(chr(10), 0, at) + 1}: {name}"
                if lines > MAX_LINES:
                    print(f"{place}: {lines} lines")
                    faults += 1
                if arguments > MAX_PARAMETERS and name not in KNOWN and not PRESCRIBED.fullmatch(file):
                    print(f"{place}: {arguments} parameters")
                    faults += 1
    lengths.sort()
    print(f"{total} functions; median {lengths[total // 2]}, p90 {lengths[total * 9 // 10]}, longest {lengths[-1]} lines")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

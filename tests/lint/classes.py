#!/usr/bin/env python3
"""Counts the methods of each class. Exit 1 and a line for each class that has too many. A plugin's interface is the standard's, so in
plugins/ the functions that override one do not count (docs/decisions/code.md: Classes have at most forty methods)."""

import pathlib
import re
import sys

FOLDERS = ("base", "wire", "pki", "governance", "plugins", "rtps", "secured", "cli", "programs")
MOST = 40
MOST_IN = {"rtps/participant": 30}


def without_comments(text):
    pattern = r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:\\\n|[^\n])*'
    return re.sub(pattern, lambda m: '""' if m[0][0] == '"' else "0" if m[0][0] == "'" else " ", text,
                  flags=re.S | re.M)


def closing(text, at):
    """Where the brace at `at` is closed."""
    depth = 0
    for i in range(at, len(text)):
        depth += {"{": 1, "}": -1}.get(text[i], 0)
        if depth == 0:
            return i
    return len(text)


def statements(body):
    """Each member's declaration without its body, and the body if it has one."""
    start = i = parens = 0
    while i < len(body):
        char = body[i]
        parens += {"(": 1, ")": -1}.get(char, 0)
        head = body[start:i].strip()
        if char == "{" and parens == 0:
            end = closing(body, i)
            is_type = re.match(r"(template\s*<.*>\s*)?(class|struct|union|enum)\b", head)
            in_list = re.search(r"\)[\w\s]*:(?!:)", head)
            starts_body = head.endswith((")", "}")) if in_list else has_parameters(head)
            if is_type or starts_body:
                yield head, body[i + 1:end]
                start = end + 1
            i = end
        elif char == ";" and parens == 0:
            yield head, ""
            start = i + 1
        i += 1


def has_parameters(declaration):
    """Does it declare a function: a list in parentheses outside of template arguments?"""
    text = re.sub(r"\b(public|protected|private)\s*:", "", declaration)
    text = re.sub(r"\b(alignas|decltype|noexcept|requires|explicit)\s*\([^()]*\)", "", text)
    if "operator" in text:
        return True
    text = text.split("{")[0]
    depth = 0
    for i, char in enumerate(text):
        if char == "<" and i and (text[i - 1].isalnum() or text[i - 1] == "_"):
            depth += 1
        elif char == ">" and depth:
            depth -= 1
        elif char == "=" and depth == 0:
            return False
        elif char == "(" and depth == 0:
            return True
    return False


def classes(text, with_overrides=True):
    """Pairs of a class's name and the number of its methods."""
    for match in re.finditer(r"\b(?<!enum )(class|struct)\s+(?:alignas\([^)]*\)\s*)?([\w:]+)[^;{}()=]*\{", text):
        body = text[match.end():closing(text, match.end() - 1)]
        methods = 0
        for head, _ in statements(body):
            head = re.sub(r"^((public|protected|private)\s*:\s*)+", "", head)
            head = re.sub(r"^template\s*<[^;{]*?>\s*(?=[\w~\[:])", "", head)
            skipped = re.match(r"(using|typedef|friend|static_assert|enum|class|struct|union)\b", head)
            imposed = not with_overrides and re.search(r"\boverride$", head)
            if not skipped and not imposed and not re.search(r"=\s*delete$", head) and has_parameters(head):
                methods += 1
        yield match[2], methods


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    files = sorted(file for folder in FOLDERS for file in (root / folder).rglob("*.[ch]pp"))
    found, counted = [], 0
    for file in files:
        name = file.relative_to(root).as_posix()
        most = next((number for folder, number in MOST_IN.items() if name.startswith(folder + "/")), MOST)
        for label, methods in classes(without_comments(file.read_text(encoding="utf-8")), not name.startswith("plugins/")):
            counted += 1
            if "--list" in sys.argv:
                print(f"{methods:4} {label} ({name})")
            if methods > most:
                found.append(f"{name}: {label} has {methods} methods, and may have {most}")
    print("\n".join(found) if found else f"{counted} classes have few enough methods")
    return 1 if found or not counted else 0


if __name__ == "__main__":
    sys.exit(main())

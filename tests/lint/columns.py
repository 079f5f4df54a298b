#!/usr/bin/env python3
"""Holds the lines of C++ sources, of CMake files and of pages to 120 columns, and comments to their wrapping.

Exit 1 and a line for each fault.

Exempt are rows of tables, commands and output (between ```), lines of one link or one command, and what others wrote
(tests/data). A comment is wrapped badly if a line of it ends inside a sentence although the next word has room within
90 columns. The layout has 100, so a short line is what an edit left behind. "clause 9.8" counts as one word.
Usage: columns.py ROOT [--write]     --write wraps the paragraphs of pages instead of complaining.
"""

import pathlib
import re
import subprocess
import sys
import textwrap

MOST_COLUMNS = 120
COMMENT_COLUMNS = 90
CODE = {".cpp", ".hpp", ".c", ".h"}
LEFT_OUT = ("tests/data/", "LICENSES/")

BLOCK = re.compile(r"\s*([-*+] |\d+\. |[|#>]|```|<!--|\[\^)")  # the start of a block, after any line
ALONE = re.compile(r"\s*([-*] )?(\[[^\]]*\]\(\S+\)|`[^`]+`)[.,;]?$|    ")  # one link or command, or shown text


COMMENT = re.compile(r"(.*?)(//[/<]*) (\S.*)$")
# The end of a sentence or of a line of its own, such as one of a synopsis.
END = re.compile(r"[.:;?!\])\"'`]$")
# A list, a command of Doxygen, a directive of a tool, or a word of a synopsis (KEY=VALUE, A|B, [OPTION]).
OWN_LINE = re.compile(r"[-*+|@\[] ?|\d+\. |NOLINT|clang-format|\S*[=|]")
WORD = re.compile(r"(?:(?:clauses?|and) (?=\d))?\S+")


def short_comments(lines):
    """The places of lines in comments that end inside a sentence and too early, from 0."""
    for place, (line, following) in enumerate(zip(lines, lines[1:])):
        first, second = COMMENT.match(line), COMMENT.match(following)
        if not first or not second or second[1].strip() or len(first[1]) != len(second[1]) or first[2] != second[2]:
            continue
        if not END.search(first[3]) and not OWN_LINE.match(second[3]):
            if len(line) + 1 + len(WORD.match(second[3])[0]) <= COMMENT_COLUMNS:
                yield place


def long_lines(lines, is_page):
    """The places of lines that are too long, from 0."""
    is_shown = False
    for place, line in enumerate(lines):
        is_fence = line.lstrip().startswith("```")
        is_shown ^= is_fence
        if len(line) <= MOST_COLUMNS:
            continue
        if not is_page or not (is_shown or is_fence or line.lstrip().startswith("|") or ALONE.match(line)):
            yield place


def wrapped(lines):
    """The same lines, with each paragraph wrapped from its first line that is too long."""
    while (place := next(long_lines(lines, True), None)) is not None:
        end = place + 1
        while end < len(lines) and lines[end].strip() and not BLOCK.match(lines[end]):
            end += 1
        marker = re.match(r"\s*([-*+] |\d+\. )?", lines[place])[0]
        text = " ".join(line.strip() for line in lines[place:end])
        text = re.sub(r"`[^`]+`", lambda span: span[0].replace(" ", "\0"), text)  # a command stays on one line
        out = textwrap.wrap(text, MOST_COLUMNS, initial_indent=" " * (len(marker) - len(marker.lstrip())),
                            subsequent_indent=" " * len(marker), break_long_words=False, break_on_hyphens=False)
        out = [line.replace("\0", " ") for line in out]
        if any(True for _ in long_lines(out, True)) or any(BLOCK.match(line) for line in out[1:]):
            sys.exit(f"wrap this by hand: {lines[place][:70]}...")
        lines = lines[:place] + out + lines[end:]
    return lines


def main():
    root, faults = pathlib.Path(sys.argv[1]), 0
    names = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True, check=True).stdout.split()
    for name in names:
        path = root / name
        is_page = path.suffix == ".md"
        is_cmake = path.suffix == ".cmake" or path.name == "CMakeLists.txt"
        if not (is_page or is_cmake or path.suffix in CODE) or name.startswith(LEFT_OUT) or not path.is_file():
            continue
        lines = path.read_text(encoding="utf-8").split("\n")
        if is_page and "--write" in sys.argv[2:] and any(True for _ in long_lines(lines, True)):
            lines = wrapped(lines)
            path.write_text("\n".join(lines), encoding="utf-8")
        for place in long_lines(lines, is_page):
            print(f"{name}:{place + 1}: {len(lines[place])} columns, more than {MOST_COLUMNS}")
            faults += 1
        for place in short_comments(lines) if path.suffix in CODE else ():
            print(f"{name}:{place + 1}: the comment is wrapped badly: the next word has room")
            faults += 1
    print(f"{faults} lines are too long or too short" if faults else f"no line has more than {MOST_COLUMNS} columns")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

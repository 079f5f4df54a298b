#!/usr/bin/env python3
"""Keeps out words and sentences that readers stumble over, in what people read.

- Everywhere but in tests: pronouns without a subject ("somebody", "whoever") and unusual verbs ("foretell", "belong into"),
  also as a part of an identifier ("by_anybody").
- In README.md, SECURITY.md and docs/: sentences of more than 45 words.

Exit 1 and a line for each place. Name the subject: "an attacker", "a participant without a certificate".
"""

import pathlib
import re
import subprocess
import sys

WORDS = re.compile(r"\b(somebody|nobody|anybody|everybody|whoever|whom|whomever|foretells?|foretold|mends?|mended"
                   r"|all the same|belongs? into)\b|(?-i:\b(Who (?:is|has))\b(?![^.!|]*\?))", re.I)
SOURCES = {".cpp", ".hpp", ".h", ".c", ".def", ".cmake", ".md", ".sh", ".txt", ".idl", ".py", ".yml"}
TEST_NAME = re.compile(r"\b[A-Z]\w*[./][A-Z]\w*_\w+")  # pages name tests as they are
# Tests quote what others write, and licences are not ours.
LEFT_OUT = ("tests/", "LICENSES/")
ALLOWED = {
    "docs/contributing.md": "names the words that it forbids",
}
MOST_WORDS = 45
PAGES = re.compile(r"^(README\.md|SECURITY\.md|docs/[\w-]+\.md)$")


def words_of(line):
    """The refused words, also those within identifiers: by_anybody is read as "by anybody", kSomebody as "k Somebody"."""
    line = TEST_NAME.sub("", line)
    line = re.sub(r"_|(?<=[a-z0-9])(?=[A-Z])|(?=[A-Z][a-z])", " ", line)
    return [found[0] for found in WORDS.finditer(line)]


def prose(markdown):
    """The running text of a page, a paragraph or list item or table cell at a time, with its line."""
    markdown = re.sub(r"```.*?```|^    .*$|<!--.*?-->", lambda m: "\n" * m[0].count("\n"), markdown, flags=re.S | re.M)
    start, block = 1, []
    for number, line in enumerate(markdown.split("\n") + [""], 1):
        ends = not line.strip() or re.match(r"\s*([-*#|]|\d+\.|\[\^)", line)
        if ends and block:
            yield start, " ".join(block)
            block = []
        if line.lstrip().startswith("|"):
            yield from ((number, cell) for cell in line.split("|"))
        elif line.strip():
            start, block = (number if not block else start), [*block, line.strip()]


def long_sentences(markdown):
    for number, text in prose(markdown):
        text = re.sub(r"`[^`]*`", "code", re.sub(r"\]\([^)]*\)", "]", text))
        for sentence in re.split(r"(?<=[.:;?!])\s+", text):
            words = len(re.findall(r"[\w'-]+", sentence))
            if words > MOST_WORDS:
                yield number, words, sentence


def main():
    root = pathlib.Path(sys.argv[1])
    names = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True, check=True).stdout.split()
    faults = 0
    for name in names:
        path = root / name
        if path.suffix not in SOURCES or name.startswith(LEFT_OUT) or not path.is_file():
            continue
        text = path.read_text(encoding="utf-8")
        if name not in ALLOWED:
            for number, line in enumerate(text.split("\n"), 1):
                for found in words_of(line):
                    print(f'{name}:{number}: "{found}": name the subject, or use the usual word')
                    faults += 1
        if PAGES.match(name):
            for number, words, sentence in long_sentences(text):
                print(f"{name}:{number}: a sentence of {words} words: {sentence[:70]}...")
                faults += 1
    print(f"{faults} places" if faults else "no place where a reader would stumble over these")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Keeps out words and sentences that readers stumble over, in what people read.

- Everywhere: pronouns without a subject ("somebody", "whoever") and unusual verbs ("foretell", "belong into"), also as a
  part of an identifier ("by_anybody"). In tests, which quote what others write, only comments and docstrings count.
- In comments of tests: history ("Before: ..."), and numbers of attacks in a file that does not name docs/attacks.md.
- In README.md, SECURITY.md and docs/: sentences of more than 45 words.
- There, in docs/attacks/, in README.md of each folder and in comments of C++: literal translations (TRANSLATED), with what
  to write instead. Not in pages that are generated from texts of the tool, nor in docs/history.md, which has former names.
- In docs/attacks/: "before the fix", because a page says what holds now.

Exit 1 and a line for each place. Name the subject: "an attacker", "a participant without a certificate"; a question may
begin with "Who is". Write "predict" for "foretell", "fix" or "repair" for "mend", "still" for "all the same", "belong in"
for "belong into". A colon or a semicolon ends a sentence when words are counted.
"""

import ast
import io
import pathlib
import re
import subprocess
import sys
import tokenize

WORDS = re.compile(r"\b(somebody|nobody|anybody|everybody|whoever|whom|whomever|foretells?|foretold|mends?|mended"
                   r"|all the same|belongs? into)\b|(?-i:\b(Who (?:is|has))\b(?![^.!|]*\?))", re.I)
SOURCES = {".cpp", ".hpp", ".h", ".c", ".def", ".cmake", ".md", ".sh", ".txt", ".idl", ".py", ".yml"}
TEST_NAME = re.compile(r"\b[A-Z]\w*[./][A-Z]\w*_\w+")  # pages name tests as they are
# What others wrote.
LEFT_OUT = ("tests/data/", "LICENSES/")
ALLOWED = {
    "docs/contributing.md": "names the words that it forbids",
    "tests/lint/prose.py": "names the words that it forbids",
    "tests/interop/insider/insider.cpp": "one of the tamperings is called nobody",
}
C_FAMILY = {".cpp", ".hpp", ".h", ".c", ".idl"}
HISTORY = re.compile(r"\bBefore:|\b[Bb]efore the fix\b")
ATTACK = re.compile(r"\bT[1-9]\d?\b")
MOST_WORDS = 45
TRANSLATED = {
    r"anew": "again",
    r"farewells?": "dispose announcement",
    r"go(es)? by UDP": "is sent over UDP",
    r"counts? for nothing": "is ignored",
    r"(does|did|do) nothing else": "is idle, or: only",
    r"met more slowly": "discovered more slowly",
    r"in truth": "really",
    r"[Bb]efore the fix": "what holds now",
}
NOT_TRANSLATED = {"docs/codes.md", "docs/rules.md", "docs/history.md", "docs/contributing.md", "docs/README.md", "cli/README.md"}
PAGES = re.compile(r"^(README\.md|SECURITY\.md|docs/[\w-]+\.md)$")


def words_of(line):
    """The refused words, also those within identifiers: by_anybody is read as "by anybody", kSomebody as "k Somebody"."""
    line = TEST_NAME.sub("", line)
    line = re.sub(r"_|(?<=[a-z0-9])(?=[A-Z])|(?=[A-Z][a-z])", " ", line)
    return [found[0] for found in WORDS.finditer(line)]


def python_comments(text):
    """Pairs of a line and its comment, and of the first line and each line of a docstring."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node):
            first = node.body[0].lineno
            yield from enumerate(node.body[0].value.value.split("\n"), first)


def comments(path, text):
    """Pairs of a line of a test and what is a comment in it; whole lines of pages."""
    if path.suffix == ".py":
        yield from python_comments(text)
        return
    mark = r"(?<!:)//.*" if path.suffix in C_FAMILY else r".*" if path.suffix == ".md" else r"(?:^|\s)#.*"
    for number, line in enumerate(text.split("\n"), 1):
        found = re.search(mark, line)
        if found:
            yield number, found[0]


def unclear_comments(lines, text):
    """Lines of comments that tell history, or name an attack whose page the file does not name."""
    for number, line in lines:
        if HISTORY.search(line):
            yield number, "say what the test guards, not what was wrong before"
        if ATTACK.search(line) and "docs/attacks.md" not in text:
            yield number, f'"{ATTACK.search(line)[0]}": name docs/attacks.md once in this file'


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


def translated(name, text):
    """Pairs of a line of a page and what is wrong with it."""
    if name.endswith((".hpp", ".cpp")):
        lines = comments(pathlib.PurePath(name), text)
    elif PAGES.match(name) or name.startswith("docs/attacks/") or name.endswith("README.md"):
        lines = enumerate(text.split("\n"), 1)
    else:
        return
    if name in NOT_TRANSLATED:
        return
    for number, line in lines:
        line = re.sub(r"`[^`]*`", "", line)
        for words, instead in TRANSLATED.items():
            if found := re.search(rf"\b{words}\b", line):
                yield number, f'"{found[0]}": write "{instead}"'


def main():
    root = pathlib.Path(sys.argv[1])
    names = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True, check=True).stdout.split()
    faults = 0
    for name in names:
        path = root / name
        if path.suffix not in SOURCES or name.startswith(LEFT_OUT) or not path.is_file():
            continue
        text = path.read_text(encoding="utf-8")
        lines = list(comments(path, text) if name.startswith("tests/") else enumerate(text.split("\n"), 1))
        if name not in ALLOWED:
            for number, line in lines:
                for found in words_of(line):
                    print(f'{name}:{number}: "{found}": name the subject, or use the usual word')
                    faults += 1
            if name.startswith("tests/") and path.suffix != ".md":
                for number, fault in unclear_comments(lines, text):
                    print(f"{name}:{number}: {fault}")
                    faults += 1
        for number, fault in translated(name, text):
            print(f"{name}:{number}: {fault}")
            faults += 1
        if PAGES.match(name):
            for number, words, sentence in long_sentences(text):
                print(f"{name}:{number}: a sentence of {words} words: {sentence[:70]}...")
                faults += 1
    print(f"{faults} places" if faults else "no place where a reader would stumble over these")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Holds the README of each folder to the files of the folder.

- Each source file that a README names in backticks exists, beside the README or from the root: `crl.hpp`, `codes/*.def`.
- So does each name without an ending in a column "file" or "header" of a table: `crl` is crl.hpp, crl.cpp or crl.def.
- Each type that a README names in backticks (`ChainVerifier`) is a word of the sources.
- Each header is named in the nearest README at or above its folder, except in those of PAGES_FOR_USERS and CLASSES_INSTEAD.

Exit 1 and a line for each fault.
"""

import pathlib
import posixpath
import re
import subprocess
import sys

NOT_OURS = ("tests/data/",)
# Pages about the use of a program, which do not describe its code.
PAGES_FOR_USERS = {"cli/README.md", "idl/README.md", "examples/README.md", "programs/keeper/README.md", "programs/peer/README.md",
                   "programs/shapes/README.md"}
# It names the classes of each folder. The header of a class has the class's name (type_names.py).
CLASSES_INSTEAD = {"rtps/README.md"}
NO_PAGE_OF_CODE = PAGES_FOR_USERS | CLASSES_INSTEAD

SOURCE = re.compile(r"[\w./*-]+\.(?:hpp|cpp|def|py|sh|cmake)")
BARE = re.compile(r"(?:[a-z0-9_]+/)*[a-z][a-z0-9_]*")
TYPE = re.compile(r"[A-Z][a-z]\w*")
SPAN = re.compile(r"`([^`\n]+)`")
FILE_COLUMN = re.compile(r"(?:source )?(?:file|header)s?\b")
ENDINGS = (".hpp", ".cpp", ".def", "")
PLACEHOLDER = re.compile(r"[A-Z]{4}")  # FILE.hpp, NAME_test.py


def tables(markdown):
    """(line number, cells, headings) of each row of each table."""
    headings = None
    for number, line in enumerate(markdown.split("\n"), 1):
        if not line.startswith("|"):
            headings = None
            continue
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if headings is None:
            headings = cells
        elif not set(line) <= set("|-: "):
            yield number, cells, headings


class Tree:
    """The tracked files, and the words of the sources."""

    def __init__(self, root):
        listed = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True, check=True).stdout
        self.root = root
        self.files = {name for name in listed.split() if (root / name).is_file()}
        self.words = set()
        for name in self.files:
            if name.endswith((".hpp", ".cpp", ".c", ".h", ".py")) and not name.startswith(NOT_OURS) and name != "tests/lint/readmes.py":
                self.words.update(re.findall(r"\w+", (root / name).read_text(encoding="utf-8")))

    def readmes(self):
        return sorted(name for name in self.files if pathlib.PurePath(name).name == "README.md" and not name.startswith(NOT_OURS))

    def found(self, page, name):
        """The files that a name in a page can mean."""
        places = {posixpath.normpath(posixpath.join(posixpath.dirname(page), name)), name}
        if "*" in name:
            return {file for file in self.files for place in places if matches(file, place)}
        return places & self.files

    def found_bare(self, page, name):
        return {file for ending in ENDINGS for file in self.found(page, name + ending)}


def matches(file, place):
    return re.fullmatch(re.escape(place).replace(r"\*", "[^/]*"), file) is not None


def faults_of_names(tree, page, markdown):
    for number, line in enumerate(markdown.split("\n"), 1):
        for name in SPAN.findall(line):
            if SOURCE.fullmatch(name) and not PLACEHOLDER.search(name) and not tree.found(page, name):
                yield number, f"there is no file {name}"
            elif page not in PAGES_FOR_USERS and TYPE.fullmatch(name) and name not in tree.words:
                yield number, f"no source has the word {name}"
    for number, cells, headings in tables(markdown):
        for cell, heading in zip(cells, headings):
            for name in SPAN.findall(cell) if FILE_COLUMN.match(heading) else ():
                if BARE.fullmatch(name) and not tree.found_bare(page, name):
                    yield number, f"there is no file {name}, with or without .hpp, .cpp or .def"


def named_headers(tree, page, markdown):
    for name in SPAN.findall(markdown):
        if SOURCE.fullmatch(name):
            yield from tree.found(page, name)
        elif BARE.fullmatch(name):
            yield from tree.found_bare(page, name)


def page_of(header, pages):
    """The nearest README at or above the header's folder."""
    for folder in pathlib.PurePath(header).parents:
        page = (folder / "README.md").as_posix()
        if page in pages:
            return page
    return None


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    tree = Tree(root)
    pages = {name: re.sub(r"^```.*?^```", lambda m: "\n" * m[0].count("\n"), (root / name).read_text(encoding="utf-8"), flags=re.S | re.M)
             for name in tree.readmes()}
    found = [f"{page}:{number}: {fault}" for page, markdown in pages.items() for number, fault in faults_of_names(tree, page, markdown)]
    named = {page: set(named_headers(tree, page, markdown)) for page, markdown in pages.items()}
    headers = [name for name in sorted(tree.files) if name.endswith(".hpp") and not name.startswith("tests/")]
    for header in headers:
        page = page_of(header, pages)
        if page == "README.md":
            found.append(f"{header}: its folder has no README")
        elif page not in NO_PAGE_OF_CODE and header not in named[page]:
            found.append(f"{page}: it does not name {header}")
    print("\n".join(found) if found else f"{len(pages)} READMEs name what is there")
    return 1 if found or not headers else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Says of each commit whether it changes comments, docstrings and pages only, and names the other files that it changes.

Files of C and C++ are compared by their tokens without comments, Python by its syntax tree without docstrings, and other
files by their lines without what follows "#". A file that is added, removed or renamed is named, except a page (.md).
Usage: scripts/comments_only.py RANGE     as for git log, such as origin/main..HEAD. Exit 1 if a commit changes more.
"""

import ast
import re
import subprocess
import sys

TOKEN = re.compile(r'R"(?P<end>\w*)\((?:.|\n)*?\)(?P=end)"|"(?:\\.|[^"\\\n])*"|\d[\w\']*|\'(?:\\.|[^\'\\\n])*\''
                   r"|//[^\n]*|/\*(?:.|\n)*?\*/|\w+|[^\s\w]")
C_LIKE = (".cpp", ".hpp", ".c", ".h", ".def", ".idl")


def git(*words):
    return subprocess.run(["git", *words], capture_output=True, text=True, errors="replace", check=True).stdout


def of_c(text):
    return [found[0] for found in TOKEN.finditer(text) if not found[0].startswith(("//", "/*"))]


def of_python(text):
    tree = ast.parse(text)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        first = body[0] if isinstance(body, list) and body else None
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str):
            first.value.value = ""
    return ast.dump(tree)


def of_others(text):
    lines = (re.sub(r"(^|\s)#.*", "", line).strip() for line in text.splitlines())
    return [line for line in lines if line]


def meaning(name, text):
    if name.endswith(C_LIKE):
        return of_c(text)
    return of_python(text) if name.endswith(".py") else of_others(text)


def other_changes(commit):
    """The files in which the commit changes more than comments."""
    for row in git("show", "--format=", "--name-status", "--no-renames", commit).splitlines():
        kind, name = row.split("\t")
        if name.endswith(".md"):
            continue
        if kind != "M" or meaning(name, git("show", f"{commit}~1:{name}")) != meaning(name, git("show", f"{commit}:{name}")):
            yield name


def main():
    commits = git("rev-list", "--no-merges", "--reverse", *sys.argv[1:]).split()
    found = 0
    for commit in commits:
        names = list(other_changes(commit))
        if names:
            found += 1
            more = f" and {len(names) - 4} more" if len(names) > 4 else ""
            print(f"{git('log', '-1', '--format=%h %s', commit).strip()}: {', '.join(names[:4])}{more}")
    print(f"{len(commits) - found} of {len(commits)} commits change comments and pages only")
    return 1 if found or not commits else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""No Python class or module defines a function twice: the first would never run, and if it is a test, test nothing.

Usage: twice.py SOURCE_FOLDER
"""

import ast
import collections
import pathlib
import sys

IS_FUNCTION = (ast.FunctionDef, ast.AsyncFunctionDef)


def twice_in(tree):
    """(line, name) of each function that replaces an earlier one of the same body."""
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef)):
            seen = collections.Counter()
            for one in node.body:
                if isinstance(one, IS_FUNCTION) and not one.decorator_list:
                    seen[one.name] += 1
                    if seen[one.name] > 1:
                        yield one.lineno, one.name


def main():
    root = pathlib.Path(sys.argv[1])
    files = [file for file in sorted(root.rglob("*.py")) if "build" not in file.relative_to(root).parts]
    found = [f"{file.relative_to(root)}:{line}: {name} is defined twice"
             for file in files for line, name in twice_in(ast.parse(file.read_text()))]
    print("\n".join(found) or f"{len(files)} files define each function once")
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main())

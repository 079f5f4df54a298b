#!/usr/bin/env python3
"""Holds the lists of cmake/public_headers.cmake to what is installed, and the API to its comments.

- Each installed header exists once in the lists, and includes only installed ones.
- Each header of the second list is included by an installed one.
- A public header has a comment at its top, and a /// comment at each function that is not obvious: not at
  constructors, destructors, operators, overrides, friends, or functions that return a member or a constant.
  A comment counts for the functions that follow it without an empty line.
- Each public class, struct and enumeration has one, too, but for declarations and specializations. It counts for the
  types of one line each that follow it without an empty line.
Exit 1 and a line for each that does not.
"""

import pathlib
import re
import sys

SET = re.compile(r"set\((DDSSEC_\w+_HEADERS)\n(.*?)\)\n", re.S)
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.M)
FUNCTION = re.compile(r"^(?:  )?(?! |return|using|friend|explicit|typedef|#|static_assert|if|for|while)"
                      r"[\w:<>,&*\[\] ]+?[ &*](\w+)\(")
TYPE = re.compile(r"^(?:  )?(?:struct|class|enum|enum class) (?:\[\[\w+\]\] )?(\w+)(?![\w<]).*[^;]$"
                  r"|^(?:  )?(?:struct|class|enum|enum class) (?:\[\[\w+\]\] )?(\w+)(?![\w<]).*\};$")
HIDDEN = re.compile(r"^ (private|protected):")
SHOWN = re.compile(r"^ public:|^(class|struct|enum|template)\b")


def lists(text):
    return {name: re.sub(r"#[^\n]*", "", body).split() for name, body in SET.findall(text)}


def numbered_lines(text):
    """The number of each line, the line, and whether a user of the header does not see it."""
    private, nested = False, False
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("namespace detail"):
            nested = True
        elif line.startswith("}  // namespace detail"):
            nested = False
        elif HIDDEN.match(line):
            private = True
        elif SHOWN.match(line):
            private = False
        yield number, line, private or nested


def uncommented(text):
    """The line and name of each public function without a comment of its group."""
    commented = False
    for number, line, hidden in numbered_lines(text):
        stripped = line.strip()
        if not stripped or line.startswith((" public:", "class ", "struct ", "};")):
            commented = False
        if stripped.startswith("///"):
            commented = True
        if commented or hidden or stripped.startswith("//"):
            continue
        found = FUNCTION.match(line)
        if found and not trivial(line, found[1]):
            yield number, found[1]


def uncommented_types(text):
    """The line and name of each public type without a comment of its group."""
    commented = False
    for number, line, hidden in numbered_lines(text):
        stripped = line.strip()
        found = TYPE.match(line)
        if stripped.startswith("///"):
            commented = True
        elif found:
            if not (commented or hidden):
                yield number, found[1] or found[2]
            commented = commented and stripped.endswith("};")
        elif not stripped.startswith(("template", "typename")):
            commented = False


def trivial(line, name):
    return ("override" in line or "operator" in line or "= delete" in line or "~" in line or name.isupper()
            or re.search(r"const( noexcept)? \{ return [^(){}]*(\(\))?; \}$", line) is not None
            or "constexpr" in line and "operator" in line)


def complaints(root):
    found = lists((root / "cmake/public_headers.cmake").read_text(encoding="utf-8"))
    public, carried = found["DDSSEC_PUBLIC_HEADERS"], found["DDSSEC_CARRIED_HEADERS"]
    installed = public + carried
    for name in sorted({one for one in installed if installed.count(one) > 1}):
        yield f"cmake/public_headers.cmake: {name} stands there twice"
    included = set()
    for name in installed:
        if not (root / name).is_file():
            yield f"cmake/public_headers.cmake: there is no {name}"
            continue
        text = (root / name).read_text(encoding="utf-8")
        for target in INCLUDE.findall(text):
            included.add(target)
            if target not in installed:
                yield f"{name}: is installed, but {target} is not (cmake/public_headers.cmake)"
        if name in public:
            if not text.startswith("//"):
                yield f"{name}:1: no comment says what the header is for"
            for line, function in uncommented(text):
                yield f"{name}:{line}: no /// comment: {function}"
            for line, kind in uncommented_types(text):
                yield f"{name}:{line}: no /// comment for the type: {kind}"
    for name in carried:
        if name not in included:
            yield f"cmake/public_headers.cmake: no installed header includes {name}"


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    lines = list(complaints(root))
    print("\n".join(lines) if lines else "the installed headers are complete, and the public ones commented")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())

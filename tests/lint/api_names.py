#!/usr/bin/env python3
"""Names of the C++ API at the last release must exist, or docs/cpp-names.md or [Unreleased] of CHANGELOG.md must name
them: users must learn what to rename. tests/lint/api_names.txt has the names of that release; a name is that of a namespace's or type's public
function, member, type or constant in the first list of cmake/public_headers.cmake, such as `rtps::QosPreset::name`.
The other way round, each new name in the table of docs/cpp-names.md is a word in one of these headers, or a header.

Usage: api_names.py ROOT [--write]     --write makes the list anew, from the present headers: only at a release.
"""

import pathlib
import re
import sys

LIST = "tests/lint/api_names.txt"
TABLE = "docs/cpp-names.md"
HEAD = "# The names of the C++ API in ddssec {}; tests/lint/api_names.py makes and reads them."
HEADERS = re.compile(r"set\(DDSSEC_PUBLIC_HEADERS\n(.*?)\)\n", re.S)
SCOPE = re.compile(r"\b(namespace|class|struct|union|enum(?: class)?)\s+(?:\[\[\w+\]\]\s*)?(?:alignas\(\w+\)\s*)?([\w:]+)")
NO_NAME = {"if", "for", "while", "return", "static_assert", "alignas", "decltype", "noexcept", "requires", "operator"}


def plain(text):
    """The text without comments, literals, directives and attributes."""
    text = re.sub(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', " ", text, flags=re.S)
    text = re.sub(r"(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'", " ", text)
    return re.sub(r"\[\[.*?\]\]|^\s*#[^\n]*(?:\\\n[^\n]*)*", " ", text, flags=re.S | re.M)


def after_braces(text, place):
    """The place behind the brace that closes the one at `place`."""
    depth = 0
    for found in re.finditer(r"[{}]", text[place:]):
        depth += 1 if found[0] == "{" else -1
        if depth == 0:
            return place + found.end()
    return len(text)


def without_templates(statement):
    """Without what stands in angle brackets: template parameters and arguments."""
    while (shorter := re.sub(r"<[^<>]*>", " ", statement)) != statement:
        statement = shorter
    return statement


def declared(statement, scope):
    """The name that a statement declares in the scope, or None."""
    statement = re.sub(r"\b(public|private|protected)\s*:(?!:)", " ", statement).strip()
    statement = without_templates(statement)
    if not statement or re.match(r"(template\s*)?(friend|namespace|static_assert)\b", statement) or "operator" in statement:
        return None
    if alias := re.match(r"(?:template\s*)?using (\w+) =", statement):
        return alias[1]
    if statement.startswith("using"):
        return None
    call = re.match(r"[^=(]*?([~\w]+)\s*\(", statement)
    name = call[1] if call else (re.findall(r"\w+", re.split(r"[={\[]|(?<!:):(?!:)", statement)[0]) or [None])[-1]
    return None if name is None or name in NO_NAME or name == scope or "~" in name or name[0].isdigit() else name


class Names:
    """Collects the qualified names of headers."""

    def __init__(self):
        self.all = set()

    def read(self, text, scope, is_shown):
        """Reads the text of a scope: a tuple of names."""
        place, begin, end = 0, 0, len(text)
        while place < end:
            letter = text[place]
            if letter == ";":
                is_shown = shown_after(text[begin:place], is_shown)
                self.note(text[begin:place], scope, is_shown)
                begin = place = place + 1
            elif letter == "{":
                head, close = text[begin:place], after_braces(text, place)
                is_shown = shown_after(head, is_shown)
                opened = SCOPE.search(without_templates(head))
                if opened and "(" not in head and "=" not in head:
                    self.enter(opened, text[place + 1:close - 1], scope, is_shown)
                    begin = close
                elif "(" in without_templates(head).split("=")[0]:
                    self.note(head, scope, is_shown)
                    begin = close
                place = close
            elif letter == "(":
                place = after_parentheses(text, place)
            else:
                place += 1

    def enter(self, opened, body, scope, is_shown):
        kind, name = opened[1], opened[2]
        inner = (*scope, *name.split("::"))
        if name == "detail" or not is_shown:
            return
        if kind != "namespace":
            self.all.add("::".join(inner))
        if kind.startswith("enum"):
            for row in re.split(r",", re.sub(r"\([^()]*\)", "", body)):
                if found := re.match(r"\s*(\w+)", row):
                    self.all.add("::".join((*inner, found[1])))
        else:
            self.read(body, inner, kind != "class")

    def note(self, statement, scope, is_shown):
        if is_shown and (name := declared(statement, scope[-1] if scope else "")):
            self.all.add("::".join((*scope, name)))


def after_parentheses(text, place):
    depth = 0
    for found in re.finditer(r"[()]", text[place:]):
        depth += 1 if found[0] == "(" else -1
        if depth == 0:
            return place + found.end()
    return len(text)


def shown_after(statement, is_shown):
    labels = re.findall(r"\b(public|private|protected)\s*:(?!:)", statement)
    return labels[-1] == "public" if labels else is_shown


def headers(root):
    listed = HEADERS.search((root / "cmake/public_headers.cmake").read_text(encoding="utf-8"))[1]
    return re.sub(r"#[^\n]*", "", listed).split()


def api(root):
    names = Names()
    for header in headers(root):
        names.read(plain((root / header).read_text(encoding="utf-8")), (), True)
    return {name.removeprefix("ddssec::") for name in names.all if name not in ("ddssec", "std")}


def unreleased(root):
    return re.search(r"^## \[Unreleased\]\n(.*?)(?=^## |\Z)", (root / "CHANGELOG.md").read_text(encoding="utf-8"), re.M | re.S)[1]


def renames(root):
    """The cells with the former and the new names in the table of renames."""
    rows = [line.split("|") for line in (root / TABLE).read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    return [(former, new) for _, former, new, *_ in rows]


def known_words(root):
    """The words in backticks in [Unreleased], and the former names of the table."""
    texts = [unreleased(root), *(former for former, _ in renames(root))]
    return {word for text in texts for span in re.findall(r"`([^`]+)`", text) for word in re.findall(r"\w+", span)}


def new_names(root):
    for _, new in renames(root):
        yield from re.findall(r"`([^`]+)`", new)


def false_renames(root):
    """A line for each new name that no public header has."""
    words = {word for header in headers(root)
             for word in re.findall(r"\w+", plain((root / header).read_text(encoding="utf-8")))}
    for name in new_names(root):
        if name.rpartition("::")[2] not in words and not (root / name).is_file():
            yield f"{TABLE} has the new name {name}, and no public header has it"


def faults(root, version):
    head, *released = (root / LIST).read_text(encoding="utf-8").splitlines()
    if head != HEAD.format(version):
        yield f"{LIST} is not that of {version}: at a release, make it with tests/lint/api_names.py . --write"
        return
    present, words = api(root), known_words(root)
    gone = set(released) - present
    for name in sorted(gone):
        is_of_another = name.rpartition("::")[0] in gone  # which is looked at by itself
        if not is_of_another and name.rpartition("::")[2] not in words:
            yield f"{name} was in {version} and is gone, and {TABLE} does not name it"
    yield from false_renames(root)
    if not present:
        yield "no name was found in the public headers: this test looks at nothing"


def main():
    root = pathlib.Path(sys.argv[1])
    version = re.search(r"project\(ddssec VERSION (\d+\.\d+\.\d+)", (root / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
    if "--write" in sys.argv[2:]:
        (root / LIST).write_text("\n".join([HEAD.format(version), *sorted(api(root))]) + "\n", encoding="utf-8")
    found = list(faults(root, version))
    print("\n".join(found) if found else f"the names of {version} exist, or {TABLE} says what became of them")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Holds docs/decisions to its form: each decision has a date and five labelled parts, in order; indexes name all.
A decision before NEEDS_ALL has What and Why at least: what it lacks was not written down at the time.

Usage: decisions.py ROOT [--write]     --write brings the indexes up to date instead of complaining.
Exit 1 and a line for each fault.
"""

import datetime
import pathlib
import re
import sys

LABELS = ["What", "Why", "Instead", "Cost", "Again when"]
NEEDS_ALL = "2026-12-01"
LABEL = re.compile(r"^- (What|Why|Instead|Cost|Again when):(.*)$", re.M)
TITLE = re.compile(r"(.+) \((\d{4}-\d{2}-\d{2})\)")
BEGIN, END = "<!-- index -->\n", "<!-- end of index -->\n"
AREA = "# Decisions: "


def anchor(heading):
    """What a link to `heading` ends with, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def decisions(text):
    """(line, heading, body) of each decision in the text of an area."""
    offset = text.index(END) + len(END)
    found = list(re.finditer(r"^## (.*)$", text[offset:], re.M))
    for at, match in enumerate(found):
        end = found[at + 1].start() if at + 1 < len(found) else None
        yield text.count("\n", 0, offset + match.start()) + 1, match[1], text[offset:][match.end():end]


def index_of_area(text):
    headings = [heading for _, heading, _ in decisions(text)]
    return "\n" + "".join(f"- [{TITLE.sub(chr(92) + '1', heading)}](#{anchor(heading)})\n" for heading in headings) + "\n"


def index_of_all(areas):
    out = "\n| area | decisions | last |\n|---|---|---|\n"
    for file, text in areas:
        titles = [TITLE.fullmatch(heading) for _, heading, _ in decisions(text)]
        area = text.splitlines()[0].removeprefix(AREA)
        last = max((title[2] for title in titles if title), default="")
        out += f"| [{area}]({file.name}) | {len(titles)} | {last} |\n"
    return out + "\n"


def is_date(text):
    try:
        return bool(datetime.date.fromisoformat(text))
    except ValueError:
        return False


def faults(name, text):
    titles = set()
    if not text.startswith(AREA):
        yield f"{name}:1: the first line does not begin with \"{AREA}\""
    for line, heading, body in decisions(text):
        where = f"{name}:{line}"
        title = TITLE.fullmatch(heading)
        if not title or not is_date(title[2]):
            yield f"{where}: the heading does not end with a date such as (2026-11-22)"
        if heading in titles:
            yield f"{where}: another decision has the same heading"
        titles.add(heading)
        labels = [label for label, _ in LABEL.findall(body)]
        is_old = bool(title) and title[2] < NEEDS_ALL
        if labels != [label for label in LABELS if label in labels or not is_old or label in LABELS[:2]]:
            yield f"{where}: it does not have {', '.join(LABELS)}, once each and in this order, as items of a list"
        for label in re.findall(r"^- (\w[\w ]{0,20}):", body, re.M):
            if label not in LABELS:
                yield f"{where}: {label} is none of the parts"
        if "None recorded" in body:
            yield f"{where}: \"None recorded\" says nothing"
        parts = LABEL.split(body)
        yield from (f"{where}: {label} is empty" for label, first, rest in zip(parts[1::3], parts[2::3], parts[3::3])
                    if not first.strip() and not rest.strip())
        if parts[0].strip():
            yield f"{where}: text stands before the first label"
    if not titles:
        yield f"{name}: there is no decision after the index"


def check_index(file, name, text, index, write):
    """A fault if the part between the marks is not `index`, unless it is written."""
    begin, end = text.index(BEGIN), text.index(END) + len(END)
    expected = BEGIN + index + END
    if text[begin:end] == expected:
        return []
    if not write:
        return [f"{name}: the index is not complete; run tests/lint/decisions.py . --write"]
    file.write_text(text[:begin] + expected + text[end:], encoding="utf-8")
    return []


def main():
    root, write = pathlib.Path(sys.argv[1]), "--write" in sys.argv[2:]
    files = sorted((root / "docs" / "decisions").glob("*.md"))
    texts = {file: file.read_text(encoding="utf-8") for file in files}
    names = {file: file.relative_to(root).as_posix() for file in files}
    found = [f"{names[file]}: the lines {BEGIN.strip()} and {END.strip()} around the index are missing"
             for file, text in texts.items() if BEGIN not in text or END not in text]
    if found or not files:
        print("\n".join(found) or "docs/decisions: there is no page")
        return 1
    areas = [(file, text) for file, text in texts.items() if file.name != "README.md"]
    for file, text in areas:
        found += [*faults(names[file], text), *check_index(file, names[file], text, index_of_area(text), write)]
    for file, text in texts.items():
        if file.name == "README.md":
            found += check_index(file, names[file], text, index_of_all(areas), write)
    count = sum(len(list(decisions(text))) for _, text in areas)
    print("\n".join(found) if found else f"{count} decisions have their form")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Holds DECISIONS.md to its form: each decision has a date and five labelled parts, in order, and the index names all.

Usage: decisions.py ROOT [--write]     --write brings the index up to date instead of complaining.
Exit 1 and a line for each fault.
"""

import datetime
import pathlib
import re
import sys

LABELS = ["What", "Why", "Instead", "Cost", "Again when"]
LABEL = re.compile(r"^- (What|Why|Instead|Cost|Again when):(.*)$", re.M)
TITLE = re.compile(r"(.+) \((\d{4}-\d{2}-\d{2})\)")
WITHOUT_DATE = r"\1"
BEGIN, END = "<!-- index -->\n", "<!-- end of index -->\n"


def anchor(heading):
    """What a link to `heading` ends with, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def sections(text):
    """(line, level, heading, body) of each heading after the index."""
    offset = text.index(END) + len(END)
    found = list(re.finditer(r"^(#{1,2}) (.*)$", text[offset:], re.M))
    for at, match in enumerate(found):
        end = found[at + 1].start() if at + 1 < len(found) else None
        line = text.count("\n", 0, offset + match.start()) + 1
        yield line, len(match[1]), match[2], text[offset:][match.end():end]


def index_of(text):
    """A table of the areas, and below it for each area a list of its decisions, which a forge shows folded."""
    areas = []
    for _, level, heading, _ in sections(text):
        if level == 1:
            areas.append((heading, []))
        elif areas:
            areas[-1][1].append(heading)
    out = BEGIN + "\n| area | decisions | last |\n|---|---|---|\n"
    for area, decisions in areas:
        last = max((title[2] for title in map(TITLE.fullmatch, decisions) if title), default="")
        out += f"| [{area}](#{anchor(area)}) | {len(decisions)} | {last} |\n"
    for area, decisions in areas:
        out += f"\n<details><summary>{area}: {len(decisions)} decisions</summary>\n\n"
        out += "".join(f"- [{TITLE.sub(WITHOUT_DATE, heading)}](#{anchor(heading)})\n" for heading in decisions)
        out += "\n</details>\n"
    return out + END


def is_date(text):
    try:
        return bool(datetime.date.fromisoformat(text))
    except ValueError:
        return False


def faults(text):
    titles, in_area = set(), False
    for line, level, heading, body in sections(text):
        where = f"DECISIONS.md:{line}"
        if level == 1:
            in_area = True
            continue
        if not in_area:
            yield f"{where}: no area (a heading with one #) stands before it"
        title = TITLE.fullmatch(heading)
        if not title or not is_date(title[2]):
            yield f"{where}: the heading does not end with a date such as (2026-11-22)"
        if heading in titles:
            yield f"{where}: another decision has the same heading"
        titles.add(heading)
        if [label for label, _ in LABEL.findall(body)] != LABELS:
            yield f"{where}: it does not have {', '.join(LABELS)}, once each and in this order, as items of a list"
        parts = LABEL.split(body)
        yield from (f"{where}: {label} is empty" for label, first, rest in zip(parts[1::3], parts[2::3], parts[3::3])
                    if not first.strip() and not rest.strip())
        if parts[0].strip():
            yield f"{where}: text stands before the first label"
    if not titles:
        yield "DECISIONS.md: there is no decision after the index"


def main():
    file = pathlib.Path(sys.argv[1]) / "DECISIONS.md"
    text = file.read_text(encoding="utf-8")
    if BEGIN not in text or END not in text:
        print(f"DECISIONS.md: the lines {BEGIN.strip()} and {END.strip()} around the index are missing")
        return 1
    found = list(faults(text))
    begin, end = text.index(BEGIN), text.index(END) + len(END)
    if text[begin:end] != index_of(text):
        if "--write" in sys.argv[2:]:
            file.write_text(text[:begin] + index_of(text) + text[end:], encoding="utf-8")
        else:
            found.append("DECISIONS.md: the index is not complete; run tests/lint/decisions.py . --write")
    print("\n".join(found) if found else f"{len([s for s in sections(text) if s[1] == 2])} decisions have their form")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

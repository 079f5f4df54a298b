"""Turns the members of a command's result, one line as the field lists make it, into nested lists of a page.

    `dir`, `cas` (each: `role`, `key` (null: none here; `mode`)); with --from: `file`

becomes a list with `dir`, and below `cas`, each: a list of its members. After "With --from:" a further list follows.
"""

import dataclasses
import textwrap

COLUMNS = 120
SHORT = 50  # a member of at most this many columns shares a line with its neighbours


@dataclasses.dataclass
class Member:
    text: str  # all of it, on one line
    name: str
    note: str = ""
    is_list: bool = False
    members: list = dataclasses.field(default_factory=list)


def closing(text, opening):
    """The place of the parenthesis that closes the one at `opening`."""
    depth = 0
    for place in range(opening, len(text)):
        depth += {"(": 1, ")": -1}.get(text[place], 0)
        if depth == 0:
            return place
    raise ValueError(f"no parenthesis closes: {text}")


def parts(text, mark):
    """The places of `mark` in the text, outside of parentheses."""
    depth = 0
    for place, letter in enumerate(text):
        depth += {"(": 1, ")": -1}.get(letter, 0)
        if depth == 0 and text.startswith(mark, place):
            yield place


def members_of(text):
    """The members of a list; ValueError if the text is none."""
    out = []
    while text:
        if not text.startswith("`"):
            raise ValueError(f"not a member: {text}")
        end = text.index("`", 1) + 1
        member = Member("", text[:end])
        if text.startswith(" (", end):
            close = closing(text, end + 1)
            member.note, member.is_list, member.members = inside(text[end + 2:close])
            end = close + 1
        member.text = text[:end]
        out.append(member)
        if text[end:end + 2] not in ("", ", "):
            raise ValueError(f"neither an end nor a comma: {text[end:]}")
        text = text[end + 2:]
    return out


def inside(text):
    """What stands in parentheses after a name: (note, whether it is a list, its members)."""
    for start in [0, *(place + 2 for place in parts(text, "; "))]:
        is_list = text.startswith("each: ", start)
        try:
            return text[:start].removesuffix("; "), is_list, members_of(text[start + 6 * is_list:])
        except ValueError:
            continue
    return text, False, []


def wrapped(text, depth):
    indent = "  " * depth
    return textwrap.fill(f"- {text}", COLUMNS, initial_indent=indent, subsequent_indent=indent + "  ",
                         break_long_words=False, break_on_hyphens=False)


def lines(members, depth=0):
    """The list, as lines of Markdown."""
    together = []
    for member in members:
        if len(member.text) <= SHORT:
            together.append(member.text)
            continue
        if together:
            yield wrapped(", ".join(together), depth)
            together = []
        if member.members:
            note = f" ({member.note})" if member.note else ""
            yield wrapped(f"{member.name}{note}{', each' if member.is_list else ''}:", depth)
            yield from lines(member.members, depth + 1)
        else:
            yield wrapped(member.text, depth)
    if together:
        yield wrapped(", ".join(together), depth)


def page_of(text):
    """The lists of a result: one, and a further one after each label, as in "; with --from: `file`"."""
    starts = [0, *(place + 2 for place in parts(text, "; ")), len(text) + 2]
    blocks = []
    for start, end in zip(starts, starts[1:]):
        part = text[start:end - 2]
        label = "" if part.startswith("`") else part[:part.index(": `") + 1]
        members = members_of(part[len(label):].strip())
        blocks.append((f"{label[0].upper()}{label[1:]}\n\n" if label else "") + "\n".join(lines(members)))
    return "\n\n".join(blocks) + "\n"

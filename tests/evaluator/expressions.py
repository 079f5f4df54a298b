"""Which names tell expressions apart: every combination of matches that any name can have, with the
shortest name that has it.

An expression becomes a row of tokens (sets of octets, and `*`). All names are then walked through at
once, as sets of positions within the rows, until no new set appears. So the list of combinations is
complete. What a bracket holds is asked of the C library, and every name found is given to the C
library's fnmatch() again: the walk and the library must agree.
"""

import ctypes
import functools
import locale
from collections import deque

locale.setlocale(locale.LC_ALL, "C")  # fnmatch() compares octets
_LIBC = ctypes.CDLL(None)
_LIBC.fnmatch.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_int]
FNM_PATHNAME, FNM_NOESCAPE = 1, 2

CLASSES = {b"alnum", b"alpha", b"blank", b"cntrl", b"digit", b"graph", b"lower", b"print", b"punct", b"space",
           b"upper", b"xdigit"}
STAR = -1
ALL = (1 << 256) - 2  # every octet but NUL
SLASH = 1 << ord("/")
MOST_STATES = 200_000
# What a name in a report should be made of, if it can be.
_READABLE = [sum(1 << c for c in group) for group in
             (b"abcdefghijklmnopqrstuvwxyz", b"0123456789", b"ABCDEFGHIJKLMNOPQRSTUVWXYZ", b"/_-. ",
              bytes(range(33, 127)))]


class Undefined(ValueError):
    """POSIX leaves the meaning of this expression open."""


def expression(text):
    """A name is matched by fnmatch() without flags."""
    return ("expression", text.encode(), 0)


def subject_value(text):
    """The value of an attribute in a subject_name_expression (10.4.1.5.3.2.1)."""
    return ("expression", text.encode(), FNM_PATHNAME | FNM_NOESCAPE)


def unescaped_expression(text):
    """As Fast DDS matches names."""
    return ("expression", text.encode(), FNM_NOESCAPE)


def cyclone_expression(text):
    """As Cyclone DDS 0.10.2 matches names (its ac_fnmatch)."""
    return ("cyclone", text.encode(), 0)


def literal(text):
    return ("literal", text.encode(), 0)


def _cyclone_bracket(text, at, octet):
    """(whether the bracket whose members begin at `at` takes the octet, what is behind it), or None:
    it is not closed."""
    negated = text[at:at + 1] == b"!"
    at += negated
    member = text[at:at + 1]
    found = False
    while member != b"]":
        member = text[at:at + 1]
        if not member:
            return None
        if text[at + 1:at + 2] == b"-":
            last = text[at + 2:at + 3]
            if last in (b"", b"]"):
                return None
            found |= member[0] <= octet <= last[0]
            at += 2
        else:
            found |= member[0] == octet
        at += 1
    return found != negated, at


def _cyclone_tokens(text):
    row, at = [], 0
    while at < len(text):
        mark = text[at:at + 1]
        at += 1
        if mark == b"*":
            if not row or row[-1] != STAR:
                row.append(STAR)
        elif mark == b"?":
            row.append(ALL)
        elif mark == b"[":
            answers = {octet: _cyclone_bracket(text, at, octet) for octet in range(1, 256)}
            if answers[1] is None:
                return None
            row.append(sum(1 << octet for octet, (takes, _) in answers.items() if takes))
            at = answers[1][1]
        else:
            row.append(1 << mark[0])
    return tuple(row)


def _cyclone_matches(row, name):
    """The product's own way: from left to right, a star by trying every length."""
    if row is None:
        return False
    if not row:
        return not name
    if row[0] == STAR:
        return any(_cyclone_matches(row[1:], name[at:]) for at in range(len(name) + 1))
    return bool(name) and bool(row[0] >> name[0] & 1) and _cyclone_matches(row[1:], name[1:])


def _class_end(text, at):
    """Behind `[:name:]` that begins at `at`, or None if it is no class."""
    end = text.find(b":]", at + 2)
    if end < 0 or not text[at + 2:end].isalpha():
        return None
    if text[at + 2:end] not in CLASSES:
        raise Undefined(text)
    return end + 2


def _element_end(text, at, escapes):
    """Behind one element of a bracket."""
    two = text[at:at + 2]
    if two == b"[:":
        return _class_end(text, at) or at + 1
    if two in (b"[.", b"[="):
        if len(text) < at + 5 or text[at + 3:at + 5] != two[1:] + b"]":
            raise Undefined(text)
        return at + 5
    if text[at:at + 1] == b"\\" and escapes:
        return at + 2
    return at + 1


def _bracket_end(text, at, flags):
    """Behind the bracket that begins at `at`; None if it is not closed."""
    escapes = not flags & FNM_NOESCAPE
    at += 2 if text[at + 1:at + 2] in (b"!", b"^") else 1
    first = True
    while at < len(text):
        if text[at:at + 1] == b"]" and not first:
            return at + 1
        was_class = text[at:at + 2] in (b"[:", b"[.", b"[=")
        if text[at:at + 1] == b"/" and flags & FNM_PATHNAME:
            raise Undefined(text)
        at = _element_end(text, at, escapes)
        if text[at:at + 1] == b"-" and text[at + 1:at + 2] not in (b"", b"]"):
            if was_class or text[at + 1:at + 2] == b"[":
                raise Undefined(text)
            at = _element_end(text, at + 1, escapes)
        first = False
    return None


@functools.lru_cache(maxsize=100_000)
def _octets_of(bracket, flags):
    """What the bracket holds, by the C library."""
    return sum(1 << octet for octet in range(1, 256)
               if _LIBC.fnmatch(bracket, bytes([octet]), flags) == 0)


@functools.lru_cache(maxsize=100_000)
def tokens(item):
    """The item as a row of sets of octets and STAR; None if it matches nothing at all."""
    kind, text, flags = item
    if kind == "literal":
        return tuple(1 << octet for octet in text)
    if kind == "cyclone":
        return _cyclone_tokens(text)
    row, at = [], 0
    every = ALL & ~SLASH if flags & FNM_PATHNAME else ALL
    while at < len(text):
        mark = text[at:at + 1]
        if mark == b"*":
            if not row or row[-1] != STAR:
                row.append(STAR)
        elif mark == b"?":
            row.append(every)
        elif mark == b"\\" and not flags & FNM_NOESCAPE:
            at += 1
            if at == len(text):
                return None
            row.append(1 << text[at])
        elif mark == b"[":
            end = _bracket_end(text, at, flags)
            if end is None and text.endswith(b"\\") and not flags & FNM_NOESCAPE:
                raise Undefined(text)
            row.append(1 << text[at] if end is None else _octets_of(text[at:end], flags))
            at = end - 1 if end else at
        else:
            row.append(1 << text[at])
        at += 1
    return tuple(row)


def is_quirk(item):
    """glibc matches nothing where an unclosed `[` ends in `-`; the contract: `[` is itself."""
    return item[0] == "expression" and item[1].endswith(b"-") and b"[" in item[1]


def matches(item, name):
    """The C library's word on one item and one name."""
    kind, text, flags = item
    if kind == "cyclone":
        return _cyclone_matches(tokens(item), name)
    if is_quirk(item):
        both = combinations((item, ("literal", name, 0)))
        return any(matched == 3 for matched, _ in both)
    return text == name if kind == "literal" else _LIBC.fnmatch(text, name, flags) == 0


def is_defined(item):
    try:
        tokens(item)
    except Undefined:
        return False
    return True


def split(pieces, by):
    """A partition of a set (each piece a bit mask) that also tells `by` apart."""
    out = []
    for piece in pieces:
        inside = piece & by
        if inside:
            out.append(inside)
        if piece ^ inside:
            out.append(piece ^ inside)
    return out


def _readable_octet(octets):
    for group in _READABLE:
        if octets & group:
            octets &= group
            break
    return (octets & -octets).bit_length() - 1


class _Walk:
    """All rows side by side: a state is the set of positions that a name may have reached."""

    def __init__(self, items):
        self.stars = self.bounded_stars = self.start = 0
        self.ends = []  # (bit of the end of a row, index of the item)
        self.advances = {}  # octets -> the positions that they leave
        position = 0
        for index, item in enumerate(items):
            row = tokens(item)
            if row is None:
                continue
            self.start |= 1 << position
            for token in row:
                if token != STAR:
                    self.advances[token] = self.advances.get(token, 0) | 1 << position
                else:
                    self.stars |= 1 << position
                    if item[2] & FNM_PATHNAME:
                        self.bounded_stars |= 1 << position
                position += 1
            self.ends.append((1 << position, index))
            position += 1
        self.start = self._closed(self.start)

    def _closed(self, state):
        return state | (state & self.stars) << 1

    def steps(self):
        """For each kind of octet: (an example, positions that it leaves, stars that take it)."""
        kinds = [ALL]
        for octets in self.advances:
            kinds = split(kinds, octets)
        if self.bounded_stars:
            kinds = split(kinds, SLASH)
        for kind in kinds:
            advance = sum(mask for octets, mask in self.advances.items() if octets & kind)
            stay = self.stars & ~self.bounded_stars if kind == SLASH else self.stars
            yield bytes([_readable_octet(kind)]), advance, stay

    def states(self):
        """Every state that a name leads to, with the shortest such name."""
        found = {self.start: b""}
        todo = deque(found)
        steps = list(self.steps())
        while todo:
            state = todo.popleft()
            name = found[state]
            for octet, advance, stay in steps:
                after = self._closed((state & advance) << 1 | state & stay)
                if after not in found:
                    found[after] = name + octet
                    todo.append(after)
            if len(found) > MOST_STATES:
                raise OverflowError("too many combinations of expressions")
        return found

    def matched(self, state):
        return sum(1 << index for end, index in self.ends if state & end)


@functools.lru_cache(maxsize=20_000)
def combinations(items):
    """[(bit mask of the items that match, a name that only these match)], complete."""
    walk = _Walk(items)
    found = {}
    for state, name in walk.states().items():
        found.setdefault(walk.matched(state), name)
    for matched, name in found.items():
        for index, item in enumerate(items):
            if not is_quirk(item) and matches(item, name) != bool(matched >> index & 1):
                raise AssertionError(f"fnmatch() disagrees with the walk on {item} and {name!r}")
    return sorted(found.items(), key=lambda pair: (len(pair[1]), pair[1]))

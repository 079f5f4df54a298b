"""Subject names: sequences of RDNs, and a set of subjects that tells all grants apart."""

import functools
from typing import NamedTuple

from expressions import combinations, literal, subject_value


class Subject(NamedTuple):
    """Of a grant. An RDN is a row of (type, item that a value must match), by type."""
    rdns: tuple

    def shape(self):
        return tuple(tuple(kind for kind, _ in rdn) for rdn in self.rdns)

    def backwards(self):
        return Subject(self.rdns[::-1])


@functools.lru_cache(maxsize=10_000)
def read_subject(text, is_expression):
    """RFC 4514 without escapes (10.4.1.5.3.1 allows no character that needs one)."""
    item = subject_value if is_expression else literal
    rdns = []
    for rdn in text.split(","):
        pairs = [pair.split("=", 1) for pair in rdn.split("+")]
        rdns.append(tuple(sorted((kind.strip(), item(value.strip())) for kind, value in pairs)))
    return Subject(tuple(rdns))


def _product(masks, pairs):
    """What a mask comes to with each of `pairs`; the first example of each is kept."""
    out = {}
    for mask, values in masks.items():
        for matched, value in pairs:
            out.setdefault(mask & matched, values + [value])
    return out


def _of_shape(shape, sides):
    """{bit mask of the sides that match: the values of such a subject}."""
    fitting = [(bit, side) for bit, side in sides if side.shape() == shape]
    masks = {sum(1 << bit for bit, _ in fitting): []}
    for place, rdn in enumerate(shape):
        for number, _ in enumerate(rdn):
            items = {}  # item -> the sides that ask for it there
            for bit, side in fitting:
                item = side.rdns[place][number][1]
                items[item] = items.get(item, 0) | 1 << bit
            asked = tuple(items)
            pairs = [(sum(items[item] for i, item in enumerate(asked) if matched >> i & 1), value)
                     for matched, value in combinations(asked)]
            masks = _product(masks, pairs)
    return masks


def representatives(subjects):
    """[(bit mask of the subjects that match, a text)]: every combination that a participant's
    subject can have but the one that matches none."""
    sides = [(2 * i, subject) for i, subject in enumerate(subjects)]
    sides += [(2 * i + 1, subject.backwards()) for i, subject in enumerate(subjects)]
    found = {}
    for shape in {min(s.shape(), s.backwards().shape()) for s in subjects}:
        for mask, values in _of_shape(shape, sides).items():
            matched = sum(1 << i for i in range(len(subjects)) if mask >> 2 * i & 3)
            kinds = [kind for rdn in shape for kind in rdn]
            shown = ", ".join(f"{k}={v.decode(errors='replace')}" for k, v in zip(kinds, values))
            found.setdefault(matched, shown)
    found.pop(0, None)
    return sorted(found.items(), key=lambda pair: pair[1])

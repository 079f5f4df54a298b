"""Expressions that only one of two documents has, and that a product matches with other names than the
standard does ("What other products read differently" in docs/comparison.md)."""

import functools
import xml.etree.ElementTree as ET

from documents import BLANKS
from expressions import Undefined, combinations, cyclone_expression, expression, unescaped_expression

HAS_BRACKET = expression("*]*")


@functools.lru_cache(maxsize=100_000)
def is_read_differently(text):
    """None: in a product's reading it has a meaning that POSIX leaves open, so neither answer is wrong."""
    if not set(text) & set("[]\\"):
        return False
    try:
        return differs_in_a_product(text)
    except Undefined:
        return None


def differs_in_a_product(text):
    for product in (cyclone_expression(text), unescaped_expression(text)):
        for matched, _ in combinations((expression(text), product, HAS_BRACKET)):
            if matched in (0b001, 0b010):
                return True
    return False


def expressions_of(xml):
    """Those that the stock products read: no relay elements, no tags."""
    found = set()
    for element in ET.fromstring(xml).iter():
        names = {"topic_rule": ["topic_expression"], "publish": ["topics/topic", "partitions/partition"],
                 "subscribe": ["topics/topic", "partitions/partition"]}.get(element.tag, ())
        found |= {(each.text or "").strip(BLANKS) for name in names for each in element.iterfind(name)}
    return found


def complaints(readings, old_xml, new_xml):
    """`readings`: the product's, as [[whether it is in the new document, expression]]."""
    old, new = expressions_of(old_xml), expressions_of(new_xml)
    expected = {(side, text) for side, texts in ((True, new - old), (False, old - new)) for text in texts
                if is_read_differently(text)}
    told = {(side, bytes.fromhex(text).decode()) for side, text in readings}
    told = {(side, text) for side, text in told if is_read_differently(text) is not None}
    yield from (f"reading of the evaluator only: {each}" for each in sorted(expected - told))
    yield from (f"reading of the product only: {each}" for each in sorted(told - expected))

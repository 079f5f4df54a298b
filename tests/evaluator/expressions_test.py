#!/usr/bin/env python3
"""No name has a combination of matches that expressions.combinations() does not list."""

import random
import unittest

from expressions import combinations, expression, is_defined, is_quirk, matches, subject_value
from words import random_expression

OCTETS = b"aabbcd1/^-[]\\*?! \xc3\xa9_A\x01\xff"


def random_items(rng):
    make = rng.choice([expression, expression, subject_value])
    items = [make(random_expression(rng)) for _ in range(rng.randint(1, 4))]
    return tuple(item for item in items if is_defined(item))


class Combinations(unittest.TestCase):
    def test_random_names_are_among_them(self):
        rng = random.Random(1)
        for _ in range(1500):
            items = random_items(rng)
            listed = {matched for matched, _ in combinations(items)}
            for _ in range(8):
                name = bytes(rng.choice(OCTETS) for _ in range(rng.randint(0, 6)))
                matched = sum(1 << i for i, item in enumerate(items) if matches(item, name))
                self.assertIn(matched, listed, (items, name))

    def test_the_shortest_name_is_given(self):
        self.assertEqual(combinations((expression("a*"), expression("*b"))),
                         [(0, b""), (1, b"a"), (2, b"b"), (3, b"ab")])

    def test_what_glibc_and_the_contract_read_differently(self):
        self.assertTrue(is_quirk(expression("[a-")))
        self.assertTrue(matches(expression("[a-"), b"[a-"))
        self.assertFalse(matches(expression("a\\"), b"a\\"))
        self.assertFalse(is_defined(expression("[[:foo:]]")))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""The variants, the table and the plot of latency.py, from figures that are made up: no program runs."""

import argparse
import sys
import unittest
import xml.etree.ElementTree

sys.dont_write_bytecode = True
import latency  # noqa: E402
import latency_plot  # noqa: E402

SVG = "{http://www.w3.org/2000/svg}"


def variants(loss=0, only=""):
    return latency.variants(argparse.Namespace(loss=loss, only=only))


def figures(of):
    """Each variant is 10 us slower than the one before."""
    return {variant: {**{key: 100 + 10 * i + j for j, (key, _) in enumerate(latency.COLUMNS)}, "lost": 3 if i == 1 else 0}
            for i, variant in enumerate(of)}


class Variants(unittest.TestCase):
    def test_names_say_what_the_arguments_do(self):
        for variant in variants():
            words = str(variant).split(", ")
            self.assertEqual("--best-effort" in variant.arguments(), "reliable" not in words)
            self.assertEqual("--waiting" in variant.arguments(), "wait" in words)
            self.assertEqual("--listener" in variant.arguments(), "listener" in words)
            self.assertEqual(variant.secured, "secured" in words)

    def test_all_combinations_are_measured_once(self):
        names = [str(variant) for variant in variants()]
        self.assertEqual(len(names), 1 + 2 * 8)
        self.assertEqual(len(set(names)), len(names))
        self.assertEqual(names[0], "UDP, wait")
        for variant in variants()[1:]:
            self.assertIn(variant.of("Cyclone"), variants())

    def test_loss_leaves_out_what_an_answer_may_end(self):
        lossy = [str(variant) for variant in variants(loss=0.2)]
        self.assertEqual(len(lossy), 12)
        self.assertFalse([name for name in lossy if "best effort, listener" in name or "UDP" in name])

    def test_memory_is_measured_secured_and_not_beside_its_floor(self):
        names = [str(v) for v in latency.memory_variants(argparse.Namespace(only=""))]
        self.assertEqual(len(set(names)), 1 + 8)
        self.assertEqual(names[0], "futex, wait")
        self.assertEqual(sum("secured" in name for name in names), 4)

    def test_only_selects_by_name(self):
        self.assertEqual([str(v) for v in variants(only="^ddssec, secured, reliable")],
                         ["ddssec, secured, reliable, wait", "ddssec, secured, reliable, listener"])


class Report(unittest.TestCase):
    def test_table_has_a_row_for_each_variant_and_ratios(self):
        measured = figures(variants())
        rows = latency.table(measured)
        self.assertEqual(len(rows), 2 + len(measured))
        self.assertEqual({row.count("|") for row in rows}, {len(latency.COLUMNS) + 4})
        # The second variant is ddssec's, and Cyclone's follows: 110 and 120 us, with UDP at 100 us.
        self.assertTrue(rows[3].startswith("| ddssec, best effort, wait (3 lost) | 110.0 | 111.0 |"), rows[3])
        self.assertTrue(rows[3].endswith("| 0.92, 0.92 | 1.10 |"), rows[3])

    def test_table_without_a_floor_has_no_ratio_to_it(self):
        rows = latency.table(figures(variants(only="ddssec, reliable, wait")))
        self.assertEqual(len(rows), 3)
        self.assertTrue(rows[2].endswith("| -, - | - |"), rows[2])

    def test_table_of_memory_has_ratios_within_each_size(self):
        of = latency.memory_variants(argparse.Namespace(only="futex|^ddssec, best effort, wait"))
        rows = latency.memory_table({64: figures(of), 4096: figures(of[1:])})
        self.assertEqual(len(rows), 2 + 3)
        self.assertEqual({row.count("|") for row in rows}, {7})
        self.assertEqual(rows[2], "| 64 | futex, wait | 100.0 | 102.0 | 106.0 | 1.00 |")
        self.assertTrue(rows[3].endswith("| 1.10 |"), rows[3])
        self.assertTrue(rows[4].startswith("| 4096 | ddssec, best effort, wait | 100.0 |"), rows[4])
        self.assertTrue(rows[4].endswith("| - |"), rows[4])

    def test_plot_draws_every_variant(self):
        for loss, lines, dashed in ((0, 16 + 4, 8), (0.2, 12, 4)):
            root = xml.etree.ElementTree.fromstring(latency_plot.draw("a title with < and &", figures(variants(loss))))
            drawn = list(root.iter(SVG + "polyline"))
            self.assertEqual(len(drawn), lines)  # the floor is in each of the four panels
            self.assertEqual(sum("stroke-dasharray" in line.attrib for line in drawn), dashed)
            self.assertEqual({len(line.attrib["points"].split()) for line in drawn}, {len(latency_plot.PERCENTILES)})
            self.assertIn("a title with < and &", [text.text for text in root.iter(SVG + "text")])


if __name__ == "__main__":
    unittest.main()

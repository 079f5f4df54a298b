#!/usr/bin/env python3
"""Checks the table of scenarios and the peers' exit codes, without running a pair.

Usage: table_test.py BIN_FOLDER
"""

import pathlib
import subprocess
import sys
import unittest

sys.dont_write_bytecode = True

import embedded_scenarios  # noqa: E402
import forecast  # noqa: E402
import measure  # noqa: E402
import scenarios  # noqa: E402
from pki import STARTER, WAITER, der_name, subject  # noqa: E402

BIN = ""
CASES = scenarios.all_cases()
CHOSEN = [case for case in CASES if case.chosen]


class Bare:
    """Stands for a network namespace; the commands of these tests need none."""

    def enter(self, command):
        return command


class Forecast(unittest.TestCase):
    def comes_up(self, script):
        product = forecast.Product("stub", ["/bin/sh", "-c", script])
        return forecast.comes_up(Bare(), product, "correct", pathlib.Path("folder"))[0]

    def test_a_product_that_aborts_does_not_come_up(self):
        self.assertTrue(self.comes_up("exit 0"))
        self.assertTrue(self.comes_up("exit 1"))  # created, and no peer came
        self.assertFalse(self.comes_up("echo refused participant; exit 2"))
        self.assertFalse(self.comes_up("kill -ABRT $$"))
        self.assertFalse(self.comes_up("exit 134"))

    def test_what_the_table_calls_unsafe_is_what_measuring_calls_unsafe(self):
        table = forecast.Table(pathlib.Path(__file__).resolve().parents[2])
        for version in table.columns:
            of_this = measure.UNSAFE | (measure.UNSAFE_WITH_CYCLONEDDS if version.startswith("cyclonedds") else set())
            unsafe = {folder for folder, outcome in table.of(version).items() if outcome == "unsafe"}
            self.assertLessEqual(unsafe, of_this, version)


class Table(unittest.TestCase):
    def test_no_case_twice(self):
        names = [(case.name, case.pair) for case in CASES]
        self.assertEqual(len(names), len(set(names)))

    def test_chosen_are_at_most_110_and_all_with_ours(self):
        self.assertLessEqual(len(CHOSEN), 110)
        self.assertFalse([case.name for case in CHOSEN if case.stock_only])

    def chosen(self, what):
        return {what(case) for case in CHOSEN if case.table == "governance"}

    def test_chosen_cover_rows_keys_directions_and_pairs(self):
        pairs = {f"{publisher}>{subscriber}" for publisher, subscriber in scenarios.OUR_PAIRS}
        self.assertEqual(self.chosen(lambda case: case.row), set(scenarios.GOVERNANCES))
        self.assertEqual(self.chosen(lambda case: case.keys), set(scenarios.KEYS.values()))
        self.assertEqual(self.chosen(lambda case: (case.pair, case.publisher_starts)),
                         {(pair, starts) for pair in pairs for starts in (True, False)})

    def test_chosen_have_each_of_our_plugins_alone_beside_both_stacks(self):
        mixed = {frozenset((case.publisher, case.subscriber)) for case in CHOSEN
                 if case.table == "mixed"}
        for mix in scenarios.MIXES:
            for other in ("ddssec", "stock", "fast"):
                self.assertIn(frozenset((mix, other)), mixed)

    def test_valid_documents_with_ours_must_give_data(self):
        for case in CASES:
            if case.table in ("governance", "mixed") and not case.stock_only:
                self.assertEqual(case.allowed, {scenarios.DATA}, case.name)

    def test_a_fault_of_ours_is_refused_when_the_participant_is_created(self):
        case = next(case for case in CASES if case.pair == "ddssec>stock"
                    and case.row == "self-signed-permissions")
        self.assertEqual(case.allowed, {scenarios.REFUSED})

    def test_two_stock_peers_fail_in_the_measured_pairs(self):
        failing = {case.name for case in CASES if case.stock_only and case.table == "governance"
                   and case.pair == "fast>stock" and "/ec/start-sub" in case.name
                   and case.allowed != {scenarios.DATA}}
        self.assertEqual(failing, {f"governance/{row}/ec/start-sub" for row in (
            "data-sign", "data-encrypt", "rtps-sign+data-encrypt", "rtps-encrypt+data-encrypt")})


class Embedded(unittest.TestCase):
    CASES = embedded_scenarios.all_cases()
    CHOSEN = [case for case in CASES if case.chosen]

    def test_every_row_has_every_pair(self):
        self.assertEqual({case.row for case in self.CASES if case.table == "embedded-governance"},
                         set(scenarios.GOVERNANCES))
        pairs = {f"{publisher}>{subscriber}" for publisher, subscriber in embedded_scenarios.PAIRS}
        self.assertEqual({case.pair for case in self.CASES}, pairs)
        names = [(case.name, case.pair) for case in self.CASES]
        self.assertEqual(len(names), len(set(names)))

    def test_chosen_cover_rows_pairs_and_directions_in_a_minute(self):
        self.assertLessEqual(len(self.CHOSEN), 60)
        positive = [case for case in self.CHOSEN if case.table == "embedded-governance"]
        self.assertEqual({case.row for case in positive}, set(scenarios.GOVERNANCES))
        self.assertEqual({case.pair for case in positive}, {case.pair for case in self.CASES})
        self.assertGreater(len({case.row for case in self.CHOSEN}), len(scenarios.GOVERNANCES) + 5)

    def test_nothing_is_excused(self):
        self.assertFalse([case.name for case in self.CASES if case.known])


class Names(unittest.TestCase):
    def test_subject_in_der(self):
        self.assertEqual(der_name("a").hex(), "301e3110300e060355040a0c07696e7465726f70"
                                              "310a300806035504030c0161")

    def test_starter_and_waiter_differ(self):
        self.assertNotEqual(subject(STARTER), subject(WAITER))


class Peers(unittest.TestCase):
    def status(self, *arguments):
        return [subprocess.run([f"{BIN}/{peer}", *arguments], capture_output=True).returncode
                for peer in ("cyclone_peer", "fastdds_peer")]

    def test_usage_errors(self):
        for arguments in ([], ["--publish", "--subscribe"], ["--publish", "--domain", "231"],
                          ["--publish", "--samples", "many"], ["--publish", "--no-such-option"],
                          ["--publish", "left-over"], ["--publish", "--property", "novalue"],
                          ["--publish", "--plugins", "other=x"]):
            self.assertEqual(self.status(*arguments), [2, 2], arguments)

    def test_missing_documents_are_refused(self):
        documents = [part for name in ("identity_ca", "identity_certificate", "private_key",
                                       "permissions_ca", "governance", "permissions")
                     for part in ("--" + name, "/no/such/file")]
        self.assertEqual(self.status("--publish", "--domain", "199", *documents), [3, 3])

    def test_nobody_there_is_no_match(self):
        self.assertEqual(self.status("--subscribe", "--plain", "--domain", "198", "--timeout", "1"),
                         [4, 4])


if __name__ == "__main__":
    BIN = sys.argv.pop(1)
    unittest.main()

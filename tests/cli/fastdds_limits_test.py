#!/usr/bin/env python3
"""Permissions that Fast DDS 2.9.1 does not use as they say (interop.doctor_chosen measures it): it ignores the <domains>
of a rule where it makes a writer or reader, and the zones of dates, and does not authenticate a Fast DDS participant with
a long document."""

import datetime

from fastdds_permissions import (DENIED_ELSEWHERE, DENIED_ELSEWHERE_LATER, DOCUMENT, END, LONG, SHORT, TOPIC, in_zone,
                                 rows, rule)
from transcript import Transcript, main

TIME = datetime.datetime(2026, 11, 20, tzinfo=datetime.timezone.utc)
NOW = ("--now", "2026-11-20T00:00:00Z")


class FastDdsLimits(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)

    def sign(self, rules, end=END):
        for name in ("talker", "listener"):
            (self.at / "p.xml").write_text(DOCUMENT.format(name=name, end=end, rules=rules))
            self.run_program("permissions", "sign", "p.xml", "--ca", "demo", "-o", f"demo/{name}/permissions.p7s",
                             "--replace", "--no-lint", *NOW)

    def found(self, rule, vendor, exit):
        answer = self.json("doctor", "demo/talker", "--vendor", vendor, *NOW, exit=exit)
        return list(answer["result"]["verdicts"].values()), [one for one in answer["diagnostics"] if one["id"] == rule]

    def talk(self, topic, vendor, exit):
        return self.json("check", "demo/talker", "demo/listener", "--topics", topic, "--vendor", vendor, *NOW,
                         exit=exit)["result"]["talk"]

    def test_check_says_who_talks(self):
        for name, end, rules, with_fastdds, with_cyclone in rows(TIME):
            with self.subTest(name):
                self.sign(rules, end)
                for vendor, is_heard in (("fastdds", with_fastdds), ("cyclonedds", with_cyclone)):
                    self.assertEqual(self.talk(TOPIC, vendor, 0 if is_heard else 1), is_heard)

    def test_a_rule_of_another_domain_denies_a_topic(self):
        self.sign(DENIED_ELSEWHERE)
        verdicts, (finding,) = self.found("DOC109", "fastdds", 1)
        self.assertEqual((verdicts, finding["line"]), (["late"], 12))
        self.assertIn(f'topic "{TOPIC}" in domain 0', finding["message"])
        self.assertTrue(self.talk("Bar", "fastdds", 0))
        self.assertEqual(self.found("DOC109", "cyclonedds", 0), (["ok"], []))
        self.sign(DENIED_ELSEWHERE_LATER)
        self.assertEqual(self.found("DOC109", "fastdds", 0), (["ok"], []))

    def test_long_permissions(self):
        self.sign(SHORT)
        self.assertEqual(self.found("DOC110", "fastdds", 0), (["ok"], []))
        self.sign(LONG)
        verdicts, (finding,) = self.found("DOC110", "fastdds", 1)
        self.assertEqual(verdicts, ["late"])
        self.assertIn("do not authenticate one", finding["message"])
        self.assertEqual(self.found("DOC110", "cyclonedds", 0), (["ok"], []))

    def test_zones_of_dates(self):
        everything = rule("allow", 0, "*")
        for end, expected in ((in_zone(TIME, -1, 12), "unsafe"), (in_zone(TIME, 1, -12), "fail")):
            self.sign(everything, end)
            verdicts, findings = self.found("DOC042", "fastdds", 1)
            self.assertEqual(verdicts, [expected])
            self.assertIn("ignores the zones of the dates", "".join(one["message"] for one in findings))
        lint = self.json("permissions", "lint", "demo/talker", *NOW, exit=None)["diagnostics"]
        self.assertIn("names an offset from UTC", "".join(one["message"] for one in lint if one["id"] == "PERM003"))

    def test_diff_sees_what_fast_dds_makes_of_a_zone(self):
        for name, end in (("old", "2026-11-27T06:00:00Z"), ("new", "2026-11-27T20:00:00+14:00")):
            (self.at / f"{name}.xml").write_text(DOCUMENT.format(name="talker", end=end, rules=rule("allow", 0, "*")))
        done = self.run_program("permissions", "diff", "old.xml", "new.xml", "--fail-on", "wider", exit=1)
        self.assertIn("with Fast DDS: validity", done.stdout + done.stderr)

    def test_diff_sees_what_cyclone_dds_makes_of_a_distant_end(self):
        for name, end in (("old", "2300-01-01T00:00:00Z"), ("new", "2250-01-01T00:00:00Z")):
            (self.at / f"{name}.xml").write_text(DOCUMENT.format(name="talker", end=end, rules=rule("allow", 0, "*")))
        done = self.run_program("permissions", "diff", "old.xml", "new.xml", "--fail-on", "wider", exit=1)
        self.assertIn("with Cyclone DDS: validity", done.stdout + done.stderr)


if __name__ == "__main__":
    main()

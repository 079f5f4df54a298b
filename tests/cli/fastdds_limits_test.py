#!/usr/bin/env python3
"""Permissions that Fast DDS 2.9.1 does not use as they say (interop.doctor_chosen measures it): it ignores the <domains>
of a rule where it makes a writer or reader, and does not authenticate a Fast DDS participant with a long document."""

from fastdds_permissions import DENIED_ELSEWHERE, DENIED_ELSEWHERE_LATER, DOCUMENT, LONG, ROWS, SHORT, TOPIC
from transcript import Transcript, main

NOW = ("--now", "2026-11-20T00:00:00Z")


class FastDdsLimits(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)

    def sign(self, rules):
        for name in ("talker", "listener"):
            (self.at / "p.xml").write_text(DOCUMENT.format(name, rules))
            self.run_program("permissions", "sign", "p.xml", "--ca", "demo", "-o", f"demo/{name}/permissions.p7s",
                             "--replace", "--no-lint", *NOW)

    def found(self, rule, vendor, exit):
        answer = self.json("doctor", "demo/talker", "--vendor", vendor, *NOW, exit=exit)
        return list(answer["result"]["verdicts"].values()), [one for one in answer["diagnostics"] if one["id"] == rule]

    def talk(self, topic, vendor, exit):
        return self.json("check", "demo/talker", "demo/listener", "--topics", topic, "--vendor", vendor, *NOW,
                         exit=exit)["result"]["talk"]

    def test_check_says_who_talks(self):
        for name, rules, is_heard in ROWS:
            with self.subTest(name):
                self.sign(rules)
                self.assertEqual(self.talk(TOPIC, "fastdds", 0 if is_heard else 1), is_heard)
                self.assertTrue(self.talk(TOPIC, "cyclonedds", 0))

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


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Permissions that Fast DDS 2.9.1 does not use as they say (measured): it ignores the <domains> of a rule where it makes a
writer or reader, and does not authenticate a Fast DDS participant with a long document."""

from transcript import Transcript, main

NOW = ("--now", "2026-11-20T00:00:00Z")
DOCUMENT = """<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions><grant name="g"><subject_name>CN={}</subject_name>
<validity><not_before>2026-01-01T00:00:00Z</not_before><not_after>2027-11-01T00:00:00Z</not_after></validity>
{}<default>DENY</default></grant></permissions></dds>
"""


def rule(kind, domain, *topics):
    listed = "<topics>" + "".join(f"<topic>{topic}</topic>" for topic in topics) + "</topics>"
    return (f"<{kind}_rule><domains><id>{domain}</id></domains><publish>{listed}</publish><subscribe>{listed}</subscribe>"
            f"</{kind}_rule>\n")


class FastDdsLimits(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)

    def sign(self, name, *rules):
        (self.at / "p.xml").write_text(DOCUMENT.format(name, "".join(rules)))
        self.run_program("permissions", "sign", "p.xml", "--ca", "demo", "-o", f"demo/{name}/permissions.p7s", "--replace",
                         "--no-lint", *NOW)

    def found(self, rule, vendor, exit):
        answer = self.json("doctor", "demo/talker", "--vendor", vendor, *NOW, exit=exit)
        return list(answer["result"]["verdicts"].values()), [one for one in answer["diagnostics"] if one["id"] == rule]

    def talk(self, topic, vendor, exit):
        return self.json("check", "demo/talker", "demo/listener", "--topics", topic, "--vendor", vendor, *NOW,
                         exit=exit)["result"]["talk"]

    def test_a_rule_of_another_domain_denies_a_topic(self):
        self.sign("talker", rule("deny", 1, "Foo"), rule("allow", 0, "*"))
        verdicts, (finding,) = self.found("DOC109", "fastdds", 1)
        self.assertEqual((verdicts, finding["line"]), (["late"], 12))
        self.assertIn('topic "Foo" in domain 0', finding["message"])
        self.assertFalse(self.talk("Foo", "fastdds", 1))
        self.assertTrue(self.talk("Bar", "fastdds", 0))
        self.assertEqual(self.found("DOC109", "cyclonedds", 0), (["ok"], []))
        self.assertTrue(self.talk("Foo", "cyclonedds", 0))
        self.sign("talker", rule("allow", 0, "*"), rule("deny", 1, "Foo"))
        self.assertEqual(self.found("DOC109", "fastdds", 0), (["ok"], []))
        self.assertTrue(self.talk("Foo", "fastdds", 0))

    def test_long_permissions(self):
        topics = [f"{'t' * 200}{number}" for number in range(300)]
        for name in ("talker", "listener"):
            self.sign(name, rule("allow", 0, "Foo", *topics[:100]))
        self.assertEqual(self.found("DOC110", "fastdds", 0), (["ok"], []))
        self.assertTrue(self.talk("Foo", "fastdds", 0))
        for name in ("talker", "listener"):
            self.sign(name, rule("allow", 0, "Foo", *topics))
        verdicts, (finding,) = self.found("DOC110", "fastdds", 1)
        self.assertEqual(verdicts, ["late"])
        self.assertIn("do not authenticate one", finding["message"])
        self.assertFalse(self.talk("Foo", "fastdds", 1))
        self.assertEqual(self.found("DOC110", "cyclonedds", 0), (["ok"], []))
        self.assertTrue(self.talk("Foo", "cyclonedds", 0))


if __name__ == "__main__":
    main()

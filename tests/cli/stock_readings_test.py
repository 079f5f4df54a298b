#!/usr/bin/env python3
"""Expressions that Cyclone DDS or Fast DDS reads in another way than ddssec, so that a topic is not protected or not
refused: doctor calls it unsafe for the product, and check warns. Each row was measured with real pairs on stock plugins
and a capture of what they sent."""

import re

from transcript import WithoutLists, main
from workshop import GOVERNANCE, Folder, Workshop, allow, grant, permissions

RULE = re.search(r" *<topic_rule>.*</topic_rule>\n", GOVERNANCE, re.S)[0]
OPEN = RULE.replace("ENCRYPT", "NONE")
DENY = ("<deny_rule><domains><id>0</id></domains><publish><topics><topic>{0}</topic></topics></publish>"
        "<subscribe><topics><topic>{0}</topic></topics></subscribe></deny_rule>")
CYCLONEDDS, FASTDDS = "cyclonedds@0.10.2", "fastdds@2.9.1"
# A topic_rule that protects "secret" by ddssec's reading; the products that send it in the clear.
PROTECTING = [("s\\ecret", {CYCLONEDDS, FASTDDS}), ("[^a-r]ecret", {CYCLONEDDS}), ("[[:alpha:]]ecret", {CYCLONEDDS}),
              ("[s-]ecret", {CYCLONEDDS}), ("[]s]ecret", {CYCLONEDDS}), ("\n  secret\n", {FASTDDS})]
# A deny_rule for "secret"; the products that let it pass.
REFUSING = [("s\\ecret", {CYCLONEDDS, FASTDDS}), ("secre[^a]", {CYCLONEDDS}), (" secret ", {FASTDDS})]
ALIKE = ["secret", "s?cret", "[a-z]ecret", "[!0-9]ecret", "*cret"]


class StockReadings(WithoutLists):
    def setUp(self):
        super().setUp()
        shop = Workshop(self.at / "shop")
        self.folders = [Folder(shop, self.at / name, f"/CN={name}", name) for name in ("talker", "partner")]

    def sign(self, governance=GOVERNANCE, rules=None):
        for folder in self.folders:
            folder.sign("governance", governance)
            folder.sign("permissions", permissions(grant(folder.subject, rules)))

    def told(self, *words, exit):
        return [one for one in self.json(*words, exit=exit)["diagnostics"] if one["id"] == "DOC107"]

    def check_row(self, products, words, file):
        verdicts = self.json("doctor", "talker", exit=1)["result"]["verdicts"]
        self.assertEqual({name for name, verdict in verdicts.items() if verdict == "unsafe"}, products)
        told = self.told("doctor", "talker", exit=1)
        self.assertEqual({vendor for one in told for vendor in one["vendors"]}, products)
        for one in told:
            self.assertIn(words, one["message"])
            self.assertTrue(one["file"].endswith(file) and one["line"] > 0, one)

    def test_a_topic_that_only_ddssec_protects(self):
        for expression, products in PROTECTING:
            rule = RULE.replace("<topic_expression>*<", f"<topic_expression>{expression}<")
            self.sign(GOVERNANCE.replace(RULE, rule + OPEN), allow("*"))
            with self.subTest(expression=expression):
                self.check_row(products, 'ENCRYPT', "governance.p7s")
        warned = self.told("check", "talker", "partner", "--topics", "secret", exit=0)
        self.assertEqual({one["severity"] for one in warned}, {"warning"})
        self.assertEqual(self.told("check", "talker", "partner", "--topics", "secret", "--vendor", "fastdds", exit=0), [])

    def test_a_topic_that_only_ddssec_refuses(self):
        for expression, products in REFUSING:
            self.sign(rules=DENY.format(expression) + allow("*"))
            with self.subTest(expression=expression):
                self.check_row(products, "which ddssec refuses", "permissions.p7s")

    def test_expressions_that_are_read_alike(self):
        for expression in ALIKE:
            rule = RULE.replace("<topic_expression>*<", f"<topic_expression>{expression}<")
            self.sign(GOVERNANCE.replace(RULE, rule + OPEN), DENY.format(expression) + allow("*"))
            with self.subTest(expression=expression):
                self.assertEqual(self.told("doctor", "talker", exit=None), [])

    def test_a_reading_that_protects_as_much(self):
        rule = RULE.replace("<topic_expression>*<", "<topic_expression>s\\ecret<")
        self.sign(GOVERNANCE.replace(RULE, rule + RULE))
        self.assertEqual(self.told("doctor", "talker", exit=0), [])


if __name__ == "__main__":
    main()

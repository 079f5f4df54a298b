#!/usr/bin/env python3
"""permissions diff: what a change of a document changes, and for which participants."""

import subprocess

from diff_documents import JOIN, Differences, governance, grant, permissions, rule, topic
from transcript import NOW, main


class PermissionsDifferences(Differences):
    def write(self, old, new, kind="permissions"):
        super().write(old, new, kind)

    def test_another_spelling_of_subject_and_expression(self):
        old = permissions(grant(rule("allow", "*"), subject="CN=a"))
        self.write(old, old.replace("<subject_name>CN=a</subject_name>",
                                    "<subject_name_expression>CN=[a]</subject_name_expression>"))
        self.diff("--fail-on", "wider")
        out = self.diff("--fail-on", "any", exit=1)
        self.assertEqual([(c["element"], c["class"], c["old"], c["new"]) for c in out["changes"]],
                         [("subject_name", "interop", "CN=a", "expression CN=[a]")])
        self.assertIn("came with DDS-Security 1.2", out["readings"]["all"][0]["sentence"])
        self.write(old, old.replace(">*<", ">**<"))
        out = self.diff("--fail-on", "any")
        self.assertEqual([(c["element"], c["class"], c["topics"]["expressions_new"]) for c in out["changes"]],
                         [("rewritten", "neutral", ["**"])])
        self.assertIn("  neutral   written differently  *  -> **  no name is treated differently  old:3 new:3",
                      self.text())

    def test_spellings_that_stock_products_do_not_recognise(self):
        texts = {name: permissions(grant(rule("allow", "*"), subject=name)) for name in ("CN=a", "cn=a", "2.5.4.3=a")}
        for old, new, options in (("CN=a", "cn=a", {"narrower": 1, "wider": 0}), ("cn=a", "CN=a", {"narrower": 0, "wider": 1}),
                                  ("cn=a", "2.5.4.3=a", {"narrower": 0, "wider": 0})):
            with self.subTest(old=old, new=new):
                self.write(texts[old], texts[new])
                for option, exit in options.items():
                    self.diff("--fail-on", option, exit=exit)
                sentences = [one["sentence"] for one in self.diff()["readings"]["all"]]
                self.assertTrue(any("Cyclone DDS and Fast DDS recognise no certificate by it" in one for one in sentences), sentences)
                self.assertNotIn("old and new files work together", self.text())

    def test_the_order_of_grants_that_contain_one_another(self):
        """Measured: stock Cyclone DDS gives the certificate CN=talker the grant of CN=talker,OU=x if it stands first."""
        for long in ("CN=talker,OU=x", "OU=x,CN=talker"):
            one, two = grant(rule("allow", "Circle")), grant(rule("allow", "Square"), subject=long, name="other")
            self.write(permissions(one, two), permissions(two, one))
            out = self.diff("--fail-on", "wider", exit=1)
            self.assertEqual((out["verdict"], out["changes"]), ("neutral", []))
            sentences = [reading["sentence"] for reading in out["readings"]["all"] if reading["document"] == "new"]
            self.assertTrue(any(f'gives a certificate of "CN=talker" the rights of "{long}"' in one for one in sentences), sentences)
            # What that changes: the product takes another grant than before, in both directions.
            for shape in ("Square", "Circle"):
                self.assertTrue(any(one.startswith("with Cyclone DDS: ") and f'topics such as "{shape}"' in one for one in sentences),
                                sentences)
            self.diff("--fail-on", "any", exit=1)
            self.diff("--fail-on", "narrower", exit=1)
            self.assertIn("what other products may read differently", self.text())
            self.write(permissions(two, one), permissions(one, two))
            self.diff("--fail-on", "wider", exit=1)
            self.diff("--fail-on", "any", exit=1)
        self.write(permissions(one), permissions(two))
        self.assertEqual(self.diff("--fail-on", "narrower", exit=1)["verdict"], "mixed")

    def test_white_space_in_an_end_tag_is_a_reading(self):
        old = permissions(grant(rule("allow", "a")))
        self.write(old, old.replace("</grant>", "</grant >"))
        self.diff("--fail-on", "wider")
        self.assertIn("</grant> has a blank", self.diff("--fail-on", "any", exit=1)["readings"]["all"][0]["sentence"])

    def test_validities_a_fraction_of_a_second_apart(self):
        old = permissions(grant(rule("allow", "*")))
        self.write(old, old.replace("2026-01-01T00:00:00Z", "2026-01-01T00:00:00.25Z"))
        out = self.diff("--fail-on", "wider")
        self.assertEqual((out["verdict"], out["changes"][0]["element"]), ("narrower", "validity"))
        self.assertIn("one second apart", out["changes"][0]["hint"])
        self.assertIn("has a fraction of a second", out["readings"]["all"][0]["sentence"])
        self.assertRegex(self.text(), r"\(they are one second\s+apart: ddssec counts")

    def test_the_order_of_rules_counts_and_the_example_shows_it(self):
        # The first rule lets the participant join, whatever comes after it.
        join, deny, allow = JOIN, rule("deny", "rt/cmd*"), rule("allow", "rt/*")
        self.write(permissions(grant(join, allow)), permissions(grant(join, deny, allow)))
        out = self.diff("--fail-on", "wider", *NOW)
        self.assertEqual((out["verdict"], out["breaks_interop"]), ("narrower", False))
        self.assertEqual(out["takes_effect"], {"embedded": "live", "cyclonedds_ddssec": "live, sessions begin again",
                                               "cyclonedds": "restart", "fastdds": "restart", "reason": "", "at": None})
        change, = out["changes"]
        self.assertEqual([change[k] for k in ("subject", "element", "operation", "old", "new")],
                         ["CN=talker", "rule", "publish", "allowed", "denied"])
        self.assertEqual(change["topics"], {
            "witness": "rt/cmd", "expressions_old": ["rt/*"], "expressions_new": ["rt/cmd*"], "other_sets": 0,
            "sets": [{"expression": "rt/cmd*", "also": None, "except": [], "more_exceptions": False}]})
        self.assertEqual((change["domains"], change["partitions"], change["old_at"], change["new_at"]),
                         ([[0, 0]], [""], "old.xml:14", "new.xml:14"))
        self.diff("--fail-on", "narrower", exit=1)
        text = self.text(*NOW)
        self.assertRegex(text, r"^subject CN=talker\n  NARROWER  publish topics rt/cmd\* "
                               r"\(e\.g\. rt/cmd\)  allowed -> denied  by rt/\* -> by rt/cmd\*")
        self.assertIn("verdict: NARROWER; old and new files work together\n", text)
        self.assertIn("running participants: on ddssec's plugins:  taken while they run\n"
                      "                      what was taken away ends within a second between embedded participants;\n",
                      text)
        self.assertRegex(text, r"on those of Cyclone DDS and Fast DDS:  restart\s+until then what was taken away")

        self.write(permissions(grant(join, deny, allow)), permissions(grant(join, allow, deny)))
        out = self.diff("--fail-on", "wider", exit=1)
        self.assertEqual((out["verdict"], out["changes"][0]["topics"]["witness"]),
                         ("wider", "rt/cmd"))
        self.assertNotIn("taken away", self.text())

    def told_for_cyclonedds(self, out):
        return [one["sentence"] for one in out["readings"]["all"] if one["sentence"].startswith("with Cyclone DDS")]

    def test_a_denial_before_the_allow_rule_refuses_the_topic_with_cyclonedds(self):
        # Cyclone DDS creates no topic whose first rule, in any direction, is a deny_rule.
        allow, deny = rule("allow", "Square"), rule("deny", "Square", operation="subscribe")
        self.write(permissions(grant(JOIN, allow, deny)), permissions(grant(JOIN, deny, allow)))
        out = self.diff("--fail-on", "narrower", exit=1)
        self.assertEqual((out["verdict"], out["changes"]), ("neutral", []))
        self.assertEqual(self.told_for_cyclonedds(out),
                         ['with Cyclone DDS: rule publish of topics such as "Square" allowed -> denied in domain 0, '
                          'partition "" for "CN=talker": narrower'])
        self.assertIn("verdict: NEUTRAL for ddssec's plugins; the lines \"interop\" say what changes", self.text())
        self.diff("--fail-on", "wider")

        self.write(permissions(grant(JOIN, deny, allow)), permissions(grant(JOIN, allow, deny)))
        out = self.diff("--fail-on", "wider", exit=1)
        self.assertIn("denied -> allowed", self.told_for_cyclonedds(out)[0])
        self.assertIn("another product allows more", self.text())

    def test_a_denial_that_cyclonedds_reads_alike_is_no_line(self):
        both = rule("deny", "Circle") + rule("deny", "Circle", operation="subscribe")
        self.write(permissions(grant(JOIN, both, rule("allow", "*"))),
                   permissions(grant(JOIN, both, rule("allow", "S*"))))
        out = self.diff("--fail-on", "narrower", exit=1)
        self.assertEqual((out["verdict"], self.told_for_cyclonedds(out)), ("narrower", []))

    def test_a_denial_after_the_allow_rule_in_the_other_direction_changes_nothing(self):
        # The first rule that names the topic allows it; the denial of one direction stays that.
        read = rule("allow", "Square", operation="subscribe")
        self.write(permissions(grant(JOIN, read, rule("allow", "Square"))),
                   permissions(grant(JOIN, read, rule("deny", "Square", operation="subscribe"), rule("allow", "Square"))))
        out = self.diff("--fail-on", "any", exit=0)
        self.assertEqual((out["verdict"], self.told_for_cyclonedds(out)), ("neutral", []))

    def takes(self, *words, exit=0):
        out = self.diff(*words, exit=exit)["takes_effect"]
        self.assertEqual(out["embedded"], out["cyclonedds_ddssec"])
        return out["embedded"], out["reason"]

    def test_the_same_file_changes_nothing_for_running_participants(self):
        one = permissions(grant(JOIN))
        self.write(one, one)
        self.assertEqual(self.takes(), ("same", ""))
        self.assertIn("running participants: on ddssec's plugins:  nothing changes\n", self.text())

    def test_a_running_participant_refuses_older_permissions(self):
        # As check_follows of the plugins does.
        one = permissions(grant(JOIN, rule("allow", "rt/a")))
        self.write(one, permissions(grant(JOIN)).replace("2026-01-01", "2025-12-31"))
        taken, reason = self.takes(*NOW)
        self.assertEqual((taken, reason),
                         ("refused", "as older: CN=talker: not_before 2025-12-31T00:00:00Z must be "
                                     "2026-01-01T00:00:00Z or later"))
        text = self.text(*NOW)
        self.assertIn("refused: the old document stays in force until a restart or its end", text)
        self.assertNotIn("ends within a second", text)

    def test_a_running_participant_refuses_permissions_that_were_signed_earlier(self):
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        one = permissions(grant(JOIN, rule("allow", "rt/a")))
        self.write(one, permissions(grant(JOIN)))
        key, cert = (str(self.at / "ca/permissions" / name) for name in ("ca.key.pem", "ca.pem"))

        def sign(name, to, second):
            self.run_program("permissions", "sign", f"{name}.xml", "--ca", "ca", "-o", f"{to}.p7s", "--replace",
                             "--now", f"2026-11-21T00:00:0{second}Z")

        def compare(old, new, *words):
            return self.json("permissions", "diff", f"{old}.p7s", f"{new}.p7s", *NOW, *words)["result"]["takes_effect"]

        def openssl(name, to, *words):
            subprocess.run(["openssl", "smime", "-sign", "-text", "-in", self.at / f"{name}.xml", "-signer", cert, "-inkey", key,
                            "-out", self.at / f"{to}.p7s", *words], check=True, capture_output=True)

        sign("old", "wide", 1)
        sign("new", "narrow", 2)
        self.assertEqual(compare("wide", "narrow")["embedded"], "live")
        for words in ((), ("--ca", "ca")):
            out = compare("narrow", "wide", *words)
            self.assertEqual((out["embedded"], out["cyclonedds_ddssec"], out["reason"]),
                             ("refused", "refused", "as older: the signing time 2026-11-21T00:00:01Z must be "
                                                    "2026-11-21T00:00:02Z or later"))
        sign("old", "again", 3)
        self.assertEqual(compare("narrow", "again")["embedded"], "live")
        self.assertEqual(compare("again", "wide")["embedded"], "refused")  # also with the same text
        sign("new", "alike", 3)
        self.assertEqual(compare("again", "alike")["embedded"], "live")

        openssl("old", "theirs")  # signed now
        openssl("old", "untimed", "-noattr")
        self.assertEqual(compare("untimed", "theirs")["embedded"], "same")
        self.assertIn("the signing time (none) must be", compare("theirs", "untimed")["reason"])
        self.assertEqual(compare("untimed", "narrow")["embedded"], "live")

    def test_a_running_participant_refuses_permissions_without_a_valid_grant_for_it(self):
        other = grant(JOIN, subject="CN=listener", name="listener")
        self.write(permissions(grant(JOIN), other), permissions(other))
        self.assertEqual(self.takes(*NOW), ("refused", "there is no grant for CN=talker any more"))
        self.write(permissions(grant(JOIN)), permissions(grant(JOIN, until="2026-02-01")))
        self.assertEqual(self.takes(*NOW), ("refused", "CN=talker: the new grant ended at 2026-02-01T00:00:00Z"))
        self.write(permissions(grant(JOIN)), permissions(grant(JOIN)).replace("2026-01-01", "2026-12-01"))
        self.assertEqual(self.takes(*NOW), ("live when it begins", "CN=talker: from 2026-12-01T00:00:00Z"))
        self.write(permissions(grant(JOIN, until="2026-02-01")), permissions(grant(JOIN)))
        taken, reason = self.takes(*NOW)
        self.assertEqual(taken, "restart")
        self.assertIn("the old grant ended at 2026-02-01T00:00:00Z", reason)

    def test_in_cyclonedds_rights_change_with_the_sessions(self):
        few, many = permissions(grant(JOIN, rule("allow", "a"))), permissions(grant(JOIN, rule("allow", "a"), rule("allow", "b")))
        again, one_more = "live, sessions begin again", permissions(grant(JOIN, rule("allow", "b")))
        for old, new, word, gains in ((many, few, again, False), (few, many, again, True), (few, one_more, again, True),
                                      (few, few.replace("<not_after>20", "<not_after>21"), "live", False)):
            self.write(old, new)
            out = self.diff(*NOW)["takes_effect"]
            self.assertEqual((out["embedded"], out["cyclonedds_ddssec"]), ("live", word))
            self.assertEqual("rights that are new count at once" in self.text(*NOW), gains)

    def test_a_participant_that_only_one_document_knows_decides_nothing_while_it_runs(self):
        other = grant(JOIN, subject="CN=listener", name="listener")
        self.write(permissions(grant(JOIN)), permissions(grant(JOIN), other))
        self.assertEqual(self.takes(*NOW), ("live", ""))

    def test_wider_and_narrower_is_mixed_and_fails_both_ways(self):
        self.write(permissions(grant(rule("allow", "rt/a*"))),
                   permissions(grant(rule("allow", "rt/*z"))))
        for threshold in ("wider", "narrower", "any"):
            out = self.diff("--fail-on", threshold, exit=1)
            self.assertEqual(out["verdict"], "mixed")
        seen = {c["class"]: c["topics"]["witness"] for c in out["changes"]}
        self.assertEqual(seen, {"wider": "rt/z", "narrower": "rt/a"})
        self.refused("usage", 2, "permissions", "diff", "old.xml", "new.xml", "--fail-on", "weaker")

    def test_a_default_comes_first_on_its_own_line(self):
        self.write(permissions(grant(rule("allow", "rt/*"))),
                   permissions(grant(rule("deny", "rt/*"), default="ALLOW")))
        out = self.diff()
        self.assertEqual([(c["element"], c["old"], c["new"], c["class"]) for c in out["changes"][:1]],
                         [("default", "DENY", "ALLOW", "wider")])
        self.assertRegex(self.text(), r"^subject CN=talker\n  WIDER     default DENY -> ALLOW  ")

    def test_times_subjects_and_grants_have_lines_of_their_own(self):
        self.write(permissions(grant(rule("allow", "rt/*"), subject="CN=talker,O=Acme")),
                   permissions(grant(rule("allow", "rt/*"), subject="O=Acme, CN=talker",
                                     until="2028-01-01"),
                               grant(rule("allow", "x"), subject="CN=new", name="new")))
        seen = [(c["element"], c["class"]) for c in self.diff()["changes"]]
        self.assertEqual(seen, [("validity", "wider"), ("grant", "wider"), ("join", "wider"),
                                ("rule", "wider"), ("subject_name", "interop")])
        text = self.text()
        self.assertIn("validity  2026-01-01T00:00:00Z .. 2027-01-01T00:00:00Z", text)
        self.assertIn("grant absent -> present", text)
        self.assertIn("publish topic x  denied -> allowed", text)
        self.assertIn("other products compare the text", text)

    def test_a_renamed_subject_can_be_followed(self):
        self.write(permissions(grant(rule("allow", "rt/*"))),
                   permissions(grant(rule("allow", "rt/*"), subject="CN=talker-2")))
        self.assertEqual(self.diff()["verdict"], "mixed")
        out = self.diff("--subject-map", "--fail-on", "wider")
        self.assertEqual((out["verdict"], [c["element"] for c in out["changes"]]),
                         ("neutral", ["subject_name"]))

    def test_an_expression_is_no_renamed_subject(self):
        everybody = permissions(grant(rule("allow", "rt/*"))).replace("<subject_name>CN=talker</subject_name>",
            "<subject_name_expression>CN=*,O=*</subject_name_expression>")
        self.assertIn("CN=*,O=*", everybody)
        self.write(permissions(grant(rule("allow", "rt/*"))), everybody)
        self.assertEqual(self.diff("--subject-map", "--fail-on", "wider", exit=1)["verdict"], "mixed")
        self.write(permissions(grant(rule("allow", "rt/*"))), permissions(grant(rule("allow", "rt/*"), subject="CN=admin")))
        self.assertNotIn("the same to ddssec", self.text("--subject-map"))

    def test_what_is_not_compared_is_unknown(self):
        self.write(permissions(grant(rule("deny", "*a" + "?" * 12), rule("allow", "*"))),
                   permissions(grant(rule("deny", "*[ab]" + "?" * 12), rule("allow", "*"))))
        self.assertEqual(self.diff("--fail-on", "narrower", exit=1)["verdict"], "unknown")
        self.assertIn("too many combinations", self.text())

    def test_relaying_is_a_right(self):
        relay = rule("allow", "rt/x", operation="relay")
        self.write(permissions(grant(rule("allow", "rt/*"))),
                   permissions(grant(rule("allow", "rt/*"), relay)))
        self.assertEqual(self.diff("--fail-on", "wider", exit=1)["verdict"], "wider")
        self.assertIn("WIDER     relay topic rt/x  denied -> allowed", self.text())

    def test_partitions_are_part_of_the_example(self):
        listed = "<partitions><partition>p</partition></partitions>\n"
        self.write(permissions(grant(rule("allow", "rt/*"))),
                   permissions(grant(rule("allow", "rt/*", partitions=listed))))
        seen = {c["class"]: c["partitions"] for c in self.diff()["changes"]}
        self.assertEqual(seen, {"wider": ["p"], "narrower": [""]})
        self.assertIn("in partition p", self.text())

    def test_documents_of_another_kind_are_refused(self):
        self.write(permissions(grant(rule("allow", "*"))), governance(topic("*")))
        self.refused("document_kind", 3, "permissions", "diff", "old.xml", "new.xml")
        self.refused("document_kind", 3, "governance", "diff", "old.xml", "new.xml")


if __name__ == "__main__":
    main()

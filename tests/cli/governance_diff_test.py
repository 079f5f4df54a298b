#!/usr/bin/env python3
"""governance diff: what a change of a document changes, and for which participants."""

import itertools
import re

from diff_documents import Differences, governance, topic
from transcript import NOW, main


class GovernanceDifferences(Differences):
    def test_a_change_on_two_layers_is_told_topic_by_topic(self):
        self.write(governance(topic("rt/cmd*"), topic("*", "SIGN")),
                   governance(topic("rt/cmd*", "SIGN"), topic("*", "SIGN"), rtps="ENCRYPT"))
        out = self.diff("--fail-on", "weaker", exit=1)
        self.assertEqual((out["verdict"], out["breaks_interop"], out["flag_day_domains"]),
                         ("mixed", True, [[0, 0]]))
        data, rtps = out["changes"]
        self.assertEqual(data["topics"], {"witness": "rt/cmd", "expressions_old": ["rt/cmd*"],
                                          "expressions_new": ["rt/cmd*"], "other_sets": 0,
                                          "sets": [{"expression": "rt/cmd*", "also": None, "except": [],
                                                    "more_exceptions": False}]})
        self.assertEqual([data[k] for k in ("element", "old", "new", "class", "interop")],
                         ["data_protection_kind", "ENCRYPT", "SIGN", "weaker", "endpoint"])
        self.assertEqual((data["mask_old"], data["mask_new"]), ("0x80000077", "0x80000057"))
        self.assertEqual(data["properties_lost"], ["insider.payload_secrecy", "relay.payload_secrecy"])
        self.assertEqual((data["old_at"], data["new_at"]), ("old.xml:10", "new.xml:10"))
        self.assertEqual([rtps[k] for k in ("element", "class", "interop", "plugin_mask_new")],
                         ["rtps_protection_kind", "stronger", "participant", "0x80000007"])
        text = self.text("--fail-on", "weaker", exit=1)
        self.assertRegex(text, r"^domain 0\n  WEAKER   breaks topics rt/cmd\* \(e\.g\. rt/cmd\)  "
                               r"data_protection_kind ENCRYPT -> SIGN  old:10 new:10\n")
        self.assertIn("now insiders without the right to read can read the payload\n", text)
        self.assertIn("STRONGER breaks all topics  rtps_protection_kind SIGN -> ENCRYPT", text)
        self.assertIn("verdict: MIXED; participants still on the old file will not talk to those "
                      "on the new one (domain 0)\n", text)

    def test_a_change_of_some_topics_parts_no_participants(self):
        """Measured: all product pairs exchange all samples on other topics."""
        self.write(governance(topic("*")), governance(topic("Circle", "NONE"), topic("*")))
        text = " ".join(self.text().split())
        self.assertIn('verdict: WEAKER; on topics with a line "breaks" (domain 0), endpoints with the old file do not match those '
                      "with the new one; other topics work", text)
        self.assertNotIn("participants still on the old file", text)
        self.assertTrue(self.diff()["breaks_interop"])

    def test_origin_of_messages_that_nothing_proves_any_more(self):
        self.write(governance(topic("*", "NONE"), rtps="SIGN_WITH_ORIGIN_AUTHENTICATION"), governance(topic("*", "NONE")))
        self.assertEqual(self.diff("--fail-on", "weaker", exit=1)["changes"][0]["properties_lost"], ["insider.sender_known"])
        self.assertIn("now insiders that may read can write in the name of another writer", " ".join(self.text().split()))
        self.assertNotIn("stays protected", self.text())

    def test_rules_in_other_words_are_neutral(self):
        self.write(governance(topic("rt/x"), topic("rt/y"), topic("*", "SIGN")),
                   governance(topic("rt/[xy]"), topic("*", "SIGN")))
        out = self.diff("--fail-on", "any")
        self.assertEqual((out["verdict"], out["changes"], out["breaks_interop"]),
                         ("neutral", [], False))
        self.assertEqual(out["rewritten"], [{"domains": [[0, 0]], "tag_set": None, "only_old": ["rt/x", "rt/y"],
                                             "only_new": ["rt/[xy]"]}])
        self.assertIn("no name is treated differently\n", self.text())

    def test_what_running_participants_do_is_told(self):
        one = governance(topic("rt/x"), topic("*"))
        for new, ours, stock in ((one, "same", "same"),
                                 (governance(topic("rt/y", "NONE"), topic("rt/x"), topic("*")), "live unless in use",
                                  "restart"),
                                 (governance(topic("*")), "restart", "restart"),
                                 (governance(topic("rt/x"), topic("*"), unauthenticated="true"), "restart", "restart")):
            self.write(one, new)
            out = self.diff()["live"]
            self.assertEqual((out["ddssec"], out["stock"]), (ours, stock))
        self.assertEqual(out["reason"], "allow_unauthenticated_participants: false became true")
        self.assertIn("allow_unauthenticated_participants: false became true)", " ".join(self.text().split()))
        self.write(governance(topic("rt/x")), governance(topic("rt/x"), topic("rt/y")))
        self.assertEqual(self.diff()["live"]["ddssec"], "live")
        self.assertIn("running participants: on ddssec's plugins:  taken while they run", self.text())

    def test_more_protection_is_taken_in_two_phases(self):
        def live(old, new):
            self.write(old, new)
            out = self.diff()["live"]
            return out["embedded"], out["cyclonedds"], out["stock"], out["reason"]
        def of(kind):
            return governance(re.sub(r"(metadata|data)_protection_kind>\w+<", rf"\1_protection_kind>{kind}<", topic("rt/x")),
                              topic("*"))
        one, more = of("SIGN"), of("ENCRYPT")
        self.assertEqual(live(one, more), ("two phases", "live unless in use", "restart", 'more protection for "rt/x"'))
        self.assertRegex(self.text(), r"embedded participants of ddssec:\s+taken while they run, in two phases")
        text = " ".join(self.text().split())
        self.assertIn("once it is signed: ddssec governance sign writes the revision that it needs", text)
        self.assertIn("a participant that stays with the old file no longer matches those that have changed", text)
        self.assertIn("put it into all folders within a minute: embedded participants change together", text)
        self.assertNotIn("second domain", text)
        self.assertEqual(live(more, one)[:3], ("restart", "restart", "restart"))
        self.assertIn("second domain", self.text())

        def numbered(text, revision):
            declaration, rest = text.split("\n", 1)
            return f'{declaration}\n<?ddssec revision="{revision}"?>\n{rest}'
        self.assertEqual(live(numbered(one, 1), numbered(more, 2))[0], "two phases")
        self.assertEqual(live(numbered(one, 2), numbered(more, 2))[0], "refused as a roll-back")
        self.assertEqual(live(numbered(one, 2), numbered(one, 1))[3], "revision 1 does not follow 2")
        self.assertEqual(live(numbered(one, 1), numbered(one, 2))[0], "same")
        self.assertEqual(live(numbered(one, 1), more)[0], "two phases", "signing it writes the next revision")

    def test_stronger_kinds_of_the_domain_are_taken_in_two_phases(self):
        """As GovernancePhases.StrongerKindOfTheDomain_Waits has it of participants, and the table of
        renew-without-restart.md."""
        origin = "_WITH_ORIGIN_AUTHENTICATION"
        kinds = ("NONE", "SIGN", "ENCRYPT", "SIGN" + origin, "ENCRYPT" + origin)
        rise = {("NONE", "SIGN"), ("NONE", "ENCRYPT"), ("SIGN", "ENCRYPT"), ("SIGN" + origin, "ENCRYPT" + origin)}
        for element in ("rtps", "discovery", "liveliness"):
            for before, after in itertools.permutations(kinds, 2):
                self.write(*(governance(topic("*", "SIGN"), **{element: kind}) for kind in (before, after)))
                live = self.diff()["live"]
                embedded = "two phases" if (before, after) in rise else "restart"
                self.assertEqual((live["embedded"], live["cyclonedds"], live["stock"]), (embedded, "restart", "restart"))
                self.assertEqual(live["reason"], f"{element}_protection_kind: {before} became {after}")
        self.write(*(governance(topic("*", "SIGN"), rtps=kind) for kind in ("SIGN", "ENCRYPT")))
        text = " ".join(self.text().split())
        self.assertIn("embedded participants of ddssec: taken while they run, in two phases", text)
        self.assertIn("Cyclone DDS on ddssec's plugins: restart", text)
        self.assertIn("a participant that stays with the old file does not talk to those that have changed", text)
        self.assertIn("start all others again at that time", text)
        self.assertNotIn("second domain", text)

    def test_protection_of_messages_begins_only_without_unauthenticated_participants(self):
        for unauthenticated, embedded in (("true", "restart"), ("false", "two phases")):
            self.write(*(governance(topic("*", "SIGN"), rtps=kind, unauthenticated=unauthenticated) for kind in ("NONE", "SIGN")))
            self.assertEqual(self.diff()["live"]["embedded"], embedded)

    def test_a_layer_that_falls_while_another_one_rises_needs_a_restart(self):
        """Each document demands one of the two. A message that lacks both must never pass."""
        self.write(governance(topic("*", "NONE"), rtps="SIGN"), governance(topic("*", "NONE", "SIGN"), rtps="NONE"))
        self.assertEqual(self.diff()["live"]["embedded"], "restart")
        self.write(governance(topic("*", "NONE", "SIGN"), rtps="NONE"), governance(topic("*", "NONE"), rtps="SIGN"))
        self.assertEqual(self.diff()["live"]["embedded"], "restart")

    def test_flags_of_topics_that_begin_are_taken_in_two_phases(self):
        for flag in ("discovery", "liveliness", "read", "write"):
            for before, after in itertools.permutations(("true", "false")):
                self.write(*(governance(topic("rt/x", **{flag: value}), topic("rt/open", discovery="false"))
                             for value in (before, after)))
                live = self.diff()["live"]
                if after == "true":
                    self.assertEqual((live["embedded"], live["cyclonedds"]), ("two phases", "live unless in use"))
                    self.assertEqual(live["reason"], 'more protection for "rt/x"')
                else:
                    self.assertEqual((live["embedded"], live["cyclonedds"]), ("restart", "restart"))

    def test_a_rule_before_others_that_protects_its_topics_more_is_taken_in_two_phases(self):
        def live(old, new):
            self.write(old, new)
            out = self.diff()["live"]
            return out["embedded"], out["cyclonedds"]
        encrypted, signed, none = (re.sub(r"(metadata|data)_protection_kind>\w+<", rf"\1_protection_kind>{kind}<", topic("rt/y"))
                                   for kind in ("ENCRYPT", "SIGN", "NONE"))
        every = signed.replace("rt/y", "*")
        self.assertEqual(live(governance(every), governance(encrypted, every)), ("two phases", "live unless in use"))
        self.assertIn('(a further rule for "rt/y")', self.text())
        self.assertEqual(live(governance(every), governance(none, every)), ("live unless in use",) * 2)
        self.assertEqual(live(governance(every), governance(signed, every)), ("live", "live"))
        stronger = encrypted.replace("rt/y", "rt/z")
        self.assertEqual(live(governance(stronger, every), governance(signed, stronger, every)), ("live unless in use",) * 2)
        self.assertEqual(live(governance(stronger, every), governance(stronger, encrypted, every)),
                         ("two phases", "live unless in use"))

    def test_a_signed_document_without_a_revision_is_refused(self):
        self.run_program("ca", "create", "ca", "--role", "permissions", "--no-passphrase", *NOW)
        less = governance(topic("rt/x", "NONE"), topic("*"))
        more = governance(re.sub(r"metadata_protection_kind>\w+<", "metadata_protection_kind>ENCRYPT<", topic("rt/x", "NONE")), topic("*"))
        further = governance(topic("rt/x", "NONE"), topic("*"), topic("rt/z"))
        def signed(name, text, *options):
            (self.at / f"{name}.xml").write_text(text)
            self.run_program("governance", "sign", f"{name}.xml", "--ca", "ca", "--no-lint", "--replace", *options, *NOW)
            return f"{name}.p7s"
        def live(old, new):
            out = self.json("governance", "diff", old, new, exit=None)["result"]["live"]
            return out["embedded"], out["cyclonedds"]
        none, refused = "--no-revision", ("refused without a revision",) * 2
        old, old_2 = signed("old", less, none), signed("old_2", less)
        new = signed("new", more, none)
        self.assertEqual(live(old, new), refused)
        self.assertEqual(live(old_2, new), refused)
        self.assertEqual(live(old_2, signed("same", less + "<!-- -->", none)), refused)
        self.assertEqual(live(old, signed("further", further, none)), ("live", "live"))
        self.assertEqual(live(old_2, signed("further", further, none)), refused)
        text = " ".join(self.run_program("governance", "diff", old, new).stdout.split())
        self.assertIn("on ddssec's plugins: refused: ddssec governance sign writes the revision that it lacks "
                      "(more protection needs a revision)", text)
        self.assertNotIn("in two phases", text)
        self.assertEqual(live(old_2, signed("new", more)), ("two phases", "live unless in use"))
        self.assertRegex(self.run_program("governance", "diff", old_2, new).stdout, r"ddssec:\s+taken while they run, in two phases\s*\(")

    def test_participants_whose_tags_only_an_expression_covers_are_judged(self):
        tagged = "<id>0</id><tag_expression>fleet-*</tag_expression>"
        self.write(governance(topic("*"), domain=tagged), governance(topic("*"), domain=tagged, unauthenticated="true"))
        self.assertEqual(self.diff()["live"]["ddssec"], "restart")

    def test_a_rule_that_opens_discovery_needs_a_restart(self):
        closed, opened = topic("rt/x"), topic("rt/open", discovery="false")
        self.write(governance(closed), governance(closed, opened))
        out = self.diff()["live"]
        self.assertEqual(out["ddssec"], "restart")
        self.assertEqual(out["reason"], 'enable_discovery_protection: true for every topic became false for "rt/open"')
        self.write(governance(closed, opened), governance(closed, opened, topic("rt/further", discovery="false")))
        self.assertEqual(self.diff()["live"]["ddssec"], "live")

    def test_a_document_that_another_ca_signed_is_refused_while_they_run(self):
        for name in ("one", "other"):
            self.run_program("ca", "create", name, "--role", "permissions", "--subject", f"CN={name}", "--no-passphrase", *NOW)
        self.write(governance(topic("rt/x")), governance(topic("rt/x"), topic("rt/y")))
        for document, ca in (("old.xml", "one"), ("new.xml", "other"), ("new.xml", "other"), ("new.xml", "one")):
            self.run_program("governance", "sign", document, "--ca", ca, "-o", f"{ca}-{document}.p7s", "--no-lint",
                             "--replace", *NOW)
        for new, expected in (("one", "live"), ("other", "live if the signer is believed")):
            out = self.json("governance", "diff", "one-old.xml.p7s", f"{new}-new.xml.p7s", exit=None)["result"]
            self.assertEqual(out["live"]["ddssec"], expected)

    def test_fail_on_says_what_is_too_much(self):
        self.write(governance(topic("*"), unauthenticated="true"), governance(topic("*")))
        for threshold, exit in (("weaker", 0), ("breaking", 0), ("any", 1)):
            self.assertEqual(self.diff("--fail-on", threshold, exit=exit)["verdict"], "stronger")
        self.write(governance(topic("*", "SIGN")), governance(topic("*")))
        for threshold, exit in (("weaker", 0), ("breaking", 1), ("any", 1)):
            self.diff("--fail-on", threshold, exit=exit)
        self.write(governance(topic("*")), governance(topic("*", "NONE")))
        self.diff()
        self.diff("--fail-on", "weaker", exit=1)
        self.refused("usage", 2, "governance", "diff", "old.xml", "new.xml", "--fail-on", "wider")

    def test_the_text_says_what_the_comparison_leaves_open(self):
        for profile in ("strict", "open"):
            self.run_program("governance", "new", "--profile", profile, "-o", f"{profile}.xml")
        text = self.run_program("governance", "diff", "strict.xml", "open.xml").stdout
        self.assertNotIn("stays protected", text)
        self.assertIn("by itself it takes no protection away", text)
        self.assertNotIn("--topics were compared", text)
        less = (self.at / "strict.xml").read_text().replace(
            "<liveliness_protection_kind>ENCRYPT", "<liveliness_protection_kind>NONE")
        (self.at / "less.xml").write_text(less)
        self.assertIn("stays protected", self.run_program("governance", "diff", "strict.xml", "less.xml").stdout)
        (self.at / "topics").write_text("Square\n")
        text = self.run_program("governance", "diff", "strict.xml", "open.xml", "--topics", "topics").stdout
        self.assertIn("only the topics of --topics were compared", text)

    def test_what_is_too_hard_is_unknown_and_fails(self):
        self.write(governance(topic("*a" + "?" * 12), topic("*", "NONE")),
                   governance(topic("*[ab]" + "?" * 12), topic("*", "NONE")))
        for threshold in ("weaker", "breaking", "any"):
            self.assertEqual(self.diff("--fail-on", threshold, exit=1)["verdict"], "unknown")
        self.assertIn("UNKNOWN", self.text())
        (self.at / "topics").write_text("# in use\nb" + "x" * 12 + "\r\n\nchatter\n")
        out = self.diff("--topics", "topics", "--fail-on", "weaker")
        self.assertEqual((out["verdict"], out["changes"][0]["topics"]["witness"]),
                         ("stronger", "b" + "x" * 12))
        (self.at / "topics").write_text("# none\n")
        self.refused("usage", 2, "governance", "diff", "old.xml", "new.xml", "--topics", "topics")

    def test_domains_and_topics_that_come_and_go(self):
        self.write(governance(topic("rt/*"), domain="<id_range><min>0</min><max>9</max></id_range>"),
                   governance(topic("*"), domain="<id>5</id>"))
        out = self.diff()
        seen = [(c["element"], c["domains"], c["old"], c["new"], c["class"]) for c in out["changes"]]
        self.assertEqual(seen, [("topic_rule", [[5, 5]], "uncovered", "covered", "wider"),
                                ("domain_rule", [[0, 4], [6, 9]], "covered", "uncovered",
                                 "narrower")])
        self.assertEqual((out["verdict"], out["changes"][0]["mask_old"]), ("mixed", None))
        self.assertIsNone(out["changes"][1]["new_at"])
        self.text()

    def test_long_and_strange_names_stay_within_the_line(self):
        strange = "rt/" + "very_long_" * 30 + "&#xE9;[&#9;]"
        self.write(governance(topic(strange), topic("*", "SIGN")),
                   governance(topic(strange, "NONE"), topic("*", "SIGN")))
        self.assertIn("...", self.text())
        names = ["rt/" + c * 60 for c in "abcdef"]
        self.write(governance(*map(topic, names), topic("*", "SIGN")),
                   governance(*(topic(n, "SIGN") for n in names), topic("*", "SIGN")))
        self.assertIn(" and 3 more", self.text())
        self.write(governance(topic("[&#9;]x"), topic("*", "SIGN")),
                   governance(topic("[&#9;]x", "NONE"), topic("*", "SIGN")))
        self.assertIn(r"\x09x", self.text())

    def test_signed_documents_are_verified_only_with_a_ca(self):
        self.write(governance(topic("*", "SIGN")), governance(topic("*")))
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        self.run_program("ca", "create", "other", "--no-passphrase", *NOW)
        for name, ca in (("old", "ca"), ("new", "ca"), ("foreign", "other")):
            xml = "old.xml" if name == "foreign" else f"{name}.xml"
            self.run_program("governance", "sign", xml, "--ca", ca, "-o", f"{name}.p7s", *NOW)
        trusted = ("--ca", "ca/permissions/ca.pem", *NOW)

        out = self.json("governance", "diff", "old.p7s", "new.p7s", *trusted)["result"]
        self.assertEqual((out["verdict"], out["signer"]["same"]), ("stronger", True))
        self.assertEqual(out["signer"]["verified"], {"old": True, "new": True})
        fingerprint = self.json("ca", "show", "ca/permissions")["result"]["sha256"]
        self.assertEqual(out["signer"]["old"], fingerprint)
        text = self.run_program("governance", "diff", "old.p7s", "new.p7s", *trusted).stdout
        self.assertIn("signer unchanged (", text)

        unverified = self.json("governance", "diff", "old.p7s", "foreign.p7s", "--fail-on",
                               "any", exit=1)["result"]
        self.assertEqual((unverified["verdict"], unverified["signer"]["same"]), ("neutral", False))
        self.assertIn("CN=other Permissions CA", unverified["signer"]["new"])
        text = self.run_program("governance", "diff", "old.p7s", "foreign.p7s").stdout
        self.assertIn("signer CHANGED\n", text)
        self.assertIn("signatures: old NOT verified, new NOT verified", text)
        self.refused("smime_signer_not_permissions_ca", 1, "governance", "diff", "old.p7s",
                     "foreign.p7s", *trusted)

        mixed = self.run_program("governance", "diff", "old.p7s", "new.xml", *trusted).stdout
        self.assertIn("signatures: old verified, new is not signed\n", mixed)

    def test_what_cannot_be_read_is_not_compared(self):
        self.write(governance(topic("*")), "no document")
        self.refused("xml_not_well_formed", 3, "governance", "diff", "old.xml", "new.xml")
        self.refused("file_not_found", 3, "governance", "diff", "old.xml", "missing.xml")


    def test_what_other_products_read_differently_is_listed(self):
        self.write(governance(topic("rt/[a]"), topic("*")), governance(topic("rt/[[.a.]]"), topic("*")).replace(
            "<allow_unauthenticated", "<enable_key_revision>false</enable_key_revision>\n<allow_unauthenticated", 1))
        out = self.diff("--fail-on", "weaker")
        self.assertEqual((out["verdict"], out["changes"], out["readings"]["complete"]), ("neutral", [], True))
        order, note, expression = out["readings"]["all"]
        self.assertIn("is not in the schema's order", order["sentence"])
        self.assertEqual((note["document"], note["expression"], note["at"]), ("new", None, "new.xml:4"))
        self.assertIn("came with DDS-Security 1.2", note["sentence"])
        self.assertEqual((expression["expression"], expression["at"]), ("rt/[[.a.]]", "new.xml:11"))
        self.diff("--fail-on", "any", exit=1)
        text = self.text()
        self.assertIn("what other products may read differently, and only one document has:\n  interop   ", text)
        self.assertRegex(text, r"Cyclone DDS does\s+not\s+match")
        self.write(governance(topic("rt/a")), governance(topic("rt/[a]")))
        self.assertEqual(self.diff()["readings"], {"all": [], "complete": True})
        self.assertNotIn("interop", self.text())

    def test_what_is_weaker_for_a_stock_product_alone_fails_the_gate(self):
        full, opened = "<id_range><min>0</min><max>230</max></id_range>", "<id_range><min>0</min></id_range>"
        weak = governance(topic("*", "NONE"), domain=full, rtps="NONE")
        weak = weak[weak.index("<domain_rule>"):weak.index("</domain_access_rules>")]
        strong = governance(topic("*"), domain=full).replace("</domain_rule>\n", "</domain_rule>").replace(
            "</domain_access_rules>", weak + "</domain_access_rules>")
        self.write(strong, strong.replace(full, opened, 1))
        out = self.diff("--fail-on", "weaker", exit=1)
        self.assertEqual((out["verdict"], out["changes"]), ("neutral", []))
        self.assertIn("rtps_protection_kind SIGN -> NONE in domain 1-230: weaker",
                      "".join(one["sentence"] for one in out["readings"]["all"]))
        changed = strong.replace(full, opened, 1)
        lines = {changed[:changed.rindex(f"<{element}>")].count("\n") + 1 for element in ("domain_rule", "topic_rule")}
        theirs = [one["at"] for one in out["readings"]["all"] if one["sentence"].startswith("with ")]
        self.assertEqual(set(theirs), {f"new.xml:{line}" for line in lines})
        text = self.text()
        for line in lines:
            self.assertRegex(text, rf"\bnew:{line}\b")
        self.assertIn("another product allows more", text)
        told = self.json("governance", "lint", "new.xml", exit=1)["diagnostics"]
        self.assertIn("apply it to domain 1-230", "".join(one["message"] for one in told if one["id"] == "GOV002"))
        self.write(strong.replace(full, opened, 1), strong)
        self.diff("--fail-on", "weaker")


if __name__ == "__main__":
    main()

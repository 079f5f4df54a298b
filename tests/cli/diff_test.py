#!/usr/bin/env python3
"""governance diff and permissions diff: what a change of a document changes, and for whom."""

import re

from transcript import Transcript, main

NOW = ("--now", "2026-11-21T00:00:00Z")


def topic(expression, data="ENCRYPT", metadata="NONE", discovery="true"):
    return (f"<topic_rule><topic_expression>{expression}</topic_expression>\n"
            f"<enable_discovery_protection>{discovery}</enable_discovery_protection>\n"
            "<enable_liveliness_protection>true</enable_liveliness_protection>\n"
            "<enable_read_access_control>true</enable_read_access_control>\n"
            "<enable_write_access_control>true</enable_write_access_control>\n"
            f"<metadata_protection_kind>{metadata}</metadata_protection_kind>\n"
            f"<data_protection_kind>{data}</data_protection_kind></topic_rule>\n")


def governance(*topics, domain="<id>0</id>", rtps="SIGN", unauthenticated="false"):
    return ('<?xml version="1.0" encoding="UTF-8"?>\n<dds><domain_access_rules><domain_rule>\n'
            f"<domains>{domain}</domains>\n"
            f"<allow_unauthenticated_participants>{unauthenticated}"
            "</allow_unauthenticated_participants>\n"
            "<enable_join_access_control>true</enable_join_access_control>\n"
            "<discovery_protection_kind>ENCRYPT</discovery_protection_kind>\n"
            "<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>\n"
            f"<rtps_protection_kind>{rtps}</rtps_protection_kind>\n"
            f"<topic_access_rules>\n{''.join(topics)}</topic_access_rules>\n"
            "</domain_rule></domain_access_rules></dds>\n")


def rule(kind, *topics, domains="<id>0</id>", operation="publish", partitions=""):
    names = "\n".join(f"<topic>{name}</topic>" for name in topics)
    return (f"<{kind}_rule>\n<domains>{domains}</domains>\n<{operation}>\n<topics>\n{names}\n"
            f"</topics>\n{partitions}</{operation}>\n</{kind}_rule>\n")


JOIN = "<allow_rule>\n<domains><id>0</id></domains>\n</allow_rule>\n"


def grant(*rules, subject="CN=talker", name="talker", until="2027-01-01", default="DENY"):
    return (f'<grant name="{name}">\n<subject_name>{subject}</subject_name>\n'
            f"<validity><not_before>2026-01-01T00:00:00Z</not_before>\n"
            f"<not_after>{until}T00:00:00Z</not_after></validity>\n{''.join(rules)}"
            f"<default>{default}</default>\n</grant>\n")


def permissions(*grants):
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<dds><permissions>\n{"".join(grants)}' \
           "</permissions></dds>\n"


class Differences(Transcript):
    def write(self, old, new, kind="governance"):
        self.kind = kind
        (self.at / "old.xml").write_text(old)
        (self.at / "new.xml").write_text(new)

    def diff(self, *words, exit=0):
        return self.json(self.kind, "diff", "old.xml", "new.xml", *words, exit=exit)["result"]

    def text(self, *words, exit=0):
        text = self.run_program(self.kind, "diff", "old.xml", "new.xml", *words, exit=exit).stdout
        self.assertLessEqual(max(map(len, text.splitlines())), 100)
        return text


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
        now = ("--now", "2026-11-21T00:00:00Z")
        self.run_program("ca", "create", "ca", "--role", "permissions", "--no-passphrase", *now)
        less = governance(topic("rt/x", "NONE"), topic("*"))
        more = governance(re.sub(r"metadata_protection_kind>\w+<", "metadata_protection_kind>ENCRYPT<", topic("rt/x", "NONE")), topic("*"))
        further = governance(topic("rt/x", "NONE"), topic("*"), topic("rt/z"))
        def signed(name, text, *options):
            (self.at / f"{name}.xml").write_text(text)
            self.run_program("governance", "sign", f"{name}.xml", "--ca", "ca", "--no-lint", "--replace", *options, *now)
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
        now = ("--now", "2026-11-21T00:00:00Z")
        for name in ("one", "other"):
            self.run_program("ca", "create", name, "--role", "permissions", "--subject", f"CN={name}", "--no-passphrase", *now)
        self.write(governance(topic("rt/x")), governance(topic("rt/x"), topic("rt/y")))
        for document, ca in (("old.xml", "one"), ("new.xml", "other"), ("new.xml", "other"), ("new.xml", "one")):
            self.run_program("governance", "sign", document, "--ca", ca, "-o", f"{ca}-{document}.p7s", "--no-lint",
                             "--replace", *now)
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
            for topic in ("Square", "Circle"):
                self.assertTrue(any(one.startswith("with Cyclone DDS: ") and f'topics such as "{topic}"' in one for one in sentences),
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
        out = self.diff("--fail-on", "wider")
        self.assertEqual((out["verdict"], out["breaks_interop"]), ("narrower", False))
        self.assertEqual(out["takes_effect"], {"embedded": "live", "cyclonedds_ddssec": "live", "cyclonedds": "restart",
                                               "fastdds": "restart", "reason": "", "at": None})
        change, = out["changes"]
        self.assertEqual([change[k] for k in ("subject", "element", "operation", "old", "new")],
                         ["CN=talker", "rule", "publish", "allowed", "denied"])
        self.assertEqual(change["topics"], {
            "witness": "rt/cmd", "expressions_old": ["rt/*"], "expressions_new": ["rt/cmd*"], "other_sets": 0,
            "sets": [{"expression": "rt/cmd*", "also": None, "except": [], "more_exceptions": False}]})
        self.assertEqual((change["domains"], change["partitions"], change["old_at"], change["new_at"]),
                         ([[0, 0]], [""], "old.xml:14", "new.xml:14"))
        self.diff("--fail-on", "narrower", exit=1)
        text = self.text()
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

#!/usr/bin/env python3
"""governance new: documents from profiles and topic rules, valid by the OMG's schema."""

import xml.etree.ElementTree as ElementTree

from transcript import NOW, Transcript, main


class NewGovernance(Transcript):
    def new(self, *words, **more):
        return self.json("governance", "new", "-o", "g.xml", *words, **more)

    def document(self):
        self.assertMeetsSchema("g.xml", "governance.xsd")
        return ElementTree.parse(self.at / "g.xml").getroot()

    def values(self, element):
        return {rule.findtext("topic_expression"): rule.findtext(element)
                for rule in self.document().iter("topic_rule")}

    def test_profiles_meet_the_schema(self):
        for profile, rtps, data in (("open", "NONE", "NONE"), ("balanced", "SIGN", "ENCRYPT"),
                                    ("strict", "SIGN", "ENCRYPT")):
            out = self.new("--profile", profile)
            self.assertEqual(out["result"], {"file": "g.xml", "profile": profile, "topic_rules": 1})
            self.assertEqual([f["mode"] for f in out["files_written"]], ["0644"])
            self.assertEqual(self.document().findtext(".//rtps_protection_kind"), rtps)
            self.assertEqual(self.values("data_protection_kind"), {"*": data})
            (self.at / "g.xml").unlink()
        self.assertEqual(self.new()["result"]["profile"], "strict")

    def test_domains_and_topic_rules(self):
        self.new("--domain", "0-5", "--domain", "7", "--topic", "rt/cam*:data=none,read=false",
                 "--topic", "a::b:metadata_protection_kind=SIGN_WITH_ORIGIN_AUTHENTICATION",
                 "--topic", "rt/<&>:", "--topic", "bare")
        root = self.document()
        self.assertEqual([e.text for e in root.find(".//domains").iter() if e.text.strip()],
                         ["0", "5", "7"])
        strict = "ENCRYPT"
        self.assertEqual(self.values("data_protection_kind"),
                         {"rt/cam*": "NONE", "a::b": strict, "rt/<&>": strict, "bare": strict,
                          "*": strict})
        self.assertEqual(self.values("metadata_protection_kind")["a::b"],
                         "SIGN_WITH_ORIGIN_AUTHENTICATION")
        self.assertEqual(self.values("enable_read_access_control")["rt/cam*"], "false")
        self.assertEqual(self.values("enable_write_access_control")["rt/cam*"], "true")

    def test_a_rule_for_everything_is_not_written_twice(self):
        self.new("--topic", "rt/a:data=SIGN", "--topic", "*:data=NONE")
        self.assertEqual(self.values("data_protection_kind"), {"rt/a": "SIGN", "*": "NONE"})

    def test_a_pre_shared_key_is_asked_for_by_name(self):
        self.new("--pre-shared-key", "encrypt")
        self.assertEqual(ElementTree.parse(self.at / "g.xml").getroot()
                         .findtext(".//rtps_psk_protection_kind"), "ENCRYPT")
        self.assertIn("rtps SIGN  pre-shared key ENCRYPT\n",
                      self.run_program("governance", "show", "g.xml").stdout)
        rule = self.json("governance", "show", "g.xml")["result"]["domain_rules"][0]
        self.assertEqual(rule["pre_shared_key"], "ENCRYPT")
        for kind in ("yes", "SIGN_WITH_ORIGIN_AUTHENTICATION"):
            self.refused("usage", 2, "governance", "new", "-o", "h.xml", "--pre-shared-key", kind)

    def test_key_revision_is_asked_for(self):
        self.new("--key-revision")
        self.assertEqual(ElementTree.parse(self.at / "g.xml").getroot()
                         .findtext(".//enable_key_revision"), "true")
        self.assertIn("rtps SIGN  keys are revised\n",
                      self.run_program("governance", "show", "g.xml").stdout)
        self.assertIs(self.json("governance", "show", "g.xml")["result"]["domain_rules"][0]["key_revision"],
                      True)

    def test_signed_at_once(self):
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        out = self.new("--sign", "--ca", "ca", *NOW)
        self.assertEqual([f["path"] for f in out["files_written"]], ["g.xml", "g.p7s"])
        self.run_program("governance", "verify", "g.p7s", "--ca", "ca/permissions/ca.pem", *NOW)
        self.refused("would_overwrite", 4, "governance", "new", "-o", "g.xml")
        (self.at / "g.xml").unlink()  # both or neither
        self.refused("would_overwrite", 4, "governance", "new", "-o", "g.p7s", "--sign", "--ca", "ca",
                     *NOW)

    def test_wrong_words_are_refused_and_nothing_is_written(self):
        new = ("governance", "new", "-o", "g.xml")
        self.refused("usage", 2, "governance", "new")
        self.refused("usage", 2, *new, "--profile", "paranoid")
        self.refused("usage", 2, *new, "--sign")
        for domain in ("231", "-1", "5-0", "0-", "x", "0-5-7"):
            self.refused("usage", 2, *new, "--domain=" + domain)
        for topic in ("", ":data=SIGN", "a:b", "a:data", "a:data=", "a:data=SIGNED", "a:read=TRUE",
                      "a:data=SIGN_WITH_ORIGIN_AUTHENTICATION", "a:colour=red", "a:data=SIGN,b"):
            told = self.refused("usage", 2, *new, "--topic", topic)
            self.assertIn("--topic", told["message"])
        self.refused("xml_control_character", 3, *new, "--topic", "a\x1bb:")


if __name__ == "__main__":
    main()

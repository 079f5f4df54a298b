#!/usr/bin/env python3
"""permissions new: the rights of one certificate's subject, valid by the OMG's schema."""

import xml.etree.ElementTree as ElementTree

from transcript import NOW, Transcript, main


class NewPermissions(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        self.run_program("identity", "issue", "talker", "--ca", "ca", "-o", "talker",
                         "--subject", "CN=talker,O=A & B,C=DE", *NOW)

    def new(self, *words, **more):
        return self.json("permissions", "new", "--cert", "talker/cert.pem", "-o", "p.xml", *NOW,
                         *words, **more)

    def document(self):
        self.assertMeetsSchema("p.xml", "permissions.xsd")
        return ElementTree.parse(self.at / "p.xml").getroot()

    def test_the_subject_and_the_dates_are_the_certificates(self):
        out = self.new("--publish", "rt/chatter", "--subscribe", "*")
        self.assertEqual(out["result"], {"file": "p.xml", "subject": "CN=talker,O=A & B,C=DE",
                                         "not_before": "2026-11-20T00:00:00Z",
                                         "not_after": "2027-11-21T00:00:00Z"})
        root = self.document()
        self.assertEqual(root.findtext(".//subject_name"), "CN=talker,O=A & B,C=DE")
        self.assertEqual([e.text for e in root.findall(".//publish/topics/topic")], ["rt/chatter"])
        self.assertEqual([e.text for e in root.findall(".//subscribe/topics/topic")], ["*"])
        self.assertEqual((root.findtext(".//domains/id"), root.findtext(".//default")), ("0", "DENY"))

    def test_denials_come_first_and_partitions_belong_to_what_is_allowed(self):
        self.new("--domain", "1-3", "--publish", "a", "--publish", "b", "--deny-publish", "c*",
                 "--deny-subscribe", "d", "--partition", "red", "--partition", "blue*")
        grant = self.document().find(".//grant")
        self.assertEqual([e.tag for e in grant],
                         ["subject_name", "validity", "allow_rule", "deny_rule", "allow_rule", "default"])
        join, allow = grant.findall("allow_rule")
        deny = grant.find("deny_rule")
        self.assertEqual([e.tag for e in join], ["domains"], "the first rule decides about joining")
        self.assertEqual([e.text for e in deny.iter("topic")], ["c*", "d"])
        self.assertEqual([e.text for e in deny.iter("partition")], [])
        self.assertEqual([e.text for e in allow.iter("partition")], ["red", "blue*"])
        self.assertEqual((allow.findtext(".//min"), allow.findtext(".//max")), ("1", "3"))

    def test_without_topics_it_may_join_and_nothing_else(self):
        self.new()
        self.assertEqual([e.tag for e in self.document().find(".//allow_rule")], ["domains"])

    def test_the_grant_has_the_name_of_the_subject(self):
        self.new("--publish", "a")
        self.assertEqual(self.document().find(".//grant").get("name"), "CN=talker,O=A & B,C=DE")
        self.run_program("identity", "issue", "radar", "--ca", "ca", "-o", "radar", *NOW)
        self.run_program("permissions", "new", "--cert", "radar", "-o", "p.xml", "--publish", "a", "--replace", *NOW)
        self.assertEqual(self.document().find(".//grant").get("name"), "radar")

    def test_its_life_can_be_shorter(self):
        self.assertEqual(self.new("--days", "30")["result"]["not_after"], "2026-12-21T00:00:00Z")
        (self.at / "p.xml").unlink()
        out = self.new("--not-after", "2027-01-01T00:00:00+01:00")
        self.assertEqual(out["result"]["not_after"], "2026-12-31T23:00:00Z")

    def test_permissions_of_another_participant_in_a_folder_are_warned_of(self):
        self.run_program("identity", "issue", "listener", "--ca", "ca", "-o", "listener", *NOW)
        self.new("--publish", "rt/a")
        sign = ("permissions", "sign", "p.xml", "--ca", "ca", "--replace", *NOW, "-o")

        def warned(to):
            return [d for d in self.json(*sign, to)["diagnostics"] if d["id"] == "DOC010"]

        told, = warned("listener/permissions.p7s")
        self.assertEqual(told["severity"], "warning")
        self.assertIn("no grant for CN=listener, the subject of listener/cert.pem", told["message"])
        for own in ("talker/permissions.p7s", "listener/of-talker.p7s"):
            self.assertEqual(warned(own), [])

    def test_sign_with_a_mistyped_subject_asks_for_a_similar_one(self):
        for name in ("camera", "robot1"):
            self.run_program("identity", "issue", name, "--ca", "ca", "-o", name, *NOW)
        for typed, meant in (("CN=camrea", "CN=camera"), ("CN=Camera", "CN=camera"), ("CN=robto1", "CN=robot1"),
                             ("CN=camera", None), ("CN=robot2", None), ("CN=unlike", None)):
            self.run_program("permissions", "new", "--cert", "camera", "-o", "p.xml", "--publish", "a", "--replace", *NOW)
            text = (self.at / "p.xml").read_text().replace("CN=camera", typed)
            (self.at / "p.xml").write_text(text)
            told = [d for d in self.json("permissions", "sign", "p.xml", "--ca", "ca", "-o", "p.p7s", "--replace",
                                         *NOW)["diagnostics"] if d["id"] == "DOC010"]
            self.assertEqual(len(told), 0 if meant is None else 1, typed)
            for one in told:
                self.assertEqual((one["severity"], one["file"]), ("warning", "p.xml"))
                self.assertIn(f'no certificate for "{typed}", so that no participant can use this grant; is "{meant}" meant?',
                              one["message"])
        self.run_program("permissions", "sign", "p.xml", "--ca", "ca/permissions", "-o", "p.p7s", "--replace", *NOW)

    def test_signed_permissions_complete_a_folder(self):
        out = self.json("permissions", "new", "--cert", "talker", "-o",
                        "talker/permissions.p7s", "--publish", "rt/a", "--sign", "--ca", "ca", *NOW)
        self.assertEqual([f["path"] for f in out["files_written"]],
                         ["talker/permissions.xml", "talker/permissions.p7s"])
        self.run_program("permissions", "verify", "talker/permissions.p7s", "--ca",
                         "ca/permissions/ca.pem", *NOW)

    def warnings(self, *words):
        return self.run_program("permissions", *words, "--ca", "ca", *NOW).stderr

    def test_end_before_the_certificates_is_warned_of(self):
        new = ("new", "--cert", "talker/cert.pem", "--publish", "a", "--replace", "--sign", "-o")
        told = self.warnings(*new, "talker/permissions.xml", "--days", "3")
        self.assertIn("warning[end_not_final]", told)
        self.assertIn("ddssec agent --permissions", told)
        self.assertIn("warning[end_not_final]", self.warnings("sign", "talker/permissions.xml", "--replace"))
        self.assertNotIn("end_not_final", self.warnings(*new, "talker/permissions.xml"))
        self.assertNotIn("end_not_final", self.warnings(*new, "elsewhere.xml", "--days", "3"))

    def test_permissions_for_a_folder_that_are_signed_elsewhere_are_warned_of(self):
        """Those in the folder stay the last that the CA signed for it."""
        new = ("new", "--cert", "talker/cert.pem", "--publish", "a", "--replace", "--sign", "-o")
        self.assertNotIn("signed_elsewhere", self.warnings(*new, "draft.xml"))  # the folder has none
        self.assertNotIn("signed_elsewhere", self.warnings(*new, "talker/permissions.xml"))
        told = self.warnings(*new, "narrow.xml")
        self.assertIn("warning[signed_elsewhere]", told)
        self.assertIn("talker/permissions.p7s", told)
        self.assertIn("warning[signed_elsewhere]", self.warnings("sign", "narrow.xml", "--replace"))
        self.assertNotIn("signed_elsewhere", self.warnings("sign", "narrow.xml", "-o", "talker/permissions.p7s", "--replace"))

    def test_a_comma_makes_no_list_of_topics(self):
        for option in ("--publish", "--subscribe", "--deny-publish", "--deny-subscribe"):
            told = self.refused("usage", 2, "permissions", "new", "--cert", "talker", option, "rt/a,rt/b", "-o", "x")
            self.assertIn(f"{option} may be repeated", told["message"])
        self.refused("usage", 2, "identity", "issue", "x", "--ca", "ca", "-o", "x", "--publish", "a,b")
        self.refused("usage", 2, "init", "x", "--allow-topics", "a,b")

    def test_wrong_words_are_refused_and_nothing_is_written(self):
        new = ("permissions", "new", "--cert", "talker/cert.pem", "-o", "p.xml", *NOW)
        self.refused("usage", 2, "permissions", "new", "-o", "p.xml")
        self.refused("usage", 2, *new, "--days", "1", "--not-after", "2027-01-01T00:00:00Z")
        self.refused("usage", 2, *new, "--days", "0")
        self.refused("usage", 2, *new, "--not-after", "tomorrow")
        self.refused("usage", 2, *new, "--not-after", "2020-01-01T00:00:00Z")
        self.refused("usage", 2, *new, "--domain", "300")
        self.refused("element_empty", 3, *new, "--publish", "")
        self.refused("xml_control_character", 3, *new, "--publish", "a", "--partition", "\x01")
        self.refused("usage", 2, *new, "--partition", "a")
        self.refused("file_not_found", 3, "permissions", "new", "--cert", "none.pem", "-o", "p.xml")
        self.refused("certificate_malformed", 3, "permissions", "new", "--cert",
                     "talker/key.pem", "-o", "p.xml")


if __name__ == "__main__":
    main()

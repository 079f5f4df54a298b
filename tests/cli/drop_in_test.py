#!/usr/bin/env python3
"""doctor, check and can know what ddssec's plugins within Cyclone DDS refuse and the embedded participant does not.
Measured with the drop-in: codes 1402 and 1612."""

import shutil

from transcript import NOW, Transcript, library_path, main, shared_library

GCM = "<symmetric_cipher><algorithm>AES128+GCM</algorithm></symmetric_cipher>"


class DropIn(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "-q", *NOW)
        self.xml = (self.at / "demo/governance.xml").read_text()
        ours = self.at / "dropin"
        ours.mkdir()
        for name in ("auth", "ac", "crypto"):
            (ours / f"libdds_security_{name}.so").write_bytes(shared_library(b"ddssec_"))
        self.drop_in = {"LD_LIBRARY_PATH": f"{ours}:{library_path()}"}

    def sign(self, *replacements):
        xml = self.xml
        for old, new in replacements:
            self.assertIn(old, xml)
            xml = xml.replace(old, new)
        (self.at / "g.xml").write_text(xml)
        self.run_program("governance", "sign", "g.xml", "-o", "g.p7s", "--ca", "demo", "-q", *NOW)
        for name in ("talker", "listener"):
            shutil.copy(self.at / "g.p7s", self.at / "demo" / name / "governance.p7s")
        (self.at / "g.p7s").unlink()

    def answers(self, exit, environment):
        """What each of the three says by DOC103; of `can` the reason."""
        out = {}
        for name, words in (("doctor", ("doctor", "demo/talker", "--vendor", "ours")),
                            ("check", ("check", "demo/talker", "demo/listener", "--topics", "Square,"))):
            told = self.json(*words, *NOW, exit=exit, environment=environment)["diagnostics"]
            out[name] = [(one["severity"], one["message"]) for one in told if "DOC103" in one["id"]]
        can = self.json("can", "demo/talker", "publish", "Square", *NOW, exit=exit, environment=environment)
        out["can"] = can["result"]["because"]
        return out

    def test_what_is_enforceable_is_no_matter(self):
        for environment in (None, self.drop_in):
            self.assertEqual([v for k, v in self.answers(0, environment).items() if k != "can"], [[], []])

    def test_access_control_that_nothing_guards(self):
        self.sign(("<metadata_protection_kind>ENCRYPT", "<metadata_protection_kind>NONE"),
                  ("<data_protection_kind>ENCRYPT", "<data_protection_kind>NONE"))
        told = self.answers(1, self.drop_in)
        for severity, message in (told["doctor"][0], told["check"][0]):
            self.assertEqual(severity, "error")
            self.assertIn("refuses to make a writer of topics under the topic_rule \"*\" (1612)", message)
        self.assertIn("DOC103: a Cyclone DDS process on ddssec's plugins refuses to make a writer", told["can"])
        told = self.answers(0, None)  # the embedded participant makes it
        self.assertEqual(told["doctor"][0][0], "warning")
        self.run_program("check", "demo/talker", "demo/listener", "--vendor", "cyclonedds", *NOW, environment=self.drop_in)

    def test_key_revision(self):
        self.sign(("<discovery_protection_kind>",
                   "<enable_key_revision>true</enable_key_revision><discovery_protection_kind>"))
        told = self.answers(1, self.drop_in)
        self.assertIn("refuses the participant (1402)", told["doctor"][0][1])
        self.assertIn("<enable_key_revision>", told["check"][0][1])
        self.assertIn("the participant does not start: DOC103", told["can"])
        self.assertEqual(self.answers(0, None)["doctor"][0][0], "warning")

    def test_algorithms_that_every_handshake_needs(self):
        self.sign(("</topic_access_rules>",
                   f"</topic_access_rules><allowed_crypto_algorithms>{GCM}</allowed_crypto_algorithms>"))
        for environment in (None, self.drop_in):  # the embedded participant refuses it as well
            told = self.answers(1, environment)
            self.assertIn("ddssec refuses the governance document", told["doctor"][0][1])
            self.assertIn("AES256+GCM", told["check"][0][1])
            self.assertIn("DOC103", told["can"])

    def test_no_passphrase_for_pre_shared_keys(self):
        self.sign(("</rtps_protection_kind>",
                   "</rtps_protection_kind><rtps_psk_protection_kind>SIGN</rtps_psk_protection_kind>"))
        for environment in (None, self.drop_in):
            self.assertIn("the participant does not start: DOC091", self.answers(1, environment)["can"])


if __name__ == "__main__":
    main()

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
        for name, words in (("doctor", ("doctor", "demo/talker", "--vendor", "ddssec")),
                            ("check", ("check", "demo/talker", "demo/listener", "--topics", "Square,"))):
            told = self.json(*words, *NOW, exit=exit, environment=environment)["diagnostics"]
            out[name] = [(one["severity"], one["message"]) for one in told if "DOC103" in one["id"]]
        can = self.json("can", "demo/talker", "publish", "Square", *NOW, exit=exit, environment=environment)
        out["can"] = can["result"]["because"]
        return out

    def properties(self, text):
        """The environment of a process with these properties."""
        (self.at / "p.properties").write_text(text)
        return {**self.drop_in, "DDSSEC_PROPERTIES": str(self.at / "p.properties")}

    def refusals(self, environment, exit):
        """What doctor says of them; check refuses the same."""
        words = ("doctor", "demo/talker", "--vendor", "ddssec")
        told = self.json(*words, *NOW, environment=environment, exit=exit)["diagnostics"]
        checked = self.json("check", "demo/talker", "demo/listener", *NOW, environment=environment, exit=exit)
        told = [one for one in told if one["id"] == "DOC093"]
        self.assertEqual(any("DOC093" in one["id"] + one["message"] for one in checked["diagnostics"]), exit == 1)
        return told

    def test_properties_of_a_process_are_judged_as_the_plugins_judge_them(self):
        for text in ("", "# nothing\n", "org.ddssec.auth.ocsp = soft\n", "org.ddssec.access.allow_shared_memory = true\n",
                     "org.ddssec.governance_change_time = of the embedded participant alone\n"):
            self.assertEqual(self.refusals(self.properties(text), 0), [], text)
        for text, sentence in (("org.ddssec.auth.oscp = soft\n", "[property_unknown 1016]"),
                               ("dds.sec.crypto.rtps_psk_secret_passphrase = data:,1:x\n", "[property_without_effect 1017]"),
                               ("org.ddssec.clock_step_grace = abc\n", "org.ddssec.clock_step_grace"),
                               ("org.ddssec.access.allow_shared_memory = maybe\n", "true or false"),
                               ("org.ddssec.crypto.trust_type_information = 7\n", "true or false"),
                               ("org.ddssec.auth.ocsp = never\n", "org.ddssec.auth.ocsp"),
                               ("org.ddssec.crypto.key_lifetime = 3600\n", "<enable_key_revision>"),
                               ("dds.sec.crypto.symmetric_cipher_algorithm = ROT13\n", "ROT13"),
                               ("dds.sec.auth.trusted_ca_dir = /nowhere\n", "dds.sec.auth.trusted_ca_dir"),
                               ("no equals sign\n", "no equals sign")):
            (told,) = self.refusals(self.properties(text), 1)
            self.assertEqual(told["severity"], "error")
            self.assertIn("a Cyclone DDS process on ddssec's plugins does not start", told["message"])
            self.assertIn(sentence, told["message"])
            self.assertEqual(told["file"], str(self.at / "p.properties"))
        (told,) = self.refusals({**self.drop_in, "DDSSEC_PROPERTIES": str(self.at / "none")}, 1)
        self.assertIn("[file_not_found 1013]", told["message"])
        (told,) = self.refusals({**self.drop_in, "DDSSEC_SYMMETRIC_CIPHER_ALGORITHM": "ROT13"}, 1)
        self.assertIn("ROT13", told["message"])
        # A process on other plugins does not read them.
        environment = self.properties("org.ddssec.auth.oscp = soft\n")
        del environment["LD_LIBRARY_PATH"]
        (told,) = self.refusals(environment, 0)
        self.assertEqual(told["severity"], "warning")

    def test_an_encrypted_key_opens_with_the_password_that_each_product_is_given(self):
        folder = self.at / "demo/talker"
        key, xml, profile = folder / "key.pem", folder / "cyclonedds.xml", folder / "fastdds.xml"
        self.openssl("pkcs8", "-topk8", "-in", key, "-out", "k.pem", "-passout", "pass:secret")
        shutil.move(self.at / "k.pem", key)
        key.chmod(0o600)
        texts = xml.read_text(), profile.read_text()

        def verdicts(exit):
            told = self.json("doctor", "demo/talker", *NOW, environment=self.drop_in, exit=exit)
            return [one for one in told["result"]["verdicts"].values()], [
                one["message"] for one in told["diagnostics"] if one["id"] == "DOC013"]

        self.assertEqual(verdicts(1)[0], ["fail"] * 3)
        (folder / "security.properties").write_text("dds.sec.auth.password = secret\n")
        self.assertEqual(verdicts(1), (["fail", "fail", "ok"], ["key.pem is encrypted, and Cyclone DDS 0.10.2 and Fast DDS "
                                                                "2.9.1 are given no password that opens it by the files"]))
        xml.write_text(texts[0].replace("</PrivateKey>", "</PrivateKey><Password>secret</Password>"))
        self.assertEqual(verdicts(1), (["ok", "fail", "ok"], ["key.pem is encrypted, and Fast DDS 2.9.1 is given no password "
                                                              "that opens it by the files"]))
        profile.write_text(texts[1].replace("</properties>", "<property><name>dds.sec.auth.builtin.PKI-DH.password</name>"
                                            "<value>secret</value></property></properties>"))
        self.assertEqual(verdicts(0), (["ok"] * 3, []))
        self.json("check", "demo/talker", "demo/listener", *NOW, environment=self.drop_in)
        xml.write_text(texts[0].replace("</PrivateKey>", "</PrivateKey><Password>wrong</Password>"))
        self.assertEqual(verdicts(1)[0], ["fail", "ok", "ok"])

    def test_a_domain_tag_is_warned_of(self):
        words = ("doctor", "demo/talker", "--vendor", "ddssec", *NOW)
        tag = "<Discovery><Tag>Robots</Tag></Discovery>"
        told = lambda environment: [(one["severity"], one["file"]) for one in self.json(
            *words, environment=environment)["diagnostics"] if one["id"] == "DOC114"]
        self.assertEqual(told(self.drop_in), [])
        file = self.at / "demo/talker/cyclonedds.xml"
        file.write_text(file.read_text().replace("</Domain>", tag + "</Domain>"))
        self.assertEqual(told(self.drop_in), [("warning", "demo/talker/cyclonedds.xml")])
        named = {**self.drop_in, "CYCLONEDDS_URI": f"file://{file}"}
        self.assertEqual(told(named), [("warning", "CYCLONEDDS_URI")])

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
        # The title of this check is longer than the usual column.
        table = self.run_program("doctor", "demo/talker", "--vendor", "ddssec", *NOW, environment=self.drop_in, exit=1).stdout
        rows = [row for row in table.splitlines() if row.endswith((" fail", " late", " ok"))]
        self.assertGreater(len(rows), 2)
        self.assertEqual(len({row.rstrip().rfind(" ") for row in rows}), 1, table)
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

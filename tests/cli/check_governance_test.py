#!/usr/bin/env python3
"""check: governance documents, domains and pre-shared keys that keep two participants apart."""

from check_participants import CheckTest
from transcript import main
from workshop import GOVERNANCE, allow, grant, permissions


class Governance(CheckTest):
    def test_the_protection_of_a_topic_is_the_products(self):
        rules = GOVERNANCE.replace("<topic_expression>*<", "<topic_expression>Squar[^b]<")
        body = rules[rules.index("<topic_rule>"):rules.index("</topic_rule>") + len("</topic_rule>")]
        open_rule = body.replace("Squar[^b]", "*").replace("ENCRYPT", "NONE")
        rules = rules.replace("</topic_access_rules>", open_rule + "</topic_access_rules>")
        for folder in (self.talker, self.listener):
            folder.sign("governance", rules)
        for vendor, payload in (("cyclonedds", "NONE"), ("fastdds", "ENCRYPT"), ("ddssec", "ENCRYPT")):
            out = self.check("--vendor", vendor, "--topics", "Square", exit=0)["result"]
            self.assertEqual(out["topics"][0]["directions"][0]["protection"]["payload"], payload, vendor)

    def test_governance_that_differs_in_one_value(self):
        self.listener.sign("governance", GOVERNANCE.replace("<rtps_protection_kind>SIGN",
                                                            "<rtps_protection_kind>NONE"))
        result = self.apart("DOC082", "<rtps_protection_kind> is SIGN at talker (governance.p7s:",
                            "NONE at listener", document="governance.p7s")
        self.assertEqual(result["join"]["masks"], ["0x80000007/0x80000006", "0x80000006/0x80000006"])
        self.assertEqual(result["join"]["differences"][0]["element"], "rtps_protection_kind")

    def test_governance_of_which_one_asks_for_more(self):
        for element, where, values in (("rtps_psk_protection_kind", "</rtps_protection_kind>", ("NONE", "SIGN")),
                                       ("enable_key_revision", "</enable_join_access_control>", ("false", "true"))):
            self.listener.sign("governance", GOVERNANCE.replace(
                where, f"{where}<{element}>{values[1]}</{element}>"))
            self.apart("DOC082", f"<{element}> is {values[0]} at talker", f"{values[1]} at listener")

    def test_pre_shared_keys(self):
        words = GOVERNANCE.replace("</rtps_protection_kind>", "</rtps_protection_kind>"
                                   "<rtps_psk_protection_kind>ENCRYPT</rtps_psk_protection_kind>")
        properties = "dds.sec.crypto.rtps_psk_secret_passphrase"

        def have(passphrase, extra="", cipher=""):
            for made, line in ((self.talker, "1:xyzzy"), (self.listener, passphrase)):
                made.sign("governance", words)
                text = f"{properties} = data:,{line}\n"
                if made is self.listener:
                    text += f"{properties}_extra = data:,{extra}\n" if extra else ""
                    text += f"dds.sec.crypto.rtps_psk_symmetric_cipher_algorithm = {cipher}\n" if cipher else ""
                (made.path / "security.properties").write_text(text)
                (made.path / "security.properties").chmod(0o600)

        have("1:xyzzy", cipher="AES256+GCM")
        self.check(exit=0)
        told = self.json("doctor", "listener", "--vendor", "ddssec", exit=0)["diagnostics"]
        self.assertEqual([one["id"] for one in told], ["DOC103"])  # the drop-in has no such keys
        for what, sentence in (
                (("2:plugh",), "talker sends under passphrase 1, and listener understands 2 only"),
                (("2:plugh", "1:xyzzy"), "listener sends under passphrase 2, and talker understands 1 only"),
                (("1:plugh",), "talker and listener have different passphrases under id 1"),
                (("1:xyzzy", "", "AES128+GCM"),
                 "pre-shared keys are for AES256+GCM at talker and for AES128+GCM at listener")):
            have(*what)
            self.apart("DOC092", sentence, document="security.properties")
            out = self.json("doctor", "talker", "--peer", "listener", "--vendor", "ddssec", exit=1)
            self.assertIn(sentence, [d["message"] for d in out["diagnostics"]])
            self.assertFalse("xyzzy" in str(out) or "plugh" in str(out))
        (self.listener.path / "security.properties").unlink()
        self.apart("DOC091", "<rtps_psk_protection_kind> is ENCRYPT", properties)
        open_file = self.at / "open.psk"
        open_file.write_text("1:xyzzy\n")
        open_file.chmod(0o644)
        (self.listener.path / "security.properties").write_text(f"{properties} = file:{open_file}\n")
        self.check(exit=0)
        out = self.json("doctor", "listener", "--vendor", "ddssec", exit=0)
        self.assertEqual([(d["id"], d["severity"]) for d in out["diagnostics"]], [("DOC091", "warning"), ("DOC103", "warning")])
        # Who cannot is told so, whatever is in the properties.
        self.apart("DOC090", "listener cannot start on its own with Cyclone DDS 0.10.2",
                   words=("--vendor", "B=cyclonedds"))

    def test_properties_with_which_the_plugins_do_not_start(self):
        revising = GOVERNANCE.replace("</enable_join_access_control>", "</enable_join_access_control>"
                                      "<enable_key_revision>true</enable_key_revision>")
        properties = self.listener.path / "security.properties"
        for governance, text, sentence in (
                (GOVERNANCE, "org.ddssec.crypto.key_lifetime = 3600\n", "<enable_key_revision>"),
                (GOVERNANCE, "org.ddssec.crypto.max_blocks_per_key = 1\n", "<enable_key_revision>"),
                (GOVERNANCE, "org.ddssec.crypto.key_lifetime = 0\n", None),
                (revising, "org.ddssec.crypto.key_lifetime = 3600\n", None),
                (revising, "org.ddssec.crypto.key_lifetime = 1h\n", "from 20 to 31536000"),
                (GOVERNANCE, "org.ddssec.files_poll_interval = five\n", "org.ddssec.files_poll_interval"),
                (GOVERNANCE, "org.ddssec.clock_step_grace = five\n", "org.ddssec.clock_step_grace"),
                (GOVERNANCE, "org.ddssec.crypto.trust_type_information = 1\n", "true or false"),
                (GOVERNANCE, "dds.sec.access.permissions = file:p.p7s\n", "[property_without_effect 1017]"),
                (revising, "org.ddssec.crypto.max_blocks_per_key = -1\n", "org.ddssec.crypto.max_blocks_per_key"),
                (revising, "no equals sign\n", "security.properties")):
            for made in (self.talker, self.listener):
                made.sign("governance", governance)
            properties.write_text(text)
            with self.subTest(text=text, sentence=sentence):
                out = self.json("doctor", "listener", "--vendor", "ddssec", exit=1 if sentence else 0)
                found = [d for d in out["diagnostics"] if d["id"] == "DOC093"]
                self.assertEqual(len(found), 1 if sentence else 0)
                if not sentence:
                    self.check(exit=0)
                    continue
                self.assertIn(sentence, found[0]["message"])
                self.apart("DOC093", sentence)
        # Cyclone DDS and Fast DDS do not read the file.
        self.listener.sign("governance", GOVERNANCE)
        self.talker.sign("governance", GOVERNANCE)
        self.check("--vendor", "A=cyclonedds", "--vendor", "B=cyclonedds", exit=0)

    def test_governance_that_differs_for_a_topic(self):
        self.listener.sign("governance", GOVERNANCE.replace("<data_protection_kind>ENCRYPT",
                                                            "<data_protection_kind>SIGN"))
        self.apart("DOC084", '"Square"', "<data_protection_kind> is ENCRYPT at talker",
                   "SIGN at listener", document="governance.p7s")
        self.assertIn("result: they authenticate, but no topic works: the protection differs\n",
                      self.run_program("check", "talker", "listener", exit=1).stdout)
        # The permissions allow it: nothing else is to be done than what DOC084 says.
        self.assertEqual({d["id"] for d in self.check(exit=1)["diagnostics"]}, {"DOC084"})
        self.listener.sign("permissions", permissions(grant(
            "CN=listener", allow("Square").replace("<publish><topics><topic>Square</topic></topics></publish>", ""))))
        self.assertEqual([d["id"] for d in self.check("--topics", "Square", exit=1)["diagnostics"]], ["DOC084"])

    def test_one_topic_whose_protection_differs_is_not_hidden_by_one_that_works(self):
        rules = allow("Square") + allow("Circle*")
        for one in (self.talker, self.listener):
            one.sign("permissions", permissions(grant(one.subject, rules)))
        at = GOVERNANCE.index("<topic_rule>")
        circle = GOVERNANCE[at:GOVERNANCE.index("</topic_access_rules>")].replace(
            "<topic_expression>*", "<topic_expression>Circle*")
        for one, kind in ((self.talker, "ENCRYPT"), (self.listener, "SIGN")):
            one.sign("governance", GOVERNANCE[:at] + circle.replace(
                "<data_protection_kind>ENCRYPT", f"<data_protection_kind>{kind}") + GOVERNANCE[at:])
        self.apart("DOC084", 'topics under the <topic_rule> "Circle*", such as "', "is ENCRYPT at talker")
        told = self.run_program("check", "talker", "listener", exit=1).stdout
        self.assertIn("result: they match, but the protection of a topic differs\n", told)
        self.assertIn("  talker publishes to listener: Square\n", told)
        self.assertNotIn("only one of them may use", told)
        self.check("--topics", "Square", exit=0)

    def test_the_domain_is_that_of_the_documents(self):
        rule = allow(domain=7)
        for party, name in ((self.talker, "talker"), (self.listener, "listener")):
            party.sign("governance", GOVERNANCE.replace("<id>0</id>", "<id>7</id>"))
            party.sign("permissions", permissions(grant(f"CN={name}", rule)))
        out = self.json("check", "talker", "listener")
        self.assertEqual((out["result"]["join"]["domain"], out["result"]["talk"]), (7, True))
        self.json("check", "talker", "listener", "--domain", "0", exit=1)
        self.assertEqual(self.json("doctor", "talker", "--peer", "listener", "--vendor", "ddssec")["result"]["domain"], 7)
        for party in (self.talker, self.listener):
            party.sign("governance", GOVERNANCE.replace("<id>0</id>", "<id>3</id><id>7</id>"))
        self.assertEqual(self.notes("check", "talker", "listener"), [])
        for party, name in ((self.talker, "talker"), (self.listener, "listener")):
            party.sign("permissions", permissions(grant(f"CN={name}", rule + allow(domain=3))))
        out = self.json("check", "talker", "listener")
        self.assertEqual(out["result"]["join"]["domain"], 3)
        told = self.notes("check", "talker", "listener")
        self.assertEqual([d["message"] for d in told], ["the documents are for domains 3, 7; domain 3 was checked"])
        self.assertIn("--domain N", told[0]["hint"])
        self.assertEqual(self.notes("check", "talker", "listener", "--domain", "7"), [])

    def notes(self, *words):
        """What is said about the domain that was taken."""
        return [d for d in self.json(*words)["diagnostics"] if d["id"] == "DOC095"]

    def test_a_domain_that_only_one_may_join(self):
        self.listener.sign("permissions", permissions(grant("CN=listener", allow(domain=7))))
        self.apart("DOC088", "talker does not let listener join domain 0", document="permissions.p7s")
        self.apart("DOC090", "DOC051", "domain 0")

    def test_access_control_that_nothing_protects(self):
        xml = GOVERNANCE
        for kind in ("metadata", "data"):
            xml = xml.replace(f"<{kind}_protection_kind>ENCRYPT", f"<{kind}_protection_kind>NONE")
        for one in (self.talker, self.listener):
            one.sign("governance", xml)
        told = [d for d in self.check(exit=0)["diagnostics"] if d["id"] == "GOV043"]
        self.assertEqual(len(told), 2)  # one for each governance document
        self.assertIn("refuse to make such an endpoint (1612)", told[0]["message"])
        self.assertTrue(told[0]["message"].startswith('topic "Square": '), told)
        for one in (self.talker, self.listener):
            one.sign("permissions", permissions(grant(one.subject, allow("*"))))
        told = [d["message"] for d in self.check(exit=0)["diagnostics"] if d["id"] == "GOV043"]
        self.assertTrue(told[0].startswith('topics "*" (e.g. "a"): access is controlled'), told)
        stock = self.check("--vendor", "cyclonedds", exit=0)["diagnostics"]
        self.assertNotIn("GOV043", [d["id"] for d in stock])


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""governance and permissions sign and verify; can: who may do what, and the line that says so."""

from transcript import Transcript, main

NOW = ("--now", "2026-11-21T00:00:00Z")
GOVERNANCE = """<?xml version="1.0" encoding="UTF-8"?>
<dds><domain_access_rules><domain_rule>
<domains><id>0</id></domains>
<allow_unauthenticated_participants>false</allow_unauthenticated_participants>
<enable_join_access_control>TRUE</enable_join_access_control>
<discovery_protection_kind>ENCRYPT</discovery_protection_kind>
<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
<rtps_protection_kind>SIGN</rtps_protection_kind>
<topic_access_rules>""" + "".join(f"""<topic_rule><topic_expression>{name}</topic_expression>
<enable_discovery_protection>true</enable_discovery_protection>
<enable_liveliness_protection>true</enable_liveliness_protection>
<enable_read_access_control>{control}</enable_read_access_control>
<enable_write_access_control>{control}</enable_write_access_control>
<metadata_protection_kind>ENCRYPT</metadata_protection_kind>
<data_protection_kind>ENCRYPT</data_protection_kind></topic_rule>""" for name, control in
                              (("open", "false"), ("rt/*", "true"))) + """
</topic_access_rules></domain_rule></domain_access_rules></dds>
"""


class Documents(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        (self.at / "governance.xml").write_text(GOVERNANCE)

    def sign(self):
        return self.json("governance", "sign", "governance.xml", "--ca", "ca", *NOW)

    def participant(self):
        self.sign()
        self.run_program("identity", "issue", "talker", "--ca", "ca", "-o", "talker", *NOW,
                         "--publish", "rt/chatter", "--governance", "governance.p7s")

    def test_what_is_signed_verifies_here_and_in_openssl(self):
        out = self.sign()["result"]
        self.assertEqual((out["file"], out["signer"]), ("governance.p7s", "CN=ca Permissions CA"))
        self.assertEqual([n["line"] for n in out["notes"]], [5])  # TRUE in capitals
        seen = self.json("governance", "verify", "governance.p7s", "--ca", "ca/permissions/ca.pem",
                         *NOW)["result"]
        self.assertEqual(seen["signer_not_after"], "2036-11-18T00:00:00Z")
        text = self.openssl("smime", "-verify", "-text", "-attime", "1795305600", "-in",
                            "governance.p7s", "-CAfile", "ca/permissions/ca.pem", "-purpose", "any")
        self.assertEqual(text.replace("\r", ""), GOVERNANCE)
        self.refused("would_overwrite", 4, "governance", "sign", "governance.xml", "--ca", "ca")

    def test_only_documents_of_the_right_kind_are_signed(self):
        self.refused("document_kind", 3, "permissions", "sign", "governance.xml", "--ca", "ca")
        (self.at / "bad.xml").write_text(GOVERNANCE.replace(">SIGN<", ">SIGNED<"))
        told = self.refused("value_not_protection_kind", 3, "governance", "sign", "bad.xml", "--ca", "ca")
        self.assertEqual((told["file"], told["line"]), ("bad.xml", 8))
        (self.at / "bad.xml").write_text('<!DOCTYPE x [<!ENTITY a "b">]>' + GOVERNANCE[38:])
        self.refused("xml_doctype", 3, "governance", "sign", "bad.xml", "--ca", "ca")

    def test_changed_foreign_and_unsigned_documents_do_not_verify(self):
        self.sign()
        signed = self.at / "governance.p7s"
        verify = ("governance", "verify", "governance.p7s", *NOW, "--ca")
        self.refused("smime_signer_not_permissions_ca", 1, *verify, "ca/identity/ca.pem")
        signed.write_text(signed.read_text().replace("<id>0<", "<id>1<"))
        self.refused("smime_signature_invalid", 1, *verify, "ca/permissions/ca.pem")
        signed.write_text(GOVERNANCE)
        self.refused("smime_not_multipart", 3, *verify, "ca/permissions/ca.pem")

    def can(self, *words, exit):
        return self.json("can", "talker", *words, *NOW, exit=exit)["result"]

    def test_can_names_the_document_and_line_that_decide(self):
        self.participant()
        yes = self.can("publish", "rt/chatter", exit=0)
        self.assertEqual((yes["file"], yes["because"]),
                         ("talker/permissions.p7s", 'an allow_rule of grant "talker"'))
        lines = (self.at / "talker/permissions.p7s").read_text().splitlines()
        document = lines[next(i for i, line in enumerate(lines) if line.startswith("<?xml")):]
        self.assertIn("<publish>", document[yes["line"] - 1])
        self.assertIn("default", self.can("subscribe", "rt/chatter", exit=1)["because"])
        self.assertIn("default", self.can("publish", "rt/chatter", "--partition", "a", exit=1)["because"])
        opened = self.can("subscribe", "open", exit=0)
        self.assertEqual((opened["file"], opened["line"]), ("talker/governance.p7s", 9))
        self.assertEqual(self.can("publish", "other", exit=1)["because"],
                         "no topic_rule matches the topic")

    def test_can_refuses_what_cannot_be_believed(self):
        self.participant()
        self.refused("domain_not_covered", 1, "can", "talker", "publish", "x", "--domain", "9", *NOW)
        self.refused("usage", 2, "can", "talker", "relay", "x")
        self.refused("grant_expired", 1, "can", "talker", "publish", "rt/x", "--now",
                     "2028-01-01T00:00:00Z")
        (self.at / "talker/permissions.p7s").unlink()
        self.refused("file_not_found", 3, "can", "talker", "publish", "rt/chatter", *NOW)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""governance and permissions sign and verify; can: who may do what, and the line that says so."""

from transcript import AT_THAT_TIME, NOW, Transcript, main

VENDORS = ("cyclonedds@0.10.2", "fastdds@2.9.1", "ddssec")
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
        signed = self.sign()
        out = signed["result"]
        self.assertEqual((out["file"], out["signer"]), ("governance.p7s", "CN=ca Permissions CA"))
        self.assertEqual([(d["id"], d["line"]) for d in signed["diagnostics"]],
                         [("GOV011", 2), ("GOV023", 5), ("GOV041", 9)])
        seen = self.json("governance", "verify", "governance.p7s", "--ca", "ca/permissions/ca.pem",
                         *NOW)["result"]
        self.assertEqual(seen["signer_not_after"], "2036-11-18T00:00:00Z")
        self.assertEqual(seen["verdicts"], dict.fromkeys(VENDORS, "accepts"))
        text = self.openssl("smime", "-verify", "-text", *AT_THAT_TIME, "-in",
                            "governance.p7s", "-CAfile", "ca/permissions/ca.pem", "-purpose", "any")
        declaration, rest = GOVERNANCE.split("\n", 1)
        self.assertEqual(text.replace("\r", ""), f'{declaration}\n<?ddssec revision="1"?>\n{rest}')
        self.refused("would_overwrite", 4, "governance", "sign", "governance.xml", "--ca", "ca")
        told = self.refused("usage", 2, "governance", "sign", "governance.p7s", "--ca", "ca", "-o", "again.p7s")
        self.assertIn("signed already", told["message"])

    def test_each_governance_document_that_is_signed_has_the_next_revision(self):
        def sign(*more, exit=0):
            return self.json("governance", "sign", "governance.xml", "--ca", "ca", "--replace", *more, *NOW, exit=exit)
        self.assertEqual([sign()["result"]["revision"] for _ in range(3)], [1, 2, 3])
        self.assertIn("revision 3\n", self.run_program("governance", "show", "governance.p7s").stdout)
        self.assertEqual(self.json("governance", "show", "governance.p7s")["result"]["revision"], 3)
        self.assertIn(", revision 4\n", self.run_program("governance", "sign", "governance.xml", "--ca", "ca", "-o",
                                                         "other.p7s", *NOW).stdout)
        self.assertEqual(sign("-o", "new.p7s")["result"]["revision"], 5)
        (self.at / "ca/permissions/signed.jsonl").unlink()
        self.assertEqual(sign("-o", "new.p7s")["result"]["revision"], 6, "that of the file that is replaced")
        self.assertNotIn("revision", sign("-o", "none.p7s", "--no-revision")["result"])
        for own, revision in ((7, None), (6, 7), (100, None)):
            declaration, rest = GOVERNANCE.split("\n", 1)
            (self.at / "governance.xml").write_text(f'{declaration}\n<?ddssec revision="{own}"?>\n{rest}')
            if revision is None:
                self.assertEqual(sign()["result"]["revision"], own)
            else:
                told = self.refused("governance_revision_used", 1, "governance", "sign", "governance.xml", "--ca", "ca",
                                    "--replace", *NOW)
                self.assertIn("more than 7", told["message"])

    def test_a_new_document_that_is_signed_has_the_next_revision(self):
        def revision(file):
            return self.json("governance", "show", file)["result"].get("revision")
        for last, document in ((1, "one"), (2, "two")):
            text = self.run_program("governance", "new", "-o", f"{document}.xml", "--sign", "--ca", "ca", *NOW).stdout
            self.assertEqual(text, f"{document}.xml\n{document}.p7s  revision {last}\n")
            self.assertEqual((revision(f"{document}.xml"), revision(f"{document}.p7s")), (None, last))
        out = self.json("governance", "new", "-o", "two.xml", "--replace", "--sign", "--ca", "ca", *NOW)["result"]
        self.assertEqual(out["revision"], 3)
        self.assertIn(', revision 4\n', self.run_program("governance", "sign", "one.xml", "--ca", "ca", "--replace", *NOW).stdout)
        out = self.json("governance", "new", "-o", "old.xml", "--sign", "--ca", "ca", "--no-revision", *NOW)["result"]
        self.assertNotIn("revision", out)
        self.assertIsNone(revision("old.p7s"))

    def test_init_and_keystore_create_begin_with_the_first_revision(self):
        self.run_program("init", "demo", "-q", *NOW)
        self.run_program("init", "ros", "--layout", "sros2", "-q", *NOW)
        self.run_program("keystore", "create", "store", "--no-passphrase", "-q", *NOW)
        for folder, xml, ca in (("demo", "governance.xml", "demo"), ("ros/enclaves", "governance.xml", "ros"),
                                ("store/enclaves", "governance.xml", "store")):
            self.assertEqual(self.json("governance", "show", f"{folder}/governance.p7s")["result"]["revision"], 1)
            self.assertNotIn("ddssec", (self.at / folder / xml).read_text())
            self.assertIn(", revision 2\n", self.run_program("governance", "sign", f"{folder}/{xml}", "--ca", ca,
                                                             "--replace", *NOW).stdout)

    def test_a_revision_that_is_none_is_refused_with_its_line(self):
        declaration, rest = GOVERNANCE.split("\n", 1)
        (self.at / "governance.xml").write_text(f'{declaration}\n<?ddssec revision="seven"?>\n{rest}')
        for command in ("lint", "show", "sign"):
            self.refused("value_not_revision", 1, "governance", command, "governance.xml",
                         *(("--ca", "ca") if command == "sign" else ()))

    def test_only_documents_of_the_right_kind_are_signed(self):
        self.refused("document_kind", 3, "permissions", "sign", "governance.xml", "--ca", "ca")
        (self.at / "bad.xml").write_text(GOVERNANCE.replace(">SIGN<", ">SIGNED<"))
        told = self.refused("value_not_protection_kind", 3, "governance", "sign", "bad.xml", "--ca", "ca")
        self.assertEqual((told["file"], told["line"]), ("bad.xml", 8))
        (self.at / "bad.xml").write_text('<!DOCTYPE x [<!ENTITY a "b">]>' + GOVERNANCE[38:])
        self.refused("xml_doctype", 3, "governance", "sign", "bad.xml", "--ca", "ca")

    def test_what_lint_calls_an_error_is_not_signed(self):
        strangers = GOVERNANCE.replace("participants>false", "participants>true")
        (self.at / "governance.xml").write_text(strangers)
        out = self.json("governance", "sign", "governance.xml", "--ca", "ca", *NOW, exit=1)
        self.assertIn("GOV022", [d["id"] for d in out["diagnostics"]])
        self.assertEqual(out["files_written"], [])
        self.assertFalse((self.at / "governance.p7s").exists())
        out = self.json("governance", "sign", "governance.xml", "--ca", "ca", "--no-lint", *NOW)
        self.assertEqual(out["diagnostics"], [])

    def verdicts(self, code, exit, *words):
        """What verify says of a document it refuses: of stock products, and of us."""
        out = self.json("governance", "verify", *words, *NOW, exit=exit)
        self.assertEqual([d["id"] for d in out["diagnostics"]], [code])
        verdicts = out["result"]["verdicts"]
        self.assertEqual(verdicts["ddssec"], "refuses")
        self.assertEqual(verdicts[VENDORS[0]], verdicts[VENDORS[1]])
        return verdicts[VENDORS[0]]

    def test_changed_foreign_and_unsigned_documents_do_not_verify(self):
        self.sign()
        signed = self.at / "governance.p7s"
        words = ("governance.p7s", "--ca")
        self.assertEqual(self.verdicts("smime_signer_not_permissions_ca", 1, *words,
                                       "ca/identity/ca.pem"), "refuses")
        signed.write_text(signed.read_text().replace("<id>0<", "<id>1<"))
        ca = "ca/permissions/ca.pem"
        self.assertEqual(self.verdicts("smime_signature_invalid", 1, *words, ca), "refuses")
        signed.write_text(GOVERNANCE)
        self.assertEqual(self.verdicts("smime_not_multipart", 3, *words, ca), "refuses")

    def test_forms_that_stock_products_accept_and_we_do_not(self):
        form = ("smime", "-sign", "-in", "governance.xml", "-signer", "ca/permissions/ca.pem",
                "-inkey", "ca/permissions/ca.key.pem", "-out", "odd.p7s")
        ca = ("odd.p7s", "--ca", "ca/permissions/ca.pem")
        self.openssl(*form, "-text", "-nodetach")
        self.assertEqual(self.verdicts("smime_not_multipart", 3, *ca), "accepts")
        self.openssl(*form)  # no text/plain header
        self.assertEqual(self.verdicts("smime_content_type", 1, *ca), "refuses")

    def test_verify_says_whom_the_subject_does_not_suit(self):
        self.run_program("identity", "issue", "talker", "--ca", "ca", "-o", "talker", "--subject",
                         "CN=talker,O=Acme,C=DE", *NOW)
        self.run_program("permissions", "new", "--cert", "talker/cert.pem", "-o", "good.xml",
                         "--publish", "a", *NOW)
        good = (self.at / "good.xml").read_text()
        for text, vendors in (("C=DE,O=Acme,CN=talker", ["fastdds"]),
                              ("/C=DE/O=Acme/CN=talker", ["fastdds"]),
                              ("CN=talker, O=Acme, C=DE", ["cyclonedds"]),
                              ("C = DE, O = Acme, CN = talker", ["cyclonedds", "fastdds"])):
            (self.at / "p.xml").write_text(good.replace("CN=talker,O=Acme,C=DE", text))
            self.run_program("permissions", "sign", "p.xml", "--ca", "ca", *NOW)
            verify = ("permissions", "verify", "p.p7s", "--ca", "ca/permissions/ca.pem", "--cert",
                      "talker/cert.pem", *NOW)
            told = self.json(*verify)["diagnostics"]
            self.assertEqual([(d["id"], d["vendors"]) for d in told], [("PERM011", vendors)])
            self.assertIn("<subject_name>CN=talker,O=Acme,C=DE</subject_name>", told[0]["hint"])
            (self.at / "p.p7s").unlink()
        (self.at / "p.xml").write_text(good.replace("CN=talker,", "CN=listener,"))
        self.run_program("permissions", "sign", "p.xml", "--ca", "ca", *NOW)
        self.assertEqual(self.json(*verify, exit=1)["diagnostics"][0]["severity"], "error")

    def can(self, *words, exit):
        return self.json("can", "talker", *words, *NOW, exit=exit)["result"]

    def test_can_names_the_document_and_line_that_decide(self):
        self.participant()
        yes = self.can("publish", "rt/chatter", exit=0)
        self.assertEqual((yes["file"], yes["because"]),
                         ("talker/permissions.p7s", 'an allow_rule of grant "talker", but only without a partition (or in "")'))
        lines = (self.at / "talker/permissions.p7s").read_text().splitlines()
        self.assertIn("<publish>", lines[yes["line"] - 1])
        self.assertIn("default", self.can("subscribe", "rt/chatter", exit=1)["because"])
        self.assertIn("default", self.can("publish", "rt/chatter", "--partition", "a", exit=1)["because"])
        opened = self.can("subscribe", "open", exit=0)
        self.assertEqual(opened["file"], "talker/governance.p7s")
        self.assertIn("<topic_rule>", (self.at / "talker/governance.p7s").read_text().splitlines()[opened["line"] - 1])
        self.assertEqual(self.can("publish", "other", exit=1)["because"],
                         "no topic_rule matches the topic")

    def line(self, file, number):
        return (self.at / file).read_text().splitlines()[number - 1]

    def test_lines_of_a_signed_document_are_those_of_the_file(self):
        self.participant()
        rules = self.json("permissions", "show", "talker", *NOW)["result"]["grants"][0]
        self.assertIn("<grant ", self.line("talker/permissions.p7s", rules["line"]))
        self.assertIn("<allow_rule>", self.line("talker/permissions.p7s", rules["rules"][0]["line"]))
        shown = self.json("governance", "show", "talker", "--topic", "open", *NOW)["result"]
        self.assertIn("<topic_rule>", self.line("talker/governance.p7s", shown["topic_rule"]["line"]))
        for one in self.json("governance", "lint", "talker", *NOW, exit=None)["diagnostics"]:
            self.assertRegex(self.line("talker/governance.p7s", one["line"]), r"<(domain|topic)_|protection_kind|>TRUE<")
        (self.at / "p.xml").write_text(GOVERNANCE.replace("<data_protection_kind>", "<data_protection_kind>\n x"))
        told = self.refused("value_not_protection_kind", 3, "governance", "lint", "p.xml")
        self.openssl("smime", "-sign", "-text", "-in", "p.xml", "-signer", "ca/permissions/ca.pem", "-inkey",
                     "ca/permissions/ca.key.pem", "-out", "p.p7s")
        signed = self.refused("value_not_protection_kind", 3, "governance", "lint", "p.p7s")
        self.assertEqual(self.line("p.p7s", signed["line"]), self.line("p.xml", told["line"]))
        self.assertGreater(signed["line"], told["line"])

    def permit(self, change):
        """The talker's permissions, changed and signed."""
        self.run_program("permissions", "new", "--cert", "talker/cert.pem", "-o", "p.xml", "--publish",
                         "rt/chatter", *NOW)
        (self.at / "p.xml").write_text(change((self.at / "p.xml").read_text()))
        self.run_program("permissions", "sign", "p.xml", "--ca", "ca", "--no-lint", *NOW)
        (self.at / "p.p7s").replace(self.at / "talker/permissions.p7s")
        (self.at / "p.xml").unlink()

    def both_refuse(self, *words):
        """can, on a topic without access control, and check; in the same words."""
        self.json("check", "talker", "listener", "--topics", "open", *words, exit=1)
        return self.json("can", "talker", "publish", "open", *words, exit=1)

    # An open topic needs no permission, but the participant must still start.
    def test_can_judges_the_whole_chain_as_check_does(self):
        self.participant()
        self.run_program("identity", "issue", "listener", "--ca", "ca", "-o", "listener", *NOW,
                         "--subscribe", "rt/chatter", "--governance", "governance.p7s")
        self.json("check", "talker", "listener", "--topics", "open", *NOW)
        self.can("publish", "open", exit=0)
        late = ("--now", "2028-01-01T00:00:00Z")
        self.assertEqual(self.both_refuse(*late)["diagnostics"][0]["id"], "grant_expired")
        self.permit(lambda xml: xml.replace("<not_after>2027", "<not_after>2035"))
        self.assertEqual(self.both_refuse(*late)["diagnostics"][0]["id"], "certificate_expired")
        self.permit(lambda xml: xml.replace("CN=talker", "CN=other"))
        self.assertEqual(self.both_refuse(*NOW)["diagnostics"][0]["id"], "no_grant_for_subject")
        # DDS-Security 1.2 table 70.
        denial = "<deny_rule><domains><id>0</id></domains></deny_rule>\n"
        self.permit(lambda xml: xml.replace("<allow_rule>", denial + "<allow_rule>", 1))
        told = self.both_refuse(*NOW)["result"]
        self.assertEqual((told["allowed"], told["because"]),
                         (False, 'joining domain 0: a deny_rule of grant "talker"'))
        self.permit(lambda xml: xml)
        (self.at / "talker/key.pem").write_bytes((self.at / "listener/key.pem").read_bytes())
        self.assertIn("the participant does not start: DOC012", self.both_refuse(*NOW)["result"]["because"])

    def test_can_takes_the_domain_from_the_documents(self):
        (self.at / "governance.xml").write_text(GOVERNANCE.replace(
            "<id>0</id>", "<id_range><min>0</min><max>9</max></id_range>"))
        self.sign()
        for name, domains in (("one", "7"), ("many", "2-4")):
            self.run_program("identity", "issue", name, "--ca", "ca", "-o", name, *NOW, "--domain", domains,
                             "--publish", "rt/x", "--governance", "governance.p7s")
        self.assertEqual(self.json("can", "one", "publish", "rt/x", *NOW)["result"]["domain"], 7)
        told = self.refused("usage", 2, "can", "many", "publish", "rt/x", *NOW)
        self.assertIn("one of 2-4", told["message"])
        self.assertEqual(self.json("can", "many", "publish", "rt/x", "--domain", "3", *NOW)["result"]["domain"], 3)

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

#!/usr/bin/env python3
"""New permissions are for the domains of the governance document, and `check` says only what was asked for."""

from transcript import NOW, Transcript, main


class GrantedDomains(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "ca", "--no-passphrase", "-q", *NOW)

    def governance(self, name, *words):
        self.run_program("governance", "new", "-o", name + ".xml", "--sign", "--ca", "ca", *words, *NOW)
        return name + ".p7s"

    def domains(self, folder):
        grants = self.json("permissions", "show", folder, *NOW)["result"]["grants"]
        rules = [rule["domains"] for grant in grants for rule in grant["rules"]]
        self.assertTrue(all(rule == rules[0] for rule in rules))
        return rules[0]

    def issue(self, name, *words):
        return self.run_program("identity", "issue", name, "--ca", "ca", "-o", name, *words, *NOW)

    def test_a_participant_gets_those_of_its_governance(self):
        governance = self.governance("g", "--domain", "5-7")
        self.issue("a", "--publish", "T", "--governance", governance)
        self.assertEqual(self.domains("a"), [[5, 7]])
        self.issue("b", "--subscribe", "T", "--governance", governance, "--domain", "6")
        self.assertEqual(self.domains("b"), [[6, 6]])
        self.run_program("check", "a", "b", "--topics", "T", "--domain", "6", *NOW)
        self.issue("c", "--publish", "T")
        self.assertEqual(self.domains("c"), [[0, 0]])
        (self.at / "fleet.toml").write_text('[[participant]]\nname = "d"\npublish = ["T"]\n')
        self.run_program("identity", "issue", "--from", "fleet.toml", "--ca", "ca", "-o", "fleet", "--governance", governance, *NOW)
        self.assertEqual(self.domains("fleet/d"), [[5, 7]])

    def test_one_outside_is_warned_of(self):
        governance = self.governance("g", "--domain", "5")
        told = self.issue("a", "--publish", "T", "--governance", governance, "--domain", "3").stderr
        self.assertIn("DOC050", told)
        self.assertIn("domain 3", told)

    def new_permissions(self, folder, *words, exit=0):
        return self.run_program("permissions", "new", "--cert", f"{folder}/cert.pem", "--publish", "U", "--replace", "--sign",
                                "--ca", "ca", "-o", f"{folder}/permissions.xml", *words, *NOW, exit=exit)

    def test_permissions_new_without_domain_takes_that_of_the_governance_document(self):
        self.issue("a", "--publish", "T", "--governance", self.governance("g", "--domain", "7"))
        self.assertEqual(self.new_permissions("a").stderr, "")
        self.assertEqual(self.domains("a"), [[7, 7]])
        self.run_program("permissions", "new", "--cert", "a/cert.pem", "--publish", "U", "-o", "elsewhere.xml", *NOW)
        self.assertEqual(self.domains("elsewhere.xml"), [[7, 7]])
        told = self.new_permissions("a", "--domain", "0").stderr
        self.assertIn("warning[DOC050]", told)
        self.issue("b", "--publish", "T", "--governance", self.governance("h", "--domain", "5-7"))
        self.assertIn("5-7", self.new_permissions("b", exit=2).stderr)
        self.new_permissions("b", "--domain", "6")
        self.assertEqual(self.domains("b"), [[6, 6]])

    def test_doctor_and_check_of_permissions_for_another_domain_name_the_permissions(self):
        governance = self.governance("g", "--domain", "7")
        self.issue("a", "--publish", "T", "--governance", governance)
        self.issue("b", "--subscribe", "T", "--governance", governance)
        self.new_permissions("a", "--domain", "0")
        told, = [d for d in self.json("doctor", "a", *NOW, exit=1)["diagnostics"] if d["severity"] == "error"]
        self.assertEqual((told["id"], told["file"]), ("DOC051", "a/permissions.p7s"))
        self.assertRegex(told["message"], r"a/permissions.p7s:\d+ allows only domain 0, and a/governance.p7s:\d+ covers only 7")
        self.assertIn("the permissions are probably wrong", told["message"])
        self.assertIn("ddssec permissions new --cert a/cert.pem --domain 7", told["hint"])
        told = self.json("check", "a", "b", *NOW, exit=1)["diagnostics"]
        self.assertEqual({d["file"] for d in told if d["severity"] == "error"}, {"a/permissions.p7s"})
        told = [d for d in self.json("doctor", "a", "--domain", "0", *NOW, exit=1)["diagnostics"] if d["id"] == "DOC050"]
        self.assertIn("the permissions are probably wrong", told[0]["message"])
        self.assertEqual(self.json("can", "a", "publish", "U", *NOW, exit=1)["result"]["domain"], 7)

    def test_sign_and_renew_of_permissions_for_another_domain_warn(self):
        self.issue("a", "--publish", "T", "--governance", self.governance("g", "--domain", "7"))
        self.new_permissions("a", "--domain", "0")
        for words in (("permissions", "sign", "a/permissions.xml", "--ca", "ca", "--replace"),
                      ("identity", "renew", "a", "--ca", "ca", "--permissions", "--days", "400")):
            told = self.json(*words, *NOW)["diagnostics"]
            self.assertEqual([(d["id"], d["severity"]) for d in told], [("DOC050", "warning")], words)
            self.assertIn("allows only domain 0", told[0]["message"])

    def test_an_enclave_gets_all_of_them(self):
        self.run_program("keystore", "create", "ks", "--domain", "3-5", "--no-passphrase", "-q", *NOW)
        self.run_program("keystore", "enclave", "ks", "/a", "--publish", "rt/chatter", *NOW)
        self.assertEqual(self.domains("ks/enclaves/a"), [[3, 5]])
        (self.at / "policy.xml").write_text(
            '<policy version="0.2.0"><enclaves><enclave path="/b"><profiles><profile ns="/" node="b"><topics publish="ALLOW">'
            "<topic>chatter</topic></topics></profile></profiles></enclave></enclaves></policy>")
        self.run_program("keystore", "enclave", "ks", "/b", "--policy", "policy.xml", "--node-defaults", *NOW)
        self.assertEqual(self.domains("ks/enclaves/b"), [[3, 5]])
        self.run_program("keystore", "permission", "ks", "/b", "--policy", "policy.xml", "--domain", "3", "--domain", "5", *NOW)
        self.assertEqual(self.domains("ks/enclaves/b"), [[3, 3], [5, 5]])

    def test_check_reports_the_required_direction(self):
        first, second = self.governance("g"), self.governance("h", "--topic", "S:data=NONE")
        self.issue("a", "--publish", "S", "--governance", first)
        self.issue("b", "--subscribe", "S", "--governance", second)
        words = ("check", "a", "b", "--topics", "S", *NOW)
        told = self.json(*words, "--require", "writer=A", exit=1)["diagnostics"]
        self.assertEqual([one["id"] for one in told if one["severity"] == "error"], ["DOC084"])
        told = self.json(*words, "--require", "writer=B", exit=1)["diagnostics"]
        self.assertEqual([one["message"].split(":")[0] for one in told if one["id"] == "DOC086"],
                         ['b may not publish "S"', 'a may not subscribe to "S"'])
        # Without --require, the denial of the other direction is intended. Only the governance needs a change.
        told = self.json(*words, exit=1)["diagnostics"]
        self.assertEqual([one["id"] for one in told if one["severity"] == "error"], ["DOC084"])

    def test_the_hint_for_an_edited_governance_works(self):
        self.run_program("keystore", "create", "ks", "--no-passphrase", "-q", *NOW)
        self.run_program("keystore", "enclave", "ks", "/a", "--publish", "rt/chatter", *NOW)
        text = self.at / "ks/enclaves/governance.xml"
        text.write_text(text.read_text().replace("ENCRYPT", "SIGN", 1))
        told = self.run_program("doctor", "ks/enclaves/a", *NOW).stderr
        self.assertIn("ddssec governance sign ", told)
        self.assertIn("governance.xml --ca CA --replace", told)
        self.run_program("governance", "sign", "ks/enclaves/governance.xml", "--ca", "ks", "--replace", *NOW)
        self.assertNotIn("DOC038", self.run_program("doctor", "ks/enclaves/a", *NOW).stderr)


if __name__ == "__main__":
    main()

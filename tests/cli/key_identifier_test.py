#!/usr/bin/env python3
"""Documents whose signature names the signer by the identifier of its key (openssl cms -sign -keyid): every command
reads them, as ddssec's plugins do."""

from transcript import NOW, Transcript, main

OURS = ("--vendor", "A=ddssec", "--vendor", "B=ddssec")
STOCK = ("--vendor", "A=cyclonedds@0.10.2", "--vendor", "B=cyclonedds@0.10.2")


class KeyIdentifier(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)
        self.former = (self.at / "demo/talker/permissions.p7s").read_bytes()
        (self.at / "former.p7s").write_bytes(self.former)
        self.openssl("smime", "-verify", "-noverify", "-text", "-in", "former.p7s", "-out", "permissions.xml")
        self.openssl("cms", "-sign", "-keyid", "-text", "-md", "sha256", "-signer", "demo/ca/permissions/ca.pem", "-inkey",
                     "demo/ca/permissions/ca.key.pem", "-in", "permissions.xml", "-out", "demo/talker/permissions.p7s")

    def test_check_predicts_that_they_talk(self):
        out = self.run_program("check", "demo/talker", "demo/listener", *OURS, *NOW)
        self.assertIn("result: they match", out.stdout)

    def test_stock_products_cannot_read_it(self):
        self.assertIn("NO", self.run_program("check", "demo/talker", "demo/listener", *STOCK, *NOW, exit=1).stdout)

    def test_show_and_diff_read_the_document(self):
        self.assertIn("CN=talker", self.run_program("permissions", "show", "demo/talker/permissions.p7s").stdout)
        out = self.run_program("permissions", "diff", "former.p7s", "demo/talker/permissions.p7s").stdout
        self.assertIn("NEUTRAL", out)

    def test_expiry_lists_the_permissions(self):
        out = self.run_program("expiry", "demo/talker", *NOW).stdout
        self.assertRegex(out, r"permissions .*CN=talker")


class AfterRotation(Transcript):
    """The CA has its name still, and another key."""

    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)
        self.run_program("identity", "issue", "away", "--ca", "demo", "-o", "demo/away", *NOW)
        (self.at / "demo/away").rename(self.at / "away")

    def test_an_old_governance_document_is_called_so(self):
        (self.at / "old.p7s").write_bytes((self.at / "demo/talker/governance.p7s").read_bytes())
        self.run_program("ca", "rotate", "demo", "--role", "permissions", *NOW)
        told = self.refused("smime_signer_not_permissions_ca", 1, "identity", "issue", "x", "--ca", "demo", "-o", "x",
                            "--governance", "old.p7s", *NOW)
        self.assertIn("it was rotated since", told["message"])
        self.assertIn("ddssec governance sign", told["hint"])

    def test_a_folder_that_was_away_is_called_so(self):
        self.run_program("ca", "rotate", "demo", "--role", "identity", *NOW)
        told = self.refused("issuer_unknown", 1, "identity", "renew", "away", "--ca", "demo", "--subject", "CN=away", *NOW)
        self.assertIn("has another key now", told["message"])
        self.assertIn("identity issue --replace", told["hint"])

    def test_and_a_list_names_both_keys(self):
        self.run_program("ca", "rotate", "demo", "--role", "identity", *NOW)
        told = self.refused("crl_signature_invalid", 1, "crl", "verify", "away", "--ca", "demo", *NOW)
        self.assertRegex(told["message"], r"with the key [0-9a-f]{40}.*with the key [0-9a-f]{40}")
        self.assertIn("start it again", told["hint"])


if __name__ == "__main__":
    main()

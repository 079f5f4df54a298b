#!/usr/bin/env python3
"""A command for one participant signs rights for that participant, and does not pass over what it cannot extend."""

import re

from transcript import NOW, Transcript, main


class OwnGrants(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "ca", "--no-passphrase", "-q", *NOW)
        self.run_program("keystore", "create", "ks", "--no-passphrase", "-q", *NOW)
        self.run_program("identity", "issue", "eve", "--ca", "ca", "-o", "eve", "-q", *NOW)
        self.run_program("permissions", "new", "--cert", "eve", "--publish", "Secret", "-o", "eve.xml", *NOW)
        self.grant = re.search(r"<grant .*?</grant>", (self.at / "eve.xml").read_text(), re.S).group(0)

    def document(self, *subjects):
        """eve.xml with a grant for each of these."""
        text = (self.at / "eve.xml").read_text()
        grants = [self.grant.replace("CN=eve", subject).replace('name="', f'name="g{i}-')
                  for i, subject in enumerate(subjects)]
        (self.at / "p.xml").write_text(text.replace(self.grant, "\n".join(grants)))

    def commands(self):
        yield "CN=mallory", ("identity", "issue", "mallory", "--ca", "ca", "-o", "mallory")
        yield "CN=/mallory", ("keystore", "enclave", "ks", "/mallory")
        yield "CN=/mallory", ("keystore", "permission", "ks", "/mallory")

    def test_grants_for_others_are_refused_and_named(self):
        for own, words in self.commands():
            with self.subTest(words=words):
                if words[1] == "permission":
                    self.run_program("keystore", "enclave", "ks", "/mallory", "--allow-all", *NOW)
                self.document(own, "CN=eve", "CN=trudy")
                before = self.files()
                told = self.refused("foreign_grant", 1, *words, "--permissions", "p.xml", *NOW)
                self.assertIn('found "CN=eve", "CN=trudy"', told["message"])
                self.assertEqual(self.files(), before)
                self.document(own)
                self.run_program(*words, "--permissions", "p.xml", *NOW)
                if words[0] == "keystore" and words[1] == "enclave":
                    (self.at / "ks/enclaves/mallory").rename(self.at / "gone")

    def test_an_option_takes_them(self):
        self.document("CN=mallory", "CN=eve")
        words = ("identity", "issue", "mallory", "--ca", "ca", "-o", "mallory", "--permissions", "p.xml")
        self.run_program(*words, *NOW, exit=1)
        self.run_program(*words, "--other-grants", *NOW)

    def test_a_fleet_too(self):
        self.document("CN=mallory", "CN=eve")
        (self.at / "fleet.toml").write_text('[[participant]]\nname = "mallory"\npermissions = "p.xml"\n')
        words = ("identity", "issue", "--from", "fleet.toml", "--ca", "ca", "-o", "fleet")
        self.assertIn("CN=eve", self.run_program(*words, *NOW, exit=1).stderr)
        self.run_program(*words, "--other-grants", *NOW)

    def test_broken_permissions_are_not_passed_over(self):
        self.run_program("identity", "issue", "a", "--ca", "ca", "-o", "a", "--publish", "x", *NOW)
        permissions = self.at / "a/permissions.p7s"
        before = (self.at / "a/cert.pem").read_bytes()
        for target in ("nowhere", "permissions.p7s"):
            permissions.unlink()
            permissions.symlink_to(target)
            told = self.json("identity", "renew", "a", "--ca", "ca", "--permissions", *NOW, exit=3)["diagnostics"][0]
            self.assertIn("a link that leads nowhere", told["message"])
            self.assertEqual((self.at / "a/cert.pem").read_bytes(), before)
        self.run_program("identity", "renew", "a", "--ca", "ca", *NOW)

    def test_permissions_are_for_certificates_of_the_same_ca(self):
        self.run_program("ca", "create", "foreign", "--no-passphrase", "-q", *NOW)
        self.run_program("identity", "issue", "s", "--ca", "foreign", "-o", "s", *NOW)
        words = ("permissions", "new", "--cert", "s", "--publish", "x", "-o", "s.xml")
        told = self.refused("issuer_unknown", 1, *words, "--sign", "--ca", "ca", *NOW)
        self.assertIn("ca/identity/ca.pem", told["message"])
        self.assertFalse((self.at / "s.xml").exists())
        self.run_program(*words, "--sign", "--ca", "ca/permissions", *NOW)
        self.run_program("permissions", "new", "--cert", "eve", "--publish", "x", "-o", "e.xml", "--sign", "--ca", "ca", *NOW)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""identity issue and show: a participant's folder, whole or not at all."""

from transcript import Transcript, main

NOW = ("--now", "2026-11-21T00:00:00Z")


class Identity(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "ca", "--passphrase-env", "SECRET", *NOW,
                         environment={"SECRET": "x"})

    def issue(self, *more):
        return ("identity", "issue", "talker", "--ca", "ca", "-o", "talker", *NOW, *more)

    def run_with_secret(self, function, *words):
        return function(*words, "--passphrase-env", "SECRET", environment={"SECRET": "x"})

    def test_issue_makes_a_complete_folder(self):
        (self.at / "governance.p7s").write_text("signed")
        out = self.run_with_secret(self.json, *self.issue(
            "--publish", "rt/chatter", "--publish", "rt/<a>&", "--subscribe", "*",
            "--domain", "7", "--governance", "governance.p7s"))
        made = {f["path"]: f["mode"] for f in out["files_written"]}
        self.assertEqual(made, {"talker/identity_ca.pem": "0644", "talker/cert.pem": "0644",
                                "talker/key.pem": "0600", "talker/permissions_ca.pem": "0644",
                                "talker/permissions.p7s": "0644", "talker/governance.p7s": "0644"})
        self.assertEqual((out["result"]["subject"], out["result"]["not_after"]),
                         ("CN=talker", "2027-11-21T00:00:00Z"))
        self.openssl("verify", "-attime", "1795305600", "-CAfile", "talker/identity_ca.pem",
                     "talker/cert.pem")
        permissions = self.openssl("smime", "-verify", "-text", "-attime", "1795305600", "-in",
                                   "talker/permissions.p7s", "-CAfile", "talker/permissions_ca.pem",
                                   "-purpose", "any")
        for text in ("<subject_name>CN=talker<", "<id>7<", "rt/&lt;a&gt;&amp;",
                     "<not_after>2027-11-21T00:00:00Z<", "<default>DENY<"):
            self.assertIn(text, permissions)

    def test_show_says_what_the_certificate_says(self):
        self.run_with_secret(self.run_program, *self.issue("--subject", "CN=/a/b,O=Example"))
        shown = self.json("identity", "show", "talker", *NOW)["result"]
        self.assertEqual((shown["subject"], shown["issuer"], shown["valid_now"]),
                         ("CN=/a/b,O=Example", "CN=ca Identity CA", True))
        self.assertEqual(shown, self.json("identity", "show", "talker/cert.pem", *NOW)["result"])
        for time, code in (("2026-11-20T00:00:00Z", "certificate_not_yet_valid"),
                           ("2028-01-01T00:00:00Z", "certificate_expired")):
            late = self.json("identity", "show", "talker", "--now", time, exit=1)
            self.assertEqual([d["id"] for d in late["diagnostics"]], [code])

    def test_a_ca_key_that_others_can_read_is_refused(self):
        key = self.at / "ca/identity/ca.key.pem"
        key.chmod(0o640)
        told = self.run_with_secret(lambda *w, **m: self.refused("key_readable_by_others", 4, *w, **m),
                                    *self.issue())
        self.assertIn("expected mode 0600, found mode 0640", told["message"])
        self.run_with_secret(self.run_program, *self.issue("--insecure-key-mode"))

    def test_wrong_and_missing_passphrases(self):
        self.refused("passphrase_needed", 4, *self.issue())
        self.refused("passphrase_wrong", 1, *self.issue("--passphrase-env", "SECRET"),
                     environment={"SECRET": "y"})

    def test_names_cannot_leave_the_folder(self):
        for name in ("../evil", "a/b", "", ".hidden", "a" * 65, "a\nb", "ä"):
            self.refused("name_unusable", 2, "identity", "issue", name, "--ca", "ca", "-o", "x")

    def test_nothing_outlives_its_ca_unless_clamped(self):
        self.run_with_secret(lambda *w, **m: self.refused("outlives_ca", 4, *w, **m),
                             *self.issue("--days", "5000"))
        out = self.run_with_secret(self.json, *self.issue("--days", "5000", "--clamp"))
        self.assertEqual(out["result"]["not_after"], "2036-11-18T00:00:00Z")

    def test_existing_folders_and_foreign_keys_are_refused(self):
        self.run_with_secret(self.run_program, *self.issue())
        self.refused("would_overwrite", 4, *self.issue())
        (self.at / "ca/identity/ca.pem").write_bytes((self.at / "ca/permissions/ca.pem").read_bytes())
        self.run_with_secret(lambda *w, **m: self.refused("key_mismatch", 1, *w, **m),
                             "identity", "issue", "b", "--ca", "ca", "-o", "b", *NOW)


if __name__ == "__main__":
    main()

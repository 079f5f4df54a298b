#!/usr/bin/env python3
"""ca create and ca show: two CAs, encrypted, complete or not there."""

import signal
import subprocess
import time

from transcript import PROGRAM, Transcript, main

SECRET = {"SECRET": "correct horse"}


class Ca(Transcript):
    def create(self, *more, exit=0):
        return self.json("ca", "create", "ca", "--passphrase-env", "SECRET", *more, exit=exit,
                         environment=SECRET)

    def test_create_makes_two_encrypted_cas_for_their_owner_only(self):
        out = self.create("--now", "2026-11-21T00:00:00Z")
        self.assertEqual(self.files(), {"ca/identity/ca.pem": 0o644, "ca/identity/ca.key.pem": 0o600,
                                        "ca/permissions/ca.pem": 0o644,
                                        "ca/permissions/ca.key.pem": 0o600})
        self.assertEqual((self.at / "ca").stat().st_mode & 0o777, 0o700)
        self.assertEqual({f["path"]: int(f["mode"], 8) for f in out["files_written"]}, self.files())
        self.assertEqual([c["subject"] for c in out["result"]["cas"]],
                         ["CN=ca Identity CA", "CN=ca Permissions CA"])
        self.assertEqual(out["result"]["cas"][0]["not_after"], "2036-11-18T00:00:00Z")
        for role in ("identity", "permissions"):
            self.assertIn("BEGIN ENCRYPTED", (self.at / "ca" / role / "ca.key.pem").read_text())
        text = self.openssl("x509", "-in", "ca/identity/ca.pem", "-noout", "-text")
        self.assertIn("CA:TRUE, pathlen:1", text)
        self.assertIn("Digital Signature, Certificate Sign, CRL Sign", text)
        self.openssl("pkey", "-in", "ca/identity/ca.key.pem", "-passin", "pass:correct horse", "-noout")

    def test_one_role_lies_in_the_folder_itself(self):
        self.create("--role", "identity", "--subject", "CN=Plant CA,O=Example", "--key", "rsa2048")
        out = self.json("ca", "show", "ca")["result"]
        self.assertEqual((out["subject"], out["algorithm"], out["key"]),
                         ("CN=Plant CA,O=Example", "RSA-2048", {"encrypted": True, "mode": "0600"}))

    def test_unencrypted_keys_need_a_flag_and_are_told(self):
        text = self.run_program("ca", "create", "ca", "--no-passphrase").stdout
        self.assertIn("NOT encrypted", text)
        self.assertIn("NOT encrypted, mode 0600", self.run_program("ca", "show", "ca/identity").stdout)

    def test_nothing_is_ever_overwritten(self):
        self.create()
        (self.at / "file").write_text("mine")
        (self.at / "empty").mkdir()
        (self.at / "link").symlink_to("nowhere")
        for place in ("ca", "ca/", "file", "empty", "link"):
            self.refused("would_overwrite", 4, "ca", "create", place, "--no-passphrase")
        self.assertFalse((self.at / "nowhere").exists())

    def test_a_passphrase_comes_from_a_file_standard_input_or_nowhere(self):
        (self.at / "secret").write_text("correct horse\n")
        self.run_program("ca", "create", "one", "--passphrase-file", "secret")
        self.run_program("ca", "create", "two", "--passphrase-file", "-", stdin="correct horse\n")
        for ca in ("one", "two"):
            self.openssl("pkey", "-in", f"{ca}/identity/ca.key.pem", "-passin", "pass:correct horse",
                         "-noout")
        self.refused("passphrase_needed", 4, "ca", "create", "three")
        self.refused("passphrase_unusable", 4, "ca", "create", "three", "--passphrase-file", "-",
                     stdin="\n")
        self.refused("passphrase_unusable", 4, "ca", "create", "three", "--passphrase-env", "SECRET",
                     environment={"SECRET": "x" * 1025})
        self.refused("file_not_found", 3, "ca", "create", "three", "--passphrase-file", "none")

    def test_odd_values_are_usage_errors(self):
        for option, value in (("--days", "0"), ("--days", "1e3"), ("--key", "dsa"), ("--role", "all")):
            self.refused("usage", 2, "ca", "create", "x", "--no-passphrase", option, value)
        self.refused("usage", 2, "ca", "create", "x", "--no-passphrase", "--subject", "CN=a")
        self.refused("subject_name_malformed", 2, "ca", "create", "x", "--no-passphrase",
                     "--role", "identity", "--subject", "nobody")

    def test_a_folder_that_cannot_be_written_fails_cleanly(self):
        self.refused("file_unwritable", 5, "ca", "create", "/proc/ca", "--no-passphrase")
        self.refused("file_unwritable", 5, "ca", "create", "missing/ca", "--no-passphrase")

    def test_an_interrupted_command_leaves_nothing(self):
        running = subprocess.Popen([PROGRAM, "ca", "create", "ca", "--passphrase-file", "-"],
                                   cwd=self.at, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while not list(self.at.iterdir()):
            time.sleep(0.01)
        running.send_signal(signal.SIGTERM)
        _, said = running.communicate("correct horse\n", timeout=60)
        self.assertEqual(running.returncode, 5)
        self.assertIn("error[interrupted]", said)
        self.assertEqual(list(self.at.iterdir()), [])

    def test_show_refuses_what_is_no_ca(self):
        self.refused("file_not_found", 3, "ca", "show", "nothing")
        (self.at / "bad").mkdir()
        (self.at / "bad/ca.pem").write_text("no certificate")
        self.refused("certificate_malformed", 3, "ca", "show", "bad")


if __name__ == "__main__":
    main()

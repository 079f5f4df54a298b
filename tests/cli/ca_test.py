#!/usr/bin/env python3
"""ca create and ca show: two CAs, encrypted, complete or not there."""

import shutil
import signal
import subprocess
import time

from transcript import AT_THAT_TIME, NOW, PROGRAM, Transcript, main

SECRET = {"SECRET": "correct horse"}


class Ca(Transcript):
    def create(self, *more, exit=0):
        return self.json("ca", "create", "ca", "--passphrase-env", "SECRET", *more, exit=exit,
                         environment=SECRET)

    def test_create_makes_two_encrypted_cas_for_their_owner_only(self):
        out = self.create("--now", "2026-11-21T00:00:00Z")
        self.assertEqual(self.files(), {"ca/identity/ca.pem": 0o644, "ca/identity/ca.key.pem": 0o600,
                                        "ca/identity/crl.pem": 0o644,
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

    def test_both_cas_of_a_folder_are_shown(self):
        self.run_program("init", "demo", *NOW)
        for folder in ("demo", "demo/ca"):
            text = self.run_program("ca", "show", folder, *NOW).stdout
            self.assertRegex(text, r"^identity CA\nsubject  CN=demo Identity CA\n(.+\n)+"
                                   r"\npermissions CA\nsubject  CN=demo Permissions CA\n(.+\n)+$")
            out = self.json("ca", "show", folder, *NOW)["result"]
            self.assertEqual((out["role"], out["subject"], [(one["role"], one["subject"]) for one in out["others"]]),
                             ("identity", "CN=demo Identity CA", [("permissions", "CN=demo Permissions CA")]))
            one = self.json("ca", "show", folder, "--role", "permissions", *NOW)["result"]
            self.assertEqual((one["subject"], one["others"]), ("CN=demo Permissions CA", []))
        shutil.rmtree(self.at / "demo/ca/identity")
        self.assertEqual(self.json("ca", "show", "demo/ca", *NOW)["result"]["role"], "permissions")

    def test_a_cas_own_folder_does_not_say_its_role(self):
        self.create()
        for role, words in (("Identity", ()), ("Permissions", ()), ("Permissions", ("--role", "identity"))):
            folder = f"ca/{role.lower()}"
            self.assertTrue(self.run_program("ca", "show", folder, *words).stdout.startswith(f"subject  CN=ca {role} CA\n"))
            out = self.json("ca", "show", folder, *words)["result"]
            self.assertEqual((out["role"], out["others"]), (None, []))

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
        subprocess.run(["bash", "-c", f'"{PROGRAM}" ca create piped --passphrase-file <(cat secret)'],
                       cwd=self.at, check=True, capture_output=True, timeout=60)
        self.openssl("pkey", "-in", "piped/identity/ca.key.pem", "-passin", "pass:correct horse", "-noout")
        self.refused("passphrase_needed", 4, "ca", "create", "three")
        self.refused("passphrase_unusable", 4, "ca", "create", "three", "--passphrase-file", "-",
                     stdin="\n")
        self.refused("passphrase_unusable", 4, "ca", "create", "three", "--passphrase-env", "SECRET",
                     environment={"SECRET": "x" * 1025})
        self.refused("file_not_found", 3, "ca", "create", "three", "--passphrase-file", "none")

    def test_a_passphrase_that_others_can_read_is_told(self):
        (self.at / "secret").write_text("correct horse\n")
        (self.at / "secret").chmod(0o640)
        out = self.json("ca", "create", "one", "--passphrase-file", "secret")
        self.assertEqual([(d["id"], d["severity"], d["file"]) for d in out["diagnostics"]],
                         [("passphrase_readable_by_others", "warning", "secret")])
        self.assertIn("(expected mode 0600, found mode 0640)", out["diagnostics"][0]["message"])
        done = self.run_program("ca", "show", "one")
        self.assertEqual(done.stderr, "")
        done = self.run_program("crl", "new", "--ca", "one", "--passphrase-file", "secret")
        self.assertIn("warning[passphrase_readable_by_others]", done.stderr)
        (self.at / "secret").chmod(0o400)
        self.assertEqual(self.json("ca", "create", "two", "--passphrase-file", "secret")["diagnostics"], [])

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

    def root(self, folder, *more):
        self.run_program("ca", "create", folder, "--no-passphrase", "--role", "identity", *more, *NOW)

    def test_an_intermediate_ca_issues_below_its_root_and_no_further(self):
        self.root("root", "--subject", "CN=Root")
        out = self.json("ca", "create", "plant", "--no-passphrase", "--role", "identity", "--days",
                        "30", "--intermediate-of", "root", *NOW)
        self.assertEqual(out["result"]["cas"][0]["subject"], "CN=plant Identity CA")
        self.run_program("identity", "issue", "a", "--ca", "plant", "-o", "a", "--days", "9", *NOW)
        self.assertEqual((self.at / "a/identity_ca.pem").read_text(),
                         (self.at / "plant/ca.pem").read_text())
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "root/ca.pem", "-untrusted",
                     "plant/ca.pem", "a/cert.pem")
        self.assertIn("pathlen:0", self.openssl("x509", "-in", "plant/ca.pem", "-noout", "-text"))
        self.assertEqual(self.json("ca", "show", "root", *NOW)["result"]["issued"], 1)
        below = ("ca", "create", "x", "--no-passphrase", "--role", "identity", "--intermediate-of")
        self.refused("path_too_long", 1, *below, "plant", *NOW)
        self.refused("outlives_ca", 4, *below, "root", "--days", "9999", *NOW)
        self.run_program(*below, "root", "--days", "9999", "--clamp", *NOW)

    def test_an_intermediate_ca_is_renewed_by_the_one_above(self):
        self.root("root", "--subject", "CN=Root")
        self.run_program("ca", "create", "plant", "--no-passphrase", "--role", "identity",
                         "--days", "30", "--intermediate-of", "root", *NOW)
        self.refused("usage", 2, "ca", "renew", "plant", "--days", "60", *NOW)
        out = self.json("ca", "renew", "plant", "--issuer", "root", "--days", "60", *NOW)["result"]
        self.assertEqual(out["not_after"], "2027-01-20T00:00:00Z")
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "root/ca.pem", "plant/ca.pem")
        self.assertEqual(self.json("ca", "show", "root", *NOW)["result"]["issued"], 2)

    def test_a_renewed_ca_still_vouches_for_what_it_issued_and_signed(self):
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        self.run_program("identity", "issue", "a", "--ca", "ca", "-o", "a", "--publish", "x", *NOW)
        before = self.json("ca", "show", "ca", *NOW)["result"]
        for role in ("identity", "permissions"):
            out = self.json("ca", "renew", "ca", "--role", role, "--days", "7000", *NOW)["result"]
            self.assertEqual(out["not_after"], "2046-01-20T00:00:00Z")
            self.assertEqual(out["folders"], [str(self.at / "a")] if role == "identity" else [])
        after = self.json("ca", "show", "ca", *NOW)["result"]
        self.assertEqual((after["subject"], after["not_after"]),
                         (before["subject"], "2046-01-20T00:00:00Z"))
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "ca/identity/ca.pem", "a/cert.pem")
        self.json("permissions", "verify", "a/permissions.p7s", "--ca", "ca/permissions/ca.pem", *NOW)
        self.run_program("identity", "issue", "b", "--ca", "ca", "-o", "b", "--publish", "x", *NOW)
        for name in ("a", "b"):  # both have participants that know the old and the new certificate
            self.openssl("verify", *AT_THAT_TIME, "-CAfile", f"{name}/identity_ca.pem",
                         "a/cert.pem", "b/cert.pem")

    def test_renewing_says_what_to_do_next_and_in_which_order(self):
        self.run_program("init", "demo", *NOW)
        told = self.run_program("ca", "renew", "demo", "--role", "permissions", *NOW).stdout
        self.assertRegex(told, r"old certificate's, which ends on 2036-.*Before that day:\n(.|\n)*stock .*refuse documents "
                               r"of the old certificate .*ddssec ca rotate demo --role permissions\n")
        told = self.run_program("ca", "renew", "demo", "--role", "identity", *NOW).stdout
        self.assertRegex(told, r"identity_ca.pem before 2036-.*\nThe revocation list ends on 2036-.*ddssec crl new --ca demo, "
                               r"then ddssec crl distribute --ca demo\n")

    def test_renewing_an_expired_ca_says_what_to_do_now(self):
        later = ("--now", "2040-01-01T00:00:00Z")
        self.run_program("init", "demo", *NOW)
        told = self.run_program("ca", "renew", "demo", "--role", "identity", *later).stdout
        self.assertRegex(told, r"identity_ca.pem now\.\nThe revocation list ended on 2036-.* Now: ddssec crl new --ca demo, ")
        told = self.run_program("ca", "renew", "demo", "--role", "permissions", *later).stdout
        self.assertRegex(told, r"which ended on 2036-.*\. Now:\n")
        self.run_program("ca", "rotate", "demo", "--role", "permissions", "--clock-is-right", *later)

    def test_renewing_a_ca_of_a_keystore_names_the_commands_of_keystores(self):
        self.run_program("keystore", "create", "a ks", "--no-passphrase", *NOW)
        self.run_program("keystore", "enclave", "a ks", "/a", "--allow-all", *NOW)
        told = self.run_program("ca", "renew", "a ks", "--role", "identity", *NOW).stdout
        self.assertIn("Enclaves of the keystore have a link to the new one.\n", told)
        told = self.run_program("ca", "renew", "a ks", "--role", "permissions", *NOW).stdout
        self.assertIn("with a new key: ddssec keystore rotate 'a ks' --role permissions\n", told)
        self.run_program("keystore", "rotate", "a ks", "--role", "permissions", *NOW)

    def test_the_former_certificate_may_end_behind_the_renewed_one(self):
        made, renewed, issued, now = (("--now", f"{day}T00:00:00Z")
                                      for day in ("2016-11-24", "2026-11-01", "2026-11-02", "2026-11-25"))
        self.run_program("init", "demo", *made)
        for role in ("permissions", "identity"):
            self.run_program("ca", "renew", "demo", "--role", role, *renewed)
        (self.at / "demo/governance.p7s").unlink()
        self.run_program("governance", "sign", "demo/governance.xml", "--ca", "demo", "-o", "demo/governance.p7s", *issued)
        for name in ("talker", "listener"):
            self.run_program("identity", "issue", name, "--ca", "demo", "-o", f"demo/{name}", "--replace", "--publish", "*",
                             "--subscribe", "*", "--governance", "demo/governance.p7s", *issued)
            self.assertEqual((self.at / f"demo/{name}/identity_ca.pem").read_text().count("BEGIN"), 2)
        self.run_program("crl", "new", "--ca", "demo", *issued)
        self.run_program("crl", "distribute", "--ca", "demo", *issued)
        self.assertNotIn("error", self.run_program("doctor", "demo/talker", *now).stderr)
        for product in ("cyclonedds@0.10.2", "fastdds@2.9.1", "ddssec"):
            self.run_program("check", "demo/talker", "demo/listener", "--vendor", f"A={product}", "--vendor",
                             f"B={product}", *now)
        ca = self.at / "demo/talker/identity_ca.pem"  # the former one first: the products read that
        first, second = ca.read_text().split("-----END CERTIFICATE-----\n")[:2]
        ca.write_text("".join(one + "-----END CERTIFICATE-----\n" for one in (second, first)))
        self.assertIn("DOC022", self.run_program("doctor", "demo/talker", *now, exit=1).stderr)

    def test_a_ca_made_by_openssl_is_taken_over(self):
        self.openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
                     "-keyout", "key.pem", "-out", "cert.pem", "-subj", "/O=Acme/CN=Plant", "-days", "30")
        take = ("ca", "import", "ca", "--cert", "cert.pem")
        self.refused("passphrase_needed", 4, *take, "--key", "key.pem")
        out = self.json(*take, "--key", "key.pem", "--passphrase-env", "SECRET", environment=SECRET)
        self.assertEqual({f["path"]: f["mode"] for f in out["files_written"]},
                         {"ca/identity/ca.pem": "0644", "ca/identity/ca.key.pem": "0600"})
        self.json(*take, "--role", "permissions")  # the other role, without a key, beside it
        self.assertIsNone(self.json("ca", "show", "ca", "--role", "permissions")["result"]["key"])
        issue = ("identity", "issue", "a", "--ca", "ca", "-o", "a", "--days", "9",
                 "--passphrase-env", "SECRET")
        self.json(*issue, environment=SECRET)
        self.openssl("verify", "-CAfile", "cert.pem", "a/cert.pem")
        self.run_program("governance", "new", "-o", "g.xml")
        self.refused("file_not_found", 3, "governance", "sign", "g.xml", "--ca", "ca/permissions")
        self.refused("would_overwrite", 4, *take, "--no-passphrase")
        self.refused("key_mismatch", 1, "ca", "import", "x", "--cert", "cert.pem", "--key", "a/key.pem",
                     "--no-passphrase")
        self.refused("not_a_ca", 1, "ca", "import", "x", "--cert", "a/cert.pem")

    def test_show_refuses_what_is_no_ca(self):
        self.refused("file_not_found", 3, "ca", "show", "nothing")
        (self.at / "bad").mkdir()
        (self.at / "bad/ca.pem").write_text("no certificate")
        self.refused("certificate_malformed", 3, "ca", "show", "bad")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""keystore import, split-ca and rotate, revocation lists, and enclaves that are issued again."""

import shutil

from keystore_folders import NEEDED, TALKER, KeystoreTest
from transcript import NOW, main


class Upkeep(KeystoreTest):
    def test_a_keystore_of_sros2_is_taken_over(self):
        self.golden()
        told = self.json("keystore", "verify", "ks", *NOW, exit=1)
        self.assertEqual(len(told["result"]["keys_for_others"]), 4)
        self.assertEqual([d["file"] for d in told["diagnostics"] if d["id"] == "key_readable_by_others"],
                         ["ks/private/ca.key.pem"])
        self.assertEqual([d["id"] for d in told["diagnostics"]].count("DOC003"), 3)
        self.refused("key_readable_by_others", 4, "keystore", "split-ca", "ks", *NOW)
        out = self.json("keystore", "import", "ks", *NOW)["result"]
        self.assertEqual(out["logged"], ["/talker_listener/listener", "/talker_listener/talker", "/wildcard"])
        self.assertEqual(len(out["keys_closed"]), 4)
        self.assertEqual(out["folders_closed"], ["ks/private"])
        self.assertEqual((self.at / "ks/private").stat().st_mode & 0o777, 0o700)
        self.assertEqual(self.json("keystore", "import", "ks", *NOW)["result"],
                         {"folders_closed": [], "keys_closed": [], "logged": []})
        self.healthy("/talker_listener/listener", "/talker_listener/talker", "/wildcard")

    def test_a_folder_behind_a_link_keeps_its_mode(self):
        """A keystore that came from another user must not close any folder of this one."""
        for name in ("private", "enclaves"):
            with self.subTest(name=name):
                shutil.rmtree(self.at / "ks", ignore_errors=True)
                shutil.rmtree(self.at / "shared", ignore_errors=True)
                self.golden()
                (self.at / "ks" / name).rename(self.at / "shared")
                (self.at / "ks" / name).symlink_to(self.at / "shared")
                (self.at / "shared").chmod(0o777)
                keys = {key: key.stat().st_mode for key in (self.at / "shared").rglob("*key.pem")}
                self.assertTrue(keys)
                refusal = self.refused("file_unwritable", 5, "keystore", "import", "ks", *NOW)
                self.assertIn("symbolic link", refusal["message"])
                self.assertEqual((self.at / "shared").stat().st_mode & 0o777, 0o777)
                self.assertEqual({key: key.stat().st_mode for key in keys}, keys)

    def test_a_copy_of_another_enclaves_certificate_is_not_logged(self):
        self.golden()
        other = self.at / "ks/enclaves/talker_listener/listener/cert.pem"
        (self.at / TALKER / "cert.pem").write_bytes(other.read_bytes())
        told = self.refused("certificate_of_another_folder", 1, "keystore", "import", "ks", *NOW)
        self.assertIn("which is also in ks/enclaves/talker_listener/listener", told["message"])
        self.assertEqual(told["hint"], "ddssec keystore verify ks names the enclave that is the copy")
        self.assertIn("enclave /talker_listener/talker has the key of enclave /talker_listener/listener",
                      self.run_program("keystore", "verify", "ks", *NOW, exit=1).stderr)
        self.run_program("keystore", "create", "own", "--no-passphrase", *NOW)
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "own", name, "--allow-all", *NOW)
        shutil.copy(self.at / "own/enclaves/b/cert.pem", self.at / "own/enclaves/a/cert.pem")
        self.refused("certificate_of_another_folder", 1, "keystore", "import", "own", *NOW)

    def test_its_certificates_are_renewed_and_revoked_in_place(self):
        self.golden()
        self.run_program("keystore", "import", "ks", *NOW)
        before = self.json("identity", "show", TALKER, *NOW)["result"]
        out = self.json("identity", "renew", TALKER, "--ca", "ks", "--days", "2000", "--permissions", *NOW)
        self.assertEqual(out["result"]["subject"], before["subject"])
        self.healthy("/talker_listener/listener", "/talker_listener/talker", "/wildcard")
        self.run_program("identity", "revoke", "ks/enclaves/talker_listener/listener", "--ca", "ks", *NOW)
        out = self.json("crl", "distribute", "--ca", "ks", *NOW)["result"]
        self.assertEqual(out["folders"], [str(self.at / TALKER), str(self.at / "ks/enclaves/wildcard")])

    def test_a_copied_or_moved_keystore_keeps_to_its_own_enclaves(self):
        self.create()
        for name in ("/a", "/b", "/c"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        shutil.copytree(self.at / "ks", self.at / "copy", symlinks=True)
        before = {p: p.read_bytes() for p in (self.at / "ks").rglob("*") if p.is_file()}
        shutil.rmtree(self.at / "copy/enclaves/c")
        own = [str(self.at / "copy/enclaves/b")]
        out = self.json("identity", "revoke", "copy/enclaves/a", "--ca", "copy", *NOW)["result"]
        left_out = [str(self.at / "ks/enclaves/c")]
        self.assertEqual((out["folders"], out["elsewhere"]), (own + left_out, left_out))
        out = self.json("crl", "distribute", "--ca", "copy", *NOW)
        self.assertEqual((out["result"]["folders"], out["result"]["elsewhere"]), (own, left_out))
        self.assertEqual([f["path"] for f in out["files_written"]], [own[0] + "/crl.pem"])
        self.assertEqual({p: p.read_bytes() for p in before}, before)  # the original knows nothing of it
        told = self.run_program("crl", "distribute", "--ca", "copy", *NOW).stdout
        self.assertIn("another copy of this CA lies beside it", told)
        (self.at / "copy").rename(self.at / "moved")
        shutil.rmtree(self.at / "ks")
        out = self.json("crl", "distribute", "--ca", "moved", *NOW)["result"]
        self.assertEqual(out["folders"], [str(self.at / "moved/enclaves/b")])

    def test_the_keystores_newer_list_counts_before_it_is_distributed(self):
        self.create()
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        self.run_program("identity", "revoke", "ks/enclaves/a", "--ca", "ks", *NOW)
        for distributed in (False, True):
            for words in (("keystore", "verify", "ks"), ("doctor", "ks/enclaves/a")):
                told = [d for d in self.json(*words, *NOW, exit=1)["diagnostics"] if d["id"] == "DOC024"]
                self.assertEqual(len(told), 1, words)
                self.assertRegex(told[0]["message"], "serial [0-9A-F]+\\) is revoked by list 2 of the CA, .*"
                                 "/ks/public/identity_ca.crl.pem; crl.pem here is list 1; "
                                 "participants that do not have that list yet accept it$")
            self.json("check", "ks/enclaves/a", "ks/enclaves/b", *NOW, exit=1 if distributed else 0)
            told = self.json("can", "ks/enclaves/a", "publish", "x", *NOW, exit=1)["result"]
            self.assertIn("is revoked by list 2", told["because"])
            self.json("can", "ks/enclaves/b", "publish", "x", *NOW)
            states = {e["subject"]: e["state"] for e in self.json("expiry", "ks", *NOW)["result"]["entries"]
                      if e["kind"] == "certificate"}
            self.assertEqual(states, {"CN=/a": "revoked", "CN=/b": "ok"})
            told = [(d["id"], d["severity"]) for d in self.json("doctor", "ks/enclaves/b", *NOW)["diagnostics"]]
            self.assertEqual(told, [] if distributed else [("DOC023", "warning")])
            out = self.json("crl", "distribute", "--ca", "ks", *NOW)["result"]
            self.assertEqual(out["of_revoked"], [str(self.at / "ks/enclaves/a")])

    def test_a_list_that_the_ca_did_not_sign_counts_for_nothing(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        (self.at / "other").mkdir()
        self.run_program("keystore", "create", "other/ks", "--no-passphrase", *NOW)
        serial = self.json("identity", "show", "ks/enclaves/a", *NOW)["result"]["serial"]
        with open(self.at / "other/ks/private/identity_ca.issued.jsonl", "w", encoding="ascii") as log:
            log.write(f'{{"event":"issued","serial":"{serial}","subject":"CN=/a",'
                      '"not_after":"2027-11-21T00:00:00Z"}\n')
        self.run_program("identity", "revoke", serial, "--ca", "other/ks", *NOW)
        shutil.copy(self.at / "other/ks/public/identity_ca.crl.pem", self.at / "ks/public/identity_ca.crl.pem")
        self.assertEqual(self.json("doctor", "ks/enclaves/a", *NOW)["diagnostics"], [])

    def test_a_revoked_enclave_comes_back_with_a_new_key(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.run_program("identity", "revoke", "ks/enclaves/a", "--ca", "ks", *NOW)
        told = self.refused("certificate_revoked", 1, "identity", "renew", "ks/enclaves/a", "--ca", "ks", *NOW)
        self.assertIn("ddssec keystore enclave", told["hint"])
        told = self.refused("would_overwrite", 4, "keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.assertIn("the enclave exists", told["message"])
        self.assertTrue(told["hint"].startswith("ddssec keystore permission gives it other rights"), told)
        self.assertIn("--replace issues it again, with a new key", told["hint"])
        self.run_program("keystore", "enclave", "ks", "/a", "--replace", *NOW)
        self.healthy("/a")

    def test_replace_of_an_enclave_keeps_its_permissions_and_the_enclaves_below_it(self):
        self.create()
        for name in ("/a", "/a/b", "/z"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        files = lambda folder: {name: (self.at / "ks/enclaves" / folder / name).read_bytes()
                                for name in ("cert.pem", "key.pem", "permissions.p7s")}
        before, below = files("a"), files("a/b")
        done = self.run_program("keystore", "enclave", "ks", "/a", "--replace", *NOW)
        self.assertIn("permissions.p7s stays, until 2027-11-21\n", done.stdout)
        self.assertIn("the certificate before it is valid until 2027-11-21", done.stdout)
        after = files("a")
        self.assertEqual([name for name in before if before[name] != after[name]], ["cert.pem", "key.pem"])
        self.assertEqual(files("a/b"), below)
        self.healthy("/a", "/a/b", "/z")
        serial = done.stdout.split("ddssec identity revoke ")[1].split()[0]
        self.json("identity", "revoke", serial, "--ca", "ks", *NOW)
        self.run_program("crl", "distribute", "--ca", "ks", *NOW)
        self.healthy("/a", "/a/b", "/z")
        self.run_program("keystore", "enclave", "ks", "/a", "--replace", "--allow-all", *NOW)
        self.assertNotEqual(files("a")["permissions.p7s"], after["permissions.p7s"])
        self.healthy("/a", "/a/b", "/z")

    def test_replace_without_permissions_of_the_enclave_asks_for_them(self):
        self.create()
        enclave = ("keystore", "enclave", "ks")
        self.refused("usage", 2, *enclave, "/a", "--replace", *NOW)  # there is nothing to keep
        for name in ("/a", "/b"):
            self.run_program(*enclave, name, "--allow-all", *NOW)
        shutil.copy(self.at / "ks/enclaves/b/permissions.p7s", self.at / "ks/enclaves/a/permissions.p7s")
        told = self.refused("no_grant_for_subject", 1, *enclave, "/a", "--replace", *NOW)
        self.assertTrue(told["hint"].startswith("give its rights, too"), told)
        later = ("--now", "2028-11-21T00:00:00Z")
        self.refused("grant_expired", 1, *enclave, "/b", "--replace", *later)
        for name in ("/a", "/b"):
            self.run_program(*enclave, name, "--replace", "--allow-all", *NOW)
        self.healthy("/a", "/b")

    def test_replace_of_an_enclave_of_another_keystore_makes_it_one_of_this_one(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.run_program("keystore", "create", "other", "--no-passphrase", *NOW)
        self.run_program("keystore", "enclave", "other", "/a", "--allow-all", *NOW)
        shutil.rmtree(self.at / "ks/enclaves/a")
        shutil.copytree(self.at / "other/enclaves/a", self.at / "ks/enclaves/a")  # follows links, as cp -rL
        told = self.json("keystore", "verify", "ks", *NOW, exit=1)["diagnostics"]
        self.assertIn("ddssec keystore enclave KEYSTORE ENCLAVE --replace",
                      [d["hint"] for d in told if d["id"] == "DOC006"][0])
        self.run_program("keystore", "enclave", "ks", "/a", "--replace", "--allow-all", *NOW)
        self.healthy("/a")

    def test_a_keystore_that_was_not_taken_over_gets_the_list_too(self):
        self.golden()
        for key in (self.at / "ks").rglob("*key.pem"):
            key.chmod(0o600)
        told = self.run_program("identity", "revoke", TALKER, "--ca", "ks", *NOW).stdout
        self.assertIn("(puts the list into 2 folders)", told)
        self.assertIn("ddssec keystore import", told)
        self.json("crl", "distribute", "--ca", "ks", *NOW)
        self.json("check", TALKER, "ks/enclaves/talker_listener/listener", *NOW, exit=1)

    def test_split_ca_parts_what_sros2_joined(self):
        self.golden()
        self.run_program("keystore", "import", "ks", *NOW)
        identity = (self.at / "ks/public/identity_ca.cert.pem").read_bytes()
        rights = self.json("can", TALKER, "publish", "rt/chatter", *NOW)["result"]["because"]
        before = self.files()
        told = self.refused("document_unlogged", 1, "keystore", "split-ca", "ks", *NOW)
        self.assertIn("--unlogged", told["hint"])
        self.assertEqual(self.files(), before)
        out = self.json("keystore", "split-ca", "ks", "--unlogged", *NOW)
        self.assertEqual(out["result"]["unlogged"],
                         ["ks/enclaves/governance.p7s"] + [f"ks/enclaves/{name}/permissions.p7s" for name in
                                                           ("talker_listener/listener", "talker_listener/talker", "wildcard")])
        self.assertEqual(out["result"]["subject"], "CN=ks Permissions CA")
        self.assertEqual((self.at / "ks/public/identity_ca.cert.pem").read_bytes(), identity)
        self.assertNotEqual((self.at / "ks/public/permissions_ca.cert.pem").read_bytes(), identity)
        self.assertEqual(self.files()["ks/private/permissions_ca.key.pem"], 0o600)
        for file in NEEDED:
            self.assertTrue((self.at / "ks" / file).is_file(), file)
        self.healthy("/talker_listener/listener", "/talker_listener/talker", "/wildcard")
        self.assertEqual(self.json("can", TALKER, "publish", "rt/chatter", *NOW)["result"]["because"], rights)
        self.assertIn("two CAs already", self.run_program("keystore", "split-ca", "ks", *NOW).stdout)

    def test_rotate_replaces_a_ca_and_everything_follows(self):
        self.create()
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        for role in ("identity", "permissions"):
            before = (self.at / f"ks/private/{role}_ca.key.pem").read_bytes()
            subject = self.json("identity", "show", "ks/enclaves/a", *NOW)["result"]["subject"]
            out = self.json("keystore", "rotate", "ks", "--role", role, *NOW)["result"]
            self.assertEqual(out["enclaves"], ["/a", "/b"])
            self.assertNotEqual((self.at / f"ks/private/{role}_ca.key.pem").read_bytes(), before)
            self.assertEqual(self.json("identity", "show", "ks/enclaves/a", *NOW)["result"]["subject"], subject)
            self.healthy("/a", "/b")
        self.refused("usage", 2, "keystore", "rotate", "ks", "--role", "both")

    def test_rotate_lets_nobody_back_in(self):
        self.create()
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        self.run_program("identity", "revoke", "ks/enclaves/b", "--ca", "ks", *NOW)
        self.run_program("keystore", "rotate", "ks", "--role", "identity", *NOW)
        self.json("keystore", "verify", "ks", *NOW, exit=1)  # /b stays with a CA that no other enclave has
        self.json("doctor", "ks/enclaves/a", *NOW)

    def test_rotate_takes_the_revocation_list_along(self):
        self.create()
        for name in ("/a", "/b", "/c"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        self.run_program("identity", "revoke", "ks/enclaves/b", "--ca", "ks", *NOW)
        self.run_program("crl", "distribute", "--ca", "ks", *NOW)
        done = self.run_program("keystore", "rotate", "ks", "--role", "identity", *NOW)
        self.assertIn("2 enclaves signed again", done.stdout)
        self.assertIn("/b is revoked and was left out", done.stdout)
        for name in ("a", "c"):
            self.json("crl", "verify", f"ks/enclaves/{name}", "--ca", "ks", *NOW)
        self.json("check", "ks/enclaves/a", "ks/enclaves/c", *NOW)
        self.json("check", "ks/enclaves/a", "ks/enclaves/b", *NOW, exit=1)

    def test_a_new_enclave_knows_who_was_revoked(self):
        self.create()
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
            self.assertEqual(self.json("crl", "show", f"ks/enclaves{name}", *NOW)["result"]["revoked"], [])
        self.run_program("identity", "revoke", "ks/enclaves/b", "--ca", "ks", *NOW)
        self.run_program("keystore", "enclave", "ks", "/c", "--allow-all", *NOW)
        self.json("crl", "verify", "ks/enclaves/c", "--ca", "ks", *NOW)
        self.json("check", "ks/enclaves/b", "ks/enclaves/c", *NOW, exit=1)

    def test_a_document_that_the_old_ca_did_not_sign_is_not_signed(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--publish", "x", *NOW)
        document = self.at / "ks/enclaves/a/permissions.p7s"
        document.write_text(document.read_text().replace("<topic>x<", "<topic>*<"))
        self.refused("smime_signature_invalid", 1, "keystore", "rotate", "ks", "--role", "permissions", *NOW)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""keystore enclave /a after /a/b, as sros2 allows: the folder of the first is there without its files."""

import os

from transcript import NOW, Transcript, main

FILES = ["cert.pem", "crl.pem", "governance.p7s", "identity_ca.cert.pem", "key.pem", "permissions.p7s", "permissions.xml",
         "permissions_ca.cert.pem"]


class DeeperEnclave(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("keystore", "create", "ks", "--no-passphrase", *NOW)
        self.run_program("keystore", "enclave", "ks", "/a/b", "--allow-all", *NOW)
        self.a = self.at / "ks/enclaves/a"

    def enclave(self, *more, **options):
        return self.json("keystore", "enclave", "ks", "/a", "--allow-all", *more, *NOW, **options)

    def test_both_are_whole(self):
        out = self.enclave()
        self.assertEqual(sorted(os.path.basename(one["path"]) for one in out["files_written"]), FILES)
        self.assertEqual(sorted(path.name for path in self.a.iterdir()), sorted([*FILES, "b"]))
        self.assertEqual((self.a / "key.pem").stat().st_mode & 0o777, 0o600)
        self.assertEqual(os.readlink(self.a / "governance.p7s"), "../governance.p7s")
        self.assertEqual(self.json("keystore", "list", "ks")["result"]["enclaves"], ["/a", "/a/b"])
        self.json("keystore", "verify", "ks", *NOW)
        for name in ("a", "a/b"):
            self.json("doctor", f"ks/enclaves/{name}", *NOW)
        self.assertIn("the enclave exists", self.refused("would_overwrite", 4, "keystore", "enclave", "ks", "/a",
                                                         "--allow-all", *NOW)["message"])

    def test_a_dry_run_writes_nothing(self):
        before = self.files()
        out = self.enclave("--dry-run")
        self.assertEqual(len(out["files_written"]), len(FILES))
        self.assertEqual(self.files(), before)

    def test_files_that_are_there_are_not_replaced(self):
        (self.a / "key.pem").write_text("another key")
        self.refused("would_overwrite", 4, "keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.assertEqual((self.a / "key.pem").read_text(), "another key")
        self.assertFalse((self.a / "cert.pem").exists())

    def test_with_replace_they_are(self):
        (self.a / "key.pem").write_text("another key")
        (self.a / "governance.p7s").symlink_to("../../elsewhere")
        self.enclave("--replace")
        self.assertIn("PRIVATE KEY", (self.a / "key.pem").read_text())
        self.assertEqual((self.a / "governance.p7s").read_bytes(), (self.a.parent / "governance.p7s").read_bytes())
        self.json("keystore", "verify", "ks", *NOW)
        self.assertEqual(self.json("keystore", "list", "ks")["result"]["enclaves"], ["/a", "/a/b"])

    def test_links_of_a_command_that_was_ended_are_kept(self):
        (self.a / "governance.p7s").symlink_to("../governance.p7s")
        self.enclave()
        self.json("keystore", "verify", "ks", *NOW)

    def test_another_link_is_refused(self):
        (self.a / "governance.p7s").symlink_to("../../elsewhere")
        self.refused("would_overwrite", 4, "keystore", "enclave", "ks", "/a", "--allow-all", *NOW)

    def test_a_link_leads_nowhere_else(self):
        (self.at / "outside").mkdir()
        self.a.rename(self.at / "outside/a")
        self.a.symlink_to(self.at / "outside/a")
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW, exit=4)
        self.assertFalse((self.at / "outside/a/cert.pem").exists())


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Folders of a keystore that cannot be looked at: they are named, and hide no other enclave."""

import os
import shutil
import subprocess
import unittest

from transcript import AT_THAT_TIME, NOW, PROGRAM, Transcript, main

NAMES = ("/a", "/b", "/c", "/d")
OTHER = 1501


class Unseen(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("keystore", "create", "ks", "--no-passphrase", *NOW)
        for name in NAMES:
            self.run_program("keystore", "enclave", "ks", name, "--publish", "rt/x", *NOW)

    def listed(self, exit=0):
        out = self.json("keystore", "list", "ks", *NOW, exit=exit)
        return out["result"]["enclaves"], [(d["id"], d.get("file", "")) for d in out["diagnostics"]]

    def issued_by_current_ca(self, name):
        done = subprocess.run(["openssl", "verify", *AT_THAT_TIME, "-CAfile", "ks/public/identity_ca.cert.pem", f"ks/enclaves{name}/cert.pem"],
                              cwd=self.at, capture_output=True, check=False)
        return done.returncode == 0

    def test_a_link_to_a_folder_is_named_and_not_followed(self):
        (self.at / "ks/enclaves/b/more").symlink_to("../c")
        self.assertEqual(self.listed(exit=3), (list(NAMES), [("keystore_unseen", "ks/enclaves/b/more")]))

    def test_folders_that_lie_too_deep_are_named(self):
        deep = self.at / "ks/enclaves/b"
        for _ in range(16):
            deep /= "x"
        deep.mkdir(parents=True)
        names, told = self.listed(exit=3)
        self.assertEqual((names, [one for one, _ in told]), (list(NAMES), ["keystore_unseen"]))

    def test_an_enclave_whose_key_is_elsewhere_is_one(self):
        (self.at / "ks/enclaves/b/key.pem").unlink()
        self.assertEqual(self.listed(), (list(NAMES), [("enclave_without_key", "")]))
        self.assertIn("warning[enclave_without_key]", self.run_program("keystore", "list", "ks").stderr)
        told = self.json("keystore", "verify", "ks", *NOW, exit=1)
        self.assertEqual([e["name"] for e in told["result"]["enclaves"]], list(NAMES))
        out = self.json("keystore", "rotate", "ks", "--role", "identity", *NOW)["result"]
        self.assertEqual(out["enclaves"], list(NAMES))
        self.assertTrue(self.issued_by_current_ca("/b"))

    def test_a_certificate_that_is_none_stops_no_rotation(self):
        certificate = self.at / "ks/enclaves/b/cert.pem"
        shutil.copy(certificate, self.at / "kept")
        certificate.write_text("garbage")
        out = self.json("keystore", "rotate", "ks", "--role", "identity", *NOW, exit=1)
        self.assertEqual(out["result"]["enclaves"], ["/a", "/c", "/d"])
        self.assertEqual([d["file"] for d in out["diagnostics"]], ["ks/enclaves/b/cert.pem"])
        shutil.copy(self.at / "kept", certificate)
        self.json("keystore", "rotate", "ks", "--role", "identity", *NOW)
        self.assertTrue(self.issued_by_current_ca("/b"))

    @unittest.skipUnless(os.geteuid() == 0, "only root can act as two users")
    def test_a_folder_that_may_not_be_entered_hides_no_enclave(self):
        self.at.chmod(0o755)
        for path in (self.at / "ks", *(self.at / "ks").rglob("*")):
            os.chown(path, 1500, 1500, follow_symlinks=False)
        closed = self.at / "ks/enclaves/b/x"
        closed.mkdir(mode=0o700)
        os.chown(closed, OTHER, OTHER)
        shutil.copy(PROGRAM, self.at / "program")
        self.enclave_b_is_closed(closed)

    def administrator(self, *words, exit):
        done = subprocess.run([self.at / "program", "keystore", *words, *NOW], cwd=self.at, text=True, capture_output=True,
                              timeout=60, check=False, user=1500, group=1500, extra_groups=[])
        self.assertEqual(done.returncode, exit, f"{words}: {done.stdout}{done.stderr}")
        return done

    def enclave_b_is_closed(self, closed):
        (self.at / "ks/enclaves/d/permissions.p7s").write_bytes((self.at / "ks/enclaves/a/permissions.p7s").read_bytes())
        for words, exit in ((("list", "ks"), 3), (("verify", "ks"), 3), (("import", "ks"), 3),
                            (("rotate", "ks", "--role", "identity"), 3)):
            done = self.administrator(*words, exit=exit)
            self.assertIn("error[keystore_unseen]", done.stderr)
            self.assertIn("  --> ks/enclaves/b/x\n", done.stderr)
            if words[0] in ("list", "verify"):
                self.assertEqual([line.split()[0] for line in done.stdout.splitlines()], list(NAMES))
            if words[0] == "verify":
                self.assertIn("DOC", done.stderr, "what is wrong with /d is missing")
        self.assertTrue(all(self.issued_by_current_ca(name) for name in NAMES))
        closed.rmdir()
        self.administrator("list", "ks", exit=0)


if __name__ == "__main__":
    main()

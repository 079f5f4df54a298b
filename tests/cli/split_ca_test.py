#!/usr/bin/env python3
"""keystore split-ca is complete when it is repeated: after a folder that took no files, and after a kill in between."""

import os
import shutil
import subprocess
import unittest

from sros2_keystore import ENCLAVES, make_keystore
from transcript import NOW, PROGRAM, Transcript, library_path, main

ADMINISTRATOR, OTHER = 1500, 1501
LIBRARY = PROGRAM.parent.parent / "lib/kill_at.so"
TALKER = "ks/enclaves/talker_listener/talker"
SPLIT = ("keystore", "split-ca", "ks")


class Keystore(Transcript):
    """A keystore of sros2, whose documents no log has."""

    def setUp(self):
        super().setUp()
        make_keystore(self.at / "ks")
        self.run_program("keystore", "import", "ks", *NOW)

    def of_present_ca(self):
        """The enclaves whose permissions the permissions CA of today signed."""
        done = {name: subprocess.run([PROGRAM, "permissions", "verify", f"ks/enclaves/{name}", "--ca", "ks", *NOW],
                                     cwd=self.at, capture_output=True, check=False).returncode for name in ENCLAVES}
        return {name for name, code in done.items() if code == 0}

    def complete(self):
        self.json("keystore", "verify", "ks", *NOW)
        self.assertEqual(self.of_present_ca(), set(ENCLAVES))
        self.assertIn("has two CAs already", self.run_program(*SPLIT, *NOW).stdout)


class SplitCa(Keystore):
    def test_a_file_in_the_way_is_named_and_the_enclave_follows_later(self):
        path = self.at / TALKER / "permissions_ca.cert.pem"
        path.unlink()
        path.mkdir()
        out = self.json(*SPLIT, "--unlogged", *NOW, exit=4)
        self.assertEqual(len(out["result"]["enclaves"]), 2)
        key = (self.at / "ks/private/permissions_ca.key.pem").read_bytes()
        self.json(*SPLIT, "--unlogged", *NOW, exit=4)  # in the way still
        self.assertNotIn("talker_listener/talker", self.of_present_ca())
        path.rmdir()
        path.symlink_to("../../../public/permissions_ca.cert.pem")
        told = self.refused("document_unlogged", 1, *SPLIT, *NOW)  # as the first time, the log lacks it
        self.assertIn(f"{TALKER}/permissions.p7s", told["file"])
        out = self.json(*SPLIT, "--unlogged", *NOW)["result"]
        self.assertEqual((out["enclaves"], out["unlogged"]),
                         (["/talker_listener/talker"], [f"{TALKER}/permissions.p7s"]))
        self.assertEqual((self.at / "ks/private/permissions_ca.key.pem").read_bytes(), key)  # no third CA
        self.complete()

    def test_documents_of_a_stranger_are_not_signed(self):
        self.json(*SPLIT, "--unlogged", *NOW)
        (self.at / "other").mkdir()
        make_keystore(self.at / "other/ks")
        self.run_program("keystore", "create", "other/new", "--no-passphrase", *NOW)
        self.run_program("keystore", "enclave", "other/new", "/talker", "--allow-all", *NOW)
        shutil.copy(self.at / "other/new/enclaves/talker/permissions.p7s", self.at / TALKER)
        self.refused("smime_signer_not_permissions_ca", 1, *SPLIT, "--unlogged", *NOW)


@unittest.skipUnless(os.geteuid() == 0, "only root can act as two users")
class Blocked(Keystore):
    """The talker's folder is another user's."""

    def setUp(self):
        super().setUp()
        self.at.chmod(0o755)
        for path in (self.at / "ks", *(self.at / "ks").rglob("*")):
            os.chown(path, ADMINISTRATOR, ADMINISTRATOR, follow_symlinks=False)
        for path in (self.at / TALKER, *(self.at / TALKER).iterdir()):
            os.chown(path, OTHER, ADMINISTRATOR, follow_symlinks=False)
        shutil.copy(PROGRAM, self.at / "program")
        self.close()

    def close(self):
        (self.at / TALKER).chmod(0o755)

    def open_again(self):
        (self.at / TALKER).chmod(0o2775)

    def split(self, *exits, **environment):
        done = subprocess.run([self.at / "program", *SPLIT, "--unlogged", *NOW], cwd=self.at, capture_output=True,
                              text=True, check=False, timeout=60, stdin=subprocess.DEVNULL, user=ADMINISTRATOR,
                              group=ADMINISTRATOR, extra_groups=[],
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), **environment})
        self.assertIn(done.returncode, exits, f"{environment}: {done.stdout}{done.stderr}")
        return done

    def test_a_folder_that_could_not_be_written_follows_later(self):
        for mode in (0o755, 0o3775):  # takes no draft; takes drafts, of which none can be put in place
            with self.subTest(oct(mode)):
                (self.at / TALKER).chmod(mode)
                self.assertIn(f"{TALKER}/", self.split(5).stderr)
                self.assertNotIn("talker_listener/talker", self.of_present_ca())
                self.open_again()
                self.split(0)
                self.complete()
                shutil.rmtree(self.at / "ks")
                self.setUp()

    def test_it_may_be_killed_in_between_too(self):
        shutil.copy(LIBRARY, self.at / "kill.so")
        before = self.at.parent / (self.at.name + "-before")
        shutil.copytree(self.at, before, symlinks=True)
        self.addCleanup(shutil.rmtree, before)
        owners = {p.relative_to(self.at): p.lstat() for p in self.at.rglob("*")}
        number, killed = 0, True
        while killed:
            number += 1
            killed = self.killed_once(number)
            shutil.rmtree(self.at / "ks")
            shutil.copytree(before / "ks", self.at / "ks", symlinks=True)
            for path, status in owners.items():
                if path.parts[0] == "ks":
                    os.chown(self.at / path, status.st_uid, status.st_gid, follow_symlinks=False)
        self.assertGreater(number, 10)

    def killed_once(self, number):
        done = self.split(5, -9, LD_PRELOAD=str(self.at / "kill.so"), KILL_AT=str(number))
        self.split(0, 5)  # the folder is closed still
        self.open_again()
        self.split(0)
        self.assertEqual(self.of_present_ca(), set(ENCLAVES), f"killed at {number}, then repeated")
        self.json("keystore", "verify", "ks", *NOW)
        return done.returncode == -9


if __name__ == "__main__":
    main()

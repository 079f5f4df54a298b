#!/usr/bin/env python3
"""A new folder is made in a folder of another user, who exchanges the unfinished one at any moment."""

import os
import shutil
import subprocess

from transcript import NOW, PROGRAM, Transcript, library_path, main

LIBRARY = PROGRAM.parent.parent / "lib/kill_at.so"
# Moves the unfinished folder away and puts $1 in its place.
EXCHANGE = """#!/bin/sh
touch ran
for one in home/.*.*.??????; do
  if [ -d "$one" ] && [ ! -L "$one" ]; then
    mv "$one" home/moved && cp -a "$1" "$one" && touch exchanged
  fi
done
exit 0
"""


class ExchangedFolders(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)
        (self.at / "exchange.sh").write_text(EXCHANGE)
        os.chmod(self.at / "exchange.sh", 0o755)

    def prepare(self):
        for name in ("home", "victim", "ran", "exchanged"):
            path = self.at / name
            shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)
        (self.at / "home").mkdir()
        (self.at / "victim").mkdir()
        (self.at / "home/link").symlink_to("../victim")
        (self.at / "home/full").mkdir()
        (self.at / "home/full/key.pem.old").write_text("another folder")

    def run_with(self, number, replacement, words):
        return subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, capture_output=True, timeout=60, check=False, text=True,
                              stdin=subprocess.DEVNULL,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(LIBRARY),
                                   "CALL": str(number), "AT_CALL": f"./exchange.sh home/{replacement}"})

    def check(self, done, told):
        self.assertEqual(list((self.at / "victim").iterdir()), [], f"{told} wrote through the link")
        self.assertEqual([p.name for p in (self.at / "home/full").iterdir()], ["key.pem.old"], told)
        if not (self.at / "exchanged").exists():
            self.assertEqual(done.returncode, 0, told)
            return
        self.assertEqual(done.returncode, 5, told)
        self.assertIn("error[file_unwritable]", done.stderr, told)
        self.assertIn("another user or program exchanged the unfinished folder", done.stderr, told)
        left = [p for p in (self.at / "home/moved").rglob("*") if p.is_file()]
        self.assertEqual(left, [], f"{told}: keys are left in the folder that was moved away")

    def everywhere(self, *words):
        number, exchanged = 0, 0
        ca = self.at / "demo"
        shutil.copytree(ca, self.at / "kept", symlinks=True)
        for replacement in ("link", "full"):
            number = 0
            while True:
                number += 1
                self.prepare()
                shutil.rmtree(ca)
                shutil.copytree(self.at / "kept", ca, symlinks=True)
                done = self.run_with(number, replacement, words)
                self.check(done, f"{words} at {number}, {replacement}: {done.stdout}{done.stderr}")
                exchanged += (self.at / "exchanged").exists()
                if not (self.at / "ran").exists():
                    break
        shutil.rmtree(self.at / "kept")
        shutil.rmtree(self.at / "home")
        self.assertGreater(exchanged, 10, words)

    def test_identity_exchanged_nothing_is_written_elsewhere(self):
        self.everywhere("identity", "issue", "new", "--ca", "demo", "-o", "home/new", "--publish", "x", "--governance",
                        "demo/governance.p7s")

    def test_ca_exchanged_nothing_is_written_elsewhere(self):
        self.everywhere("ca", "create", "home/ca", "--no-passphrase")

    def test_keystore_exchanged_nothing_is_written_elsewhere(self):
        self.everywhere("keystore", "create", "home/ks", "--no-passphrase")


if __name__ == "__main__":
    main()

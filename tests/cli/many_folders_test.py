#!/usr/bin/env python3
"""Commands that work on many participants: what they cost, and that they say how far they are."""

import base64
import os
import pty
import re
import resource
import subprocess

from transcript import NOW, PROGRAM, Transcript, library_path, main

SLOWNESS = 10 if "asan" in str(PROGRAM) else 1
FOLDERS = 100


class ManyFolders(Transcript):
    def issue(self, count):
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        (self.at / "fleet.toml").write_text(
            "".join(f'[[participant]]\nname = "p{i}"\npublish = ["rt/p{i}"]\n' for i in range(count)))
        self.run_program("identity", "issue", "--from", "fleet.toml", "--ca", "ca", "-o", "out", *NOW)
        self.folders = sorted((self.at / "out").iterdir())

    def list_all(self):
        """The lists of the CAs have an entry of each participant, as after a renewal of all."""
        def block(path):
            text = base64.encodebytes(path.read_bytes()).decode()
            return f"-----BEGIN SIGNED PERMISSIONS-----\n{text}-----END SIGNED PERMISSIONS-----\n"
        (self.at / "ca/identity/renewed.pem").write_text(
            "".join((folder / "cert.pem").read_text() for folder in self.folders))
        (self.at / "ca/permissions/renewed.pem").write_text(
            "".join(block(folder / "permissions.p7s") for folder in self.folders))

    def seconds(self, *words):
        """Of a processor."""
        def spent():
            usage = resource.getrusage(resource.RUSAGE_CHILDREN)
            return usage.ru_utime + usage.ru_stime
        before = spent()
        self.run_program(*words, *NOW)
        return spent() - before

    def entries(self):
        texts = [(folder / "renewed.pem").read_text() for folder in self.folders]
        return {(text.count("BEGIN CERTIFICATE"), text.count("BEGIN SIGNED PERMISSIONS")) for text in texts}

    def test_distribute_verifies_each_entry_once(self):
        self.issue(FOLDERS)
        self.list_all()
        for former in ("none", "the same"):
            taken = self.seconds("crl", "distribute", "--ca", "ca")
            self.assertLess(taken, 5 * SLOWNESS, f"lists before: {former}")
            self.assertEqual(self.entries(), {(FOLDERS, FOLDERS)})

    def test_agent_with_more_folders_than_open_files_keeps_all(self):
        self.issue(40)
        done = subprocess.run([PROGRAM, "agent", *map(str, self.folders), "--ca", "ca", "--once", *NOW], cwd=self.at, text=True,
                              capture_output=True, timeout=120, check=False, stdin=subprocess.DEVNULL,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path()},
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (64, resource.getrlimit(resource.RLIMIT_NOFILE)[1])))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(done.stdout.count('"event":"current"'), 40)

    def test_folders_with_other_lists_are_judged_each_by_its_own(self):
        self.issue(4)
        self.list_all()
        certificate = (self.folders[1] / "cert.pem").read_text()
        (self.folders[0] / "renewed.pem").write_text(certificate)
        self.run_program("ca", "create", "other", "--no-passphrase", *NOW)
        self.run_program("identity", "issue", "x", "--ca", "other", "-o", "x", *NOW)
        (self.folders[2] / "renewed.pem").write_text((self.at / "x/cert.pem").read_text())
        (self.folders[3] / "identity_ca.pem").write_text((self.at / "other/identity/ca.pem").read_text())
        (self.folders[3] / "renewed.pem").write_text((self.at / "x/cert.pem").read_text())
        self.run_program("crl", "distribute", "--ca", "ca", *NOW, exit=(0, 1, 3))
        lists = [(folder / "renewed.pem").read_text() for folder in self.folders]
        self.assertEqual([text.count("BEGIN CERTIFICATE") for text in lists[:3]], [4, 4, 4])
        self.assertNotIn((self.at / "x/cert.pem").read_text(), lists[2])
        self.assertIn((self.at / "x/cert.pem").read_text(), lists[3])
        self.assertNotIn(certificate, lists[3])

    # ---- progress

    def said(self, *words, terminal=False):
        """What the command writes to standard error, which is a terminal or a pipe. Its clock is slow: each step takes
        a second."""
        library = PROGRAM.parent.parent / "lib/slow_steps.so"
        environment = {**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(library)}
        end, own = pty.openpty() if terminal else os.pipe()
        with subprocess.Popen([PROGRAM, *words, *NOW], cwd=self.at, env=environment, stdout=subprocess.DEVNULL,
                              stderr=own) as command:
            os.close(own)
            text = b""
            while True:
                try:
                    octets = os.read(end, 65536)
                except OSError:  # the terminal's other end is closed
                    break
                if not octets:
                    break
                text += octets
        os.close(end)
        self.assertIn(command.returncode, (0, 1), text)
        return text.decode()

    def expect_progress(self, *words, of):
        self.assertRegex(self.said(*words), rf"(?m)^\d+ of {of}$")
        self.assertRegex(self.said(*words, terminal=True), rf"\r\d+ of {of}.*\r\x1b\[K".replace(".*", "[^\n]*"))
        self.assertIsNone(re.search(r"\d+ of ", self.said(*words, "-q")))

    def test_long_work_says_how_far_it_is(self):
        self.issue(6)
        self.list_all()
        self.expect_progress("crl", "distribute", "--ca", "ca", of="6 revocation lists")
        self.expect_progress("crl", "distribute", "--ca", "ca", of="6 renewal lists")
        self.expect_progress("ca", "rotate", "ca", "--role", "identity", "--overlap", "30d", "--dry-run",
                             of="6 participants")
        self.expect_progress("ca", "rotate", "ca", "--role", "identity", "--overlap", "30d", "--dry-run",
                             of="12 steps of the forecast")
        self.expect_progress("ca", "rotate", "ca", "--role", "permissions", "--overlap", "30d", "--dry-run",
                             of="6 participants")
        self.expect_progress("expiry", "out", of=r"\d+ files")


if __name__ == "__main__":
    main()

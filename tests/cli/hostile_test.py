#!/usr/bin/env python3
"""Whatever a file holds: an error with a hint, its exit code, and nothing written."""

import os
import shutil
import signal
import subprocess
import time

from transcript import DATA, NOW, PROGRAM, Transcript, main

HEAD = b'<?xml version="1.0" encoding="UTF-8"?>\n'
HUGE = 100 * 1024 * 1024
POLICY = DATA / "sros2/upstream/policies/talker_listener.policy.xml"

# What no command can read, whatever it expects.
CONTENTS = {
    "empty": b"",
    "nul": b"\0" * 4096,
    "noise": bytes(range(256)) * 64,
    "doctype": HEAD + b'<!DOCTYPE dds [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><dds>&b;</dds>',
    "entity": HEAD + b"<!DOCTYPE x SYSTEM 'file:///etc/passwd'><dds/>",
    "deep": HEAD + b"<a>" * 100_000,
    "html": b"<html><body>not found</body></html>",
    "pem-cut": b"-----BEGIN CERTIFICATE-----\nMIIB",
    "pem-empty": b"-----BEGIN CERTIFICATE-----\n-----END CERTIFICATE-----\n",
    "mime-cut": b"MIME-Version: 1.0\r\nContent-Type: multipart/signed; boundary=\"x\"\r\n\r\n--x\r\n",
    "toml-deep": b"participant = " + b"[" * 100_000,
    "json": b'{"participant": [{"name": "a"}]}',
}

SECRET = "hunter2"
SECRETS = [text.replace("S", SECRET) for text in (
    "S\n", "root:$6$S:1:2:3\n", "A: b\nS\n", "A: S\x01\n", "token=S\n", "S==\n", "key = 'S", "x = S\n", "{\"a\": S}\n",
    "<a b=S>\n", "<a>&S;</a>\n", "<a/>S\n", "<?S?><a/>\n", "<!S>\n", "<?xml version='1.0' encoding='S S'?><a/>\n",
    "<a b='x'S/>\n", "Content-Type: S\n\n", "Content-Type: multipart/signed; protocol=S; boundary=x\n\n",
    "Content-Type: multipart/signed; S\n\n", "-----BEGIN S-----\nS\n-----END S-----\n")]


class Hostile(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        self.run_program("governance", "new", "-o", "g.xml", "--sign", "--ca", "ca", *NOW)
        self.run_program("identity", "issue", "a", "--ca", "ca", "-o", "a", "--publish", "x", *NOW)
        self.run_program("keystore", "create", "ks", "--no-passphrase", *NOW)

    def readers(self, file):
        """Every way to make the program read a file."""
        trust = ("--ca", "ca/permissions/ca.pem")
        for group in ("governance", "permissions"):
            yield (group, "lint", file)
            yield (group, "show", file)
            yield (group, "diff", file, "g.xml")
            yield (group, "sign", file, "--ca", "ca", "-o", "out")
            yield (group, "verify", file, *trust)
            yield (group, "verify", "g.p7s", "--ca", file)
        yield ("permissions", "lint", "g.xml", "--cert", file)
        yield ("permissions", "from-ros-policy", file, "-o", "out")
        yield ("permissions", "new", "--cert", file, "-o", "out")
        yield ("identity", "issue", "--from", file, "--ca", "ca", "-o", "out")
        yield ("identity", "issue", "b", "--permissions", file, "--ca", "ca", "-o", "out")
        yield ("identity", "issue", "b", "--governance", file, "--ca", "ca", "-o", "out")
        yield ("identity", "sign-csr", file, "--ca", "ca", "--yes", "-o", "out")
        yield ("identity", "show", file)
        yield ("inspect", file)
        yield ("identity", "renew", file, "--ca", "ca")
        yield ("identity", "revoke", file, "--ca", "ca")
        yield ("ca", "import", "out", "--cert", file)
        yield ("ca", "import", "out", "--cert", "ca/identity/ca.pem", "--key", file, "--no-passphrase")
        yield ("crl", "show", file)
        yield ("crl", "verify", file, "--ca", "ca")
        yield ("keystore", "enclave", "ks", "/a", "--policy", file)
        yield ("keystore", "enclave", "ks", "/a", "--permissions", file)

    def refuse(self, words, why):
        before = self.files()
        done = subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, text=True, capture_output=True,
                              timeout=60, check=False, stdin=subprocess.DEVNULL)
        self.assertEqual(self.files(), before, f"{words} on {why}")
        self.assertIn(done.returncode, (1, 3), f"{words} on {why}: {done.stderr}")
        self.assertRegex(done.stderr, r"(?m)^error\[\w+\]: .*\n(  --> .*\n)?  hint: .+$", f"{words} on {why}")
        if done.returncode == 3 and "verify" not in words:
            self.assertIn(f"  --> {why}", done.stderr, f"{words} on {why}")

    def test_no_command_takes_them(self):
        for name, content in CONTENTS.items():
            (self.at / name).write_bytes(content)
            for words in self.readers(name):
                self.refuse(words, name)

    def test_what_is_another_kind_of_file_is_not_quoted(self):
        """A file in a participant's folder may be a link of its owner's to what only root may read."""
        for number, content in enumerate(SECRETS):
            name = f"secret-{number}"
            (self.at / name).write_text(content)
            for words in self.readers(name):
                self.check_silence(words, content)
        for file in ("identity_ca.pem", "cert.pem", "permissions_ca.pem", "governance.p7s", "permissions.p7s",
                     "crl.pem", "security.properties", "cyclonedds.xml"):
            kept = (self.at / "a" / file).read_bytes() if (self.at / "a" / file).exists() else None
            for number, content in enumerate(SECRETS):
                (self.at / "a" / file).unlink(missing_ok=True)
                (self.at / "a" / file).symlink_to(self.at / f"secret-{number}")
                self.check_silence(("doctor", "a"), content)
            (self.at / "a" / file).unlink()
            if kept is not None:
                (self.at / "a" / file).write_bytes(kept)

    def check_silence(self, words, content):
        done = subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, text=True, capture_output=True,
                              timeout=60, check=False, stdin=subprocess.DEVNULL)
        self.assertNotIn(SECRET, done.stdout + done.stderr, f"{words} on {content!r}")

    def test_nor_what_is_too_large_no_file_or_not_there(self):
        with open(self.at / "huge", "wb") as huge:
            huge.truncate(HUGE)
        (self.at / "dangling").symlink_to("nowhere")
        (self.at / "round").symlink_to("round")
        for name in ("huge", "dangling", "round", "/dev/zero"):
            for words in self.readers(name):
                self.refuse(words, name)

    def test_lists_of_topics(self):
        with open(self.at / "huge", "wb") as huge:
            huge.truncate(HUGE)
        (self.at / "empty").write_text("# nothing\n")
        self.refuse(("governance", "diff", "g.xml", "g.xml", "--topics", "huge"), "huge")
        self.refused("usage", 2, "governance", "diff", "g.xml", "g.xml", "--topics", "empty")
        self.refuse(("check", "a", "a", "--topics", "huge"), "huge")

    def test_nul_octets_and_paths_in_names(self):
        def fleet(line, code, exit=3):
            (self.at / "fleet.toml").write_text(f'[[participant]]\nname = "b"\n{line}\n')
            told = self.refused(code, exit, "identity", "issue", "--from", "fleet.toml", "--ca", "ca",
                                "-o", "out", *NOW)
            self.assertEqual(told["file"], "fleet.toml")
        for name in (r"a\u0000b", r"../a", r"a/b", r"/etc/a", r"..", r".", r"a\nb", r"\u202ea"):
            (self.at / "fleet.toml").write_text(f'[[participant]]\nname = "{name}"\n')
            told = self.refused("name_unusable", 2, "identity", "issue", "--from", "fleet.toml", "--ca", "ca",
                                "-o", "out", *NOW)
            self.assertIn('; subject = "CN=..." gives the certificate any other name', told["hint"])
        fleet(r'subject = "CN=a\u0000b"', "subject_name_malformed", 2)
        fleet(r'publish = ["a\u0000b"]', "xml_control_character")
        (self.at / "fleet.toml").write_text('[[participant]]\nname = "b"\npermissions = "a\\u0000b"\n')
        self.refused("file_unreadable", 3, "identity", "issue", "--from", "fleet.toml", "--ca", "ca",
                     "-o", "out", *NOW)
        text = POLICY.read_text()
        (self.at / "policy.xml").write_text(text.replace("chatter", "chat\0ter"))
        self.refused("xml_control_character", 3, "permissions", "from-ros-policy", "policy.xml", "-o", "out")

    def test_links_at_the_target_are_not_followed(self):
        (self.at / "mine").write_text("mine")
        (self.at / "folder").mkdir()
        for name, to in (("file-link", "mine"), ("folder-link", "folder"), ("dangling", "nowhere")):
            (self.at / name).symlink_to(to)
            for words in (("identity", "issue", "b", "--ca", "ca", "-o", name), ("init", name),
                          ("identity", "csr", "b", "-o", name), ("ca", "create", name, "--no-passphrase"),
                          ("keystore", "create", name, "--no-passphrase"),
                          ("governance", "new", "-o", name), ("governance", "sign", "g.xml", "--ca", "ca", "-o", name),
                          ("permissions", "new", "--cert", "a/cert.pem", "-o", name, "--publish", "x")):
                self.refused("would_overwrite", 4, *words, *NOW)
        for file, words in (("a/cert.pem", ("identity", "renew", "a", "--ca", "ca")),
                            ("ks/public/permissions_ca.cert.pem", ("ca", "renew", "ks", "--role", "permissions"))):
            elsewhere = self.at / "elsewhere" / file
            elsewhere.parent.mkdir(parents=True)
            content = (self.at / file).read_bytes()
            (self.at / file).rename(elsewhere)
            (self.at / file).symlink_to(elsewhere)
            self.refused("would_overwrite", 4, *words, *NOW)
            self.assertEqual(elsewhere.read_bytes(), content)

    def test_an_interrupted_change_of_many_files_changes_none(self):
        self.run_program("crl", "new", "--ca", "ca", *NOW)
        folders = [f"many/{i}" for i in range(2000)]
        for folder in folders:
            (self.at / folder).mkdir(parents=True)
            (self.at / folder / "crl.pem").write_text("old")
        running = subprocess.Popen([PROGRAM, "crl", "distribute", *folders, "--ca", "ca", *NOW], cwd=self.at,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while running.poll() is None and not list((self.at / "many/0").glob(f"crl.pem.{running.pid}.*.new")):
            pass
        running.send_signal(signal.SIGINT)
        out, said = running.communicate(timeout=60)
        self.assertEqual((running.returncode, out), (5, ""))
        self.assertIn("error[interrupted]", said)
        self.assertEqual({(self.at / folder / "crl.pem").read_text() for folder in folders}, {"old"})

    def test_what_a_killed_command_left_is_removed_and_nothing_else(self):
        gone = subprocess.Popen(["true"])
        gone.wait()
        here = os.stat("/proc/self/ns/pid").st_ino
        self.run_program("crl", "new", "--ca", "ca", *NOW)
        folder = self.at / "many"
        folder.mkdir()
        elsewhere = self.at / "elsewhere"
        elsewhere.mkdir()
        (elsewhere / "kept").write_text("kept")
        old = time.time() - 2 * 24 * 60 * 60

        def make(name, modified=None):
            (folder / name).write_text("a draft")
            if modified:
                os.utime(folder / name, (modified, modified))
            return name

        left = [make(f"crl.pem.{gone.pid}.{here}.new"), make(f"crl.pem.{gone.pid}.{here}.7.new"),
                make(f"crl.pem.{os.getpid()}.{here + 1}.new", old)]
        kept = [make(f"crl.pem.{os.getpid()}.{here}.new"),     # of a process that lives
                make(f"crl.pem.{gone.pid}.{here + 1}.new"),    # of another container, today
                make(f"cert.pem.{gone.pid}.{here}.new"),       # of another file: a list may name it
                make(f"crl.pem.{gone.pid}.new"), make("crl.pem.new"), make(f"crl.pem.{gone.pid}.{here}.x.new"),
                make(f"crl.pem.0.{here}.new"), f"crl.pem.{gone.pid}.{here}.8.new", f"crl.pem.{gone.pid}.{here}.9.new"]
        (folder / kept[-1]).symlink_to(elsewhere / "kept")
        (folder / kept[-2]).mkdir()
        self.run_program("crl", "distribute", "many", "--ca", "ca", *NOW)
        self.assertEqual({p.name for p in folder.iterdir()}, {*kept, "crl.pem"}, f"and not {left}")

        for name in (f".demo.{gone.pid}.{here}.abcDE1", f".demo.{os.getpid()}.{here}.abcDE2", ".demo.abcDE3",
                     f".demo.{gone.pid}.{here}.abcDE4.new"):
            (self.at / name / "ca").mkdir(parents=True)
            (self.at / name / "ca/key.pem").write_text("key")
            (self.at / name / "link").symlink_to(elsewhere)
        (self.at / f".demo.{gone.pid}.{here}.abcDE5").symlink_to(elsewhere)
        self.run_program("init", "demo", *NOW)
        self.assertEqual(sorted(p.name[-6:] for p in self.at.glob(".demo.*")),
                         ["E4.new", "abcDE2", "abcDE3", "abcDE5"])
        self.assertEqual((elsewhere / "kept").read_text(), "kept")
        for path in (*folder.iterdir(), *self.at.glob(".demo.*")):  # or tearDown takes them for this test's
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()


if __name__ == "__main__":
    main()

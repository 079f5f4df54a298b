#!/usr/bin/env python3
"""A command that is killed between any two of its writes leaves every file old or new, none half; the next run
finishes the work."""

import json
import os
import re
import shutil
import subprocess
import xml.etree.ElementTree

from sros2_keystore import make_keystore
from transcript import NOW, PROGRAM, Transcript, library_path, main

POLICY = """<policy version="0.2.0"><enclaves><enclave path="/e"><profiles><profile ns="/" node="a">
<topics publish="ALLOW"><topic>x</topic></topics></profile></profiles></enclave></enclaves></policy>
"""
LIBRARY = PROGRAM.parent.parent / "lib/kill_at.so"
STEP = int(os.environ.get("DDSSEC_KILL_STEP", "1"))  # 1: before each write; 3: before the first, the fourth and so on
DRAFT = re.compile(r"(^|/)\.[^/]+\.\w{6}(/|$)|(\.\d+){2,3}\.new$|\.ddssec-unfinished$")


def is_whole(path, octets):
    if path.endswith(".xml"):
        xml.etree.ElementTree.fromstring(octets)
        return True
    if path.endswith(".pem"):
        text = octets.decode()
        return text.endswith("-----\n") and text.count("-----BEGIN ") == text.count("-----END ") > 0
    if path.endswith(".p7s"):
        boundary = re.search(rb'boundary="([^"]+)"', octets).group(1)
        return octets.rstrip().endswith(b"--" + boundary + b"--")
    if path.endswith(".json"):
        json.loads(octets)
        return True
    if path.endswith(".jsonl"):  # a line that is cut short is told by the missing end and passed over
        for line in octets.decode().split("\n")[:-1]:
            json.loads(line)
        return True
    raise AssertionError(f"what is {path}?")


class Interrupted(Transcript):
    first = 0

    def setUp(self):
        super().setUp()
        self.top = self.at
        self.at = self.top / "base"
        self.at.mkdir()

    def octets(self):
        files = {str(p.relative_to(self.at)): p for p in self.at.rglob("*") if p.is_file()}
        return {name: p.read_bytes() for name, p in files.items() if not DRAFT.search(name)}

    def run_until(self, number, words):
        """Killed before that call; 0: not at all."""
        return subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, capture_output=True, timeout=60, check=False,
                              stdin=subprocess.DEVNULL, text=True,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(LIBRARY),
                                   "KILL_AT": str(number)})

    def kill_at(self, number, words):
        done = self.run_until(number, words)
        self.assertIn(done.returncode, (0, -9), f"{words} at {number}: {done.stderr}")
        return done.returncode != 0

    def everywhere(self, *words, after, again=None, refused=(), removes=()):
        """`after`: commands that find all well when the command was run again (`again`: with these words). `refused`:
        exit codes of that run besides 0. `removes`: files that the command removes."""
        base, number = self.top / "before", 1 + self.first % STEP
        self.first += 1  # so that commands of the same writes are killed at different ones
        self.at.rename(base)
        try:
            while True:
                shutil.copytree(base, self.at, symlinks=True)  # to the same place, since the logs have paths
                before = self.octets()
                killed = self.kill_at(number, words)
                left = self.octets()
                self.assertLessEqual(before.keys() - set(removes), left.keys(), f"{words} at {number}: a file is lost")
                for name, octets in left.items():
                    if before.get(name) != octets:
                        self.assertTrue(is_whole(name, octets), f"{words} at {number}: {name} is cut short")
                if killed:
                    done = self.run_until(0, again or words)
                    self.assertIn(done.returncode, (0, *refused), f"{words} at {number}, then again: {done.stderr}")
                    if done.returncode == 0 and again is None:  # else it may write other files
                        rest = [str(p.relative_to(self.at)) for p in self.at.rglob("*")]
                        self.assertEqual([name for name in rest if DRAFT.search(name)], [],
                                         f"{words} at {number}, then again: drafts are left")
                for command in after:
                    done = self.run_until(0, command)
                    self.assertEqual(done.returncode, 0, f"{words} at {number}, then {command}: {done.stdout}{done.stderr}")
                shutil.rmtree(self.at)
                if not killed:
                    break
                number += STEP
        finally:
            shutil.rmtree(self.at, ignore_errors=True)
            base.rename(self.at)
        self.assertGreater(number, 3, words)

    def test_what_makes_folders(self):
        self.everywhere("init", "demo", after=[("doctor", "demo/talker"), ("doctor", "demo/listener")], refused=(4,))
        self.everywhere("ca", "create", "ca", "--no-passphrase", after=[("ca", "show", "ca")], refused=(4,))
        self.everywhere("keystore", "create", "ks", "--no-passphrase", after=[("ca", "show", "ks")], refused=(4,))

    def test_what_adds_to_a_ca(self):
        self.run_program("init", "demo", *NOW)
        self.everywhere("identity", "issue", "b", "--ca", "demo", "-o", "demo/b", "--publish", "x", "--governance",
                        "demo/governance.p7s", after=[("doctor", "demo/b"), ("ca", "show", "demo")], refused=(4,))
        self.everywhere("identity", "revoke", "demo/talker", "--ca", "demo", refused=(1,),
                        after=[("crl", "distribute", "--ca", "demo"), ("crl", "verify", "demo/listener", "--ca", "demo")])
        self.everywhere("crl", "new", "--ca", "demo", after=[("crl", "verify", "demo", "--ca", "demo")])
        self.everywhere("crl", "distribute", "--ca", "demo", after=[("doctor", "demo/talker")])

    def test_what_changes_a_participant(self):
        self.run_program("init", "demo", *NOW)
        well = [("doctor", "demo/talker"), ("check", "demo/talker", "demo/listener")]
        self.everywhere("identity", "issue", "talker", "--ca", "demo", "-o", "demo/talker", "--replace", "--publish", "*",
                        "--subscribe", "*", after=well)
        self.everywhere("identity", "renew", "demo/talker", "--ca", "demo", "--permissions", after=well)
        self.everywhere("identity", "renew", "demo/talker", "--ca", "demo", "--rekey", after=well)
        self.everywhere("identity", "renew", "demo/talker", "--ca", "demo", "--rekey", after=well,
                        again=("identity", "renew", "demo/talker", "--ca", "demo"))  # of the key that is there
        (self.at / "demo/talker/permissions.p7s").unlink()
        (self.at / "demo/talker/crl.pem").unlink()
        self.everywhere("identity", "issue", "talker", "--ca", "demo", "-o", "demo/talker", "--publish", "*", "--subscribe",
                        "*", after=well, refused=(4,))

    def test_what_writes_documents(self):
        self.run_program("init", "demo", *NOW)
        new = ("governance", "new", "-o", "g.xml", "--sign", "--ca", "demo")
        verify = ("governance", "verify", "g.p7s", "--ca", "demo")
        self.everywhere(*new, after=[verify], again=(*new, "--replace"))
        self.run_program(*new, *NOW)
        self.everywhere(*new, "--profile", "open", "--replace", after=[verify])

    def test_what_replaces_a_ca_step_by_step(self):
        self.run_program("init", "demo", *NOW)
        well = [("ca", "show", "demo"), ("check", "demo/talker", "demo/listener")]
        for role in ("identity", "permissions"):
            rotate = ("ca", "rotate", "demo", "--role", role)
            steps = [(*rotate, *words) for words in (("--overlap", "30d"), ("--move",), ("--end",))]
            for number, step in enumerate(steps):  # refused: it was complete already
                self.everywhere(*step, after=[*well, *steps[number + 1:], *well], refused=(1,),
                                removes=(f"demo/ca/{role}/ca.overlap.json",))
                self.run_program(*step, *NOW)

    def test_what_writes_files_of_other_kinds(self):
        (self.at / "policy.xml").write_text(POLICY)
        self.everywhere("permissions", "from-ros-policy", "policy.xml", "-o", "p.xml", after=[("permissions", "lint", "p.xml")],
                        refused=(4,))

    def test_what_signs_what_is_there(self):
        self.run_program("init", "demo", *NOW)
        (self.at / "demo/governance.p7s").unlink()
        sign = ("governance", "sign", "demo/governance.xml", "--ca", "demo", "-o", "demo/governance.p7s")
        self.everywhere(*sign, after=[("governance", "verify", "demo/governance.p7s", "--ca", "demo")], again=(*sign, "--replace"))
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "-o", "p.xml", *NOW)
        sign = ("permissions", "sign", "p.xml", "--ca", "demo", "-o", "demo/talker/permissions.p7s")
        self.everywhere(*sign, "--replace", after=[("doctor", "demo/talker"), ("check", "demo/talker", "demo/listener")])

    def test_what_renews_a_ca_and_takes_one_over(self):
        self.run_program("init", "demo", *NOW)
        self.everywhere("ca", "renew", "demo", after=[("ca", "show", "demo"), ("check", "demo/talker", "demo/listener")])
        self.run_program("ca", "create", "plant", "--role", "identity", "--intermediate-of", "demo/ca/identity",
                         "--no-passphrase", "--days", "300", *NOW)
        self.everywhere("ca", "renew", "plant", "--issuer", "demo/ca/identity", "--days", "400",
                        after=[("ca", "show", "plant"), ("ca", "show", "demo")])
        for role in ("identity", "permissions"):
            take = ("ca", "import", "ca", "--role", role, "--cert", f"demo/ca/{role}/ca.pem", "--key",
                    f"demo/ca/{role}/ca.key.pem", "--no-passphrase")
            self.everywhere(*take, after=[("ca", "show", "ca", "--role", role)], refused=(4,))
            self.run_program(*take, *NOW)

    def test_what_issues_on_request_and_from_a_file(self):
        self.run_program("init", "demo", *NOW)
        sign = ("identity", "sign-csr", "r", "--ca", "demo", "--yes")
        self.everywhere("identity", "csr", "r", "-o", "r", after=[(*sign, "--dry-run")], refused=(4,))
        self.run_program("identity", "csr", "r", "-o", "r", *NOW)
        self.everywhere(*sign, after=[("identity", "show", "r/cert.pem"), ("ca", "show", "demo")], refused=(4,))
        (self.at / "fleet.toml").write_text('publish = ["x"]\n[[participant]]\nname = "b"\n[[participant]]\nname = "c"\n')
        self.everywhere("identity", "issue", "--from", "fleet.toml", "--ca", "demo", "-o", "out", "--governance",
                        "demo/governance.p7s", after=[("doctor", "out/b"), ("check", "out/b", "demo/talker")], refused=(4,))

    def test_what_writes_permissions(self):
        self.run_program("init", "demo", *NOW)
        new = ("permissions", "new", "--cert", "demo/talker", "--publish", "x", "-o", "p.xml")
        verify = ("permissions", "verify", "p.p7s", "--ca", "demo")
        self.everywhere(*new, after=[("permissions", "lint", "p.xml")], refused=(4,))
        self.everywhere(*new, "--sign", "--ca", "demo", after=[verify],
                        again=(*new, "--sign", "--ca", "demo", "--replace"))
        self.run_program(*new, *NOW)
        self.everywhere("permissions", "sign", "p.xml", "--ca", "demo", after=[verify], refused=(4,))

    def interrupt_at(self, number, *words):
        """A signal comes just before that call."""
        return subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, capture_output=True, timeout=60, check=False, text=True,
                              stdin=subprocess.DEVNULL,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(LIBRARY),
                                   "AT_CALL": "kill -TERM $PPID", "CALL": str(number)})

    def test_an_interrupted_distribution_says_what_it_has_written(self):
        self.run_program("init", "demo", "--participant", "a", "--participant", "b", "--participant", "c", *NOW)
        self.run_program("identity", "renew", "demo/a", "--ca", "demo", *NOW)
        before, number, said = self.octets(), 0, set()
        base = self.top / "before"
        shutil.copytree(self.at, base, symlinks=True)
        while True:
            number += 1
            done = self.interrupt_at(number, "crl", "distribute", "--ca", "demo")
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, 5, done.stderr)
            changed = {name for name, octets in self.octets().items() if before.get(name) != octets}
            renewed = len({name for name in changed if name.endswith("/renewed.pem")})
            if "nothing was written" in done.stderr:
                self.assertEqual(changed, set(), f"at {number}: {done.stderr}")
            else:
                self.assertIn("error[interrupted_between_files]", done.stderr)
                self.assertIn(f"is in 3 folders, the renewal list in {renewed} of them", done.stderr)
                said.add(renewed)
            shutil.rmtree(self.at)
            shutil.copytree(base, self.at, symlinks=True)
        self.assertGreaterEqual(said, {1, 2}, "it was not interrupted between two lists")

    def test_a_disk_that_is_full_leaves_each_file_old_or_new(self):
        self.run_program("init", "demo", *NOW)
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "-o", "p.xml", *NOW)
        for words in (("identity", "renew", "demo/talker", "--ca", "demo", "--permissions"),
                      ("identity", "renew", "demo/talker", "--ca", "demo", "--rekey"),
                      ("permissions", "sign", "p.xml", "--ca", "demo", "-o", "demo/talker/permissions.p7s", "--replace"),
                      ("crl", "new", "--ca", "demo"), ("crl", "distribute", "--ca", "demo")):
            with self.subTest(words=words):
                self.full_everywhere(*words)

    def full_everywhere(self, *words):
        """The disk is full from some write on. When it has room, the command succeeds."""
        base, writes = self.top / "full", 0
        shutil.copytree(self.at, base, symlinks=True)
        while True:
            writes += 1
            before = self.octets()
            done = subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, capture_output=True, timeout=60, check=False, text=True,
                                  stdin=subprocess.DEVNULL,
                                  env={**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(LIBRARY),
                                       "FULL_AT": str(writes)})
            if done.returncode == 0:
                break
            self.assertRegex(done.stderr, r"error\[file_unwritable\]", f"{words}, full at {writes}")
            for name, octets in self.octets().items():
                if before.get(name) != octets:
                    self.assertTrue(is_whole(name, octets), f"{words}, full at {writes}: {name} is cut short")
            self.assertLessEqual(before.keys(), self.octets().keys())
            again = self.run_until(0, words)
            self.assertEqual(again.returncode, 0, f"{words}, full at {writes}, then again: {again.stderr}")
            self.assertEqual(self.run_until(0, ("doctor", "demo/talker")).returncode, 0)
            shutil.rmtree(self.at)
            shutil.copytree(base, self.at, symlinks=True)
        self.assertGreater(writes, 1, words)
        shutil.rmtree(base)

    def test_what_changes_a_keystore(self):
        self.run_program("init", "ks", "--layout", "sros2", *NOW)
        self.everywhere("keystore", "permission", "ks", "/talker", "--publish", "r*", "--subscribe", "r*",
                        after=[("keystore", "verify", "ks")])
        self.everywhere("keystore", "enclave", "ks", "/talker", "--replace", after=[("keystore", "verify", "ks")])

    def test_what_takes_over_a_keystore_of_sros2(self):
        make_keystore(self.at / "ks")
        self.everywhere("keystore", "import", "ks", after=[("keystore", "verify", "ks"), ("ca", "show", "ks")])
        self.run_program("keystore", "import", "ks", *NOW)
        self.everywhere("keystore", "split-ca", "ks", "--unlogged", after=[("keystore", "verify", "ks")])

    def test_what_replaces_a_ca(self):
        self.run_program("init", "demo", *NOW)
        well = [("check", "demo/talker", "demo/listener")]
        for role in ("identity", "permissions"):
            self.everywhere("ca", "rotate", "demo", "--role", role, after=well)
        self.run_program("init", "ks", "--layout", "sros2", *NOW)
        self.everywhere("keystore", "enclave", "ks", "/b", "--allow-all", after=[("keystore", "verify", "ks")], refused=(4,))
        self.everywhere("keystore", "rotate", "ks", "--role", "permissions", after=[("keystore", "verify", "ks")])


if __name__ == "__main__":
    main()

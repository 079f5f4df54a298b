#!/usr/bin/env python3
"""A participant's folder is another user's, who changes it while a command of root's reads and writes it."""

import ctypes
import fcntl
import os
import pathlib
import shutil
import struct
import subprocess
import threading
import time
import unittest

from transcript import NOW, PROGRAM, Transcript, main

OTHER = 65534
CLOSED_UNWRITTEN, MODE_CHANGED = 0x10, 0x4
NEEDS_ROOT = unittest.skipUnless(os.geteuid() == 0, "only root can make files of another user")


class Exchange(threading.Thread):
    """Calls `then` as soon as a file was read (or its mode was changed) so many times, unless `end` was called before."""

    def __init__(self, file, then, event=CLOSED_UNWRITTEN, times=1):
        super().__init__(daemon=True)
        libc = ctypes.CDLL(None)
        self.events = libc.inotify_init()
        assert libc.inotify_add_watch(self.events, os.fsencode(file), event) >= 0
        self.then, self.times, self.is_done, self.is_over = then, times, False, False
        self.lock = threading.Lock()
        self.start()

    def run(self):
        seen = 0
        while seen < self.times:
            seen += len(os.read(self.events, 4096)) // struct.calcsize("iIII")
        with self.lock:
            if not self.is_over:
                self.then()
                self.is_done = True

    def end(self):
        with self.lock:
            self.is_over = True


class Exchanged(Transcript):
    """The folder becomes a link to another one after its certificate was read."""

    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)
        (self.at / "etc").mkdir()
        (self.at / "home").mkdir()
        for folder, topic in (("etc/controller", "a"), ("home/talker", "b")):
            self.run_program("identity", "issue", pathlib.Path(folder).name, "--ca", "demo", "-o", folder, "--publish",
                             topic, "--governance", "demo/governance.p7s", *NOW)

    def exchange(self):
        (self.at / "home/talker").rename(self.at / "home/moved")
        (self.at / "home/talker").symlink_to(self.at / "etc/controller")

    def restore(self):
        if (self.at / "home/moved").exists():
            (self.at / "home/talker").unlink()
            (self.at / "home/moved").rename(self.at / "home/talker")

    def contents(self):
        return {p.name: p.read_bytes() for p in (self.at / "etc/controller").iterdir()}

    def check_stays(self, *words, file="home/talker/cert.pem", rounds=4):
        before = self.contents()
        for times in range(1, rounds + 1):
            exchange = Exchange(self.at / file, self.exchange, times=times)
            done = subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, capture_output=True, text=True, timeout=60,
                                  check=False, stdin=subprocess.DEVNULL)
            self.assertEqual(self.contents(), before, f"{words}, exchanged after {times}: {done.stdout}{done.stderr}")
            if times == 1:
                exchange.join(timeout=10)
                self.assertTrue(exchange.is_done, words)
            exchange.end()  # its file may have been read too few times, and be read again by the next command
            self.restore()

    def test_no_renewal_writes_into_another_folder(self):
        self.check_stays("identity", "renew", "home/talker", "--ca", "demo", "--rekey")
        self.check_stays("identity", "renew", "home/talker", "--ca", "demo", "--permissions")

    def test_no_rotation_writes_into_another_folder(self):
        self.check_stays("ca", "rotate", "demo", "home/talker", "--role", "identity", rounds=2)
        self.check_stays("ca", "rotate", "demo", "home/talker", "--role", "permissions", rounds=1,
                         file="home/talker/permissions.p7s")

    def test_no_list_is_put_into_another_folder(self):
        self.run_program("ca", "create", "other", "--no-passphrase", *NOW)
        self.run_program("identity", "issue", "controller", "--ca", "other", "-o", "etc/controller", "--replace", *NOW)
        self.run_program("crl", "new", "--ca", "demo", *NOW)
        self.check_stays("crl", "distribute", "--ca", "demo")

    def test_nothing_is_issued_into_another_folder(self):
        self.check_stays("identity", "issue", "talker", "--ca", "demo", "-o", "home/talker", "--replace", "--publish", "c",
                         rounds=1)

    def test_a_link_in_place_of_the_folder_is_refused(self):
        self.exchange()
        before = self.contents()
        for words in (("identity", "renew", "home/talker", "--ca", "demo"),
                      ("ca", "rotate", "demo", "home/talker", "--role", "permissions")):
            told = self.refused("would_overwrite", 4, *words, *NOW)
            self.assertIn("it is a link", told["message"])
        told = self.json("crl", "distribute", "home/talker", "--ca", "demo", *NOW, exit=4)
        self.assertEqual([d["id"] for d in told["diagnostics"]], ["would_overwrite"])
        self.assertEqual(self.contents(), before)


class Locked(Transcript):
    """Locks that another process holds."""

    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)

    def hold(self, path):
        file = os.open(self.at / path, os.O_RDONLY)
        self.addCleanup(os.close, file)
        fcntl.flock(file, fcntl.LOCK_EX)

    def held(self, name, *words):
        begin = time.monotonic()
        told = self.refused("file_unwritable", 5, *words, *NOW)
        self.assertIn(f"process {os.getpid()} of user {os.geteuid()} has locked it for more than", told["message"])
        self.assertTrue(told["file"].endswith(name), told)
        return time.monotonic() - begin

    @NEEDS_ROOT
    def test_what_another_user_locks_in_its_own_folder_is_not_waited_for(self):
        list_ = self.at / "demo/talker/.ddssec-unfinished"
        list_.write_text("")
        for path in (list_, self.at / "demo/talker"):
            os.chown(path, OTHER, OTHER)
        self.hold(list_)
        begin = time.monotonic()
        self.refused("unfinished_untrusted", 4, "identity", "renew", "demo/talker", "--ca", "demo", *NOW)
        self.assertLess(time.monotonic() - begin, 5)
        list_.unlink()

    def test_the_wait_for_an_own_list_ends(self):
        list_ = self.at / "demo/talker/.ddssec-unfinished"
        list_.touch(0o600)
        self.hold(list_)
        self.assertGreater(self.held(list_.name, "identity", "renew", "demo/talker", "--ca", "demo"), 9)
        list_.unlink()

    def test_the_wait_for_a_ca_ends(self):
        self.hold("demo/ca/identity/ca.key.pem")
        self.assertGreater(self.held("ca.key.pem", "identity", "revoke", "demo/talker", "--ca", "demo"), 19)

    def test_what_others_can_open_holds_no_ca(self):
        for path in ("", "ca", "ca/identity"):
            (self.at / "demo" / path).chmod(0o755)
        for path in ("demo/ca/identity", "demo/ca/identity/ca.pem", "demo/ca/identity/crl.pem",
                     "demo/ca/identity/issued.jsonl", "demo/ca/permissions/signed.jsonl"):
            self.hold(path)
        begin = time.monotonic()
        self.run_program("identity", "renew", "demo/listener", "--ca", "demo", "--permissions", *NOW)
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)
        self.assertLess(time.monotonic() - begin, 10)


class Keys(Transcript):
    """keystore import makes keys readable by their owner only, and no other file."""

    def setUp(self):
        super().setUp()
        self.run_program("keystore", "create", "ks", "--no-passphrase", *NOW)
        for name in ("a", "z"):
            self.run_program("keystore", "enclave", "ks", f"/{name}", "--publish", "rt/x", *NOW)
        self.keys = [self.at / f"ks/enclaves/{name}/key.pem" for name in ("a", "z")]
        for key in self.keys:
            key.chmod(0o644)
        self.precious = self.at / "precious"
        self.precious.write_text("root's")
        self.precious.chmod(0o644)

    def exchange(self):
        link = self.keys[1].with_name("link")
        link.symlink_to(self.precious)
        link.rename(self.keys[1])

    def test_keys_are_closed(self):
        self.assertEqual(len(self.json("keystore", "import", "ks", *NOW)["result"]["keys_closed"]), 2)
        self.assertEqual({key.stat().st_mode & 0o777 for key in self.keys}, {0o600})

    def test_not_what_a_link_leads_to(self):
        Exchange(self.keys[0], self.exchange, MODE_CHANGED)
        subprocess.run([PROGRAM, "keystore", "import", "ks", *NOW], cwd=self.at, capture_output=True, timeout=60, check=False)
        self.assertEqual(self.precious.stat().st_mode & 0o777, 0o644)

    def test_nor_a_file_with_further_names(self):
        self.keys[0].chmod(0o600)
        self.keys[1].unlink()
        os.link(self.precious, self.keys[1])
        told = self.refused("file_unwritable", 5, "keystore", "import", "ks", *NOW)
        self.assertIn("further names", told["message"])
        self.assertEqual(self.precious.stat().st_mode & 0o777, 0o644)


@NEEDS_ROOT
class Owners(Transcript):
    """What root replaces in a folder of the user that runs the participant."""

    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)
        for path in (self.at / "demo/talker", *(self.at / "demo/talker").iterdir()):
            os.chown(path, OTHER, OTHER)

    def owners(self):
        stats = [p.stat() for p in (self.at / "demo/talker").iterdir()]
        return {(one.st_uid, one.st_gid) for one in stats}

    def doctor(self):
        return self.run_program("doctor", "demo/talker", *NOW, exit=None).stderr

    def test_files_stay_the_users(self):
        for words in (("identity", "renew", "demo/talker", "--ca", "demo", "--rekey", "--permissions"),
                      ("crl", "distribute", "--ca", "demo"), ("ca", "rotate", "demo", "--role", "identity"),
                      ("identity", "issue", "talker", "--ca", "demo", "-o", "demo/talker", "--replace", "--publish", "x")):
            self.run_program(*words, *NOW)
            self.assertEqual(self.owners(), {(OTHER, OTHER)}, words)
        self.assertEqual((self.at / "demo/talker/key.pem").stat().st_mode & 0o777, 0o600)
        self.assertNotIn("DOC003", self.doctor())

    def test_the_group_of_a_file_stays_when_its_owner_replaces_it(self):
        for path in (self.at, *self.at.rglob("*")):
            os.chown(path, OTHER, OTHER)
        shutil.copy(PROGRAM, self.at / "ddssec")
        certificate, group = self.at / "demo/talker/cert.pem", 12345
        os.chown(certificate, OTHER, group)
        subprocess.run([self.at / "ddssec", "identity", "renew", "demo/talker", "--ca", "demo", *NOW], cwd=self.at, check=True,
                       capture_output=True, timeout=60, user=OTHER, group=OTHER, extra_groups=[group])
        self.assertEqual((certificate.stat().st_uid, certificate.stat().st_gid), (OTHER, group))

    def test_doctor_names_a_key_that_the_folders_owner_cannot_read(self):
        os.chown(self.at / "demo/talker/key.pem", 0, 0)
        self.assertRegex(self.doctor(), f"DOC003.*key.pem belongs to user 0 with mode 0600, .* user {OTHER}, who cannot")


class Tokens(Transcript):
    """What a folder says of a token."""

    def test_an_attribute_that_is_given_twice_opens_nothing(self):
        self.run_program("init", "demo", *NOW)
        folder = self.at / "demo/talker"
        (folder / "key.pem").unlink()
        (folder / "pin").write_text("1")
        os.mkfifo(folder / "fifo")
        for uri in (f"pkcs11:object=x?pin-source=file:{folder}/pin&pin-source=file:{folder}/fifo",
                    f"pkcs11:object=x;pin-source=file:{folder}/pin?pin-source=file:{folder}/fifo"):
            (folder / "key.p11").write_text(uri + "\n")
            for words in (("doctor", "demo/talker"), ("check", "demo/talker", "demo/listener")):
                done = subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, capture_output=True, text=True, timeout=20,
                                      check=False, stdin=subprocess.DEVNULL)
                self.assertIn("an attribute is given twice", done.stdout + done.stderr, words)

    def test_no_key_is_written_over_what_names_one_in_a_token(self):
        self.run_program("init", "demo", *NOW)
        folder = self.at / "demo/talker"
        (folder / "key.pem").unlink()
        (folder / "key.p11").write_text("pkcs11:object=x\n")
        before = {p.name: p.read_bytes() for p in folder.iterdir()}
        self.refused("key_in_token", 1, "identity", "issue", "talker", "--ca", "demo", "-o", "demo/talker",
                     "--replace", "--publish", "x", *NOW)
        self.assertEqual({p.name: p.read_bytes() for p in folder.iterdir()}, before)


if __name__ == "__main__":
    main()

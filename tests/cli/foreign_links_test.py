#!/usr/bin/env python3
"""The owner of a folder above a participant's folder puts a link there, to the folder of another participant."""

import fcntl
import json
import os
import shutil
import subprocess
import threading
import unittest

from agent_folders import AgentTest, Running, ShortLived
from transcript import PROGRAM, Transcript, main

ALICE, BOB = 65533, 65534
LATER = ("--now", "+300d")


def give(path, user):
    for one in (path, *path.rglob("*")):
        os.chown(one, user, user, follow_symlinks=False)


class TwoHomes(AgentTest):
    """home/alice/dds/talker and home/bob/dds/talker: each user owns the folders above, too."""

    def setUp(self):
        super().setUp()
        self.at.chmod(0o755)
        for name in ("alice", "bob"):
            (self.at / f"home/{name}/dds").mkdir(parents=True)
            self.run_program("identity", "issue", name, "--ca", "demo", "-o", f"home/{name}/dds/talker", "--publish", name,
                             "--governance", "demo/governance.p7s")
        self.home = self.at / "home"
        self.alice, self.bob = "home/alice/dds/talker", "home/bob/dds/talker"

    denied = Transcript.refused

    def logged(self, subject):
        lines = (self.at / "demo/ca/identity/issued.jsonl").read_text().splitlines()
        return [line["folder"] for line in map(json.loads, lines) if line.get("subject") == subject]


@unittest.skipUnless(os.geteuid() == 0, "only root can make files of another user")
class ForeignLinks(TwoHomes):
    def setUp(self):
        super().setUp()
        give(self.home / "alice", ALICE)
        give(self.home / "bob", BOB)

    def exchange(self):
        (self.home / "alice/dds").rename(self.home / "alice/dds.real")
        (self.home / "alice/dds").symlink_to("../bob/dds")
        os.chown(self.home / "alice/dds", ALICE, ALICE, follow_symlinks=False)

    def check_refusal(self, told):
        self.assertIn(self.alice, told["file"])
        self.assertIn("dds: a link in the path", told["message"])
        self.assertIn(f"a link of user {ALICE} to ../bob/dds, in a folder of user {ALICE}", told["message"])

    def test_agent_link_above_the_folder_refused(self):
        self.exchange()
        told = self.refused("link_untrusted", "--ca", "demo", "--permissions", *LATER, folder=self.alice, exit=4)
        self.check_refusal(told)
        self.assertEqual(self.once("--ca", "demo", *LATER, folder=self.bob)[0]["event"], "renewed")

    def test_agent_with_a_hook_or_a_dry_run_link_refused(self):
        self.exchange()
        self.refused("link_untrusted", "--hook", self.signing_hook(), *LATER, folder=self.alice, exit=4)
        self.refused("link_untrusted", "--ca", "demo", "--dry-run", *LATER, folder=self.alice, exit=4)

    def test_agent_link_in_the_place_of_another_certificate_not_opened(self):
        """Alice has a second folder with the first one's certificate, and a link to what only root may open."""
        second = self.home / "alice/second"
        shutil.copytree(self.home / "alice/dds/talker", second)
        give(second, ALICE)
        fifo = self.at / "fifo"
        os.mkfifo(fifo, 0o600)
        certificate = self.home / "alice/dds/talker/cert.pem"
        certificate.unlink()
        certificate.symlink_to(fifo)
        os.chown(certificate, ALICE, ALICE, follow_symlinks=False)
        opened = threading.Event()
        writer = threading.Thread(target=lambda: (os.close(os.open(fifo, os.O_WRONLY)), opened.set()))
        writer.start()
        try:
            self.once("--ca", "demo", *LATER, folder=str(second), exit=1)
            self.assertFalse(opened.is_set(), "the agent opened the file that the link leads to")
        finally:
            os.close(os.open(fifo, os.O_RDONLY | os.O_NONBLOCK))
            writer.join()

    def test_agent_certificate_of_an_own_ca_does_not_set_how_often_the_ca_is_asked(self):
        self.run_program("ca", "create", "other", "--role", "identity", "--no-passphrase")
        ShortLived(self.at, self.at / "other").put_into(self.at / self.alice, 1)
        give(self.home / "alice", ALICE)
        agent = Running(self.at, self.alice, "--ca", "demo")
        try:
            self.assertGreaterEqual(agent.wait_for("failed")["again_in"], 60)
        finally:
            agent.end()

    def test_commands_of_root_link_above_the_folder_refused(self):
        self.exchange()
        before = self.contents()
        for words in (("identity", "renew", self.alice, "--ca", "demo"),
                      ("identity", "renew", self.alice, "--ca", "demo", "--rekey"),
                      ("identity", "renew", self.alice + "/cert.pem", "--ca", "demo", "--within", "1d"),
                      ("identity", "issue", "alice", "--ca", "demo", "-o", self.alice, "--replace")):
            self.check_refusal(self.denied("link_untrusted", 4, *words))
            self.assertEqual(self.contents(), before, words)

    def test_list_link_above_a_folder_not_put_there(self):
        self.run_program("crl", "new", "--ca", "demo")
        self.exchange()
        before = self.contents()
        told = self.json("crl", "distribute", self.alice, "--ca", "demo", exit=4)
        self.check_refusal(told["diagnostics"][0])
        self.assertEqual(self.contents(), before)

    def test_rotation_link_above_a_folder_left_out(self):
        self.run_program("ca", "rotate", "demo", "--role", "identity", "--overlap", "30d")
        self.exchange()
        self.check_refusal(self.denied("link_untrusted", 4, "ca", "rotate", "demo", self.alice, "--role", "identity",
                                        "--move"))
        self.assertEqual(self.logged("CN=bob"), [str(self.at / self.bob)])

    def test_exchanged_folders_log_keeps_the_place(self):
        """Without any link: all may write in the folder above, as in some shared folder."""
        shared = self.at / "shared"
        for name in ("a", "b"):
            (shared / name).mkdir(parents=True)
        for name, user in (("alice", "a"), ("bob", "b")):
            self.run_program("identity", "issue", name, "--ca", "demo", "-o", f"shared/{user}/talker", "--replace")
        (shared / "a").rename(shared / "c")
        (shared / "b").rename(shared / "a")
        (shared / "b").symlink_to("a")  # where the log has the certificate of bob
        self.run_program("identity", "renew", "shared/a/talker", "--ca", "demo")
        self.once("--ca", "demo", *LATER, folder="shared/a/talker")
        self.assertEqual(set(self.logged("CN=bob")), {str(self.at / self.bob), str(shared / "b/talker")})

    def test_rekey_copied_certificate_refused(self):
        """Alice has a copy of bob's certificate, and the log has it for her folder."""
        (self.at / self.alice / "cert.pem").write_bytes((self.at / self.bob / "cert.pem").read_bytes())
        log = self.at / "demo/ca/identity/issued.jsonl"
        log.write_text(log.read_text().replace(str(self.at / self.bob), str(self.at / self.alice)))
        renew = ("identity", "renew", self.alice, "--ca", "demo", "--rekey")
        told = self.denied("key_mismatch", 1, *renew)
        self.assertIn("the key of CN=bob", told["message"])
        key = self.at / self.alice / "key.pem"
        self.openssl("pkey", "-in", key, "-aes128", "-passout", "pass:secret", "-out", self.at / "closed")
        shutil.copy(self.at / "closed", key)
        self.assertIn("with a passphrase", self.denied("key_mismatch", 1, *renew)["message"])
        key.unlink()
        self.denied("key_mismatch", 1, *renew)
        self.assertFalse(key.exists())

    def test_ca_of_another_user_with_a_link_to_the_operators_refused(self):
        self.run_program("keystore", "create", "plant", "--no-passphrase")
        self.run_program("identity", "csr", "mallory", "-o", "request")
        key = self.at / "plant/private/identity_ca.key.pem"
        before = key.read_bytes()
        for link in ("private", "private/identity_ca.key.pem"):
            with self.subTest(link):
                hers = self.home / "alice/keystore"
                shutil.rmtree(hers, ignore_errors=True)
                shutil.copytree(self.at / "plant", hers, symlinks=True)
                (shutil.rmtree if link == "private" else os.unlink)(hers / link)
                (hers / link).symlink_to(self.at / "plant" / link)
                give(hers, ALICE)
                for command in (("identity", "sign-csr", "request", "--ca", hers, "--yes"),
                                ("keystore", "enclave", hers, "/a", "--allow-all"),
                                ("keystore", "rotate", hers, "--role", "identity")):
                    told = self.json(*command, exit=4)["diagnostics"]
                    self.assertEqual([one["id"] for one in told], ["link_untrusted"], command)
        self.assertEqual(key.read_bytes(), before)
        self.assertFalse((self.at / "request/cert.pem").exists())

    def test_ca_exchanged_for_the_operators_while_the_command_waits_refused(self):
        self.run_program("keystore", "create", "plant", "--no-passphrase")
        self.run_program("keystore", "create", "home/alice/keystore", "--no-passphrase")
        self.run_program("identity", "csr", "mallory", "-o", "request")
        hers = self.home / "alice/keystore"
        give(hers, ALICE)
        with open(hers / "private/identity_ca.key.pem", "rb") as key:
            fcntl.flock(key, fcntl.LOCK_EX)
            command = subprocess.Popen([PROGRAM, "identity", "sign-csr", "request", "--ca", hers, "--yes"], cwd=self.at,
                                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            with self.assertRaises(subprocess.TimeoutExpired):  # it waits
                command.wait(1)
            for name in ("private", "public"):
                (hers / name).rename(hers / f"{name}.real")
                (hers / name).symlink_to(self.at / "plant" / name)
                os.chown(hers / name, ALICE, ALICE, follow_symlinks=False)
        told, _ = command.communicate(timeout=60)
        self.assertNotEqual(command.returncode, 0, told)
        self.assertFalse((self.at / "request/cert.pem").exists(), told)

    def test_new_enclave_link_above_it_refused(self):
        self.run_program("keystore", "create", "plant", "--no-passphrase")
        (self.at / "plant/enclaves").rename(self.at / "elsewhere")
        (self.at / "plant/enclaves").symlink_to("../elsewhere")
        give(self.at / "plant", ALICE)
        told = self.json("keystore", "enclave", "plant", "/a", "--allow-all", exit=4)["diagnostics"]
        self.assertEqual([one["id"] for one in told], ["link_untrusted"])
        self.assertFalse((self.at / "elsewhere/a").exists())

    def test_ca_of_another_user_with_a_link_in_its_folder_followed(self):
        self.run_program("keystore", "create", "one", "--single-ca", "--no-passphrase")
        give(self.at / "one", ALICE)
        self.run_program("keystore", "enclave", "one", "/a", "--allow-all")

    def test_link_in_or_below_a_folder_of_another_user_refused(self):
        """Also a link of root: the owner can move it, or put another folder in its place."""
        (self.home / "alice/links").mkdir()
        (self.home / "alice/links/dds").symlink_to(self.home / "alice/dds")
        self.denied("link_untrusted", 4, "identity", "renew", "home/alice/links/dds/talker", "--ca", "demo")


class OwnLinks(TwoHomes):
    def setUp(self):
        super().setUp()
        if os.geteuid() == 0:
            give(self.home / "bob", BOB)

    def renew(self, folder):
        self.run_program("identity", "renew", folder, "--ca", "demo")
        self.assertEqual(self.once("--ca", "demo", *LATER, folder=folder)[0]["event"], "renewed")
        self.assertEqual(set(self.logged("CN=bob")), {str(self.at / self.bob)})

    def test_link_of_the_operator_followed(self):
        (self.at / "etc").symlink_to("home")
        (self.at / "whole").symlink_to(self.home / "bob/dds")
        self.renew("etc/bob/dds/talker")
        self.renew(self.at / "etc/bob/dds/talker")
        self.renew("whole/talker")
        self.renew("etc/../whole/./talker/")

    @unittest.skipUnless(os.geteuid() == 0, "only root can make files of another user")
    def test_link_in_a_folder_that_all_may_write_followed_if_it_is_sticky(self):
        folder = self.at / "open"
        folder.mkdir()
        (folder / "link").symlink_to(self.home / "bob")
        folder.chmod(0o1777)
        self.renew("open/link/dds/talker")
        folder.chmod(0o777)
        self.denied("link_untrusted", 4, "identity", "renew", "open/link/dds/talker", "--ca", "demo")
        folder.chmod(0o1777)
        os.chown(folder / "link", ALICE, ALICE, follow_symlinks=False)
        self.denied("link_untrusted", 4, "identity", "renew", "open/link/dds/talker", "--ca", "demo")

    def test_links_in_a_circle_refused(self):
        (self.at / "one").symlink_to("two")
        (self.at / "two").symlink_to("one")
        event = self.refused("file_unreadable", "--ca", "demo", folder="one/talker", exit=3)
        self.assertIn("link", event["message"])

    def test_working_folder_reached_by_a_link_followed(self):
        """The system knows where that folder really is."""
        (self.at / "etc").symlink_to("home/bob")
        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        where, self.at = self.at, self.at / "etc/dds"
        self.run_program("identity", "renew", "talker", "--ca", where / "demo")
        self.at = where
        self.assertEqual(set(self.logged("CN=bob")), {str(self.at / self.bob)})


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Another user owns the folder above a participant's, and exchanges it while the agent works."""

import os
import subprocess
import unittest

from agent_folders import AgentTest, checked_events
from transcript import PROGRAM, library_path, main

LIBRARY = PROGRAM.parent.parent / "lib/kill_at.so"
OTHER = 65534
SCRIPT = "./exchange.sh"
OWN_LOCK = {"AT_LOCK": SCRIPT, "LOCK": "1"}  # on the folder
LATER_LOCKS = {"AT_LOCK": SCRIPT, "LOCK": "2"}  # the first of each process of the agent
RESOLVED = {"AT_RESOLVED": SCRIPT}  # the links in the path of a hook


@unittest.skipUnless(os.geteuid() == 0, "only root can make files of another user")
class Exchanged(AgentTest):
    def setUp(self):
        super().setUp()
        self.at.chmod(0o755)
        self.home = self.at / "home"
        self.home.mkdir()
        self.run_program("identity", "issue", "robot", "--ca", "demo", "-o", "home/robot")
        self.mine = self.home / "mine"

    def make_own(self, key=None):
        """A folder of the other user, with the certificate of the robot, which is no secret."""
        self.mine.mkdir(exist_ok=True)
        for name in ("cert.pem", "identity_ca.pem"):
            (self.mine / name).write_bytes((self.home / "robot" / name).read_bytes())
        if key:
            (self.mine / "key.pem").write_bytes(key.read_bytes())
        else:
            self.openssl("genpkey", "-algorithm", "EC", "-pkeyopt", "ec_paramgen_curve:P-256", "-out", self.mine / "key.pem")
        for path in (self.home, self.mine, *self.mine.iterdir()):
            os.chown(path, OTHER, OTHER)

    def once(self, folder, command, moment, *words):
        script = self.at / "exchange.sh"
        script.write_text(f"#!/bin/sh\n[ -e home/aside ] || {{ {command}; }}\n")
        script.chmod(0o755)
        done = subprocess.run([PROGRAM, "agent", folder, "--once", *words, *self.LATER], cwd=self.at, text=True,
                              capture_output=True, timeout=60, check=False, stdin=subprocess.DEVNULL,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(LIBRARY),
                                   **moment})
        self.assertTrue((self.home / "aside").exists(), done.stderr)
        return checked_events(done.stdout)[0]

    def exchange_locked(self, *words):
        event = self.once("home/robot", "mv home/robot home/aside && mv home/mine home/robot", OWN_LOCK, *words)
        self.assertEqual((event["event"], event["code"]), ("failed", "folder_untrusted"), event)
        self.assertIn("in its place", event["message"])

    def test_a_locked_folder_of_root_no_new_key_for_its_name(self):
        self.make_own()
        self.exchange_locked("--ca", "demo", "--rekey")

    def test_a_locked_folder_of_root_no_question_to_a_hook(self):
        """Folders of root need no --trust; those of other users do."""
        self.make_own()
        self.openssl("req", "-x509", "-new", "-key", self.mine / "key.pem", "-subj", "/CN=admin", "-days", "30",
                     "-out", self.mine / "cert.pem")
        self.exchange_locked("--hook", self.signing_hook(before=f"echo >{self.at}/asked"))
        self.assertFalse((self.at / "asked").exists())

    def test_a_link_to_the_folder_of_a_copied_key_no_renewal_elsewhere(self):
        self.make_own(self.home / "robot/key.pem")
        event = self.once("home/mine", "mv home/mine home/aside && ln -s robot home/mine", LATER_LOCKS, "--ca", "demo")
        self.assertEqual(event["event"], "failed", event)
        self.assertIn(event["code"], ("folder_untrusted", "file_unwritable", "certificate_of_another_folder",
                                      "would_overwrite"))

    def lead_to_another(self, link_of=OTHER, home_of=OTHER):
        """Two users, each with a folder dds/robot; the first one's dds becomes a link to the other's."""
        for name, user in (("home", OTHER), ("next", OTHER - 1)):
            (self.at / name / "dds").mkdir(parents=True)
            self.run_program("identity", "issue", name, "--ca", "demo", "-o", f"{name}/dds/robot")
            for path in (self.at / name, *(self.at / name).rglob("*")):
                os.chown(path, user, user)
        (self.home / "dds").rename(self.home / "aside")
        (self.home / "dds").symlink_to("../next/dds")
        os.chown(self.home / "dds", link_of, link_of, follow_symlinks=False)
        os.chown(self.home, home_of, home_of)
        return (self.at / "next/dds/robot/cert.pem").read_bytes()

    def renew_by_both(self, exit):
        command = self.run_program("identity", "renew", "home/dds/robot", "--ca", "demo", exit=exit)
        done = self.run_program("agent", "home/dds/robot", "--once", "--ca", "demo", *self.LATER, exit=exit)
        return command, checked_events(done.stdout)[0]

    def test_a_link_of_the_folders_owner_in_the_path_leads_nowhere(self):
        before = self.lead_to_another()
        command, event = self.renew_by_both(exit=4)
        self.assertIn("link_untrusted", command.stderr)
        self.assertIn("a link of user ", command.stderr)
        self.assertEqual((event["event"], event["code"]), ("failed", "link_untrusted"), event)
        self.assertEqual((self.at / "next/dds/robot/cert.pem").read_bytes(), before)

    def test_a_link_of_root_in_a_folder_of_another_user_leads_nowhere(self):
        before = self.lead_to_another(link_of=0)
        _, event = self.renew_by_both(exit=4)
        self.assertEqual(event["code"], "link_untrusted", event)
        self.assertEqual((self.at / "next/dds/robot/cert.pem").read_bytes(), before)

    def test_a_link_of_root_in_a_folder_of_root_is_followed(self):
        before = self.lead_to_another(link_of=0, home_of=0)
        self.renew_by_both(exit=0)
        self.assertNotEqual((self.at / "next/dds/robot/cert.pem").read_bytes(), before)

    def test_the_process_of_another_user_has_nothing_of_the_agents(self):
        self.make_own(self.home / "robot/key.pem")
        self.run_program("identity", "issue", "own", "--ca", "demo", "-o", "home/own")
        for path in (self.home / "own", *(self.home / "own").iterdir()):
            os.chown(path, OTHER, OTHER)
        # The process with the CA writes a file, too.
        event = self.once("home/own", f"[ $(id -u) = {OTHER} ] || exit 0; "
                          "{ tr '\\0' '\\n' </proc/$PPID/environ; env; id -u; } >home/aside; echo forged; echo forged >&2", {"AT_RENAME": SCRIPT, "CA_PASS": "secret"}, "--ca", "demo")
        seen = (self.home / "aside").read_text()
        self.assertEqual(event["event"], "renewed", event)
        self.assertIn(str(OTHER), seen)
        self.assertNotIn("secret", seen)

    def test_a_folder_that_becomes_a_link_to_one_of_root_no_hook_is_run(self):
        """In a folder with the sticky bit, as /tmp."""
        self.make_own()
        os.chown(self.home, 0, 0)
        self.home.chmod(0o1777)
        for folder in (self.mine, self.home / "robot"):
            (folder / "ask").write_text(f"#!/bin/sh\necho >{self.at}/asked\n")
            (folder / "ask").chmod(0o755)
        event = self.once("demo/talker", "mv home/mine home/aside && ln -s robot home/mine", RESOLVED,
                          "--hook", self.mine / "ask")
        self.assertEqual(event["code"], "hook_unsafe", event)
        self.assertFalse((self.at / "asked").exists())


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Code of a folder's owner can run in the process that works there. It finds nothing of the agent in it."""

import os
import pty
import subprocess
import unittest

from agent_folders import AgentTest, checked_events
from transcript import PROGRAM, library_path, main

LIBRARY = PROGRAM.parent.parent / "lib/worker_spy.so"
OTHER = 65534
SECRET = "hook-token-" + "5ecret"


@unittest.skipUnless(os.geteuid() == 0, "only root can make files of another user")
class Worker(AgentTest):
    def setUp(self):
        super().setUp()
        self.at.chmod(0o755)
        for path in (self.talker, *self.talker.iterdir()):
            os.chown(path, OTHER, OTHER)
        (self.at / "needle").write_text(SECRET[::-1])

    def loot_of(self, *words, **more):
        """What the owner could find, by kind."""
        done = subprocess.run([PROGRAM, "agent", "demo/talker", "--once", *words, *self.LATER], cwd=self.at, text=True,
                              capture_output=True, timeout=60, check=False, **more,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(LIBRARY),
                                   "TOKEN": SECRET, "CA_PASS": SECRET, "XDG_CONFIG_HOME": str(self.at)})
        event, = checked_events(done.stdout)
        self.assertEqual(event["event"], "renewed", event)
        out = {}
        for line in (self.at / "loot").read_text().splitlines():
            kind, _, rest = line.partition(" ")
            out.setdefault(kind, []).append(rest)
        return out

    def check_clean(self, loot):
        names = {variable.partition("=")[0] for variable in loot["variable"]}
        self.assertLessEqual(names, {"PATH", "LC_ALL", "HOME", "LD_LIBRARY_PATH", "LD_PRELOAD", "OPENSSL_CONF",
                                     "OPENSSL_ENGINES", "OPENSSL_MODULES", "PKCS11_MODULE_PATH", "SOFTHSM2_CONF"})
        self.assertIn("HOME=/nonexistent", loot["variable"])
        self.assertEqual(loot["memory"], ["no"])
        self.assertEqual((loot["terminal"], loot["leader"]), (["no"], ["yes"]))
        self.assertEqual(loot["core"], ["0"])
        files = dict(line.split(" ", 1) for line in loot["file"])
        self.assertEqual({files[number] for number in "012"}, {"/dev/null"})
        self.assertEqual([files[number].partition(":")[0] for number in "34"], ["pipe", "pipe"])
        self.assertTrue(files["5"].endswith("/.ddssec-agent"), files)
        for number in set(files) - set("012345"):
            self.assertEqual(files[number], str(self.talker), "only the folder itself is open besides")

    def test_worker_with_a_ca_has_no_passphrase(self):
        key = self.ca / "ca.key.pem"
        self.openssl("pkcs8", "-topk8", "-in", key, "-out", self.at / "closed", "-passout", f"pass:{SECRET}")
        key.write_bytes((self.at / "closed").read_bytes())
        self.check_clean(self.loot_of("--ca", "demo", "--passphrase-env", "CA_PASS"))

    def test_worker_with_a_hook_has_no_variable_of_it(self):
        hook = self.signing_hook(before=f'[ "$TOKEN" = {SECRET} ] || exit 1')
        self.check_clean(self.loot_of("--hook", hook, "--hook-env", "TOKEN", "--trust", self.ca / "ca.pem"))

    def test_worker_of_an_agent_on_a_terminal_has_no_terminal(self):
        """An input that is pushed into it (TIOCSTI) would be a command of root's shell."""
        terminal, other = pty.openpty()

        def take():
            os.setsid()
            os.close(os.open(os.ttyname(other), os.O_RDWR))

        try:
            self.check_clean(self.loot_of("--ca", "demo", preexec_fn=take))
        finally:
            os.close(terminal)
            os.close(other)


class OwnFolder(AgentTest):
    def test_worker_started_by_hand_does_nothing(self):
        done = subprocess.run([PROGRAM, "--agent-worker"], cwd=self.at, capture_output=True, timeout=60, check=False)
        self.assertEqual((done.returncode, done.stdout), (1, b""))

    def test_relative_folder_and_any_name_renewed(self):
        name = "demo/t\u00e9 \"x\n"
        self.talker.rename(self.at / name)
        self.run_program("identity", "renew", name, "--ca", "demo", "--subject", "CN=talker")
        events = self.once("--ca", "demo", *self.LATER, folder=name)
        self.assertEqual(events[0]["event"], "renewed", events)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The agent is killed at any moment: every file is old or new, and the next run does the work."""

import datetime
import os
import random
import shutil
import signal
import subprocess
import time

from agent_folders import AgentTest, Running, ShortLived, checked_events
from interrupted_test import is_whole
from transcript import PROGRAM, library_path, main

LIBRARY = PROGRAM.parent.parent / "lib/kill_at.so"
KILLS = 15


class Interrupted(AgentTest):
    def is_well(self, *now):
        self.run_program("doctor", "demo/talker", *now)
        self.assertEqual(self.public_key(), self.openssl("pkey", "-in", self.talker / "key.pem", "-pubout"))

    def lists(self):
        """The renewal list of the folder, with an entry of a former renewal, and those of the CAs."""
        return {path: path.read_text() for path in (self.talker / "renewed.pem", self.ca / "renewed.pem",
                                                    self.ca.parent / "permissions/renewed.pem")}

    def check_lists(self, former):
        """Each is there and whole. That of the folder is the former one, or has what the CA issued last: true if so."""
        lists = self.lists()
        for path, text in lists.items():
            self.assertTrue(is_whole(path.name, text.encode()), path)
            self.assertEqual(text.count("-----BEGIN "), former[path].count("-----BEGIN "), path)
        text = lists[self.talker / "renewed.pem"]
        is_new = text != former[self.talker / "renewed.pem"]
        if is_new:
            self.assertIn(lists[self.ca / "renewed.pem"].strip(), text)
        return is_new

    def run_killed_at(self, number, words):
        """Runs the agent once; its processes are killed at their write with this number. True if one was killed. Each
        process counts its own writes: the one that keeps the folder, the one of the CA, and the agent itself, which makes
        the lock."""
        done = subprocess.run([PROGRAM, "agent", "demo/talker", "--once", *words, *self.LATER], cwd=self.at, text=True,
                              capture_output=True, timeout=60, check=False, stdin=subprocess.DEVNULL,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(LIBRARY),
                                   "KILL_AT": str(number)})
        killed = done.returncode != 0
        renewed = [event for event in checked_events(done.stdout) if event["event"] == "renewed"]
        if killed:  # perhaps when the certificate was in its place
            self.assertIn([event["problem"]["code"] for event in renewed], ([], ["internal"]))
        else:
            self.assertEqual(["problem" in event for event in renewed], [False])
        return killed

    def check_recovered(self, former, words, owner, where):
        """The next run of the agent does the work, whatever the killed one left."""
        again = self.once(*words, *self.LATER, exit=None)
        self.assertIn(again[0]["event"], ("renewed", "current"), where)
        cut = again[0].get("problem", {"code": "log_line_unreadable"})  # the last line of the CA's log
        self.assertEqual(cut["code"], "log_line_unreadable", where)
        self.is_well("--now", "+301d")
        self.assertEqual(self.check_lists(former), "--ca" in words, f"a CA of a hook has no list here: {where}")
        if "--ca" in words:
            self.assertIn((self.talker / "cert.pem").read_text(), (self.talker / "renewed.pem").read_text(), where)
        self.assertEqual({p.stat().st_uid for p in self.talker.iterdir()}, {owner}, where)
        left = [p.name for p in self.talker.iterdir() if p.name.endswith(".new") or ".ddssec" in p.name]
        self.assertEqual(left, [], where)

    def kill_at_each_write(self, *words, owner=os.geteuid()):
        self.run_program("identity", "renew", "demo/talker", "--ca", "demo", "--permissions", "--days", "400")
        self.run_program("crl", "distribute", "--ca", "demo")
        os.chown(self.talker / "renewed.pem", owner, owner)
        former = self.lists()
        base = self.at.parent / (self.at.name + "-base")
        subprocess.run(["cp", "-a", self.at, base], check=True)
        self.addCleanup(shutil.rmtree, base, True)
        number, killed = 0, True
        while killed:
            number += 1
            shutil.rmtree(self.at / "demo")
            subprocess.run(["cp", "-a", base / "demo", self.at / "demo"], check=True)
            killed = self.run_killed_at(number, words)
            self.check_lists(former)
            self.check_recovered(former, words, owner, f"{words} at {number}")
        self.assertGreater(number, 3)
        shutil.rmtree(base)
        shutil.rmtree(self.at / "demo")
        self.run_program("init", "demo")

    def test_kill_between_two_writes_leaves_old_or_new_files(self):
        self.kill_at_each_write("--ca", "demo", "--permissions")
        self.kill_at_each_write("--ca", "demo", "--rekey")
        self.kill_at_each_write("--hook", self.signing_hook("-days", "600"), "--rekey")

    def test_kill_in_a_folder_of_another_user_leaves_its_owner(self):
        if os.geteuid() != 0:
            self.skipTest("only root can make files of another user")
        self.at.chmod(0o755)
        for path in (self.talker, *self.talker.iterdir()):
            os.chown(path, 65534, 65534)
        self.kill_at_each_write("--ca", "demo", "--permissions", owner=65534)

    def once_full_at(self, number, words, now):
        """The events of one look, in which each process finds the disk full from its write with this number on."""
        done = subprocess.run([PROGRAM, "agent", "demo/talker", "--once", *words, *now], cwd=self.at, text=True,
                              capture_output=True, timeout=60, check=False, stdin=subprocess.DEVNULL,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(LIBRARY),
                                   "FULL_AT": str(number)})
        self.assertIn(done.returncode, (0, 5), done.stderr)
        return done.returncode == 0, checked_events(done.stdout)

    def test_a_disk_that_is_full_leaves_each_file_old_or_new_and_the_next_look_does_the_work(self):
        base = self.at.parent / (self.at.name + "-base")
        subprocess.run(["cp", "-a", self.at / "demo", base], check=True)
        self.addCleanup(shutil.rmtree, base, True)
        now = ("--now", f"{datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(days=300):%Y-%m-%dT%H:%M:%SZ}")
        alone = 0
        for words in (("--ca", "demo", "--permissions"), ("--ca", "demo", "--permissions", "--rekey")):
            number, is_done = 0, False
            while not is_done:
                number += 1
                shutil.rmtree(self.at / "demo")
                subprocess.run(["cp", "-a", base, self.at / "demo"], check=True)
                before = self.contents()
                is_done, (event,) = self.once_full_at(number, words, now)
                where = f"{words}, full at {number}: {event}"
                for name, octets in self.contents().items():
                    self.assertTrue(octets == before.get(name) or is_whole(name, octets), where)
                self.assertEqual(self.contents().keys() - {"demo/talker/renewed.pem"}, before.keys(), where)
                problem = event.get("problem", event)
                self.assertEqual(problem.get("code"), None if is_done else "file_unwritable", where)
                # At the same second the CA can give no later certificate, but it can extend the permissions.
                alone += event["event"] == "renewed" and not event["permissions_extended"]
                again, = self.once(*words, *now)
                self.assertIn(again["event"], ("renewed", "current"), f"{where}, then {again}")
                self.assertNotIn("problem", again, where)
                self.is_well("--now", "+660d")  # the permissions last as long as the new certificate
            self.assertGreater(number, 3)
        self.assertGreater(alone, 0, "the certificate was never renewed without the permissions")

    def test_kill_of_all_processes_at_any_moment_leaves_whole_files(self):
        short = ShortLived(self.at, self.ca)
        short.put_into(self.talker, 5)
        hook = self.hook(short.script(5))
        renewed = 0
        for _ in range(KILLS):
            agent = Running(self.at, "demo/talker", "--hook", hook, "--rekey")
            time.sleep(random.uniform(0.05, 2.5))
            if random.random() < 0.5:
                agent.kill_session()
            agent.end(signal.SIGKILL)
            renewed += len(agent.events("renewed"))
            for name in ("cert.pem", "key.pem"):
                self.assertTrue((self.talker / name).read_text().endswith("-----\n"), name)
        short.put_into(self.talker, 1)
        agent = Running(self.at, "demo/talker", "--hook", self.hook(short.script(3600)), "--rekey")
        agent.wait_for("renewed")
        self.assertEqual(agent.end(), 0)
        self.assertGreater(renewed, 0)
        self.is_well()


if __name__ == "__main__":
    main()

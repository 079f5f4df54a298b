#!/usr/bin/env python3
"""ddssec agent: an overlap of its CA ends at its date."""

import datetime
import json
import os
import shutil
import signal
import unittest

from agent_folders import AgentTest, Running
from transcript import main

DAY = ("--now", "+40d")
ROLES = ("identity", "permissions")


class Overlap(AgentTest):
    def begin(self):
        for role in ROLES:
            self.run_program("ca", "rotate", "demo", "--role", role, "--overlap", "30d")

    def certificates(self, path):
        return (self.at / path).read_text().count("BEGIN CERTIFICATE")

    def look(self, *words, exit=0):
        return self.once("--ca", "demo", *words, exit=exit)

    def all_files(self):
        return {str(p): p.read_bytes() for p in (self.at / "demo").rglob("*") if p.is_file()}

    def test_before_the_date_nothing_is_ended(self):
        self.begin()
        self.assertEqual([event["event"] for event in self.look("--permissions", "--now", "+29d")], ["current"])
        self.assertEqual(self.certificates("demo/ca/identity/ca.pem"), 2)

    def test_at_the_date_both_overlaps_end_as_by_hand(self):
        self.begin()
        one, other, folder = self.look("--permissions", *DAY)
        for event, role in ((one, "identity"), (other, "permissions")):
            self.assertEqual((event["event"], event["role"], event["left"]), ("overlap_ended", role, []))
            self.assertEqual(sorted(event["folders"]), sorted(str(self.at / "demo" / name) for name in ("talker", "listener")))
            for file in (f"demo/ca/{role}/ca.pem", f"demo/talker/{role}_ca.pem", f"demo/listener/{role}_ca.pem"):
                self.assertEqual(self.certificates(file), 1, file)
        self.assertEqual(folder["event"], "current")
        self.run_program("check", "demo/talker", "demo/listener", *DAY)
        self.assertEqual([event["event"] for event in self.look("--permissions", *DAY)], ["current"])

    def test_without_permissions_only_the_identity_cas_overlap_ends(self):
        self.begin()
        self.assertEqual([event["event"] for event in self.look(*DAY)], ["overlap_ended", "current"])
        self.assertEqual([self.certificates(f"demo/ca/{role}/ca.pem") for role in ROLES], [1, 2])

    def test_dry_run_says_what_would_end_and_writes_nothing(self):
        self.begin()
        before = self.all_files()
        self.assertEqual(self.look("--dry-run", *DAY)[0]["event"], "overlap_due")
        self.assertEqual(self.all_files(), before)

    def test_folder_that_is_away_is_named_as_by_hand(self):
        self.begin()
        (self.at / "demo/listener").rename(self.at / "away")
        event = self.look(*DAY, exit=None)[0]
        self.assertEqual((event["event"], event["left"]), ("overlap_ended", [str(self.at / "demo/listener")]))
        self.assertEqual(event["problem"]["code"], "participant_elsewhere")
        self.assertEqual(self.json("ca", "show", "demo", "--role", "identity", *DAY)["result"]["rotation"]["elsewhere"],
                         [str(self.at / "demo/listener")])

    def test_key_that_cannot_be_read_leaves_the_overlap_and_says_so(self):
        (self.at / "secret").write_text("correct horse\n")
        self.run_program("ca", "create", "ca", "--passphrase-file", "secret")
        self.run_program("identity", "issue", "a", "--ca", "ca", "-o", "a", "--publish", "x", "--passphrase-file", "secret")
        self.run_program("ca", "rotate", "ca", "--role", "identity", "--overlap", "30d", "--passphrase-file", "secret")
        (self.at / "ca/identity/ca.key.pem").write_text("nothing")
        first = self.once("--ca", "ca", "--passphrase-file", "secret", *DAY, folder="a", exit=3)[0]
        self.assertEqual((first["event"], first["folder"], first["again_in"]), ("failed", "ca", 3600))
        self.assertEqual(self.certificates("ca/identity/ca.pem"), 2)

    def test_record_that_cannot_be_read_is_reported_and_the_other_overlap_ends(self):
        """Otherwise the former CA would be trusted for ever, and nothing would say so."""
        self.begin()
        (self.at / "demo/ca/identity/ca.overlap.json").write_text("{}")
        one, other, folder = self.look("--permissions", *DAY, exit=1)
        self.assertEqual((one["event"], one["code"], one["again_in"]), ("failed", "overlap_unreadable", 3600))
        self.assertEqual(one["file"], "demo/ca/identity/ca.overlap.json")
        self.assertEqual((other["event"], other["role"]), ("overlap_ended", "permissions"))
        self.assertEqual(folder["event"], "current")
        self.assertEqual([self.certificates(f"demo/ca/{role}/ca.pem") for role in ROLES], [2, 1])

    @unittest.skipUnless(os.geteuid() == 0, "only root has folders of other users")
    def test_folder_of_another_user_keeps_the_overlap_and_names_the_command(self):
        self.begin()
        self.at.chmod(0o755)
        for path in (self.at / "demo/listener", *(self.at / "demo/listener").rglob("*")):
            shutil.chown(path, 65534, 65534)
        event = self.look(*DAY, exit=4)[0]
        self.assertEqual((event["event"], event["code"], event["file"]),
                         ("failed", "folder_untrusted", str(self.at / "demo/listener")))
        self.assertIn("ddssec ca rotate demo --role identity --end --when-due", event["hint"])
        self.assertEqual(self.certificates("demo/ca/identity/ca.pem"), 2)

    def end_in(self, seconds, folder):
        """The shortest time of --overlap is an hour."""
        record = self.at / folder / "ca.overlap.json"
        until = (datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(seconds=seconds)).strftime("%FT%TZ")
        record.write_text(json.dumps(json.loads(record.read_text()) | {"until": until}))

    def test_daemon_key_that_refuses_its_passphrase_does_not_delay_the_other_overlap(self):
        for name in ("ca", "other"):
            (self.at / f"{name}-secret").write_text(f"correct {name}\n")
            self.run_program("ca", "create", name, "--passphrase-file", f"{name}-secret")
        secret = ("--passphrase-file", "ca-secret")
        self.run_program("identity", "issue", "a", "--ca", "ca", "-o", "a", "--publish", "x", *secret)
        for role in ROLES:
            self.run_program("ca", "rotate", "ca", "--role", role, "--overlap", "30d", *secret)
        agent = Running(self.at, "a", "--ca", "ca", "--permissions", *secret)
        self.addCleanup(agent.end, signal.SIGKILL)
        agent.wait_for("current")
        key, others = (self.at / f"{name}/permissions/ca.key.pem" for name in ("ca", "other"))
        right = key.read_bytes()
        key.write_bytes(others.read_bytes())
        self.end_in(0, "ca/permissions")
        self.end_in(4, "ca/identity")
        agent.process.send_signal(signal.SIGHUP)
        failed = agent.wait_for("failed")
        self.assertEqual((failed["code"], failed["again_in"]), ("passphrase_wrong", None))
        self.assertEqual(agent.wait_for("overlap_ended")["role"], "identity")
        key.write_bytes(right)
        agent.process.send_signal(signal.SIGHUP)
        self.assertEqual(agent.wait_for("overlap_ended", 2)["role"], "permissions")
        self.assertEqual(len(agent.events("failed")), 1)
        self.assertEqual(agent.end(), 0)

    def test_daemon_ends_it_at_its_date_without_a_signal(self):
        self.begin()
        for role in ROLES:
            self.end_in(4, f"demo/ca/{role}")
        agent = Running(self.at, "demo/talker", "--ca", "demo", "--permissions")
        self.addCleanup(agent.end, signal.SIGKILL)
        agent.wait_for("overlap_ended", 2)
        self.assertEqual({event["role"] for event in agent.events("overlap_ended")}, set(ROLES))
        self.assertEqual(agent.events("failed"), [])
        self.assertEqual(agent.end(), 0)
        self.run_program("check", "demo/talker", "demo/listener")


if __name__ == "__main__":
    main()

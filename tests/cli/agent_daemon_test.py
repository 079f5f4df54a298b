#!/usr/bin/env python3
"""ddssec agent as a daemon: repetitions, signals, its end."""

import json
import os
import signal
import time

from agent_folders import SIGN, AgentTest, Running, ShortLived
from transcript import main


class Daemon(AgentTest):
    def start(self, *words, **environment):
        agent = Running(self.at, *words, **environment)
        self.addCleanup(agent.end, signal.SIGKILL)
        return agent

    def short_lived(self, seconds):
        short = ShortLived(self.at, self.ca)
        short.put_into(self.talker, seconds)
        return short, self.hook(short.script(seconds))

    def test_renews_again_and_again_and_ends_cleanly(self):
        _, hook = self.short_lived(9)
        agent = self.start("demo/talker", "--hook", hook)
        first, second = agent.wait_for("renewed", 1), agent.wait_for("renewed", 2)
        self.assertNotEqual(first["serial"], second["serial"])
        self.assertEqual(agent.events("failed"), [])
        self.assertTrue((self.talker / ".ddssec-agent").exists())
        self.assertEqual(agent.end(), 0)
        self.assertEqual([e["event"] for e in agent.lines][0::len(agent.lines) - 1], ["started", "stopped"])
        self.assertFalse((self.talker / ".ddssec-agent").exists())

    def test_the_ca_here_issues_for_as_long(self):
        self.short_lived(27)
        log = self.ca / "issued.jsonl"
        line = json.loads(log.read_text().splitlines()[0])
        line["serial"] = self.openssl("x509", "-in", self.talker / "cert.pem", "-noout", "-serial").strip().split("=")[1]
        line["folder"] = str(self.talker)
        for name in ("sha256", "key", "file"):
            line.pop(name, None)
        line["subject"] = "CN=talker"
        log.write_text(log.read_text() + json.dumps(line) + "\n")
        agent = self.start("demo/talker", "--ca", "demo")
        agent.wait_for("renewed")
        begin, end = self.dates()
        self.assertEqual((end - begin).total_seconds(), 27)
        agent.wait_for("renewed", 2)
        self.assertEqual(agent.end(), 0)

    def test_tries_again_later_each_time_and_on_sighup(self):
        _, hook = self.short_lived(3600)
        self.hook("exit 1")
        agent = self.start("demo/talker", "--hook", hook)
        agent.wait_for("current")
        self.assertEqual(agent.events("failed"), [])
        short, _ = ShortLived.__new__(ShortLived), None
        short.at = self.at / "short"
        short.put_into(self.talker, 1)
        agent.process.send_signal(signal.SIGHUP)
        third = agent.wait_for("failed", 3)
        waits = [event["again_in"] for event in agent.events("failed")][:3]
        self.assertEqual(third["failures"], 3)
        self.assertEqual(waits, sorted(waits))
        self.hook(short.script(3600))
        agent.process.send_signal(signal.SIGHUP)
        agent.wait_for("renewed", seconds=20)
        self.assertEqual(agent.end(signal.SIGINT), 0)

    def due_folder(self, name):
        """Two thirds of its certificate's year are over. Returns the certificate."""
        if not (self.at / "old").exists():
            self.run_program("ca", "create", "old", "--role", "identity", "--no-passphrase", "--now", "-400d")
        self.run_program("identity", "issue", name, "--ca", "old", "-o", name, "--days", "365", "--now", "-300d")
        return (self.at / name / "cert.pem").read_bytes()

    def test_CertificatesPutBackInTwoFolders_AreNotRenewedEachSecond(self):
        """Each renewal makes the agent look at the other folder, too."""
        due = {name: self.due_folder(name) for name in ("one", "two")}
        agent = self.start(*due, "--ca", "old")
        end, seen = time.monotonic() + 30, 0
        while not agent.events("failed"):
            self.assertLess(time.monotonic(), end, agent.lines)
            renewed = agent.events("renewed")
            for event in renewed[seen:]:
                (self.at / "back").write_bytes(due[event["folder"]])
                os.rename(self.at / "back", self.at / event["folder"] / "cert.pem")
            seen = len(renewed)
            time.sleep(0.05)
        self.assertEqual(f"error[{agent.events('failed')[0]['code']}]", "error[renewed_too_often]")
        self.assertEqual(seen, 4)
        for name in due:
            self.assertEqual((self.at / "old/issued.jsonl").read_text().count(f'/{name}"'), 3, name)  # with its first one
        agent.process.send_signal(signal.SIGHUP)  # the operator has repaired it
        agent.wait_for("renewed", 6, seconds=20)
        self.assertEqual(agent.end(), 0)

    def test_EarlierCertificateOfARevokedOne_IsNotRenewedByAHook(self):
        """The owner of the folder puts it back, and removes the list there."""
        earlier, ca = self.due_folder("one"), self.at / "old"
        hook = self.hook(f"echo >>{self.at}/asked\n{SIGN.format(ca=ca)} -days 400")
        agent = self.start("one", "--hook", hook, "--trust", ca / "ca.pem")
        agent.wait_for("renewed")
        by_openssl = ("ca", "-config", ShortLived(self.at, ca).at / "openssl.cnf")
        self.openssl(*by_openssl, "-revoke", "one/cert.pem")  # this one alone
        self.openssl(*by_openssl, "-gencrl", "-crldays", "30", "-out", ca / "crl.pem")
        (self.at / "one/cert.pem").write_bytes(earlier)
        agent.process.send_signal(signal.SIGHUP)
        self.assertEqual(agent.wait_for("failed")["code"], "certificate_revoked")
        self.assertEqual(len((self.at / "asked").read_text()), 1)
        self.assertEqual(agent.end(), 0)

    def test_a_stop_does_not_wait_for_a_hook(self):
        self.short_lived(1)
        agent = self.start("demo/talker", "--hook", self.hook(f"echo >{self.at}/began; exec sleep 300"))
        while not (self.at / "began").exists():
            time.sleep(0.05)
        begin = time.monotonic()
        self.assertEqual(agent.end(), 0)
        self.assertLess(time.monotonic() - begin, 10)
        self.assertEqual(agent.events("failed"), [])

    def test_a_wrong_passphrase_is_tried_once(self):
        self.run_program("ca", "create", "locked", "--role", "identity", "--passphrase-env", "PASS",
                         environment={"PASS": "right horse"})
        self.run_program("identity", "issue", "x", "--ca", "locked", "-o", "x", "--days", "1", "--passphrase-env", "PASS",
                         "--now", "-1d", environment={"PASS": "right horse"})
        os.mkfifo(self.at / "pipe")  # which can be read only once, when it is needed
        agent = self.start("x", "--ca", "locked", "--passphrase-file", "pipe")
        (self.at / "pipe").write_text("wrong horse\n")
        event = agent.wait_for("failed")
        self.assertIn("--passphrase-file", event["hint"])
        self.assertEqual((event["code"], event["again_in"]), ("passphrase_wrong", None))
        time.sleep(2)  # in which nothing may be tried: a first repetition comes sooner
        self.assertEqual(len(agent.events("failed")), 1)
        self.assertEqual(agent.end(), 0)

    def test_AWrongPassphrase_IsFoundAtTheStart(self):
        right, wrong = {"PASS": "right horse"}, {"PASS": "wrong horse"}
        self.run_program("ca", "create", "locked", "--passphrase-env", "PASS", environment=right)
        self.run_program("identity", "issue", "x", "--ca", "locked", "-o", "x", "--passphrase-env", "PASS", environment=right)
        words = ("agent", "x", "--ca", "locked", "--passphrase-env", "PASS")
        for more in ((), ("--once",), ("--once", "--dry-run"), ("--once", "--dry-run", "--permissions")):
            done = self.run_program(*words, *more, exit=1, environment=wrong)
            self.assertEqual(done.stdout, "")
            self.assertIn("error[passphrase_wrong]", done.stderr)
            self.assertIn("check what --passphrase-file or --passphrase-env gives", done.stderr)
        self.assertEqual(self.once(*words[2:], folder="x", environment=right)[0]["event"], "current")
        self.run_program(*words[:4], "--once", exit=4)


if __name__ == "__main__":
    main()

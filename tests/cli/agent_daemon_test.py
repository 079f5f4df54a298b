#!/usr/bin/env python3
"""ddssec agent as a daemon: repetitions, signals, its end."""

import ctypes
import fcntl
import json
import os
import pathlib
import signal
import subprocess
import time

from agent_folders import SIGN, AgentTest, Running, ShortLived
from transcript import PROGRAM, library_path, main


PTRACE_SEIZE = 0x4206


def seize(pid):
    """Traces the process. Until the tracer waits for it, its parent does not see its end: to the parent it is like one
    that waits for a file system that does not answer."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.ptrace.argtypes = (ctypes.c_long, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
    return libc.ptrace(PTRACE_SEIZE, pid, None, None) == 0


def workers_of(agent):
    """The numbers of the processes in which the agent works in a folder."""
    tasks = pathlib.Path(f"/proc/{agent.pid}/task").glob("*/children")
    numbers = [int(number) for task in tasks for number in task.read_text().split()]
    return [number for number in numbers
            if b"--agent-worker" in pathlib.Path(f"/proc/{number}/cmdline").read_bytes()]


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

    def test_certificates_put_back_in_two_folders_are_not_renewed_each_second(self):
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

    def test_answers_of_a_hook_that_do_not_fit_are_refused_for_the_same_reason_each_time(self):
        ShortLived(self.at, self.ca).put_into(self.talker, 15, age=45)  # due; tried again after 1, 2 and 4 s
        hook = self.hook(f"cat >/dev/null; cat {self.talker}/cert.pem")
        agent = self.start("demo/talker", "--hook", hook)
        agent.wait_for("failed", 4)
        self.assertEqual({event["code"] for event in agent.events("failed")}, {"renewal_goes_back"})
        self.assertEqual(agent.end(), 0)

    def test_earlier_certificate_of_a_revoked_one_is_not_renewed_by_a_hook(self):
        """The owner of the folder puts it back, and removes the list there."""
        earlier, ca = self.due_folder("one"), self.at / "old"
        hook = self.hook(f"echo >>{self.at}/asked\n{SIGN.format(ca=ca)} -days 400")
        agent = self.start("one", "--hook", hook, "--trust", ca / "ca.pem")
        agent.wait_for("renewed")
        short_lived = ShortLived(self.at, ca)
        by_openssl = ("ca", "-config", short_lived.at / "openssl.cnf")
        self.openssl(*by_openssl, "-revoke", "one/cert.pem")  # this one alone
        self.openssl(*by_openssl, "-gencrl", "-crldays", "30", "-out", ca / "crl.pem")
        (self.at / "one/cert.pem").write_bytes(earlier)
        agent.process.send_signal(signal.SIGHUP)
        self.assertEqual(agent.wait_for("failed")["code"], "certificate_revoked")
        self.assertEqual(len((self.at / "asked").read_text()), 1)
        time.sleep(1)  # dates have whole seconds
        short_lived.put_into(self.at / "one", 4)  # by the operator, in place of the revoked one
        agent.process.send_signal(signal.SIGHUP)
        agent.wait_for("renewed", 2, seconds=20)
        self.assertEqual(agent.end(), 0)

    def test_a_stop_does_not_wait_for_a_hook(self):
        self.short_lived(1)
        agent = self.start("demo/talker", "--hook", self.hook(f"echo >{self.at}/began; exec sleep 300"))
        self.wait_until_hook_begins()
        begin = time.monotonic()
        self.assertEqual(agent.end(), 0)
        self.assertLess(time.monotonic() - begin, 10)
        self.assertEqual(agent.events("failed"), [])

    def wait_until_hook_begins(self):
        end = time.monotonic() + 30
        while not (self.at / "began").exists():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)

    def seize_worker(self, agent):
        """Its hook has begun, so it waits for the answer."""
        self.wait_until_hook_begins()
        worker, = workers_of(agent.process)
        if not seize(worker):
            self.skipTest("no process may be traced here")
        return worker

    def test_stop_with_a_worker_that_cannot_be_ended_is_obeyed(self):
        self.short_lived(1)
        agent = self.start("demo/talker", "--hook", self.hook(f"echo >{self.at}/began; exec sleep 300"))
        worker = self.seize_worker(agent)
        begin = time.monotonic()
        self.assertEqual(agent.end(), 0)
        self.assertLess(time.monotonic() - begin, 15)
        os.waitpid(worker, 0)

    def test_worker_that_cannot_be_ended_is_the_last_one_of_its_folder_until_it_ends(self):
        self.short_lived(1)
        hook = self.hook(f"echo >{self.at}/began; until [ -e {self.at}/go ]; do sleep 0.05; done; exit 1")
        agent = self.start("demo/talker", "--hook", hook)
        worker = self.seize_worker(agent)
        (self.at / "go").touch()

        def refused(code, count):
            event = agent.wait_for("failed", count)
            self.assertEqual(event["code"], code)
            return event["message"]
        refused("hook_failed", 1)
        self.assertIn(f"process {worker}", refused("process_unended", 2))
        self.assertEqual(workers_of(agent.process), [])
        (self.at / "began").unlink()
        os.waitpid(worker, 0)
        agent.process.send_signal(signal.SIGHUP)
        self.wait_until_hook_begins()
        self.assertEqual(agent.end(), 0)

    def test_started_with_a_hook_says_whether_revocation_is_checked(self):
        _, hook = self.short_lived(3600)
        trust = self.at / "trust.pem"
        trust.write_bytes((self.ca / "ca.pem").read_bytes())
        lists = self.ca / "crl.pem"
        for words, expected in (((), None), (("--trust", trust), None), (("--trust", trust, "--crl", lists), str(lists)),
                                (("--trust", self.ca / "ca.pem"), str(lists))):
            agent = self.start("demo/talker", "--hook", hook, *words)
            self.assertEqual(agent.wait_for("started")["crl"], expected)
            self.assertEqual(agent.end(), 0)

    def test_stop_with_a_reader_that_stopped_is_obeyed(self):
        end, output = os.pipe()
        fcntl.fcntl(output, fcntl.F_SETPIPE_SZ, 4096)
        os.write(output, bytes(4096))
        agent = subprocess.Popen([PROGRAM, "agent", "demo/talker", "--ca", "demo"], cwd=self.at, stdout=output,
                                 stderr=subprocess.PIPE, text=True, env={**os.environ, "LD_LIBRARY_PATH": library_path()})
        self.addCleanup(agent.kill)
        self.assertIn("events_lost", agent.stderr.readline())
        agent.terminate()
        self.assertEqual(agent.wait(timeout=30), 0)
        for file in (end, output):
            os.close(file)
        agent.stderr.close()

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

    def test_a_wrong_passphrase_is_found_at_the_start(self):
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

"""Folders, certificates of seconds and hooks for the tests of `ddssec agent`."""

import datetime
import json
import os
import pathlib
import signal
import subprocess
import threading
import time

import jsonschema

from transcript import PROGRAM, SCHEMA, Transcript, library_path

EVENTS = jsonschema.Draft202012Validator({"$defs": SCHEMA["$defs"], "$ref": "#/$defs/event of agent"})
SIGN = "openssl x509 -req -sha256 -CA {ca}/ca.pem -CAkey {ca}/ca.key.pem -set_serial 0x$(openssl rand -hex 16)"
CONFIGURATION = """[ca]
default_ca = one
[one]
new_certs_dir = {at}
database = {at}/index.txt
rand_serial = yes
unique_subject = no
policy = any
default_md = sha256
certificate = {ca}/ca.pem
private_key = {ca}/ca.key.pem
x509_extensions = leaf
[any]
commonName = supplied
[leaf]
basicConstraints = critical,CA:FALSE
keyUsage = critical,digitalSignature
"""


def checked_events(text):
    out = [json.loads(line) for line in text.splitlines()]
    for event in out:
        wrong = jsonschema.exceptions.best_match(EVENTS.iter_errors(event))
        assert wrong is None, f"{event}: {wrong}"
    return out


class AgentTest(Transcript):
    """Begins with the CAs of `init` and a participant of a year."""

    LATER = ("--now", "+300d")  # after two thirds of a year

    def setUp(self):
        super().setUp()
        self.run_program("init", "demo")
        self.ca = self.at / "demo/ca/identity"
        self.talker = self.at / "demo/talker"

    def once(self, *words, exit=0, folder="demo/talker", **more):
        """The events of one look."""
        return checked_events(self.run_program("agent", folder, "--once", *words, exit=exit, **more).stdout)

    def hook(self, text, mode=0o755):
        """A script; its path is what --hook takes."""
        path = self.at / "hook"
        path.write_text("#!/bin/sh\n" + text + "\n")
        path.chmod(mode)
        return str(path)

    def signing_hook(self, *words, before=""):
        """One that signs what it reads with the CA of `init`."""
        return self.hook(before + "\n" + SIGN.format(ca=self.ca) + " " + " ".join(words or ("-days", "400")))

    def refused(self, code, *words, exit=1, folder="demo/talker", **more):
        """It changes nothing and says why, as an event and on standard error."""
        before = self.contents()
        done = self.run_program("agent", folder, "--once", *words, exit=exit, **more)
        event, = checked_events(done.stdout)
        self.assertEqual((event["event"], event["code"]), ("failed", code), event)
        self.assertIn(f"error[{code}]: ", done.stderr)
        self.assertEqual(self.contents(), before)
        return event

    def contents(self):
        return {str(p.relative_to(self.at)): p.read_bytes() for p in self.at.rglob("demo/talker/*") if p.is_file()}

    def dates(self, file=None):
        text = self.openssl("x509", "-in", file or self.talker / "cert.pem", "-noout", "-startdate", "-enddate")
        return [datetime.datetime.strptime(line.split("=")[1], "%b %d %H:%M:%S %Y %Z") for line in text.splitlines()]

    def public_key(self, file=None):
        return self.openssl("x509", "-in", file or self.talker / "cert.pem", "-noout", "-pubkey")


class ShortLived:
    """A CA that signs for seconds, with `openssl ca`: of the tools here only that sets a time of day."""

    def __init__(self, at, ca):
        self.at = pathlib.Path(at, "short")
        self.at.mkdir()
        (self.at / "index.txt").touch()
        (self.at / "openssl.cnf").write_text(CONFIGURATION.format(at=self.at, ca=ca))

    def script(self, seconds, age=0):
        """Commands of a shell that sign the request on standard input, from `age` seconds ago on. Each call has its own
        database."""
        return (f'd=$(mktemp -d {self.at}/XXXXXX) && sed "s,^database.*,database = $d/index.txt," {self.at}/openssl.cnf >$d/cnf\n'
                f': >$d/index.txt; cat >$d/csr\n'
                f'openssl ca -batch -notext -preserveDN -config $d/cnf -in $d/csr -startdate $(date -u -d "-{age} seconds" +%Y%m%d%H%M%SZ) '
                f'-enddate $(date -u -d "+{seconds} seconds" +%Y%m%d%H%M%SZ) 2>/dev/null')

    def put_into(self, folder, seconds, age=0):
        """A certificate for the folder's key and subject in place of its own."""
        run = lambda *words, text=None: subprocess.run(words, input=text, text=True, capture_output=True, check=True).stdout
        subject = run("openssl", "x509", "-in", folder / "cert.pem", "-noout", "-subject", "-nameopt", "compat").strip()
        request = run("openssl", "req", "-new", "-key", folder / "key.pem", "-subj", subject.removeprefix("subject="))
        (folder / "cert.pem").write_text(run("sh", "-c", self.script(seconds, age), text=request))


class Running:
    """The agent as a daemon, in a process group of its own."""

    def __init__(self, at, *words, **environment):
        self.process = subprocess.Popen([PROGRAM, "agent", *map(str, words)], cwd=at, text=True, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
                                        env={**os.environ, "LD_LIBRARY_PATH": library_path(), **environment})
        self.lines = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines += checked_events(line)

    def events(self, name):
        return [event for event in list(self.lines) if event["event"] == name]

    def wait_for(self, name, count=1, seconds=60):
        end = time.monotonic() + seconds
        while len(self.events(name)) < count:
            assert time.monotonic() < end and self.process.poll() is None, f"no {name}: {self.lines}"
            time.sleep(0.05)
        return self.events(name)[count - 1]

    def kill_session(self):
        """SIGKILL to the agent and everything that it started, each in a session of its own."""
        sessions, found = {self.process.pid}, {}
        for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
            try:
                fields = stat.read_text().rpartition(")")[2].split()
                found[int(stat.parent.name)] = int(fields[3])
                if int(fields[1]) == self.process.pid:
                    sessions.add(int(stat.parent.name))
            except (FileNotFoundError, ProcessLookupError):
                continue
        for process, session in found.items():
            if session in sessions or process in sessions:
                try:
                    os.kill(process, signal.SIGKILL)
                except ProcessLookupError:
                    continue

    def end(self, by=signal.SIGTERM):
        """The exit code."""
        if self.process.poll() is None:
            self.process.send_signal(by)
        code = self.process.wait(timeout=30)
        self._reader.join(timeout=30)
        self.process.stdout.close()
        self.process.stderr.close()
        return code

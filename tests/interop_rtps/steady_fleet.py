"""A fleet of steady peers (steady_peer.hpp) with documents of seconds, `ddssec agent`, and what all of them said."""

import collections
import concurrent.futures
import datetime
import hashlib
import json
import os
import pathlib
import queue
import secrets
import ssl
import subprocess
import tempfile
import threading
import time

from shapes_process import Namespace, check  # puts the folders of what follows in place
from pki import CA_CONFIGURATION

DOMAIN = 9
# Seconds that a certificate lasts, and permissions. The agent begins each certificate earlier by an eighth of its time.
LASTING = {"short": (48, 60), "long": (32, 40)}
START = 1.5        # the first certificates last this many times longer, until all processes have started
LOOKS = 1          # seconds between two looks at the files
USUAL, SLOWEST = 0.2, 2  # seconds of a command of ddssec; documents last longer where it takes longer, to this factor
ANSWER = 30.0      # seconds that a process on a loaded machine may need for an answer

RULE = """
        <topic_rule>
          <topic_expression>{topic}</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>{metadata}</metadata_protection_kind>
          <data_protection_kind>{data}</data_protection_kind>
        </topic_rule>"""
PERMISSIONS_XML = """<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <permissions>
    <grant name="{name}">
      <subject_name>CN={name}</subject_name>
      <validity><not_before>2026-01-01T00:00:00Z</not_before><not_after>{end}</not_after></validity>
      <allow_rule>
        <domains><id>{domain}</id></domains>
        <publish><topics>{publish}</topics></publish>
        <subscribe><topics>{subscribe}</topics></subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
"""


def in_utc(seconds, form="%Y-%m-%dT%H:%M:%SZ"):
    return datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc).strftime(form)


def replace_file(path, octets):
    part = path.with_name(path.name + ".part")
    part.write_bytes(octets)
    os.replace(part, path)


class Folders:
    """The CAs and the participants' folders that `ddssec init` makes, and what is written into them. `before`: words
    before each command that signs."""

    def __init__(self, build, at, names, topics, form, before=()):
        self.before = list(before)
        self.tool, self.at, self.names = build / "bin/ddssec", pathlib.Path(at), names
        self.topics, self.denied = list(topics), {}
        self.kinds = {"Raised": ("SIGN", "SIGN")}  # metadata and data; of the others NONE and ENCRYPT
        self.signing = threading.Lock()  # permissions are not signed while their CA is replaced
        self.pace, self.slowest = 1.0, 0.0  # seconds of the slowest command
        self.ddssec("init", "demo", "--domain", str(DOMAIN), "--profile", "balanced", "--dropin", str(build / "dropin"),
                    *(word for name in names for word in ("--participant", name)))
        for name in names:
            (self[name] / "security.properties").write_text(f"org.ddssec.files_poll_interval = {LOOKS}\n")
        text = (self.at / "demo/governance.xml").read_text()
        begin = text.index("<topic_rule>")
        self._frame = text[:begin], text[text.index("</topic_rule>") + len("</topic_rule>"):]
        self.put_governance(names)
        self.first_governance = (self[names[0]] / "governance.p7s").read_bytes()
        began = time.monotonic()
        for name in names:
            self.put_permissions(name, 3600)
        self.pace = min(SLOWEST, max(1.0, (time.monotonic() - began) / len(names) / USUAL))
        self.certificate, self.permissions = (int(seconds * self.pace) // 8 * 8 for seconds in LASTING[form])

    def __getitem__(self, name):
        return self.at / "demo" / name

    def ddssec(self, *words):
        began = time.monotonic()
        done = subprocess.run([*self.before, str(self.tool), *words], cwd=self.at, text=True, capture_output=True)
        self.slowest = max(self.slowest, time.monotonic() - began)
        check(f"ddssec {' '.join(words)}: {done.stdout}{done.stderr}", done.returncode == 0)
        return done.stdout

    def openssl(self, *words):
        done = subprocess.run([*self.before, "openssl", *map(str, words)], capture_output=True)
        check(f"openssl {words}: {done.stderr}", done.returncode == 0)
        return done.stdout

    def put_governance(self, names):
        """One rule for each topic."""
        xml = self.at / "demo/governance.xml"
        rules = []
        for topic in self.topics:
            metadata, data = self.kinds.get(topic, ("NONE", "ENCRYPT"))
            rules.append(RULE.format(topic=topic, metadata=metadata, data=data))
        xml.write_text(self._frame[0] + "".join(rules) + self._frame[1])
        self.ddssec("governance", "sign", "demo/governance.xml", "--ca", "demo", "--replace", "-q")
        for name in names:
            replace_file(self[name] / "governance.p7s", (self.at / "demo/governance.p7s").read_bytes())

    def put_permissions(self, name, seconds=0):
        xml = self.at / f"{name}.permissions.xml"
        topics = {kind: "".join(f"<topic>{topic}</topic>" for topic in self.topics
                                if (kind, topic) != self.denied.get(name)) for kind in ("publish", "subscribe")}
        end = in_utc(time.time() + (seconds or self.permissions))
        xml.write_text(PERMISSIONS_XML.format(name=name, domain=DOMAIN, end=end, **topics))
        self.ddssec("permissions", "sign", str(xml), "--ca", "demo", "-o", str(self[name] / "permissions.p7s"),
                    "--replace", "-q")

    def distribute(self, names):
        """The list of what was renewed."""
        self.ddssec("crl", "distribute", *(f"demo/{name}" for name in names), "--ca", "demo", "-q")

    def put_certificate(self, name, seconds):
        """A certificate of seconds, which no command of ddssec issues by itself, and its line in the CA's log. Returns
        its end."""
        ca, folder, at = self.at / "demo/ca/identity", self[name], pathlib.Path(tempfile.mkdtemp(dir=self.at))
        serial = f"40{secrets.token_hex(15)}".upper()
        (at / "index.txt").touch()
        (at / "serial").write_text(serial + "\n")
        text = CA_CONFIGURATION.format(folder=at).replace(f"{at}/cert.pem", f"{ca}/ca.pem")
        (at / "openssl.cnf").write_text(text.replace(f"{at}/key.pem", f"{ca}/ca.key.pem"))
        begin, end = (int(time.time()) + offset for offset in (-seconds // 8, seconds))
        self.openssl("req", "-new", "-key", folder / "key.pem", "-subj", f"/CN={name}", "-out", at / "csr")
        self.openssl("ca", "-batch", "-notext", "-config", at / "openssl.cnf", "-in", at / "csr", "-out", at / "cert.pem",
                     "-startdate", in_utc(begin, "%Y%m%d%H%M%SZ"), "-enddate", in_utc(end, "%Y%m%d%H%M%SZ"))
        key = self.openssl("pkey", "-in", folder / "key.pem", "-pubout", "-outform", "DER")
        pem = (at / "cert.pem").read_text()
        line = {"event": "issued", "time": in_utc(time.time()), "serial": serial, "subject": f"CN={name}",
                "not_after": in_utc(end), "sha256": hashlib.sha256(ssl.PEM_cert_to_DER_cert(pem)).hexdigest(),
                "key": hashlib.sha256(key).hexdigest(), "folder": str(folder)}
        with open(ca / "issued.jsonl", "a", encoding="utf-8") as log:
            log.write(json.dumps(line, separators=(",", ":")) + "\n")
        replace_file(folder / "cert.pem", pem.encode())
        return end

    def put_certificates(self, names, seconds):
        """The end of each."""
        with concurrent.futures.ThreadPoolExecutor(max_workers=4) as pool:
            return dict(zip(names, pool.map(lambda name: self.put_certificate(name, seconds), names)))


class PermissionsRenewer(threading.Thread):
    """Signs permissions anew for each participant at half of their time."""

    def __init__(self, folders, names):
        super().__init__(daemon=True)
        self.folders, self.names, self.ended, self.fault = folders, names, threading.Event(), None
        self.start()

    def run(self):
        try:
            while not self.ended.is_set():
                with self.folders.signing:
                    for name in self.names:
                        self.folders.put_permissions(name)
                    self.folders.distribute(self.names)
                self.ended.wait(self.folders.permissions / 2)
        except AssertionError as fault:
            self.fault = str(fault)

    def close(self):
        self.ended.set()
        self.join()


class Peer:
    """One process."""

    def __init__(self, build, space, folders, name):
        self.name, self.is_embedded, self.folder = name, name.startswith("e"), folders[name]
        self.events_file, self.errors = folders.at / f"{name}.events", open(folders.at / f"{name}.stderr", "wb")
        settings = {**os.environ, "DDSSEC_EVENT_LOG": str(self.events_file),
                    "CYCLONEDDS_URI": f"file://{self.folder}/cyclonedds.xml",
                    "DDSSEC_PROPERTIES": str(self.folder / "security.properties")}
        program = "steady_embedded" if self.is_embedded else "steady_cyclone"
        command = [str(build / "bin" / program), name, str(DOMAIN)]
        self.process = subprocess.Popen(space.enter(command + ([str(self.folder)] if self.is_embedded else [])),
                                        text=True, env=settings, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=self.errors)
        self._lines = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            self._lines.put(line)
        self._lines.put(None)

    def answer(self):
        try:
            line = self._lines.get(timeout=ANSWER)
        except queue.Empty:
            line = None
        check(f"{self.name} does not answer; code {self.process.poll()}: {self.last_words()}", line is not None)
        return json.loads(line)

    def ask(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        return self.answer()

    def last_words(self):
        return (self.folder.parent.parent / f"{self.name}.stderr").read_text(errors="replace")[-1500:]

    def events(self, name=None, after=0.0):
        """Those of that name that were raised after that time."""
        out = []
        for line in self.events_file.read_text(errors="replace").splitlines() if self.events_file.exists() else []:
            try:
                event = json.loads(line)
            except json.JSONDecodeError:
                continue  # its end is still to come
            at = datetime.datetime.strptime(event["time"], "%Y-%m-%dT%H:%M:%S.%fZ")
            event["at"] = at.replace(tzinfo=datetime.timezone.utc).timestamp()
            if event["at"] >= after and name in (None, event["name"]):
                out.append(event)
        return out

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self._reader.join()
        self.process.stdin.close()
        self.process.stdout.close()
        self.errors.close()


class Agent:
    """`ddssec agent`, which may be killed and begins anew."""

    def __init__(self, folders, names):
        self.folders, self.names, self.events, self.killed = folders, names, [], 0
        self.start()

    def start(self):
        words = ["agent", *(str(self.folders[name]) for name in self.names), "--ca", "demo"]
        self.process = subprocess.Popen([str(self.folders.tool), *words], cwd=self.folders.at, text=True,
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self._reader = threading.Thread(target=self._read, args=(self.process,), daemon=True)
        self._reader.start()

    def _read(self, process):
        for line in process.stdout:
            try:
                self.events.append(json.loads(line))
            except json.JSONDecodeError:
                pass  # cut off by a kill

    def count(self, event):
        return sum(one["event"] == event for one in list(self.events))

    def log(self):
        return [f"{one['time']} agent: {one['event']} {one.get('folder', '')[-2:]} {one.get('code', '')}"
                for one in list(self.events)]

    def failures(self):
        return collections.Counter(one["code"] for one in list(self.events) if one["event"] == "failed")

    def kill_and_start(self):
        """kill -9 by its process id, in the middle of its work: as soon as it has renewed one more certificate."""
        renewed, end = self.count("renewed"), time.monotonic() + self.folders.certificate + ANSWER
        while self.count("renewed") == renewed:
            check(f"the agent renews nothing: {self.events[-5:]}", time.monotonic() < end)
            time.sleep(0.01)
        self.close()
        self.killed += 1
        self.start()

    def close(self):
        self.process.kill()
        self.process.wait()
        self._reader.join()
        self.process.stdout.close()


__all__ = ["Agent", "Folders", "LOOKS", "Namespace", "Peer", "PermissionsRenewer", "START", "check", "replace_file"]

#!/usr/bin/env python3
"""Certificates and permissions of seconds are renewed while their participants run, in the embedded
participant and in Cyclone DDS with our plugins, also beside stock plugins; in one case with a new key each time. Prints
how long nothing came at each former end. The cases "measure" run only on request.
Usage: renewal_test.py BUILD [FILTER]"""

import datetime
import os
import pathlib
import re
import shutil
import subprocess
import sys
import threading
import time

sys.dont_write_bytecode = True
from shapes_process import SAMPLE, Namespace, check  # puts the folders of what follows in place
import story_cases
from documents import Governance, Permissions
from pki import Pki

DOMAIN = 9
TOPIC = "Square"
CERTIFICATE, PERMISSIONS = 25, 30  # seconds that each is valid
RENEWED = (14, 38)                 # seconds after the first documents
LOOKS = 1                          # seconds between two looks at the files
WATCHED = 72                       # seconds
GAP = 12.0                         # seconds without a sample that a loaded machine may need
LATE = 4.0                         # seconds after an end until a participant is cut off
LIBRARIES = {"Authentication": ("auth", "authentication"), "AccessControl": ("ac", "access_control"),
             "Cryptographic": ("crypto", "crypto")}
EVERYTHING = Governance(discovery="ENCRYPT", liveliness="ENCRYPT", rtps="SIGN", metadata="NONE", data="ENCRYPT")


class Documents:
    """The folder of one participant, with documents of seconds."""

    def __init__(self, pki, name):
        self.pki, self.name = pki, name
        self.folder = pathlib.Path(pki.folder, "participant-" + name)
        self.folder.mkdir()
        self.identity, self.authority = pki.ca("identity", "ec"), pki.ca("permissions", "ec")
        self.signer = f"{self.authority}/cert.pem", f"{self.authority}/key.pem"
        self.rekeys, self.keys = False, 1
        self.began = time.time()
        for document, source in {"identity_ca.pem": f"{self.identity}/cert.pem", "key.pem": pki.key(name, "ec"),
                                 "permissions_ca.pem": self.signer[0],
                                 "governance.p7s": pki.sign(EVERYTHING.xml(), *self.signer)}.items():
            shutil.copy(source, self.folder / document)
        self.put(0)
        (self.folder / "security.properties").write_text(f"org.ddssec.files_poll_interval = {LOOKS}\n")

    def put(self, after, certificate=CERTIFICATE, permissions=PERMISSIONS):
        """Documents that are valid for so long after `after`, counted from the first ones; with another key, if
        `rekeys`."""
        def end(seconds):
            return datetime.datetime.fromtimestamp(self.began + after + seconds, datetime.timezone.utc)
        new, key = {}, None
        if self.rekeys:
            self.keys += 1
            new["key.pem"] = key = self.pki.key(f"{self.name}-{self.keys}", "ec")
        document = Permissions((TOPIC,), (TOPIC,), "", DOMAIN, not_after=f"{end(permissions):%Y-%m-%dT%H:%M:%S}")
        new["cert.pem"] = self.pki.leaf(self.name, "ec", self.identity, until=end(certificate), key=key)
        new["permissions.p7s"] = self.pki.sign(document.xml(self.name), *self.signer)
        for file, source in new.items():
            shutil.copy(source, self.folder / (file + ".new"))
        for file in new:
            os.replace(self.folder / (file + ".new"), self.folder / file)

    def cyclone(self, build, stock):
        """The environment of a Cyclone DDS with these documents."""
        at = self.folder
        files = {"Authentication": (("IdentityCertificate", "cert.pem"), ("IdentityCA", "identity_ca.pem"),
                                    ("PrivateKey", "key.pem")),
                 "AccessControl": (("PermissionsCA", "permissions_ca.pem"), ("Governance", "governance.p7s"),
                                   ("Permissions", "permissions.p7s")), "Cryptographic": ()}
        text = ""
        for part, (short, function) in LIBRARIES.items():
            path = f"dds_security_{short}" if stock else f"{build}/dropin/libdds_security_{short}.so"
            text += (f'<{part}><Library path="{path}" initFunction="init_{function}" '
                     f'finalizeFunction="finalize_{function}"/>')
            text += "".join(f"<{name}>file:{at}/{file}</{name}>" for name, file in files[part]) + f"</{part}>"
        (at / "cyclone.xml").write_text(f'<CycloneDDS><Domain id="any"><Security>{text}</Security></Domain></CycloneDDS>')
        return [f"CYCLONEDDS_URI=file://{at}/cyclone.xml", f"DDSSEC_PROPERTIES={at}/security.properties",
                f"DDSSEC_EVENT_LOG={at}/events"]


class Process:
    """A shapes program; every line with the time at which it came, counted from the first documents."""

    def __init__(self, space, command, began):
        self.lines, self.began = [], began
        self.process = subprocess.Popen(space.enter(command), text=True, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.append((time.time() - self.began, line.rstrip("\n")))

    def samples(self):
        """(time, number) of each."""
        return [(at, int(found[5])) for at, line in list(self.lines) if (found := SAMPLE.match(line))]

    def close(self):
        self.process.kill()
        self.process.wait()
        self._reader.join()
        self.process.stdout.close()


def command(build, documents, kind, publishes, reliable):
    programs = build / "bin"
    if kind == "embedded":
        # The type of shapes_cyclone: with stock plugins, Cyclone DDS matches no other.
        words = "--final "
        words += "-P -k 0 -z 0 --write-period 33 -v d" if publishes else "-S -k 0 -v d"
        words += "" if reliable else " -b"
        return [str(programs / "ddssec-shapes"), *words.split(), "-d", str(DOMAIN), "--security", str(documents.folder)]
    return ["env", *documents.cyclone(build, kind == "stock"), str(programs / "shapes_cyclone"),
            "-P" if publishes else "-S", str(DOMAIN), TOPIC, "all"]


def said(documents, process, code):
    """Whether it raised that event, which is a word of its sentence or of the event file."""
    events = documents.folder / "events"
    text = events.read_text() if events.exists() else ""
    return re.search(code, text + "\n".join(line for _, line in process.lines))


def gaps(samples):
    """(begin, seconds, samples that never came) of each interruption."""
    out = []
    for (before, first), (after, second) in zip(samples, samples[1:]):
        if after - before > 0.5 or second - first > 1:
            out.append((before, after - before, max(0, second - first - 1)))
    return out


class Story:
    """`lasting`: which of the two have documents that do not end. `first`: how many seconds the first certificate and
    permissions of the others last."""

    def __init__(self, build, folder, publisher, subscriber, reliable, lasting, first=(CERTIFICATE, PERMISSIONS)):
        pki = Pki(folder)
        self.space, self.processes = Namespace(), []
        for kind in ("identity", "permissions"):
            pki.ca(kind, "ec")
        for name in ("pub", "sub"):
            pki.key(name, "ec")
        self.documents = [Documents(pki, name) for name in ("pub", "sub")]
        self.began = self.documents[0].began
        for i, documents in enumerate(self.documents):
            documents.put(0, *((3600, 3600) if i in lasting else first))
        for documents, kind, publishes in zip(self.documents, (publisher, subscriber), (True, False)):
            self.processes.append(Process(self.space, command(build, documents, kind, publishes, reliable), self.began))
        self.publisher, self.subscriber = self.processes

    def wait_until(self, seconds):
        time.sleep(max(0.0, self.began + seconds - time.time()))

    def talks_before(self, seconds):
        while not self.subscriber.samples():
            check(f"no sample: {[p.lines[-3:] for p in self.processes]}", time.time() < self.began + seconds)
            time.sleep(0.1)

    def close(self):
        for process in self.processes:
            process.close()
        self.space.close()


def renewed_twice(story, whose, strict):
    """`strict`: what must be so; else it is only measured."""
    story.talks_before(CERTIFICATE - 5)
    for i, at in enumerate(RENEWED):
        story.wait_until(at)
        for documents in whose:
            documents.put(*((CERTIFICATE, CERTIFICATE, PERMISSIONS) if i == 0 else (0, 3600, 3600)))
    story.wait_until(WATCHED)
    samples = story.subscriber.samples()
    found = gaps(samples)
    note = "; ".join(f"at {at:.1f} s: {seconds:.1f} s, {lost} lost" for at, seconds, lost in found)
    note = f"{len(samples)} samples, last at {samples[-1][0]:.1f} s; {note or 'no gap'}"
    if strict:
        check(f"it does not talk any more: {note}", samples[-1][0] > WATCHED - 3)
        # Between two embedded participants the session goes on.
        check(f"too long: {note}", all(seconds < GAP for _, seconds, _ in found) if strict != "gapless" else not found)
        check(f"out of order or twice: {note}", all(a < b for (_, a), (_, b) in zip(samples, samples[1:])))
    return note


def not_renewed(story, ended, process):
    story.talks_before(CERTIFICATE - 5)
    story.wait_until(CERTIFICATE + LATE + 5)
    last = story.subscriber.samples()[-1][0]
    check(f"cut off at {last:.1f} s", last < CERTIFICATE + LATE)
    check("no reason", said(ended, process, "identity_ended|a certificate in use has expired"))
    return f"cut off at {last:.1f} s"


def cases():
    for publisher, subscriber in (("embedded", "embedded"), ("ddssec", "ddssec"), ("ddssec", "embedded"),
                                  ("embedded", "ddssec")):
        yield f"renewed/{publisher}/{subscriber}", publisher, subscriber, True, "both"
    # Documents of the stock side do not end: it does not read them again.
    yield "renewed/embedded/stock", "embedded", "stock", True, "both"
    yield "renewed/stock/embedded", "stock", "embedded", True, "both"
    yield "renewed/best_effort/embedded/embedded", "embedded", "embedded", False, "both"
    yield "rekeyed/embedded/embedded", "embedded", "embedded", True, "rekeyed"
    yield "ends/embedded/embedded", "embedded", "embedded", True, "none"
    yield "ends/ddssec/ddssec", "ddssec", "ddssec", True, "none"
    yield "measure/ddssec/stock", "ddssec", "stock", True, "measure"
    yield "measure/stock/ddssec", "stock", "ddssec", True, "measure"


def lasting(case):
    """Those whose documents do not end: in the cases "none" the subscriber's, else those of stock plugins."""
    _, publisher, subscriber, _, what = case
    return (1,) if what == "none" else tuple(i for i, kind in enumerate((publisher, subscriber)) if kind == "stock")


def begin(build, folder, case):
    _, publisher, subscriber, reliable, _ = case
    return Story(build, folder, publisher, subscriber, reliable, lasting(case))


def check_events(story, whose, strict):
    for i in whose:
        documents, process = story.documents[i], story.processes[i]
        codes = ["identity_renewed|presents a renewed certificate", "permissions_renewed|renewed permissions of this participant"]
        codes += ["peer_identity_renewed", "peer_permissions_renewed"] if strict == "gapless" else []
        for code in codes:
            check(f"{documents.name} never said {code}", said(documents, process, code))
        if strict == "gapless":
            check(f"{documents.name} ended a session", not said(documents, process, "session_outlived|identity_ended"))


def play(story, case):
    _, publisher, subscriber, reliable, what = case
    if what == "none":
        return not_renewed(story, story.documents[0], story.publisher)
    whose = [i for i in (0, 1) if i not in lasting(case)]
    strict = "gapless" if (publisher, subscriber) == ("embedded", "embedded") and reliable else what == "both"
    for i in whose:
        story.documents[i].rekeys = what == "rekeyed"
    note = renewed_twice(story, [story.documents[i] for i in whose], strict)
    if what != "measure":
        check_events(story, whose, strict)
    return note + (f"; {story.documents[0].keys} keys each" if what == "rekeyed" else "")


def chosen():
    """Without a filter all but the cases that only measure."""
    return [case for case in cases() if any(sys.argv[2:]) or not case[0].startswith("measure")]


if __name__ == "__main__":
    sys.exit(story_cases.run(chosen(), begin, play, at_once=10))

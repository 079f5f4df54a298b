#!/usr/bin/env python3
"""Participants report 30, 7 and 1 days before the end of their certificate, permissions, revocation list or CA, each
once: the embedded participant, and Cyclone DDS with our plugins. Their calendars are set forward.
Usage: ends_soon_test.py BUILD [FILTER]"""

import datetime
import json
import pathlib
import shutil
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from shapes_process import Namespace, check  # puts the folders of what follows in place
import story_cases
from documents import Permissions
from pki import CA_EXTENSIONS, ORGANIZATION, Pki, subject
from renewal_test import DOMAIN, TOPIC, Documents, Process, command

FAKETIME = next(pathlib.Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"), None)
AGE, LEFT = 100, 31  # days since the documents began, and until they end
# The days by which the calendar is set forward, and the time left that the event then names.
STEPS = ((1, "in 29 days"), (24, "in 6 days"), (30, "in 23 hours"))
NAMES = {"own": ("identity_ends_soon", "permissions_end_soon", "crl_ends_soon"),
         "ca": ("identity_ends_soon", "permissions_end_soon")}
PATIENCE = 40.0      # seconds
AFTERWARDS = 12.0    # seconds in which nothing may be said again; an equal event within 10 s is not passed on


def openssl(*words):
    done = subprocess.run(["openssl", *words], capture_output=True, text=True, check=False)
    check(f"openssl {' '.join(words)}: {done.stderr}", done.returncode == 0)


def date(days):
    return datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(days=days)


def span(begin, end):
    return "-startdate", f"{date(begin):%Y%m%d%H%M%SZ}", "-enddate", f"{date(end):%Y%m%d%H%M%SZ}"


def shorten(authority):
    """Gives a CA, which has signed nothing yet, a certificate that ends soon."""
    extensions, request = f"{authority}/short.extensions", f"{authority}/short.csr"
    pathlib.Path(extensions).write_text("\n".join(CA_EXTENSIONS) + "\n", encoding="ascii")
    name = pathlib.Path(authority).name
    openssl("req", "-new", "-key", f"{authority}/key.pem", "-subj", f"/O={ORGANIZATION}/CN={name}", "-out", request)
    openssl("ca", "-batch", "-notext", "-selfsign", "-config", f"{authority}/openssl.cnf", *span(-AGE, LEFT),
            "-extfile", extensions, "-in", request, "-out", f"{authority}/short.pem")
    shutil.move(f"{authority}/short.pem", f"{authority}/cert.pem")


class EndingDocuments(Documents):
    """`what`: the documents of the participant ("own"), or its CAs ("ca"), end in LEFT days."""

    def __init__(self, pki, name, what):
        super().__init__(pki, name)
        left, config = (LEFT if what == "own" else 300), f"{self.identity}/openssl.cnf"
        request, certificate = self.folder / "request.csr", self.folder / "cert.pem"
        openssl("req", "-new", "-key", pki.key(name, "ec"), "-subj", f"/O={ORGANIZATION}/CN={name}", "-out", str(request))
        openssl("ca", "-batch", "-notext", "-config", config, *span(-AGE, left), "-in", str(request), "-out", str(certificate))
        openssl("ca", "-config", config, "-gencrl", "-crl_lastupdate", f"{date(-AGE):%Y%m%d%H%M%SZ}", "-crl_nextupdate",
                f"{date(left):%Y%m%d%H%M%SZ}", "-out", str(self.folder / "crl.pem"))
        text = Permissions((TOPIC,), (TOPIC,), "", DOMAIN, not_before=f"{date(-AGE):%Y-%m-%dT%H:%M:%S}",
                           not_after=f"{date(left):%Y-%m-%dT%H:%M:%S}")
        shutil.copy(pki.sign(text.xml(name), *self.signer), self.folder / "permissions.p7s")
        with (self.folder / "security.properties").open("a", encoding="ascii") as properties:
            properties.write("org.ddssec.clock_step_grace = 3\n")

    def events(self):
        log = self.folder / "events"
        return [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()] if log.exists() else []


class Ending:
    """Two participants of one kind, and the calendar of both."""

    def __init__(self, build, folder, kind, what):
        pki = Pki(folder)
        self.space, self.processes, self.what = Namespace(), [], what
        if what == "ca":
            for role in ("identity", "permissions"):
                shorten(pki.ca(role, "ec"))
        self.documents = [EndingDocuments(pki, name, what) for name in ("pub", "sub")]
        self.calendar = pathlib.Path(folder, "calendar")
        self.set(0)
        began = time.time()
        for documents, publishes in zip(self.documents, (True, False)):
            words = command(build, documents, kind, publishes, True)
            variables = [f"LD_PRELOAD={FAKETIME}", f"FAKETIME_TIMESTAMP_FILE={self.calendar}", "FAKETIME_NO_CACHE=1",
                         "FAKETIME_DONT_FAKE_MONOTONIC=1", "DONT_FAKE_MONOTONIC=1",
                         f"DDSSEC_EVENT_LOG={documents.folder}/events"]
            self.processes.append(Process(self.space, ["env", *variables, *words], began))

    def set(self, days):
        new = self.calendar.with_suffix(".new")
        new.write_text(f"+{days}d\n", encoding="ascii")
        new.replace(self.calendar)

    def said(self):
        """How often each participant has said each of the events."""
        return [[sum(event["name"] == name for event in documents.events()) for name in NAMES[self.what]]
                for documents in self.documents]

    def until(self, what, is_so):
        end = time.monotonic() + PATIENCE
        while not is_so():
            check(f"{what} did not happen: {self.said()}", time.monotonic() < end)
            time.sleep(0.1)

    def close(self):
        for process in self.processes:
            process.close()
        self.space.close()


def each_once(story):
    names = NAMES[story.what]
    subscriber = story.processes[1]
    story.until("the first samples", subscriber.samples)
    time.sleep(AFTERWARDS)
    check(f"said more than {STEPS[0][0]} days too early: {story.said()}", story.said() == [[0] * len(names)] * 2)
    for count, (days, words) in enumerate(STEPS, 1):
        story.set(days)
        story.until(f"the events of {words}", lambda count=count: min(map(min, story.said())) >= count)
        time.sleep(AFTERWARDS)
        check(f"{words}: not once each: {story.said()}", story.said() == [[count] * len(names)] * 2)
        for documents in story.documents:
            last = {event["name"]: event for event in documents.events()}
            for name in names:
                check(f"{last[name]}", words in last[name]["sentence"] and last[name]["severity"] == "warning")
            whose = subject(documents.name) if story.what == "own" else "CN=ca-identity-ec"
            check(last["identity_ends_soon"]["sentence"], whose.split(",")[0] in last["identity_ends_soon"]["sentence"])
    before = len(subscriber.samples())
    story.until("a sample at the end", lambda: len(subscriber.samples()) > before)
    return f"{len(STEPS)} times {', '.join(names)} of each"


def cases():
    for kind in ("embedded", "ddssec"):
        for what in NAMES:
            yield f"{what}/{kind}", kind, what


def begin(build, folder, case):
    return Ending(build, folder, *case[1:])


def play(story, _):
    return each_once(story)


if __name__ == "__main__":
    check("libfaketime is not installed (scripts/bootstrap.sh --dev)", FAKETIME)
    sys.exit(story_cases.run(cases(), begin, play, at_once=4))

#!/usr/bin/env python3
"""What `ddssec permissions diff` predicts for a running participant happens when it gets the document: it takes the
permissions at once or when they begin, refuses them, or needs a restart. A Cyclone DDS on ddssec's plugins also refuses
the governance documents for which `ddssec governance diff` predicts a restart.
Usage: permissions_forecast_test.py BUILD [FILTER]"""

import dataclasses
import datetime
import json
import os
import shutil
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from shapes_process import check  # puts the folders of what follows in place
import story_cases
from documents import Permissions
from renewal_test import DOMAIN, EVERYTHING, TOPIC, Process, Story, command, said

BEFORE = 25     # seconds until samples flow, at most
ENDING = 30     # seconds until the permissions of the case "restart" end
LATER = 15      # seconds until those of the case "later" begin
CHANGES = 15.0  # seconds in which a change must show on a loaded machine
SILENCE = 3.0   # seconds without a sample, of which there are 30 a second
WATCHED = 10.0  # seconds in which samples must not come back
HOSTS = {"embedded": "embedded", "ddssec": "cyclonedds_ddssec"}  # the members of JSON


class Predicted(Story):
    """The permissions of the publisher change."""

    def __init__(self, build, folder, host, lasting, first):
        super().__init__(build, folder, host, host, True, lasting, first)
        self.build, self.host, self.mine = build, host, self.documents[0]

    def put(self, topics, predicted, **times):
        """Puts permissions for these topics into the publisher's folder, if that is predicted for them."""
        text = Permissions(topics, topics, "", DOMAIN, **times)
        result = self.replace("permissions", text.xml(self.mine.name))
        word = result["takes_effect"][HOSTS[self.host]]
        check(f"permissions diff predicts {word!r}, not {predicted!r}: {result}", word == predicted)

    def replace(self, kind, text):
        """Puts the document into the publisher's folder, and returns what `ddssec diff` said of it before."""
        new, place = self.mine.pki.sign(text, *self.mine.signer), self.mine.folder / f"{kind}.p7s"
        done = subprocess.run([self.build / "bin/ddssec", kind, "diff", place, new, "--format", "json"],
                              capture_output=True, text=True, check=False)
        shutil.copy(new, self.mine.folder / "new")
        os.replace(self.mine.folder / "new", place)
        return json.loads(done.stdout)["result"]

    def now(self):
        return time.time() - self.began

    def last(self):
        return self.subscriber.samples()[-1][0]

    def flows(self, what):
        since = self.now()
        while self.last() <= since:
            check(f"no sample {what}", self.now() < since + CHANGES)
            time.sleep(0.1)

    def falls_silent(self, what):
        since = self.now()
        while self.now() - self.last() < SILENCE:
            check(f"samples {what}", self.now() < since + CHANGES)
            time.sleep(0.1)

    def refusals(self):
        """The sentences of refused governance documents."""
        log = self.mine.folder / "events"
        events = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
        return [event["sentence"] for event in events if event["name"] == "governance_renewal_refused"]

    def says(self, name):
        end = self.now() + CHANGES
        while not said(self.mine, self.publisher, name):
            check(f"never said {name}", self.now() < end)
            time.sleep(0.1)


def live(story):
    story.talks_before(BEFORE)
    story.put(("Other",), "live", not_after="2036-01-01T00:00:00")
    story.falls_silent("after the right was taken away")
    story.put((TOPIC,), "live", not_after="2037-01-01T00:00:00")
    story.flows("after the right was given again")


def later(story):
    story.talks_before(BEFORE)
    begins = datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(seconds=LATER)
    at = story.now() + LATER
    story.put(("Other",), "live when it begins", not_before=f"{begins:%Y-%m-%dT%H:%M:%S}", not_after="2036-01-01T00:00:00")
    story.wait_until(at - 2)
    story.flows("before the new permissions begin")
    story.wait_until(at)
    story.falls_silent("after permissions without that right have begun")


def refused(story):
    story.talks_before(BEFORE)
    story.put(("Other",), "refused", not_before="2019-01-01T00:00:00", not_after="2036-01-01T00:00:00")
    story.says("permissions_renewal_refused")
    story.flows("after permissions were refused")


def restart(story):
    story.talks_before(ENDING - 5)
    story.wait_until(ENDING)
    story.falls_silent("after the permissions have ended")
    story.put((TOPIC,), "restart", not_after="2036-01-01T00:00:00")
    since = story.now()
    time.sleep(WATCHED)
    check("samples without a restart", story.last() < since)
    story.publisher.close()
    story.publisher = story.processes[0] = Process(story.space, command(story.build, story.mine, story.host, True, True),
                                                   story.began)
    story.flows("after the restart")


def sessions_begin_again(story):
    story.talks_before(BEFORE)
    story.put((TOPIC,), "live", not_after="2036-01-01T00:00:00")
    story.says("permissions_renewed")
    story.flows("after permissions with the same rights")
    story.put(("Other",), "live, sessions begin again", not_after="2035-01-01T00:00:00")
    story.falls_silent("after the right was taken away")
    story.says("own_rights_lost")


def governance_of_cyclone(story):
    """Endpoints that exist cannot get other protection there."""
    story.talks_before(BEFORE)
    former = story.mine.folder / "governance.p7s"
    present = former.read_bytes()
    for predicted, changed in (("restart", dataclasses.replace(EVERYTHING, rtps="ENCRYPT")),
                               ("live unless in use", dataclasses.replace(EVERYTHING, metadata="ENCRYPT"))):
        began = story.refusals()
        result = story.replace("governance", changed.xml().replace("?>\n", '?>\n<?ddssec revision="1"?>\n', 1))
        word = result["live"]["cyclonedds"]
        check(f"governance diff predicts {word!r}, not {predicted!r}: {result}", word == predicted)
        end = story.now() + CHANGES
        while story.refusals() == began:
            check(f"the document was not refused: {predicted}", story.now() < end)
            time.sleep(0.1)
        check("the event does not say what must restart", "restart the participant" in story.refusals()[-1])
        story.flows("after the governance was refused")
        (story.mine.folder / "former").write_bytes(present)
        os.replace(story.mine.folder / "former", former)
        time.sleep(2.5)  # looked at twice: the next refusal is another one


def cases():
    for what in (live, later, refused, restart):
        yield what.__name__, what, "embedded"
    for what in (sessions_begin_again, later, refused, restart, governance_of_cyclone):
        yield f"{what.__name__}/ddssec", what, "ddssec"


def begin(build, folder, case):
    ends = case[1] is restart
    return Predicted(build, folder, case[2], (1,) if ends else (0, 1), (3600, ENDING))


def play(story, case):
    case[1](story)
    return ""


if __name__ == "__main__":
    sys.exit(story_cases.run(cases(), begin, play, at_once=9))

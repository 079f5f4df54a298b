#!/usr/bin/env python3
"""What `ddssec permissions diff` predicts for a running embedded participant happens when it gets the document: it takes
the permissions at once or when they begin, refuses them, or needs a restart.
Usage: permissions_forecast_test.py BUILD [FILTER]"""

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
from renewal_test import DOMAIN, TOPIC, Process, Story, command, said

BEFORE = 25     # seconds until samples flow, at most
ENDING = 30     # seconds until the permissions of the case "restart" end
LATER = 15      # seconds until those of the case "later" begin
CHANGES = 15.0  # seconds in which a change must show on a loaded machine
SILENCE = 3.0   # seconds without a sample, of which there are 30 a second
WATCHED = 10.0  # seconds in which samples must not come back


class Predicted(Story):
    """The permissions of the publisher change."""

    def __init__(self, build, folder, lasting, first):
        super().__init__(build, folder, "embedded", "embedded", True, lasting, first)
        self.build, self.mine = build, self.documents[0]

    def put(self, topics, predicted, **times):
        """Puts permissions for these topics into the publisher's folder, if that is predicted for them."""
        text = Permissions(topics, topics, "", DOMAIN, **times)
        new = self.mine.pki.sign(text.xml(self.mine.name), *self.mine.signer)
        place = self.mine.folder / "permissions.p7s"
        done = subprocess.run([self.build / "bin/ddssec", "permissions", "diff", place, new, "--format", "json"],
                              capture_output=True, text=True, check=False)
        word = json.loads(done.stdout)["result"]["takes_effect"]["embedded"]
        check(f"permissions diff predicts {word!r}, not {predicted!r}: {done.stdout}", word == predicted)
        shutil.copy(new, self.mine.folder / "permissions.new")
        os.replace(self.mine.folder / "permissions.new", place)

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
    story.publisher = story.processes[0] = Process(story.space, command(story.build, story.mine, "embedded", True, True),
                                                   story.began)
    story.flows("after the restart")


def cases():
    for what in (live, later, refused, restart):
        yield what.__name__, what


def begin(build, folder, case):
    ends = case[1] is restart
    return Predicted(build, folder, (1,) if ends else (0, 1), (3600, ENDING))


def play(story, case):
    case[1](story)
    return ""


if __name__ == "__main__":
    sys.exit(story_cases.run(cases(), begin, play, at_once=4))

#!/usr/bin/env python3
"""A running participant gets permissions with fewer rights: the matches that they no longer allow end. Equal and wider
rights end nothing. In Cyclone DDS with our plugins, with peers of the same kind and embedded ones.
Usage: rights_test.py BUILD [FILTER]"""

import json
import os
import shutil
import sys
import time

sys.dont_write_bytecode = True
from shapes_process import check  # puts the folders of what follows in place
from documents import Permissions
from processors import IDLE, idle_share, processor_time
import story_cases
from renewal_test import DOMAIN, TOPIC, Story

BEFORE = 25     # seconds until samples flow, at most
AT_ONCE = 2.0   # seconds until what was taken away has ended
LATE = 4.0      # and what a machine that is not idle in these seconds may need beyond that
WATCHED = 8.0   # seconds without a sample that comes back


def put(documents, publish, subscribe, year):
    """Permissions with these topics, which end in that year."""
    text = Permissions(publish, subscribe, "", DOMAIN, not_after=f"{year}-01-01T00:00:00")
    signed = documents.pki.sign(text.xml(documents.name), *documents.signer)
    shutil.copy(signed, documents.folder / "permissions.new")
    os.replace(documents.folder / "permissions.new", documents.folder / "permissions.p7s")
    return time.time() - documents.began


def events(documents, name):
    log = documents.folder / "events"
    lines = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    return [event for event in lines if event["name"] == name]


def flows(story, since):
    """Seconds of the longest pause since then."""
    times = [since, *(at for at, _ in story.subscriber.samples() if at > since), time.time() - story.began]
    return max(b - a for a, b in zip(times, times[1:]))


def taken_away(story, narrowed, embedded):
    """From the publisher (0) or the subscriber (1)."""
    story.talks_before(BEFORE)
    mine = story.documents[narrowed]
    allowed = ((TOPIC,), ("Other",)) if narrowed == 0 else (("Other",), (TOPIC,))
    at = put(mine, (TOPIC,), (TOPIC,), 2036)                   # the same rights
    time.sleep(1.2)
    put(mine, (TOPIC, "More"), (TOPIC, "More"), 2036)          # wider ones
    time.sleep(1.2)
    put(mine, *allowed, 2035)                                  # fewer, but none of an endpoint
    time.sleep(2.5 + LATE / 2)
    pause = flows(story, at)
    check(f"a pause of {pause:.1f} s although no endpoint lost a right", pause < 1.0 + LATE / 2)
    check(f"{events(mine, 'own_rights_lost')}", not events(mine, "own_rights_lost"))
    at, before = put(mine, ("Other",), ("Other",), 2034), processor_time()
    time.sleep(AT_ONCE + LATE)
    idle = idle_share(before)
    time.sleep(WATCHED)
    last = story.subscriber.samples()[-1][0] - at
    limit = AT_ONCE + (0 if idle > IDLE else LATE)
    check(f"samples for {last:.1f} s after the right was taken away, with processors {idle:.0%} idle", last < limit)
    ended = f"ended after {last:.1f} s, of at most {limit:.0f} s"
    if embedded:
        return ended
    told = events(mine, "own_rights_lost")
    check(f"{len(told)} events", len(told) == 1)
    check(told[0]["sentence"], TOPIC in told[0]["sentence"])
    return f"{ended}; longest pause before {pause:.2f} s"


def cases():
    for publisher, subscriber in (("ddssec", "ddssec"), ("ddssec", "embedded"), ("embedded", "ddssec"), ("embedded", "embedded")):
        for narrowed, who in enumerate(("publisher", "subscriber")):
            yield f"{who}/{publisher}/{subscriber}", publisher, subscriber, narrowed


def begin(build, folder, case):
    _, publisher, subscriber, _ = case
    return Story(build, folder, publisher, subscriber, True, (0, 1))


def play(story, case):
    _, publisher, subscriber, narrowed = case
    return taken_away(story, narrowed, (publisher, subscriber)[narrowed] == "embedded")


if __name__ == "__main__":
    sys.exit(story_cases.run(cases(), begin, play, at_once=4))

#!/usr/bin/env python3
"""A running participant gets permissions with fewer rights: the matches that they no longer allow end. In Cyclone DDS
with our plugins they come back with the rights, and an endpoint that only wider permissions allow matches, with one end
of the sessions. Equal rights, and wider ones that no endpoint needs, end nothing. With peers of the same kind and
embedded ones.
Usage: rights_test.py BUILD [FILTER]"""

import json
import os
import shutil
import sys
import time

sys.dont_write_bytecode = True
from shapes_process import SAMPLE, check  # puts the folders of what follows in place
from documents import Permissions
from processors import IDLE, idle_share, processor_time
import story_cases
from renewal_test import DOMAIN, TOPIC, Process, Story, command

BEFORE = 25     # seconds until samples flow, at most
AT_ONCE = 2.0   # seconds until what was taken away has ended
LATE = 4.0      # and what a machine that is not idle in these seconds may need beyond that
WATCHED = 8.0   # seconds without a sample that comes back
AGAIN = 8.0     # seconds until a session has begun again
MORE = TOPIC + "1"


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


def samples(story, topic, since):
    """When samples of the topic came since then."""
    return [at for at, line in list(story.subscriber.lines)
            if at > since and (found := SAMPLE.match(line)) and found[1] == topic]


def flows(story, since):
    """Seconds of the longest pause since then."""
    times = [since, *samples(story, TOPIC, since), time.time() - story.began]
    return max(b - a for a, b in zip(times, times[1:]))


def comes(story, topic, since):
    """Seconds until a sample came: a right counts within two seconds, and then sessions begin again."""
    limit = AT_ONCE + LATE + AGAIN
    while not samples(story, topic, since):
        check(f"no sample of {topic} within {limit} s", time.time() - story.began < since + limit)
        time.sleep(0.1)
    return samples(story, topic, since)[0] - since


def told_once(documents, name, topic):
    told = events(documents, name)
    check(f"{name}: {told}", len(told) == 1 and topic in told[0]["sentence"])


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
    for name in ("own_rights_lost", "own_rights_gained"):
        check(f"{events(mine, name)}", not events(mine, name))
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
    told_once(mine, "own_rights_lost", TOPIC)
    back = comes(story, TOPIC, put(mine, (TOPIC,), (TOPIC,), 2033))
    told_once(mine, "own_rights_gained", TOPIC)
    return f"{ended}; longest pause before {pause:.2f} s; back after {back:.1f} s"


class WithMore(Story):
    """The participants use a second topic. The permissions of those in `gaining` do not allow it yet."""

    def __init__(self, build, folder, kinds, gaining):
        super().__init__(build, folder, *kinds, True, (0, 1))
        for process in self.processes:
            process.close()
        for i in {0, 1} - set(gaining):
            put(self.documents[i], (TOPIC, MORE), (TOPIC, MORE), 2036)
        self.processes = []
        for i, (documents, kind) in enumerate(zip(self.documents, kinds)):
            words = command(build, documents, kind, i == 0, True)
            words = [*words, "--num-topics", "2"] if kind == "embedded" else [*words[:-1], "more"]
            self.processes.append(Process(self.space, words, self.began))
        self.publisher, self.subscriber = self.processes


def gained(story, gaining):
    """By participants in Cyclone DDS, which then make endpoints of a further topic."""
    story.talks_before(BEFORE)
    theirs = [story.documents[i] for i in gaining]
    time.sleep(2.0)
    check(f"samples of {MORE} without a right", not samples(story, MORE, 0.0))
    at = [put(mine, (TOPIC, MORE), (TOPIC, MORE), 2036) for mine in theirs][0]
    after, again = comes(story, MORE, at), comes(story, TOPIC, at + AT_ONCE)
    for mine in theirs:
        put(mine, (TOPIC, MORE), (TOPIC, MORE), 2037)          # the same rights
    time.sleep(1.2)
    at = [put(mine, (TOPIC, MORE, "Third"), (TOPIC, MORE), 2038) for mine in theirs][0]
    time.sleep(AT_ONCE + LATE)
    pause = flows(story, at)
    check(f"a pause of {pause:.1f} s although no endpoint gained a right", pause < 1.0 + LATE / 2)
    if len(theirs) == 1:
        told_once(theirs[0], "own_rights_gained", MORE)
    told = [len(events(mine, "own_rights_gained")) for mine in theirs]
    check(f"each says it once at most: {told}", 1 <= sum(told) and max(told) == 1)
    for mine in theirs:
        check(f"{events(mine, 'own_rights_lost')}", not events(mine, "own_rights_lost"))
    return f"the new topic after {after:.1f} s, the other one again after {again + AT_ONCE:.1f} s"


def cases():
    for publisher, subscriber in (("ddssec", "ddssec"), ("ddssec", "embedded"), ("embedded", "ddssec"), ("embedded", "embedded")):
        for narrowed, who in enumerate(("publisher", "subscriber")):
            yield f"{who}/{publisher}/{subscriber}", publisher, subscriber, narrowed
            if (publisher, subscriber)[narrowed] == "ddssec":
                yield f"gained/{who}/{publisher}/{subscriber}", publisher, subscriber, (narrowed,)
    yield "gained/both/ddssec/ddssec", "ddssec", "ddssec", (0, 1)


def begin(build, folder, case):
    name, publisher, subscriber, narrowed = case
    if name.startswith("gained"):
        return WithMore(build, folder, (publisher, subscriber), narrowed)
    return Story(build, folder, publisher, subscriber, True, (0, 1))


def play(story, case):
    name, publisher, subscriber, narrowed = case
    if name.startswith("gained"):
        return gained(story, narrowed)
    return taken_away(story, narrowed, (publisher, subscriber)[narrowed] == "embedded")


if __name__ == "__main__":
    sys.exit(story_cases.run(cases(), begin, play, at_once=4))

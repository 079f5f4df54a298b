#!/usr/bin/env python3
"""Both CAs are replaced with an overlap while reliable data flows between participants that are not restarted:
Cyclone DDS on our plugins, and embedded ones. Prints how long nothing came, and how many samples were lost, at each step.
Usage: overlap_test.py BUILD [FILTER]"""

import itertools
import pathlib
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from shapes_process import Namespace, check  # puts the folders of what follows in place
import story_cases
from renewal_test import DOMAIN, GAP, LOOKS, Documents, Process, command, gaps, said

START = 30      # seconds until the two must talk
STEP = 6        # seconds for each step of a rotation: more than a look at the files takes
AFTER = 25      # seconds to watch after the former CAs have ended
ROLES = ("identity", "permissions")
STEPS = (("--overlap", "30d"), ("--move",), ("--end",))
# What each participant must have said at the end.
SAID = ("identity_ca_renewed|identity CAs of the participant",
        "permissions_ca_renewed|permissions CAs of the participant",
        "identity_renewed|presents a renewed certificate",
        "permissions_renewed|renewed permissions of this participant")


class Folder(Documents):
    """A participant's folder that `ddssec init` made."""

    def __init__(self, folder, name, began):  # pylint: disable=super-init-not-called
        self.name, self.folder, self.began = name, folder / "demo" / name, began
        (self.folder / "security.properties").write_text(f"org.ddssec.files_poll_interval = {LOOKS}\n")


class Story:
    def __init__(self, build, folder, kinds):
        self.build, self.at = build, pathlib.Path(folder)
        self.is_embedded = set(kinds) == {"embedded"}
        self.began, self.processes, self.steps = time.time(), [], []
        self.ddssec("init", "demo", "--participant", "pub", "--participant", "sub", "--domain", str(DOMAIN))
        self.space = Namespace()
        self.documents = [Folder(self.at, name, self.began) for name in ("pub", "sub")]
        for documents, kind, publishes in zip(self.documents, kinds, (True, False)):
            self.processes.append(Process(self.space, command(build, documents, kind, publishes, True), self.began))
        self.subscriber = self.processes[1]

    def ddssec(self, *words):
        done = subprocess.run([str(self.build / "bin/ddssec"), *words], cwd=self.at, text=True, capture_output=True)
        check(f"ddssec {' '.join(words)}: {done.stderr}", done.returncode == 0)

    def now(self):
        return time.time() - self.began

    def talks(self):
        while len(self.subscriber.samples()) < 30:
            check(f"no sample: {[p.lines[-3:] for p in self.processes]}", self.now() < START)
            time.sleep(0.1)

    def rotate(self):
        for step in STEPS:
            self.steps.append((step[0], self.now()))
            for role in ROLES:
                self.ddssec("ca", "rotate", "demo", "--role", role, *step)
            time.sleep(STEP)
        time.sleep(AFTER - STEP)

    def lost(self):
        """For each step: the longest time without a sample, and how many were lost."""
        samples, out = self.subscriber.samples(), []
        ends = [at for _, at in self.steps[1:]] + [self.now()]
        for (name, begin), end in zip(self.steps, ends):
            found = [gap for gap in gaps(samples) if begin <= gap[0] + gap[1] and gap[0] < end]
            out.append((name, max((gap[1] for gap in found), default=0.0), sum(gap[2] for gap in found)))
        return out

    def close(self):
        for process in self.processes:
            process.close()
        self.space.close()


def rotated(story):
    story.talks()
    story.rotate()
    samples, lost = story.subscriber.samples(), story.lost()
    note = "; ".join(f"{name}: {seconds:.1f} s, {count} lost" for name, seconds, count in lost)
    note = f"{len(samples)} samples; {note}"
    for name, seconds, count in lost if story.is_embedded else lost[:-1]:
        check(f"a step that ends nothing lost samples: {note}", (name, count) == (name, 0))
    check(f"it does not talk any more: {note}", samples[-1][0] > story.now() - 3)
    check(f"too long: {note}", all(seconds < GAP for _, seconds, _ in lost))
    check(f"out of order or twice: {note}", all(a < b for (_, a), (_, b) in zip(samples, samples[1:])))
    for documents, process in zip(story.documents, story.processes):
        for code in SAID:
            check(f"{documents.name} never said {code}", said(documents, process, code))
    return note


def cases():
    for kinds in itertools.product(("ddssec", "embedded"), repeat=2):
        yield "/".join(kinds), kinds


def begin(build, folder, case):
    return Story(build, folder, case[1])


def play(story, _):
    return rotated(story)


if __name__ == "__main__":
    sys.exit(story_cases.run(cases(), begin, play, at_once=4))

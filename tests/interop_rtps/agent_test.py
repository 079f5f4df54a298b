#!/usr/bin/env python3
"""Two Cyclone DDS processes on our plugins with certificates of 30 seconds. `ddssec agent` renews each of them twice while
they exchange data; neither is cut off. The publisher's folder is tended directly. The subscriber's files are a mounted
secret as kubelet makes it: links into a folder that is exchanged as a whole after the agent has renewed the original.
Usage: agent_test.py BUILD"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading

sys.dont_write_bytecode = True
from renewal_test import GAP, Story, gaps, said
from shapes_process import SAMPLE, check

SECONDS = 30   # that each certificate is valid
WATCHED = 66   # two former ends (30 s, some 51 s), and some time after each; the third comes after 70 s
HOOK = """#!/bin/sh
set -e
d=$(mktemp -d {at}/XXXXXX)
cat >"$d/csr"
openssl ca -batch -notext -preserveDN -config {ca}/openssl.cnf -in "$d/csr" -startdate $(date -u +%Y%m%d%H%M%SZ) \\
  -enddate $(date -u -d "+{seconds} seconds" +%Y%m%d%H%M%SZ) 2>/dev/null
"""


class MountedSecret(threading.Thread):
    """Makes the files of `folder` links, and exchanges all of them at once whenever `original` has another certificate."""

    def __init__(self, folder, original):
        super().__init__(daemon=True)
        self.folder, self.original, self.number, self.ended = folder, original, 0, threading.Event()
        self.names = [path.name for path in folder.iterdir()]
        shutil.copytree(folder, original)
        original.chmod(0o700)
        self.exchange()
        for name in self.names:
            (folder / name).unlink()
            (folder / name).symlink_to(f"..data/{name}")

    def exchange(self):
        self.number += 1
        inside = self.folder / f"..{self.number}"
        inside.mkdir()
        for name in self.names:
            shutil.copy(self.original / name, inside)
        (self.folder / "..data_tmp").symlink_to(inside.name)
        os.replace(self.folder / "..data_tmp", self.folder / "..data")

    def run(self):
        while not self.ended.wait(0.5):
            if (self.original / "cert.pem").read_bytes() != (self.folder / "cert.pem").read_bytes():
                self.exchange()


class Agent:
    def __init__(self, build, at, ca, folders):
        hook = pathlib.Path(at, "hook")
        hook.write_text(HOOK.format(at=at, ca=ca, seconds=SECONDS))
        hook.chmod(0o755)
        self.events = []
        self.process = subprocess.Popen([build / "bin/ddssec", "agent", *folders, "--hook", str(hook)], text=True,
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE)
        self._reader = threading.Thread(target=lambda: self.events.extend(map(json.loads, self.process.stdout)), daemon=True)
        self._reader.start()

    def end(self):
        self.process.terminate()
        code = self.process.wait(timeout=30)
        self._reader.join()
        self.process.stdout.close()
        return code


def run(build, at):
    story = Story(build, at, "ddssec", "ddssec", True, (), (SECONDS, 3600))
    publisher, subscriber = story.documents
    secret = MountedSecret(subscriber.folder, pathlib.Path(at, "original"))
    secret.start()
    agent = Agent(build, at, publisher.identity, [publisher.folder, secret.original])
    try:
        story.talks_before(SECONDS - 5)
        story.wait_until(WATCHED)
        samples = story.subscriber.samples()
        note = "; ".join(f"at {begin:.1f} s: {long:.1f} s, {lost} lost" for begin, long, lost in gaps(samples))
        note = f"{len(samples)} samples, last at {samples[-1][0]:.1f} s; {note or 'no gap'}"
        check(f"it does not talk any more: {note}", samples[-1][0] > WATCHED - 3)
        check(f"too long: {note}", all(long < GAP for _, long, _ in gaps(samples)))
        for documents, process in zip(story.documents, story.processes):
            check(f"{documents.name} took nothing", said(documents, process, "presents a renewed certificate"))
    except AssertionError as fault:
        said_by = [line for p in story.processes for line in p.lines if not SAMPLE.match(line[1])][-40:]
        raise AssertionError(f"{fault}\n{said_by}\n{agent.events}") from None
    finally:
        code = agent.end()
        secret.ended.set()
        secret.join()
        story.close()
    renewed = [sum(e["event"] == "renewed" and e["folder"] == str(folder) for e in agent.events)
               for folder in (publisher.folder, secret.original)]
    check(f"renewed {renewed} times: {agent.events}", min(renewed) >= 2)
    check(f"failures: {agent.events}", code == 0 and not [e for e in agent.events if e["event"] == "failed"])
    return f"renewed {renewed} times; {note}"


def main():
    with tempfile.TemporaryDirectory(prefix="ddssec-agent-") as folder:
        print("ok", run(pathlib.Path(sys.argv[1]).resolve(), folder))


if __name__ == "__main__":
    main()

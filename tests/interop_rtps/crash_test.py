#!/usr/bin/env python3
"""A peer is killed (SIGKILL) in mid-flow and started again at once, at the same ports: the other one
matches the new one and goes on, and sees the old one's lease end.
Usage: crash_test.py BUILD [--chosen] [--filter TEXT]"""

import sys

from faults_test import LIMIT, PAIRS, expect, run_cases
from faulty_world import Loopback

LEASE = 3
OPTIONS = ["--samples", 10000, "--hold", "--lease", LEASE, "--timeout", LIMIT]
RESUMES = 8   # seconds within which samples must flow again


def crash(world, pair, secured, role):
    """`role`: who is killed."""
    kinds = dict(zip(("publish", "subscribe"), pair))
    peers = {role: world.start(kinds[role], role, OPTIONS, secured)
             for role in ("subscribe", "publish")}
    expect(peers["subscribe"].wait(lambda peer: len(peer.samples) >= 5, 15), "no flow at first")
    stays = peers["publish" if role == "subscribe" else "subscribe"]
    peers[role].kill()
    before = len(stays.samples)
    peers[role] = world.start(kinds[role], role, OPTIONS, secured)
    if role == "subscribe":
        before = 0
    resumed = peers["subscribe"].wait(lambda peer: len(peer.samples) > before + 5, RESUMES)
    expect(resumed is not None, f"no flow within {RESUMES} s of the start")
    ended = stays.wait(lambda peer: peer.times("unmatched"), LEASE + 4)
    expect(ended is not None, "the one that stays does not see the lease of the dead one end")
    flows = len(peers["subscribe"].samples)
    expect(peers["subscribe"].wait(lambda peer: len(peer.samples) > flows + 5, 5),
           "the end of the old lease ends the flow from the new one")
    return f"flows {resumed:.2f} s after the start, lease ends {resumed + ended:.2f} s after the kill"


def kill_publisher(world, pair, secured):
    return crash(world, pair, secured, "publish")


def kill_subscriber(world, pair, secured):
    return crash(world, pair, secured, "subscribe")


def cases():
    for scenario in (kill_publisher, kill_subscriber):
        for pair in PAIRS:
            for secured in (False, True):
                yield scenario, pair, secured


def is_chosen(scenario, pair, secured):
    return secured == (scenario is kill_publisher) or pair == ("embedded", "embedded")


if __name__ == "__main__":
    sys.exit(run_cases(cases(), is_chosen, lambda build, seed: Loopback(), __doc__))

#!/usr/bin/env python3
"""Secured peers that have nothing to say to each other stay matched for several leases, whatever the
governance protects, and one that is killed is lost when its lease ends, although everything that the two
said is recorded and sent again and again from then on. The embedded participant believes no announcement
of an authenticated peer: it asks, by the keys of the pair, and each vendor answers.
Usage: idle_test.py BUILD [--chosen] [--filter TEXT]"""

import sys
import time

from faults_test import PAIRS, expect, run_cases
from faulty_world import Loopback
from freshness_test import Recorder
from scenarios import GOVERNANCES

LEASE = 3  # seconds
LEASES = 4  # without a word
SLACK = 2  # seconds: a peer is asked each third of a lease, and the machine may be busy
LIMIT = 60


def idle(row):
    def scenario(world, pair, secured):
        recorder = Recorder(world.network.spaces[0])
        try:
            return idle_and_gone(world, row, pair, secured, recorder)
        finally:
            recorder.close()
    scenario.__name__ = row
    return scenario


def idle_and_gone(world, row, pair, secured, recorder):
    """One sample each second would be a sign of life; there is one sample altogether."""
    world.governance = GOVERNANCES[row]
    options = ["--samples", 1000, "--hold", "--interval", LIMIT * 1000, "--lease", LEASE,
               "--timeout", LIMIT]
    peers = {"subscriber": world.start(pair[1], "subscribe", options, secured),
             "publisher": world.start(pair[0], "publish", options, secured)}
    expect(peers["subscriber"].wait(lambda peer: peer.samples, 20), "the sample did not come")
    time.sleep(LEASE * LEASES)
    for name, peer in peers.items():
        expect(not peer.times("unmatched") and not peer.times("end"), f"the {name} says {peer.said}")
    gone, left = sorted(peers, key=lambda name: pair[name == "subscriber"] == "embedded")
    peers[gone].kill()
    count = recorder.stop()
    expect(count > 10, f"only {count} datagrams are recorded")
    recorder.replay()
    lost = peers[left].wait(lambda peer: peer.times("unmatched"), 2 * LEASE + 2)
    expect(lost is not None, f"the {left} still believes in the {gone}")
    expect(lost <= LEASE + SLACK, f"the {left} believed in the {gone} for {lost:.1f} s")
    return f"idle for {LEASES} leases, lost {lost:.1f} s after its end, in spite of {count} recorded datagrams"


def cases():
    for row in GOVERNANCES:
        for pair in PAIRS + [("embedded", "ddssec"), ("ddssec", "embedded")]:
            yield idle(row), pair, True


def is_chosen(scenario, pair, secured):
    """Each governance with one of the pairs, and those that protect least with all vendors."""
    rows, pairs = list(GOVERNANCES), PAIRS[1:]
    turn = rows.index(scenario.__name__)
    return pair == pairs[turn % len(pairs)] or (
        scenario.__name__ in ("all-none", "rtps-sign") and pair in (PAIRS[1], PAIRS[3]))


if __name__ == "__main__":
    sys.exit(run_cases(list(cases()), is_chosen, lambda build, seed: Loopback(), __doc__))

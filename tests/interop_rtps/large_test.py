#!/usr/bin/env python3
"""Samples of 64 MiB between two processes on loopback: each octet as it was sent.
Usage: large_test.py BUILD [--filter TEXT]"""

import sys

from faults_test import PAIRS, expect, run_cases
from faulty_world import Loopback

SIZE, COUNT, LIMIT = 64 << 20, 3, 60


def large(world, pair, secured):
    # A string, numbers and lengths stand before the octets: the sample as a whole is just below.
    options = ["--samples", COUNT, "--payload", SIZE - 64, "--timeout", LIMIT]
    subscriber = world.start(pair[1], "subscribe", options, secured)
    publisher = world.start(pair[0], "publish", options, secured)
    expect(subscriber.wait(lambda peer: peer.times("matched"), 15), "no match")
    taken = subscriber.wait(lambda peer: len(peer.samples) >= COUNT or peer.times("end"), LIMIT)
    expect(subscriber.numbers() == list(range(COUNT)), f"{subscriber.numbers()} {subscriber.said}")
    expect(publisher.wait(lambda peer: peer.times("acknowledged"), LIMIT), "not acknowledged")
    return f"{COUNT} in {taken:.1f} s"


def cases():
    for pair in PAIRS:
        for secured in (False, True):
            yield large, pair, secured


if __name__ == "__main__":
    sys.exit(run_cases(cases(), lambda *case: True, lambda build, seed: Loopback(), __doc__))

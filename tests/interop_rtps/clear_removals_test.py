#!/usr/bin/env python3
"""While samples flow, a stranger without a certificate says in the clear, in the name of each of two participants, that its
endpoints and its secure discovery are gone, or puts its readers elsewhere. Discovery is protected, so the two go on. One of the two
is the embedded participant, and the other one is Cyclone DDS on its own plugins.
Usage: clear_removals_test.py BUILD [--chosen] [--filter TEXT]"""

import pathlib
import subprocess
import sys
import time

from faults_test import expect, run_cases
from faulty_world import Loopback
from documents import Governance
from scenarios import SROS2

STRANGER = pathlib.Path(__file__).resolve().parent.parent / "interop" / "stranger.py"
LIMIT = 60  # seconds
PATIENCE = 30
GOVERNANCES = {"sros2": SROS2, "messages-none": Governance(discovery="ENCRYPT", metadata="ENCRYPT", data="ENCRYPT")}
PAIRS = [("embedded", "stock"), ("stock", "embedded")]


class Stranger:
    def __init__(self, space):
        self._process = subprocess.Popen(space.enter([sys.executable, str(STRANGER), "removing-later"]), text=True,
                                         stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        expect(self._process.stdout.readline() == "listening\n", "the stranger does not listen")

    def forge(self):
        self._process.stdin.write("now\n")
        self._process.stdin.flush()
        count = int(self._process.stdout.readline().removeprefix("forged ") or 0)
        expect(count, "the stranger forged nothing")
        return count

    def close(self):
        self._process.kill()
        self._process.communicate()


def goes_on(subscriber, peers):
    time.sleep(3)  # what was believed shows by then
    for peer in peers:
        expect(not peer.times("unmatched 0"), f"an endpoint is gone: {peer.said}")
    later = time.monotonic()
    expect(subscriber.wait(lambda peer: peer.samples[-1][0] > later, 5), "the flow ended")


def removing(row):
    def scenario(world, pair, secured):
        world.governance = GOVERNANCES[row]
        options = ["--samples", 2000, "--hold", "--timeout", LIMIT]
        stranger = Stranger(world.network.spaces[0])
        try:
            subscriber = world.start(pair[1], "subscribe", options, secured)
            publisher = world.start(pair[0], "publish", [*options, "--keep-last", 1, "--interval", 50], secured)
            expect(subscriber.wait(lambda peer: len(peer.samples) >= 20, PATIENCE), "no flow")
            count = stranger.forge()
            goes_on(subscriber, (subscriber, publisher))
        finally:
            stranger.close()
        return f"went on in spite of {count} forged datagrams"
    scenario.__name__ = row
    return scenario


def cases():
    for row in GOVERNANCES:
        for pair in PAIRS:
            yield removing(row), pair, True


if __name__ == "__main__":
    sys.exit(run_cases(list(cases()), lambda *_: True, lambda build, seed: Loopback(), __doc__))

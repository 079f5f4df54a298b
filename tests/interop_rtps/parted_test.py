#!/usr/bin/env python3
"""While samples flow, an attacker without a certificate says once, in the clear and in the name of the other side, that
its endpoint has ended. The flow to or from the embedded participant stops and comes back, because it reads the other's
announcements again. Discovery of the topic and RTPS messages are not protected.
Usage: parted_test.py BUILD [--chosen] [--filter TEXT]"""

import struct
import subprocess
import sys
import time

from faults_test import expect, run_cases
from faulty_world import Loopback
from scenarios import GOVERNANCES
from stranger import Network, clear_discovery, parameters, submessages

LIMIT = 60  # seconds
ANNOUNCEMENT_REFRESH = 4  # seconds until announcements are read again (rtps/participant/announcement_refresh.hpp)
ROWS = ("all-none", "discovery-encrypt-topic-off", "data-encrypt")
OTHERS = ("embedded", "stock", "ddssec", "fast")


def announced(message, writer):
    """The number and the endpoint of an announcement in the clear of that builtin writer; None if there is none."""
    for kind, flags, body in submessages(message):
        if kind != 0x15 or body[8:12] != writer or flags & 0x0d != 5:
            continue
        high, low = struct.unpack_from("<iI", body, 12)
        at = 4 + struct.unpack_from("<H", body, 2)[0]
        if flags & 2:
            at += sum(4 + len(value) for _, value in parameters(body[at:])) + 4
        for name, value in parameters(body[at + 4:]):
            if name == 0x5a and value[15] < 0xc0:
                return (high << 32) + low, bytes(value)
    return None


def listen(of_reader):
    """Waits for the announcement of the reader (or writer), then for a line of input, and forges its end."""
    network, found = Network(), {}
    writer = bytes.fromhex("000004c2" if of_reader else "000003c2")
    print("listening", flush=True)
    while len(network.ports) < 2 or not found:
        for _, message in network.heard(0.2):
            network.note(message)
            if said := announced(message, writer):
                found[said[1]] = said[0]
    print("found", flush=True)
    sys.stdin.readline()
    (endpoint, number), = found.items()
    of = endpoint[:12]
    other, = (prefix for prefix in network.ports if prefix != of)
    network.send(other, clear_discovery(of, other, number + 1, endpoint[12:], of_reader, b"", True))
    print("forged", flush=True)


class Attacker:
    def __init__(self, space, of_reader):
        self._process = subprocess.Popen(space.enter([sys.executable, __file__, "--listen", str(int(of_reader))]),
                                         text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.expect("listening")

    def expect(self, word):
        line = self._process.stdout.readline().strip()
        expect(line == word, f"the attacker says {line!r}, not {word!r}")

    def forge(self):
        self.expect("found")
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        self.expect("forged")

    def close(self):
        self._process.kill()
        self._process.communicate()


def parted(row, of_reader):
    def scenario(world, pair, secured):
        world.governance = GOVERNANCES[row]
        options = ["--samples", 2000, "--hold", "--timeout", LIMIT]
        attacker = Attacker(world.network.spaces[0], of_reader)
        try:
            subscriber = world.start(pair[1], "subscribe", options, secured)
            world.start(pair[0], "publish", [*options, "--keep-last", 1, "--interval", 50], secured)
            expect(subscriber.wait(lambda peer: len(peer.samples) >= 20, 25), "no flow")
            forged = time.monotonic()
            attacker.forge()
            came_back = subscriber.wait(lambda peer: peer.samples[-1][0] > forged + ANNOUNCEMENT_REFRESH + 2, 15)
        finally:
            attacker.close()
        times = [at for at, _ in subscriber.samples if at > forged - 1]
        gap = max(later - at for at, later in zip(times, times[1:]))
        expect(came_back, "the two stayed apart")
        expect(gap > ANNOUNCEMENT_REFRESH / 2, f"nothing stopped: the longest pause was {gap:.1f} s")
        return f"apart for {gap:.1f} s"
    scenario.__name__ = f"{row} {'reader' if of_reader else 'writer'}"
    return scenario


def cases():
    for row in ROWS:
        for other in OTHERS:
            yield parted(row, True), ("embedded", other), True
            yield parted(row, False), (other, "embedded"), True


def is_chosen(scenario, pair, secured):
    return not scenario.__name__.startswith("discovery") and "ddssec" not in pair


if __name__ == "__main__":
    if sys.argv[1] == "--listen":
        sys.exit(listen(sys.argv[2] == "1"))
    sys.exit(run_cases(list(cases()), is_chosen, lambda build, seed: Loopback(), __doc__))

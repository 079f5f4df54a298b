#!/usr/bin/env python3
"""Everything that was recorded from the publisher is sent again and again to a subscriber that starts later: unchanged,
and for all participants and with later sequence numbers where these are readable. If both sides are ours (the embedded
participant, or Cyclone DDS with our plugins), the subscriber accepts nothing that was recorded. The publisher's history
has one sample, which a later subscriber rightly gets. So the publisher writes more after the recording, before that
subscriber starts. Publishers with stock plugins do not say what they sent before, so with data protection alone the
recordings are new.
Usage: freshness_test.py BUILD [--chosen] [--filter TEXT]"""

import subprocess
import sys

from faults_test import expect, run_cases
from faulty_world import Loopback
from scenarios import GOVERNANCES

LIMIT = 60  # seconds
ROWS = ("data-encrypt", "metadata-encrypt", "rtps-encrypt", "rtps-encrypt+data-encrypt", "everything-encrypt-oa")
OURS = [("embedded", "ddssec"), ("ddssec", "embedded"), ("embedded", "embedded")]

RECORDED = 40  # samples
# At a first line of input it stops and says "recorded N"; from a second one on, until its input ends, it sends that again.
RECORDER = """
import socket, struct, sys, threading
packets = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))
packets.settimeout(0.2)
seen, ends = {}, threading.Event()

def record():
    while not ends.is_set():
        try:
            packet = packets.recv(65535)
        except TimeoutError:
            continue
        size = (packet[0] & 15) * 4
        if packet[9] == 17 and packet[size + 8:size + 12] == b"RTPS":
            seen[int.from_bytes(packet[size + 2:size + 4], "big"), packet[size + 8:]] = True

def renumbered(message):
    out, at = bytearray(message), 20
    while at + 24 <= len(out):
        kind, flags, size = out[at], out[at + 1], int.from_bytes(out[at + 2:at + 4], "little")
        if kind == 0x0e:  # INFO_DST: for all participants
            out[at + 4:at + 16] = bytes(12)
        if kind in (0x15, 0x16) and flags & 1:
            number = int.from_bytes(out[at + 20:at + 24], "little") + %d
            out[at + 8:at + 12] = bytes(4)  # for each reader
            out[at + 20:at + 24] = number.to_bytes(4, "little")
        at += 4 + size if size else len(out)
    return bytes(out)

recorder = threading.Thread(target=record)
recorder.start()
print("ready", flush=True)
sys.stdin.readline()
ends.set()
recorder.join()
print("recorded", len(seen), flush=True)
sys.stdin.readline()
out, ends = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), threading.Event()
threading.Thread(target=lambda: (sys.stdin.read(), ends.set()), daemon=True).start()
while not ends.wait(0.05):
    for port, message in seen:
        for octets in {message, renumbered(message)}:
            out.sendto(octets, ("127.0.0.1", port))
""" % (RECORDED + 20)


class Recorder:
    def __init__(self, space):
        self._process = subprocess.Popen(space.enter([sys.executable, "-c", RECORDER]), text=True,
                                         stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        expect(self._process.stdout.readline() == "ready\n", "cannot listen")

    def _tell(self, word):
        self._process.stdin.write(word + "\n")
        self._process.stdin.flush()

    def stop(self):
        self._tell("stop")
        return int(self._process.stdout.readline().split()[1])

    def replay(self):
        self._tell("replay")

    def close(self):
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()


def later_number(subscriber):
    """The number of a sample that the subscriber had not taken yet."""
    before = subscriber.numbers()[-1]
    expect(subscriber.wait(lambda peer: peer.numbers()[-1] > before, 5), "the flow ended")
    return subscriber.numbers()[-1]


def later(row):
    def scenario(world, pair, secured):
        world.governance = GOVERNANCES[row]
        options = ["--samples", 2000, "--hold", "--timeout", LIMIT]
        recorder = Recorder(world.network.spaces[0])
        try:
            first = world.start(pair[1], "subscribe", options, secured)
            world.start(pair[0], "publish", [*options, "--keep-last", 1, "--interval", 50], secured)
            expect(first.wait(lambda peer: len(peer.samples) >= RECORDED, 25), "no flow")
            count = recorder.stop()
            later_number(first)
            written = later_number(first)  # after all that was recorded
            first.kill()
            recorder.replay()
            second = world.start(pair[1], "subscribe", options, secured)
            expect(second.wait(lambda peer: len(peer.samples) >= 2 * RECORDED, 25), "no flow to the later one")
            old = [number for number in second.numbers() if number < written]
        finally:
            recorder.close()
        if pair[0] == "stock":
            expect(old, "nothing that was recorded was new: does the test still replay?")
        else:
            expect(not old, f"it took {old[:10]}, although {written} was written before it joined")
        return f"{count} datagrams again and again: {len(old)} old samples"
    scenario.__name__ = row
    return scenario


def cases():
    for row in ROWS:
        for pair in OURS:
            yield later(row), pair, True
    yield later("data-encrypt"), ("stock", "embedded"), True


def is_chosen(scenario, pair, secured):
    return scenario.__name__ in ("data-encrypt", "rtps-encrypt")


if __name__ == "__main__":
    sys.exit(run_cases(list(cases()), is_chosen, lambda build, seed: Loopback(), __doc__))

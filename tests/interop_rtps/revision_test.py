#!/usr/bin/env python3
"""Key revision between processes: one of three loses its trust while they talk, or the keys of two
come to the end of their time. They lose nothing, and from then on send nothing that is protected by
the former keys.
Usage: revision_test.py BUILD [FILTER]"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from datetime import datetime, timedelta, timezone

from shapes_process import SAMPLE, check, run  # puts the folders of what follows in place
from documents import DOMAIN, TOPIC, Permissions
from pki import Pki
from surroundings import ENCRYPT, make_folder

PATIENCE = 40  # seconds; nothing that comes takes so long
ON_ITS_WAY = 1.0  # seconds a message under the former keys may be late
GOVERNANCE = replace(ENCRYPT, revises_keys=True)

# First and last time of each revision that messages of each sender are protected under: the first
# submessage is SRTPS_PREFIX (0x33), and the kind of its transformation begins with the revision.
WATCH = """
import json, signal, socket, sys, time
signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
packets, seen = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800)), {}
print("ready", flush=True)
try:
    while True:
        message = packets.recv(65535)[28:]
        if message[:4] == b"RTPS" and message[20:21] == b"\\x33":
            now, sender = time.monotonic(), seen.setdefault(message[8:20].hex(), {})
            sender.setdefault(int.from_bytes(message[24:27], "big"), [now, now])[1] = now
finally:
    print(json.dumps(list(seen.values())), flush=True)
"""


class Wire:
    """What an eavesdropper sees of the revisions."""

    def __init__(self, space):
        self._process = subprocess.Popen(space.enter([sys.executable, "-c", WATCH]), text=True,
                                         stdout=subprocess.PIPE)
        check("cannot listen", self._process.stdout.readline() == "ready\n")

    def close(self):
        """Of each sender {revision: (first, last)}."""
        self._process.terminate()
        said, _ = self._process.communicate(timeout=PATIENCE)
        return [{int(revision): times for revision, times in sender.items()}
                for sender in json.loads(said or "[]")]


def start_third(case, pki):
    """A subscriber whose permissions end in a few seconds, and which has heard something before."""
    for seconds in (4, 16, 64):
        end = datetime.now(timezone.utc) + timedelta(seconds=seconds)
        folder = make_folder(pki, "carol", GOVERNANCE,
                             Permissions((), (TOPIC,), not_after=f"{end:%Y-%m-%dT%H:%M:%S}"))
        carol = case.start(f"-S -k 0 --security {folder}")
        if carol.says_within(SAMPLE.pattern, seconds):
            return carol
    raise AssertionError(f"the third was never heard: {carol.lines[-5:]}")


def two_revise(case, pki, then):
    """Two talk; whatever comes `then`, both revise their keys, once or more, and lose nothing."""
    alice, bob = (make_folder(pki, name, GOVERNANCE, Permissions()) for name in ("alice", "bob"))
    for folder in (alice, bob):
        pathlib.Path(folder, "security.properties").write_text(PROPERTIES.get(then, ""))
    wire = Wire(case.space)
    try:
        bob = case.start(f"-S -k 0 --read-period 10 -v d --security {bob}")
        alice = case.start(f"-P -k 0 -z 0 --write-period 10 -v d --security {alice}")
        bob.hears(10, PATIENCE)
        then(case, pki, alice, bob)
    finally:
        senders = wire.close()
    check("codes", alice.interrupt() == 0 and bob.interrupt() == 0)
    got = bob.samples()
    check(f"lost some: {got}", got == list(range(got[0], got[0] + len(got))))
    revised = [sender for sender in senders if max(sender) > 0]
    check(f"not two revised: {senders}", len(revised) == 2)
    for sender in revised:
        late = sender[0][1] - min(first for revision, (first, _) in sender.items() if revision > 0)
        check(f"sends under the former keys {late:.1f} s after the new ones", late < ON_ITS_WAY)


def both_have_revised(alice, bob):
    for process in (alice, bob):
        process.says("our keys were revised", PATIENCE)
    time.sleep(2 * ON_ITS_WAY)


def third_loses_its_trust(case, pki, alice, bob):
    carol = start_third(case, pki)
    both_have_revised(alice, bob)
    carol.sizes_for(0.5)
    bob.hears(100, PATIENCE)
    check("the third hears on", not carol.sizes_for(0.5))


def time_ends(_case, _pki, alice, bob):
    both_have_revised(alice, bob)
    bob.hears(100, PATIENCE)


PROPERTIES = {time_ends: "org.ddssec.crypto.key_lifetime = 20\n"}


def permissions_end(case):
    with tempfile.TemporaryDirectory() as base:
        two_revise(case, Pki(base), third_loses_its_trust)


def keys_end(case):
    with tempfile.TemporaryDirectory() as base:
        two_revise(case, Pki(base), time_ends)


if __name__ == "__main__":
    sys.exit(run([permissions_end, keys_end], [DOMAIN], 1))

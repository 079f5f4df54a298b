#!/usr/bin/env python3
"""Two hosts of Cyclone DDS on our plugins meet, each with a publisher and a subscriber, while the link between
them loses all messages of the key exchange in one direction, for longer than our authentication waits for
keys. When that is over, samples flow in both directions.

Usage: lost_keys_test.py BUILD [FILTER]
"""

import os
import pathlib
import sys
import tempfile
import time

sys.dont_write_bytecode = True
sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "interop_rtps"))

import pair  # noqa: E402
import stories  # noqa: E402
from faulty_world import ADDRESSES, Link  # noqa: E402
from insider_test import BUILD, EVERYTHING, World, check, samples  # noqa: E402
from scenarios import SROS2  # noqa: E402

LOSS, PATIENCE = 25, 30  # seconds
PAYLOADS = 32, 48        # octets of the samples that each end publishes
FEW = 3


class Apart(World):
    """Two network namespaces with a faulty link between them."""

    def __init__(self, folder, kind, governance):
        super().__init__(folder, kind, governance)
        self.link = Link(BUILD, seed=1)

    def __exit__(self, *_):
        super().__exit__()
        self.did = self.link.close()

    def peer(self, end, role):
        words = self.side.arguments(self.pki, self.keys, end == 0)
        addresses = ["--address", ADDRESSES[end], "--peer", ADDRESSES[1 - end]]
        events = {"DDSSEC_EVENT_LOG": os.path.join(self.folder, f"{role}-{end}.events")}
        peer = pair.start(self.programs, self.link.spaces[end], self.kind,
                          ["--hold", f"--{role}", "--payload", str(PAYLOADS[end]), "--timeout", "200", *addresses, *words],
                          os.path.join(self.programs.logs, f"{role}-{end}"), events)
        self.watch(peer)
        return peer


def meet(world, loses):
    world.link.do(f"lose-keys {loses}")
    subscribers = [world.peer(end, "subscribe") for end in (0, 1)]
    for end in (0, 1):
        world.peer(end, "publish")
    world.passes(LOSS)
    from_other = lambda end: samples(subscribers[end], PAYLOADS[1 - end])
    check("samples came without keys", not from_other(2 - loses))
    world.link.do("lose-keys 0")
    start = time.monotonic()
    try:
        world.until("samples in both directions", lambda: all(len(from_other(end)) >= FEW for end in (0, 1)), PATIENCE)
    except AssertionError as one:
        raise AssertionError(f"{one}; samples from the other end: {[len(from_other(end)) for end in (0, 1)]}") from one
    seconds = time.monotonic() - start
    before = [len(from_other(end)) for end in (0, 1)]
    world.passes(3)
    check("they do not go on", all(len(from_other(end)) > before[end] + 10 for end in (0, 1)))
    check("a process ended", not any(peer.ended for peer in world.peers))
    return seconds


def attempt(case):
    _, governance, loses = case
    fault, seconds = None, 0.0
    with tempfile.TemporaryDirectory(prefix="ddssec-lost-keys-") as folder, Apart(folder, "ours", governance) as world:
        try:
            seconds = meet(world, loses)
        except AssertionError as one:
            fault = f"{one}{world.logs()}"
    if not fault and " lost 0 " in world.did.split(";")[2 - loses]:
        fault = f"the link lost nothing: {world.did}"
    return fault, f"samples {seconds:.1f} s after the loss ended; {world.did}"


def cases():
    for name, governance in (("everything", EVERYTHING), ("sros2", SROS2)):
        for loses in (1, 2):
            yield f"{name}/from-{loses}", governance, loses


if __name__ == "__main__":
    sys.exit(stories.run(cases(), attempt, at_once=4))

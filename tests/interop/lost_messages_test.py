#!/usr/bin/env python3
"""Two hosts of Cyclone DDS meet, each with a publisher and a subscriber, while the link between them loses all
messages of one kind in one direction, or holds them back, for longer than our authentication waits: those of the key
exchange, or a message of the handshake. When that is over, samples flow in both directions. One host may run stock plugins, which
do not notice that ours begin anew.

Usage: lost_messages_test.py BUILD [FILTER]
"""

import os
import pathlib
import re
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

LOSS, PATIENCE = 30, 30  # seconds
PAYLOADS = 32, 48        # octets of the samples that each end publishes
FEW = 3


class Apart(World):
    """Two network namespaces with a faulty link between them."""

    def __init__(self, folder, kinds, governance):
        super().__init__(folder, kinds[0], governance)
        self.kinds, self.link = kinds, Link(BUILD, seed=1)

    def __exit__(self, *_):
        super().__exit__()
        self.did = self.link.close()

    def peer(self, end, role):
        words = self.side.arguments(self.pki, self.keys, end == 0)
        addresses = ["--address", ADDRESSES[end], "--peer", ADDRESSES[1 - end]]
        events = {"DDSSEC_EVENT_LOG": os.path.join(self.folder, f"{role}-{end}.events")}
        peer = pair.start(self.programs, self.link.spaces[end], self.kinds[end],
                          ["--hold", f"--{role}", "--payload", str(PAYLOADS[end]), "--timeout", "200", *addresses, *words],
                          os.path.join(self.programs.logs, f"{role}-{end}"), events)
        self.watch(peer)
        return peer


def meet(world, does, end):
    world.link.do(f"{does} {end}")
    subscribers = [world.peer(end, "subscribe") for end in (0, 1)]
    for end in (0, 1):
        world.peer(end, "publish")
    # The time counts from when they meet, which a loaded machine delays. Ours begin anew after 20 s and need some 4 s for
    # that. If the loss ended meanwhile, a stock peer would believe a held reply whose handshake ours gave up, for good.
    world.until("all four starting", lambda: all(peer.created for peer in world.peers), PATIENCE)
    taken = world.link.taken()
    world.until("the link losing messages of them", lambda: world.link.taken() >= taken + len(world.peers), PATIENCE)
    world.passes(LOSS)
    from_other = lambda end: samples(subscribers[end], PAYLOADS[1 - end])
    check("samples came in spite of the loss", not from_other(2 - end))
    world.link.do(f"{does} 0")
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
    _, kinds, governance, does, end = case
    fault, seconds = None, 0.0
    with tempfile.TemporaryDirectory(prefix="ddssec-lost-keys-") as folder, Apart(folder, kinds, governance) as world:
        try:
            seconds = meet(world, does, end)
        except AssertionError as one:
            fault = f"{one}{world.logs()}"
    if not fault and re.search(" lost 0 .*delayed 0$", world.did.split(";")[2 - end]):
        fault = f"the link lost and held nothing: {world.did}"
    return fault, f"samples {seconds:.1f} s after the loss ended; {world.did}"


def cases():
    """The first of two begins the handshake; the link loses or holds what the end of that number sends."""
    both = ("ddssec", "ddssec")
    for name, governance in (("everything", EVERYTHING), ("sros2", SROS2)):
        for end in (1, 2):
            yield f"{name}/keys-from-{end}", both, governance, "lose keys", end
    ours_begins, stock_begins = ("ddssec", "stock"), ("stock", "ddssec")
    yield "ddssec-stock/keys-of-stock", ours_begins, SROS2, "lose keys", 2
    yield "stock-ddssec/keys-of-stock", stock_begins, SROS2, "lose keys", 1
    yield "stock-ddssec/request", stock_begins, SROS2, "hold +Req", 1
    yield "stock-ddssec/reply", stock_begins, SROS2, "hold +Reply", 2


if __name__ == "__main__":
    sys.exit(stories.run(cases(), attempt, at_once=8))

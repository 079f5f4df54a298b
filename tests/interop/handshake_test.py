#!/usr/bin/env python3
"""Two participants meet while a stranger forges handshake messages or announcements (stranger.py). Cyclone's core can be left in
a state of its handshake from which it never begins again while the peer is there. Our authentication makes it
begin again, so that the two talk after some seconds, and each side that did so says it once.

A stranger can also make the core of one side drop a peer that has authenticated. The peer keeps the session, until our
authentication proves to it that the session is lost, also while the core asks no plugin about the peer. What the stranger recorded in the first session is not new in the next.

What a reader acknowledges to one of its writers acknowledges nothing to another, although a stranger sends it there.

Where discovery is protected, endpoints that are announced or removed in the clear do not count, although the core believes them.
Nor does a clear request for a type. Neither does so while the two still meet.

Usage: handshake_test.py BUILD [FILTER]
"""

import pathlib
import signal
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True

import stories  # noqa: E402
from documents import Governance  # noqa: E402
from insider_test import EVERYTHING, FORGED, HONEST, World, check, go_on, prefix_begin, samples  # noqa: E402
from pki import STARTER  # noqa: E402
from scenarios import EO, GOVERNANCES, SROS2  # noqa: E402

STRANGER = pathlib.Path(__file__).resolve().parent / "stranger.py"
PATIENCE = {"request": 30, "answered": 90, "flood": 90, "announced": 90, "nameless": 90, "nameless-elsewhere": 90, "fewer": 90,
            "rightless": 15, "early": 60, "privileged": 60, "parting": 90, "parting-both": 90, "removing": 60, "crowding": 60, "redirecting": 60}  # seconds
TRIES = 4  # the peer's own announcement may be the first
CAN_BE_LATE = ("announced", "nameless", "nameless-elsewhere", "fewer")
MULTICAST = ("<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/></Interfaces>"
             "<AllowMulticast>spdp</AllowMulticast></General><Discovery><SPDPInterval>500ms</SPDPInterval>"
             "<LeaseDuration>10s</LeaseDuration></Discovery></Domain></CycloneDDS>")

ELSEWHERE = MULTICAST.replace("</Discovery>", "<Ports><Base>8000</Base></Ports><SPDPMulticastAddress>239.255.0.9</SPDPMulticastAddress></Discovery>")
NAMELESS = {"nameless": MULTICAST, "nameless-elsewhere": ELSEWHERE}  # where discovery is heard

# With this small buffer, datagrams that are sent to a stopped process are lost.
SHORT_OF_MEMORY = MULTICAST.replace("</Discovery>", "</Discovery><Internal><SocketReceiveBufferSize min=\"16kB\" max=\"16kB\"/></Internal>")


def stranger(world, mode):
    words = [mode.removesuffix("-elsewhere")]
    if mode == "redirecting":
        words.append(prefix_begin(STARTER))
    if mode == "answered":
        world.side.arguments(world.pki, world.keys, True)
        words.append(world.pki.leaf(STARTER, "ec", world.pki.ca("identity-main", "ec")))
    process = subprocess.Popen(world.namespace.enter([sys.executable, str(STRANGER), *words]),
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    check("the stranger does not listen", process.stdout.readline() == "listening\n")
    return process


def meet(world, mode):
    if mode in NAMELESS:
        world.settings["CYCLONEDDS_URI"] = NAMELESS[mode]
    process = stranger(world, mode)
    try:
        subscriber = world.honest("subscribe", True)
        world.until("the subscriber's start", lambda: subscriber.created)
        world.honest("publish", False)
        world.until("the two talking", lambda: len(samples(subscriber, HONEST)) >= 3, PATIENCE[mode])
        check("the stranger forged nothing", process.stdout.readline().startswith("forged "))
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    go_on(world, subscriber)
    again = world.events("handshake_begun_again")
    check(f"more than one event a side: {again}", len(again) <= 2)
    return len(again)


def part(world):
    """The two talk; the stranger makes a core drop the peer; they talk again."""
    subscriber = world.honest("subscribe", True)
    world.honest("publish", False, ["--keep-last", "1"])  # only its last sample comes again
    world.until("the two talking", lambda: len(samples(subscriber, HONEST)) >= 3)
    process = stranger(world, "privileged")
    try:
        world.until("a reset", lambda: world.events("session_reset_by_peer"), PATIENCE["privileged"])
        before = len(samples(subscriber, HONEST))
        world.until("the two talking again", lambda: len(samples(subscriber, HONEST)) >= before + 3, PATIENCE["privileged"])
        world.passes(8)  # the stranger is done
        check("the stranger forged nothing", process.stdout.readline().startswith("forged "))
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    got = samples(subscriber, HONEST)
    check(f"recorded samples count again: {got}", got == sorted(got))
    go_on(world, subscriber, got[-1])
    return 0


def part_for_good(world, mode):
    """The same, and what the stranger announces then keeps the core from asking our authentication about the peer again."""
    world.settings["CYCLONEDDS_URI"] = MULTICAST
    subscriber = world.honest("subscribe", True)
    world.honest("publish", False)
    world.until("the two talking", lambda: len(samples(subscriber, HONEST)) >= 3)
    forge(world, mode)
    before = len(samples(subscriber, HONEST))
    world.until("the two talking again", lambda: len(samples(subscriber, HONEST)) >= before + 30, PATIENCE[mode])
    go_on(world, subscriber, samples(subscriber, HONEST)[-1])
    return 0


def forge(world, mode):
    process = stranger(world, mode)
    try:
        check("the stranger forged nothing", process.stdout.readline().startswith("forged "))
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def remove(world):
    """The two talk; the stranger removes their endpoints in the clear, or tries to."""
    subscriber = world.honest("subscribe", True)
    publisher = world.honest("publish", False)
    world.until("the two talking", lambda: len(samples(subscriber, HONEST)) >= 3, PATIENCE["removing"])
    forge(world, "removing")
    world.passes(2)
    for peer in (publisher, subscriber):
        check(f"an endpoint is gone: {peer.lines}", "unmatched 0" not in peer.lines)
    go_on(world, subscriber)
    return 0


def ask(world):
    """The two talk; the stranger asks both for a type, in the clear, so that their processes end."""
    subscriber = world.honest("subscribe", True)
    world.honest("publish", False)
    world.until("the two talking", lambda: len(samples(subscriber, HONEST)) >= 3)
    world.passes(1)
    forge(world, "asking")
    world.passes(2)
    check("a process ended", not any(peer.ended for peer in world.peers))
    go_on(world, subscriber)
    return 0


def crowd(world):
    """The stranger invents readers in the subscriber's name; then a further process of its certificate reads, too."""
    subscriber = world.honest("subscribe", True)
    world.honest("publish", False)
    world.until("the two talking", lambda: len(samples(subscriber, HONEST)) >= 3, PATIENCE["crowding"])
    forge(world, "crowding")
    world.passes(2)
    words = world.side.arguments(world.pki, world.keys, True)
    second = world.start("second", world.kind, ["--subscribe", "--payload", str(HONEST), "--timeout", "200", *words], {})
    world.until("the further one reading", lambda: len(samples(second, HONEST)) >= 3, PATIENCE["crowding"])
    go_on(world, subscriber)
    check("an honest certificate is accused", not world.events("receiver_places_taken"))
    return 0


def redirect(world):
    """One reader, and two writers of one entity id. While the reader is stopped the stranger gives what it acknowledged to the
    writer that is ahead to the other one, which must not forget its samples for that."""
    world.settings["CYCLONEDDS_URI"] = SHORT_OF_MEMORY
    subscriber = world.honest("subscribe", True, ["--volatile"])
    world.honest("publish", False, ["--volatile"])
    words = world.side.arguments(world.pki, world.keys, False)
    world.start("ahead", world.kind, ["--publish", "--volatile", "--payload", str(FORGED), "--interval", "20", "--timeout", "200",
                                      *words], world.settings)
    process = stranger(world, "redirecting")
    try:
        world.until("the two talking", lambda: len(samples(subscriber, HONEST)) >= 3, PATIENCE["redirecting"])
        world.until("the other ahead", lambda: len(samples(subscriber, FORGED)) > 100 + len(samples(subscriber, HONEST)),
                    PATIENCE["redirecting"])
        subscriber.process.send_signal(signal.SIGSTOP)
        world.passes(1)
        process.stdin.write("now\n")
        process.stdin.flush()
        check("the stranger forged nothing", process.stdout.readline() not in ("", "forged 0\n"))
        subscriber.process.send_signal(signal.SIGCONT)
    finally:
        process.kill()
        process.wait()
        process.stdin.close()
        process.stdout.close()
    go_on(world, subscriber)
    return 0


# With origin authentication recorded messages never open again.
GOVERNANCE_OF = {"privileged": GOVERNANCES["everything-encrypt"], "removing": SROS2,
                 "redirecting": Governance(discovery="ENCRYPT", metadata="ENCRYPT"), "crowding": Governance(metadata=EO),
                 "rightless": Governance(join=False, metadata="ENCRYPT")}  # a peer without permissions may join
STORIES = {"privileged": part, "parting": lambda world: part_for_good(world, "parting"),
           "parting-both": lambda world: part_for_good(world, "parting-both"),
           "removing": remove, "crowding": crowd, "asking": ask, "redirecting": redirect}


def once(kind, mode):
    """The fault, how many sides began again, and whether an announcement was refused."""
    governance = GOVERNANCE_OF.get(mode, EVERYTHING)
    with tempfile.TemporaryDirectory(prefix="ddssec-handshake-") as folder, World(folder, kind, governance) as world:
        try:
            begun_again = STORIES[mode](world) if mode in STORIES else meet(world, mode)
            came_first = world.events("token_class_wrong") if mode == "announced" else begun_again
            return None, begun_again, bool(came_first)
        except AssertionError as one:
            return f"{one}{world.logs()}", 0, False


def attempt(case):
    _, kind, mode = case
    for _ in range(TRIES if mode in CAN_BE_LATE else 1):
        fault, again, refused = once(kind, mode)
        if fault or refused:
            break
    else:
        fault = f"no forged announcement came first in {TRIES} tries" if mode in CAN_BE_LATE else fault
    return fault, f"begun again by {again}"


def cases():
    for kind in ("ddssec", "ddssec-auth"):
        for mode in ("request", "answered", "announced"):
            yield f"{mode}/{kind}", kind, mode
    # With a stock cryptography the two stay apart where one side finishes and the other's handshake fails at its last message:
    # 3 of 60 tries. Only our cryptography tells that keys do not come.
    yield "flood/ddssec", "ddssec", "flood"
    yield "nameless/ddssec-auth", "ddssec-auth", "nameless"
    for mode in ("nameless", "nameless-elsewhere", "fewer", "rightless", "privileged", "parting", "parting-both", "early",
                 "removing", "crowding", "asking", "redirecting"):
        # With a stock cryptography the two stay apart.
        yield f"{mode}/ddssec", "ddssec", mode


if __name__ == "__main__":
    sys.exit(stories.run(cases(), attempt))

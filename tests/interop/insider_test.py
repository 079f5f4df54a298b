#!/usr/bin/env python3
"""A hostile insider against Cyclone DDS processes on our plugins: a participant with a valid certificate
that does not keep to the rules (insider/insider.cpp). A subscriber and a publisher talk to each other; then
the insider comes. It may read nothing and forge nothing, the two go on, and one event names it.

Each story is told three times: with all of our plugins, with only our cryptography beside stock ones, and
with only our access control. What a single plugin cannot prevent is not asserted there; docs/defences-in-cyclone-dds.md
says what that is.

Usage: insider_test.py BUILD [FILTER]
"""

import glob
import hashlib
import json
import os
import pathlib
import re
import selectors
import shutil
import sys
import tempfile
import time
from dataclasses import replace

sys.dont_write_bytecode = True

import pair  # noqa: E402
import stories  # noqa: E402
from documents import Governance, Keys, Permissions, Side  # noqa: E402
from pki import STARTER, Pki, der_name  # noqa: E402
from runner import LIBRARIES  # noqa: E402
from scenarios import EO, GOVERNANCES, S, SO  # noqa: E402

BUILD = pathlib.Path(sys.argv[1]).resolve()
LIBRARY = BUILD / "lib" / "libddssec_test_insider.so"
PATIENCE = 20.0  # seconds
HONEST, FORGED = 32, 48  # octets of payload, by which samples are told apart
FURTHER = 12     # samples that must come after the attack, at ten a second
INSIDER = "insider"
ZEROS = "00000000-0000-0000-0000-000000000001"  # a partition
EVERYTHING = GOVERNANCES["everything-encrypt-oa"]
MESSAGES_ONLY = Governance(rtps=EO, read=False, write=False)
SIGNED = Governance(discovery=SO, liveliness=S, rtps=S, metadata=S)
ELSEWHERE = Permissions(publish=("Elsewhere",), subscribe=("Elsewhere",))


def those_that_meet(cases, kinds_of):
    return pair.those_that_meet(pair.Programs(str(BUILD / "bin"), "", ""), cases, kinds_of)


class World:
    """A network namespace with an honest pair, which the insider may join."""

    documents = None  # the Pki of all stories, if they share one

    def __init__(self, folder, kind, governance):
        self.kind, self.folder = kind, folder
        self.pki, self.keys = self.documents or Pki(folder), Keys()
        self.side = Side(governance)
        logs = os.path.join(folder, "logs")
        os.mkdir(logs)
        self.programs = pair.Programs(str(BUILD / "bin"), str(BUILD / "dropin"), logs)
        if kind in LIBRARIES:
            os.mkdir(self.programs.plugins(kind))
            shutil.copy(BUILD / "dropin" / LIBRARIES[kind], self.programs.plugins(kind))
        self.namespace, self.peers, self.settings = pair.Namespace(), [], {}
        self._selector = selectors.DefaultSelector()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for peer in self.peers:
            peer.kill()
            peer.process.stdout.close()
        self._selector.close()
        self.namespace.close()

    def start(self, name, kind, words, variables):
        peer = pair.start(self.programs, self.namespace, kind, ["--hold", *words],
                          os.path.join(self.programs.logs, name), variables)
        self.watch(peer)
        return peer

    def watch(self, peer):
        self.peers.append(peer)
        self._selector.register(peer.process.stdout, selectors.EVENT_READ, peer)

    def honest(self, role, starts, more=()):
        return self.honest_with(role, self.side.arguments(self.pki, self.keys, starts), more)

    def honest_with(self, role, words, more=()):
        events = {"DDSSEC_EVENT_LOG": os.path.join(self.folder, f"{role}.events"), **self.settings}
        return self.start(role, self.kind, ["--" + role, "--payload", str(HONEST), "--timeout", "200", *more, *words], events)

    def insider(self, role, tamper, permissions, more=()):
        """Faster than the honest publisher, so that its numbers overtake the other's."""
        words = replace(self.side, permissions=permissions).of(INSIDER, self.pki, self.keys)
        plugins = ",".join(f"{part}={LIBRARY}" for part in ("auth", "ac", "crypto"))
        return self.start(f"insider-{role}", "stock",
                          ["--" + role, "--payload", str(FORGED), "--interval", "20", "--plugins", plugins, *more, *words],
                          {"INSIDER_TAMPER": tamper, "INSIDER_VICTIM": prefix_begin(STARTER)})

    def until(self, what, is_so, patience=PATIENCE):
        end = time.monotonic() + patience
        while not is_so():
            for key, _ in self._selector.select(0.05):
                if not key.data.read():
                    self._selector.unregister(key.fileobj)
            if time.monotonic() > end:
                raise AssertionError(f"{what} did not happen")

    def passes(self, seconds):
        end = time.monotonic() + seconds
        self.until("time passing", lambda: time.monotonic() > end, seconds + 1)

    def events(self, *codes):
        """The events of both honest processes with one of these codes."""
        found = []
        for path in glob.glob(os.path.join(self.folder, "*.events")):
            with open(path) as file:
                found += [event for event in map(json.loads, file) if event["name"] in codes]
        return found

    def logs(self):
        texts = []
        for peer in self.peers:
            lines = pathlib.Path(peer.log).read_text(errors="replace").splitlines()
            texts += [f"\n    | {os.path.basename(peer.log)}: {line[:180]}" for line in lines[1:][-12:]]
        return "".join(texts)


def prefix_begin(common_name):
    """The first six octets of its GUID: a set bit and 47 bits of the subject's hash (DDS-Security 1.2, clause 10.3.3)."""
    number = int.from_bytes(hashlib.sha256(der_name(common_name)).digest()[:6], "big")
    return f"{number >> 1 | 1 << 47:012x}"


def samples(peer, octets):
    """The numbers of the samples with that payload, in the order in which they came."""
    found = (re.fullmatch(r"sample (\d+) (\d+)(.*)", line) for line in peer.lines)
    return [int(one[1]) for one in found if one and int(one[2]) == octets]


def said(peer, text):
    return text in pathlib.Path(peer.log).read_text(errors="replace")


def prefix_of(peer):
    return re.search(r"insider: own prefix ([0-9a-f]{24})", pathlib.Path(peer.log).read_text())[1]


def check(what, is_so):
    if not is_so:
        raise AssertionError(what)


def go_on(world, subscriber, after=0):
    """The honest pair, without a gap after that sample."""
    before = len(samples(subscriber, HONEST))
    world.until("the honest pair going on", lambda: len(samples(subscriber, HONEST)) >= before + FURTHER)
    got = [number for number in samples(subscriber, HONEST) if number > after]
    check(f"samples are lost: {got}", got == list(range(got[0], got[0] + len(got))))


def one_event_names(world, code, insider, whose):
    """Exactly so many, and the insider in each by its GUID."""
    world.until(f"an event {code}", lambda: len(world.events(code)) >= whose, 5)
    world.passes(0.5)
    events = world.events(code)
    check(f"{len(events)} events {code}: {events}", len(events) == whose)
    for event in events:
        check(f"the event names {event['guid']}", event["guid"].startswith(prefix_of(insider)))


def begin(world):
    """The honest pair talks."""
    subscriber = world.honest("subscribe", False)
    world.honest("publish", True)
    world.until("the honest pair talking", lambda: len(samples(subscriber, HONEST)) >= 3)
    return subscriber


def announce(world):
    """What the host does not ask, cryptography does."""
    subscriber = begin(world)
    writer = world.insider("publish", "announce", ELSEWHERE)
    reader = world.insider("subscribe", "announce", ELSEWHERE)
    world.until("the insider's announcements", lambda: said(writer, "tampered") and said(reader, "tampered"))
    if world.kind == "ddssec":
        # One at the subscriber about the writer, one at the publisher about the reader.
        world.until("the refusals", lambda: len(world.events("match_not_permitted")) >= 2, 8)
        world.passes(1)
        events = world.events("match_not_permitted")
        check(f"not one event for each: {events}", len(events) == 2)
        wanted = {prefix_of(peer) for peer in (writer, reader)}
        check(f"they name others: {events}", {event["guid"].split(".")[0] for event in events} == wanted)
        check("they name no subject", all(INSIDER in event["peer_subject"] for event in events))
        check("they name no topic", all("Square" in event["sentence"] for event in events))
        check("the insider reads", not samples(reader, HONEST))
        check("the insider writes", not samples(subscriber, FORGED))
    go_on(world, subscriber)


def decoy(world):
    """A subscriber in every partition. The insider may write in one, and does announce a writer there. A second writer, in
    another partition, hides that it is access controlled."""
    everywhere = Side(EVERYTHING, Permissions(partition="*"))
    world.side = replace(everywhere, partition="*")
    subscriber = world.honest("subscribe", False)
    world.side = replace(everywhere, partition="Open")
    world.honest("publish", True)
    world.until("the honest pair talking", lambda: len(samples(subscriber, HONEST)) >= 3)
    insider = world.insider("publish", "decoy", Permissions(partition="Open"), ["--partition", "Hidden", "--decoy", "Open"])
    world.until("the announcement that hides", lambda: said(insider, "tampered"))
    if world.kind == "ddssec":
        world.passes(3)
        check("the insider writes", not samples(subscriber, FORGED))
        one_event_names(world, "match_not_permitted", insider, 1)
    go_on(world, subscriber)


def decoy_alone(world):
    """The control: what the insider announces honestly it may write, so its samples come."""
    everywhere = Side(EVERYTHING, Permissions(partition="*"))
    world.side = replace(everywhere, partition="*")
    subscriber = world.honest("subscribe", False)
    world.insider("publish", "decoy", Permissions(partition="Open"), ["--partition", "Open", "--decoy", "Open"])
    world.until("what it may write", lambda: len(samples(subscriber, FORGED)) >= 3)


def honest_announcement(world):
    """The control: the same insider, announcing its endpoints as they are, is refused by every mix."""
    subscriber = begin(world)
    writer = world.insider("publish", "nothing", ELSEWHERE)
    reader = world.insider("subscribe", "nothing", ELSEWHERE)
    world.until("the insider being there", lambda: said(writer, "victim prefix") and said(reader, "victim prefix"))
    go_on(world, subscriber)
    check("the insider reads", not samples(reader, HONEST))
    check("the insider writes", not samples(subscriber, FORGED))


def tokens(world, tamper):
    """Keys in another's name."""
    subscriber = begin(world)
    insider = world.insider("publish", tamper, Permissions())
    world.until("the false tokens", lambda: said(insider, "tampered"))
    if world.kind == "ddssec":
        one_event_names(world, "token_source_mismatch", insider, 2 if tamper == "participant" else 1)
    if world.kind == "ddssec-crypto":
        # A stock authentication does not tell the GUID: the two names that disagree, and the keys, are left.
        code = "keys_already_set" if tamper == "participant" else "token_source_mismatch"
        world.until("a refusal", lambda: world.events(code), 5)
        world.passes(0.5)
        check("not one event", len(world.events(code)) == 1)
    if world.kind != "ddssec-ac":
        go_on(world, subscriber)
        check("the insider's samples came", not samples(subscriber, FORGED))


def token_requests(world):
    """NACK_FRAGs for the key tokens that the publisher sends to others: the core answers each of them."""
    world.honest("publish", True)
    insider = world.insider("subscribe", "requests", ELSEWHERE)
    world.until("the requests", lambda: said(insider, "tampered"))
    subscriber = world.honest("subscribe", False)
    world.until("the honest pair talking", lambda: len(samples(subscriber, HONEST)) >= 3)
    if world.kind == "ddssec-ac":  # the control: a stock cryptography gives the keys away
        return world.until("the keys of others", lambda: said(insider, "got key tokens for another"))
    one_event_each(world, "token_fragment_not_sent", insider)
    world.passes(3)
    check("the insider got key tokens for another", not said(insider, "got key tokens for another"))
    go_on(world, subscriber)


def without_data(world, tamper):
    """Tokens that are a key, or the hash of one: Cyclone DDS reads what is not there. Or a fragment: it keeps each
    until all have come."""
    subscriber = begin(world)
    insider = world.insider("publish", tamper, ELSEWHERE)
    world.until("the tokens without data", lambda: said(insider, "tampered"))
    if world.kind == "ddssec":
        one_event_names(world, "token_source_unreadable", insider, 2)
    go_on(world, subscriber)


def restarts(world, tamper, permissions):
    """Tokens of invented endpoints, which the host would hold, come again, also from the next participant of the
    same certificate: that corrupts its memory."""
    subscriber = begin(world)
    for turn in range(3):
        insider = world.insider("publish", tamper, permissions)
        world.until("the false tokens", lambda: said(insider, "tampered"))
        if turn == 0:
            one_event_each(world, "token_source_unreadable", insider)
        insider.stop()
        world.until("the insider's end", lambda: insider.ended)
        world.passes(0.3)
    go_on(world, subscriber)
    check("the insider's samples came", not samples(subscriber, FORGED))


def one_event_each(world, code, insider):
    """At least one process refuses, each at most once, and names the insider."""
    world.until(f"an event {code}", lambda: world.events(code), 8)
    world.passes(0.5)
    events = world.events(code)
    check(f"{len(events)} events {code}: {events}", len(events) <= 2)
    if world.kind == "ddssec":
        check(f"they name others: {events}", all(event["guid"].startswith(prefix_of(insider)) for event in events))


def names(world, tamper, code="builtin_source_mismatch"):
    """Discovery and liveliness in another's name."""
    subscriber = begin(world)
    insider = world.insider("subscribe" if tamper == "speak-as" else "publish", tamper,
                            ELSEWHERE if tamper == "speak-as" else Permissions())
    world.until("the false name", lambda: said(insider, "tampered"))
    one_event_each(world, code, insider)
    check("the victim is accused", not world.events("match_not_permitted"))
    go_on(world, subscriber)


def type_information(world, tamper):
    """Announcements with type information that ends the process whose core reads it. No event is due: our plugins
    remove the type information of every peer, and do not read it."""
    subscriber = begin(world)
    honest = list(world.peers)
    roles = ("subscribe", "publish") if tamper == "circle" else ("publish",)  # two could end each other
    insiders = [world.insider(role, tamper, ELSEWHERE) for role in roles]
    world.until("the false type information", lambda: all(said(one, "tampered") for one in insiders))
    world.passes(2)
    check("a process ended", not any(peer.ended for peer in honest))
    go_on(world, subscriber)
    check("an event blames its type information", not world.events("builtin_source_unreadable"))
    check("the insider's samples came", not samples(subscriber, FORGED))


def refused(world, tamper, code="builtin_source_unreadable", permissions=ELSEWHERE):
    """What would end the victim's writer or the process: harmless fragments of which the core makes something else, or
    addresses in the form of RTPS 1, for which it frees memory that it never wrote."""
    subscriber = begin(world)
    honest = list(world.peers)
    insider = world.insider("publish", tamper, permissions)
    world.until("what the insider sends", lambda: said(insider, "tampered"))
    world.passes(2)
    check("a process ended", not any(peer.ended for peer in honest))
    go_on(world, subscriber)
    one_event_each(world, code, insider)
    check("the insider's samples came", not samples(subscriber, FORGED))


def costly(world, tamper):
    """An announcement whose matching would take the core hours: a later participant is still met."""
    world.side = Side(EVERYTHING, Permissions(partition="*"), partition=ZEROS)
    subscriber = begin(world)
    insider = world.insider("subscribe", tamper, ELSEWHERE)
    world.until("the announcement", lambda: said(insider, "tampered"))
    one_event_each(world, "builtin_source_unreadable", insider)
    late = world.honest("subscribe", False)
    world.until("a later subscriber", lambda: len(samples(late, HONEST)) >= 3)
    go_on(world, subscriber)


def source(world):
    """A message that goes on in another's name."""
    subscriber = begin(world)
    insider = world.insider("publish", "source", Permissions())
    world.until("a false source", lambda: said(insider, "tampered"))
    if world.kind != "ddssec-ac":
        # Without our authentication the plugins do not know that the name is another peer's.
        code = "info_source_of_peer" if world.kind == "ddssec" else "info_source_mismatch"
        one_event_names(world, code, insider, 1)
        go_on(world, subscriber)
        check("the insider speaks as another", not samples(subscriber, FORGED))


def cases():
    for kind in ("ddssec", "ddssec-crypto", "ddssec-ac"):
        yield f"announce/{kind}", kind, EVERYTHING, announce
        yield f"honest/{kind}", kind, EVERYTHING, honest_announcement
        yield f"decoy/{kind}", kind, EVERYTHING, decoy
        yield f"decoy-alone/{kind}", kind, EVERYTHING, decoy_alone
        for tamper in ("participant", "endpoint"):
            yield f"tokens-{tamper}/{kind}", kind, EVERYTHING, lambda world, t=tamper: tokens(world, t)
        yield f"requests/{kind}", kind, EVERYTHING, token_requests
        if kind != "ddssec-ac":
            for tamper in ("key-only", "key-hash", "fragment"):
                yield f"{tamper}/{kind}", kind, EVERYTHING, lambda world, t=tamper: without_data(world, t)
        if kind == "ddssec":
            for tamper in ("dispose", "speak-as"):
                yield f"{tamper}/{kind}", kind, EVERYTHING, lambda world, t=tamper: names(world, t)
        if kind != "ddssec-ac":
            for tamper in ("type", "circle", "many"):
                yield f"{tamper}/{kind}", kind, EVERYTHING, lambda world, t=tamper: type_information(world, t)
            # Where announcements are only signed, the core reads its own copy of them.
            yield f"circle-signed/{kind}", kind, SIGNED, lambda world: type_information(world, "circle")
            for tamper in ("splice", "splice-type"):
                yield f"{tamper}/{kind}", kind, EVERYTHING, lambda world, t=tamper: refused(world, t)
            for tamper, code, permissions in (("address", "builtin_source_unreadable", ELSEWHERE),
                                              ("address-qos", "inline_qos_refused", Permissions())):
                yield (f"{tamper}/{kind}", kind, EVERYTHING,
                       lambda world, t=tamper, c=code, p=permissions: refused(world, t, c, p))
            for tamper in ("partitions", "locators"):
                yield f"{tamper}/{kind}", kind, EVERYTHING, lambda world, t=tamper: costly(world, t)
            for tamper, permissions in (("repeat", ELSEWHERE), ("invent", Permissions()), ("nobody", Permissions())):
                yield (f"{tamper}/{kind}", kind, EVERYTHING,
                       lambda world, t=tamper, p=permissions: restarts(world, t, p))
            yield f"clear/{kind}", kind, EVERYTHING, lambda world: names(world, "clear")
            yield f"smuggle/{kind}", kind, EVERYTHING, lambda world: names(world, "smuggle", "secure_group_malformed")
        yield f"source/{kind}", kind, MESSAGES_ONLY, source


def play(chosen, name):
    """The exit status. All stories use the same keys and documents: making them takes long."""
    with tempfile.TemporaryDirectory(prefix=f"ddssec-{name}-documents-") as folder:
        World.documents = Pki(folder)
        return stories.run(chosen, stories.attempt_in(World, name))


if __name__ == "__main__":
    sys.exit(play(cases(), "insider"))

#!/usr/bin/env python3
"""Every QoS policy that DCPS puts in force, between the embedded participant and itself, and Cyclone DDS
and Fast DDS each way: match, mismatch (the status names the policy), effect. All at once in one network
namespace and one discovery, each case on topics of its own. Usage: policies.py BUILD [FILTER]"""

import heapq
import itertools
import pathlib
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
from pair import Namespace  # noqa: E402

OURS, CYCLONE, FAST = "embedded", "cyclone", "fastdds"
PATIENCE = 10.0  # seconds until what must happen has happened
(DURABILITY, DEADLINE, OWNERSHIP, LIVELINESS, RELIABILITY, DESTINATION_ORDER,
 DATA_REPRESENTATION, TYPE_CONSISTENCY) = 2, 4, 6, 8, 11, 12, 23, 24
# Cyclone DDS counts this policy behind two of its own; Fast DDS 2.9 checks none of those below, and
# refuses a reader that orders by source.
NUMBER_AT = {(CYCLONE, DATA_REPRESENTATION): 25}
FAST_DOES_NOT_CHECK = (DESTINATION_ORDER, DATA_REPRESENTATION, TYPE_CONSISTENCY)


class Peer:
    """One stack's policy peer: commands in, answers out."""

    def __init__(self, space, build, kind, log):
        self.kind = kind
        self.process = subprocess.Popen(space.enter([str(build / "bin" / f"policy_{kind}")]), text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log)
        if self.process.stdout.readline().strip() != "ready":
            raise RuntimeError(f"policy_{kind} did not start")

    def ask(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline().strip()
        if answer in ("refused", "unknown command", ""):
            raise AssertionError(f"{self.kind}: {command}: {answer or 'gone'}")
        return answer

    def status(self, endpoint):
        return {key: int(value) for key, value in
                (word.split("=") for word in self.ask(f"status {endpoint}").split()[1:])}

    def take(self, endpoint):
        return self.ask(f"take {endpoint}").split()[1:]

    def close(self):
        self.process.stdin.close()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise AssertionError(f"policy_{self.kind} hung at its end") from None
        finally:
            self.process.stdout.close()


class Case:
    """What the scenarios are written in: `w` and `r` are the writer's and the reader's side; the
    generators yield how many seconds to wait."""

    def __init__(self, writer, reader, name):
        self.w, self.r = writer, reader
        self.name = f"{name}: {writer.kind} > {reader.kind}"
        self.topic = "".join(c if c.isalnum() else "_" for c in self.name)
        self.endpoints = itertools.count()
        self.got = {}

    def writer(self, policies="", topic=""):
        endpoint = f"{self.topic}_{next(self.endpoints)}"
        self.w.ask(f"writer {endpoint} {self.topic}{topic} {policies}")
        return endpoint

    def reader(self, policies="", topic=""):
        endpoint = f"{self.topic}_{next(self.endpoints)}"
        self.r.ask(f"reader {endpoint} {self.topic}{topic} {policies}")
        return endpoint

    def until(self, what, ready):
        end = time.monotonic() + PATIENCE
        while not ready():
            if time.monotonic() > end:
                raise AssertionError(f"never {what}")
            yield 0.05

    def matched(self, writer, reader, readers=1, writers=1):
        yield from self.until("matched", lambda: self.w.status(writer)["matched"] == readers and
                              self.r.status(reader)["matched"] == writers)

    def pair(self, offered="", requested=None):
        """A matched writer and reader."""
        writer = self.writer(offered)
        reader = self.reader(offered if requested is None else requested)
        yield from self.matched(writer, reader)
        return writer, reader

    def collect(self, reader):
        self.got.setdefault(reader, []).extend(self.r.take(reader))
        return self.got[reader]

    def comes(self, reader, *expected):
        """Exactly these samples come; what came is forgotten."""
        yield from self.until(f"exactly {expected}, but {self.got.get(reader)}",
                              lambda: len(self.collect(reader)) >= len(expected))
        came = self.got.pop(reader)
        if came != list(expected):
            raise AssertionError(f"expected {expected}, came {came}")

    def check(self, what, is_so):
        if not is_so:
            raise AssertionError(what)


# ---- mismatch ---------------------------------------------------------------------------------------

MISMATCHES = [
    ("reliability", "reliability=best_effort", "reliability=reliable", RELIABILITY),
    ("durability", "durability=volatile", "durability=transient_local", DURABILITY),
    ("deadline", "deadline=2000", "deadline=1000", DEADLINE),
    ("ownership", "ownership=exclusive", "ownership=shared", OWNERSHIP),
    ("liveliness kind", "liveliness=automatic", "liveliness=topic", LIVELINESS),
    ("liveliness lease", "lease=20000", "lease=10000", LIVELINESS),
    ("destination order", "order=reception", "order=source", DESTINATION_ORDER),
    ("data representation", "representation=2", "representation=1", DATA_REPRESENTATION),
    ("type consistency", "describe=no", "describe=no types=known", TYPE_CONSISTENCY),
]

def mismatch(case, offered, requested, policy):
    writer, reader = case.writer(offered), case.reader(requested)
    for peer, endpoint in ((case.w, writer), (case.r, reader)):
        if peer.kind == FAST and policy in FAST_DOES_NOT_CHECK:
            continue
        number = NUMBER_AT.get((peer.kind, policy), policy)
        yield from case.until(f"said policy {number} at {peer.kind}",
                              lambda p=peer, e=endpoint, n=number: p.status(e)["incompatible"] == n)
        case.check(f"{peer.kind} matched", peer.status(endpoint)["matched"] == 0)


def partitions(case):
    writer = case.writer("partition=room1")
    elsewhere, reader = case.reader("partition=hall"), case.reader("partition=room*")
    yield from case.matched(writer, reader)
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")
    case.check("another partition matched", case.r.status(elsewhere)["matched"] == 0)
    if case.r.kind != CYCLONE:  # there it is one; in DDS 1.4 it is not
        case.check("a partition is called incompatible", case.r.status(elsewhere)["incompatible"] == 0)


# ---- effect -----------------------------------------------------------------------------------------

def deadline(case):
    writer, reader = yield from case.pair("deadline=300")
    case.w.ask(f"write {writer} RED 1")
    yield from case.until("missed a deadline", lambda: case.r.status(reader)["deadline"] >= 1 and
                          case.w.status(writer)["deadline"] >= 1)


def lifespan(case):
    offered = "durability=transient_local history=all lifespan=400"
    requested = "durability=transient_local history=all"
    if case.r.kind == FAST:  # a reader of it goes by its own LIFESPAN
        requested += " lifespan=400"
    writer, reader = yield from case.pair(offered, requested)
    case.w.ask(f"write {writer} RED 1")
    yield 1.2
    case.check("a sample outlived its lifespan", case.r.take(reader) == [])
    late = case.reader(requested)
    yield from case.matched(writer, late, readers=2)
    case.w.ask(f"write {writer} RED 2")
    yield from case.comes(late, "RED:2:A")


def ownership(case):
    weak = case.writer("ownership=exclusive strength=5 history=all")
    strong = case.writer("ownership=exclusive strength=10 history=all")
    reader = case.reader("ownership=exclusive history=all")
    yield from case.matched(weak, reader, writers=2)
    yield from case.matched(strong, reader, writers=2)
    case.w.ask(f"write {strong} RED 1")
    yield from case.comes(reader, "RED:1:A")
    for x in range(2, 5):
        case.w.ask(f"write {weak} RED {100 + x}")
        case.w.ask(f"write {strong} RED {x}")
    yield from case.comes(reader, "RED:2:A", "RED:3:A", "RED:4:A")
    case.w.ask(f"delete {strong}")
    yield from case.until("gone", lambda: case.r.status(reader)["matched"] == 1)
    case.w.ask(f"write {weak} RED 200")
    yield from case.until("taken over", lambda: "RED:200:A" in case.collect(reader))


def states(case):
    writer, reader = yield from case.pair("history=all")
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")
    case.w.ask(f"dispose {writer} RED")
    yield from case.until("disposed", lambda: any(s.endswith(":-:D") for s in case.collect(reader)))
    case.w.ask(f"write {writer} RED 2")
    yield from case.until("alive again", lambda: "RED:2:A" in case.collect(reader))
    if case.r.kind == FAST:  # says nothing of instances without writers, whoever writes
        return
    case.w.ask(f"unregister {writer} RED")
    yield from case.until("without writers", lambda: any(s.endswith(":-:N") for s in case.collect(reader)))
    case.w.ask(f"write {writer} GREEN 3")
    yield from case.until("there", lambda: "GREEN:3:A" in case.collect(reader))
    case.got.clear()
    case.w.ask(f"delete {writer}")
    yield from case.until("left alone", lambda: any(s.endswith(":-:N") for s in case.collect(reader)))


def deletion_disposes(case):
    """Fast DDS only unregisters, and Cyclone DDS tells its own kind alone, by a vendor's parameter."""
    ends = "D" if case.w.kind == OURS else "N"
    writer, reader = yield from case.pair("history=all autodispose=on")
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")
    case.w.ask(f"delete {writer}")
    yield from case.until("ended", lambda: any(s.endswith(":-:" + ends) for s in case.collect(reader)))


def purge(case):
    if case.r.kind != OURS:  # what others do with what they hold is not between us
        return
    writer, reader = yield from case.pair("history=all purge=300")
    kept = case.reader("history=all")
    yield from case.matched(writer, kept, readers=2)
    case.w.ask(f"write {writer} RED 1")
    case.w.ask(f"dispose {writer} RED")
    yield 1.0
    yield from case.until("kept", lambda: "RED:1:D" in case.collect(kept))
    case.check(f"not purged: {case.collect(reader)}", not case.collect(reader))


def late_joiner(case):
    writer = case.writer("durability=transient_local history=2")
    for x in range(5):
        case.w.ask(f"write {writer} RED {x}")
        case.w.ask(f"write {writer} BLUE {x}")
    reader = case.reader("durability=transient_local history=all")
    yield from case.until("got the history", lambda: len(case.collect(reader)) >= 4)
    case.check(f"not the newest two of each: {case.got[reader]}",
               sorted(case.got[reader]) == ["BLUE:3:A", "BLUE:4:A", "RED:3:A", "RED:4:A"])
    young = case.reader("history=all")
    yield from case.matched(writer, young, readers=2)
    case.w.ask(f"write {writer} RED 9")
    # Cyclone DDS sends a volatile reader what it keeps for others, whoever reads.
    old = ["RED:3:A", "BLUE:3:A", "RED:4:A", "BLUE:4:A"] if case.w.kind == CYCLONE else []
    yield from case.until("got the new sample", lambda: "RED:9:A" in case.collect(young))
    case.check(f"got something old: {case.got[young]}",
               set(case.got[young]) <= {"RED:9:A", *old})


def keep_last(case):
    writer, reader = yield from case.pair("history=all", "history=2")
    for x in range(6):
        case.w.ask(f"write {writer} RED {x}")
    case.w.ask(f"write {writer} BLUE 1")
    yield 1.0
    case.check("not the newest two", sorted(case.r.take(reader)) == ["BLUE:1:A", "RED:4:A", "RED:5:A"])


def resource_limits(case):
    if case.r.kind != OURS:
        return
    writer, reader = yield from case.pair("history=all", "history=all samples=2")
    for x in range(5):
        case.w.ask(f"write {writer} RED {x}")
    yield from case.until("rejected", lambda: case.r.status(reader)["rejected"] >= 1)
    yield from case.comes(reader, *(f"RED:{x}:A" for x in range(5)))


def manual_by_topic(case):
    writer, reader = yield from case.pair("liveliness=topic lease=600 history=all",
                                          "history=all lease=600")
    case.w.ask(f"write {writer} RED 1")
    for _ in range(6):
        yield 0.2
        case.w.ask(f"assert {writer}")
    case.check("not asserted", case.r.status(reader)["alive"] == 1)
    if case.r.kind == FAST:  # never misses a writer of this kind, whoever writes
        return
    yield from case.until("lost its writer", lambda: case.r.status(reader)["not_alive"] == 1)
    yield from case.until("lost its liveliness", lambda: case.w.status(writer)["lost"] >= 1)
    case.w.ask(f"write {writer} RED 2")
    yield from case.until("found its writer again", lambda: case.r.status(reader)["alive"] == 1)


def manual_by_participant(case):
    writer, reader = yield from case.pair("liveliness=participant lease=600 history=all",
                                          "history=all lease=600")
    for _ in range(6):
        yield 0.2
        case.w.ask(f"assert {writer}")
    case.check("not asserted", case.r.status(reader)["alive"] == 1)


def automatic(case):
    writer, reader = yield from case.pair("liveliness=automatic lease=700")
    case.w.ask(f"write {writer} RED 1")
    for _ in range(10):
        yield 0.2
        case.check("not asserted", case.r.status(reader)["alive"] == 1)


def by_source(case):
    if FAST in (case.w.kind, case.r.kind):
        return
    writer = case.writer("order=source history=all")
    other = case.writer("order=source history=all")
    reader = case.reader("order=source history=all")
    yield from case.matched(writer, reader, writers=2)
    yield from case.matched(other, reader, writers=2)
    case.w.ask(f"write {writer} RED 2 2000")
    yield from case.comes(reader, "RED:2:A")
    case.w.ask(f"write {other} RED 1 1000")
    case.w.ask(f"write {other} RED 3 3000")
    yield from case.comes(reader, "RED:3:A")


def representation_2(case):
    if FAST in (case.w.kind, case.r.kind):
        return
    writer, reader = yield from case.pair("representation=2 history=all")
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")


def type_consistency(case):
    """A reader that wants to know the type, and the same: Fast DDS 2.9 tells nothing of types."""
    if FAST in (case.w.kind, case.r.kind):
        return
    writer, reader = yield from case.pair("history=all", "history=all types=same")
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")


def content_filter(case):
    if case.r.kind == CYCLONE:  # its filters are functions of the application's own
        return
    few = case.reader("history=all filter=x>2")  # Fast DDS cannot read x>=2 without spaces
    blue = case.reader("history=all filter=color='BLUE'")
    writer = case.writer("history=all")
    for reader in (few, blue):
        yield from case.matched(writer, reader, readers=2)
    for x in range(6):
        case.w.ask(f"write {writer} RED {x}")
    case.w.ask(f"write {writer} BLUE 1")
    yield from case.comes(few, "RED:3:A", "RED:4:A", "RED:5:A")
    yield from case.comes(blue, "BLUE:1:A")
    if case.r.kind == OURS:
        case.check("what was filtered counts as lost", case.r.status(few)["samples_lost"] == 0)


def filtered_history(case):
    """A late joiner asks for what its filter lets pass, and the writer answers with GAP for the rest."""
    if case.r.kind == CYCLONE:
        return
    writer = case.writer("durability=transient_local history=all")
    for x in range(6):
        case.w.ask(f"write {writer} RED {x}")
    few = case.reader("durability=transient_local history=all filter=x>3")
    yield from case.matched(writer, few)
    yield from case.comes(few, "RED:4:A", "RED:5:A")


def time_based_filter(case):
    if case.r.kind != OURS:
        return
    writer, reader = yield from case.pair("history=all", "history=all separation=700")
    for x in range(10):
        case.w.ask(f"write {writer} RED {x}")
    yield 0.3
    case.check("more than one came", case.collect(reader) == ["RED:0:A"])
    yield from case.comes(reader, "RED:0:A", "RED:9:A")


EFFECTS = [partitions, deadline, lifespan, ownership, states, deletion_disposes, purge,
           late_joiner, keep_last, resource_limits,
           manual_by_topic, manual_by_participant, automatic, by_source, representation_2,
           type_consistency,
           content_filter, filtered_history, time_based_filter]


# ---- all at once --------------------------------------------------------------------------------------

def scenarios(peers, second, wanted):
    for writer, reader in ((OURS, OURS), (OURS, CYCLONE), (CYCLONE, OURS), (OURS, FAST), (FAST, OURS)):
        ends = peers[writer], second if writer == reader else peers[reader]
        for name, offered, requested, policy in MISMATCHES:
            if (FAST in (writer, reader) and policy == DATA_REPRESENTATION or
                    reader == FAST and policy in (DESTINATION_ORDER, TYPE_CONSISTENCY)):
                continue
            case = Case(*ends, f"{name} mismatch")
            if wanted in case.name:
                yield case, mismatch(case, offered, requested, policy)
        for effect in EFFECTS:
            case = Case(*ends, effect.__name__.replace("_", " "))
            if wanted in case.name:
                yield case, effect(case)


def run(all_scenarios):
    """Steps each scenario when its time has come; the faults, by name."""
    order = itertools.count()
    waiting = [(0.0, next(order), case, steps) for case, steps in all_scenarios]
    faults = {case.name: None for _, _, case, _ in waiting}
    while waiting:
        due, _, case, steps = heapq.heappop(waiting)
        time.sleep(max(0.0, due - time.monotonic()))
        try:
            heapq.heappush(waiting, (time.monotonic() + next(steps), next(order), case, steps))
        except StopIteration:
            pass
        except AssertionError as fault:
            faults[case.name] = str(fault)
    return faults


def main():
    build, wanted = pathlib.Path(sys.argv[1]).resolve(), (sys.argv[2:] or [""])[0]
    space = Namespace()
    with tempfile.TemporaryFile("w+") as log:
        peers = {kind: Peer(space, build, kind, log) for kind in (OURS, CYCLONE, FAST)}
        second = Peer(space, build, OURS, log)
        faults = run(list(scenarios(peers, second, wanted)))
        for peer in (*peers.values(), second):
            peer.close()
        space.close()
        log.seek(0)
        complaints = [line for line in log.read().splitlines() if "malformed" in line.lower()]
    for name, fault in faults.items():
        print(f"{'FAILED' if fault else 'ok':8}{name}{': ' + fault if fault else ''}")
    print("\n".join(complaints[:10]))
    return 1 if complaints or any(faults.values()) or not faults else 0


if __name__ == "__main__":
    sys.exit(main())

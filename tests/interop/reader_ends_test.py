#!/usr/bin/env python3
"""A process deletes readers, and stays, or ends in order. The writers hear that, as without security: two of ours, also where the writer
comes after the readers have gone, and a writer on stock plugins. Cyclone's core says the end of a reader outside of any protection,
where discovery is protected; our plugins say it inside (plugins/cyclonedds/own_readers.hpp), and the end of a participant by
a token (plugins/cyclonedds/lost_sessions.hpp). Where the readers are on stock plugins, a writer of the embedded participant asks
them (rtps/participant/reader_end_checks.hpp).

Usage: reader_ends_test.py BUILD [FILTER]
"""

import sys
import tempfile

sys.dont_write_bytecode = True

import stories  # noqa: E402
from insider_test import EVERYTHING, HONEST, World, check, samples, those_that_meet  # noqa: E402
from documents import Governance  # noqa: E402
from scenarios import EO, SROS2  # noqa: E402

PASSING = 20   # readers
PATIENCE = 25  # seconds
SOON = 5       # seconds, if the embedded participant ends, which proves it
ASKED = 8      # seconds; a reader is asked for four, and a lease is ten
STAYS = 3      # seconds in which nothing else may be heard
GOVERNANCES = {"sros2": SROS2, "everything": EVERYTHING,
               "origin": Governance(discovery=EO, liveliness=EO, rtps=EO, metadata=EO, data="ENCRYPT"),
               "discovery": Governance(discovery="ENCRYPT", read=False, write=False)}

DATA_ONLY = Governance(data="ENCRYPT")


class Ends(World):
    def readers(self):
        return self.honest("subscribe", True, ["--passing", str(PASSING)])

    def writer(self, kind):
        words = self.side.arguments(self.pki, self.keys, False)
        return self.start("publish", kind, ["--publish", "--payload", str(HONEST), "--timeout", "200", *words], self.settings)


def matched(writer):
    """The number of readers that it has, as it said last."""
    said = [line.split()[1] for line in writer.lines if line.startswith(("matched ", "unmatched "))]
    return int(said[-1]) if said else 0


def has_gone(readers):
    return "the passing readers are deleted" in readers.lines


def one_is_left(world, writer, readers):
    world.until("the writer hearing of the ends", lambda: matched(writer) == 1, PATIENCE)
    world.passes(STAYS)
    check(f"the writer has {matched(writer)} readers", matched(writer) == 1)
    before = len(samples(readers, HONEST))
    world.until("the reader that is left hearing on", lambda: len(samples(readers, HONEST)) >= before + 5, PATIENCE)


def they_end(world, kind):
    writer, readers = world.writer(kind), world.readers()
    world.until("all readers being met", lambda: matched(writer) == PASSING + 1, PATIENCE)
    world.until("the readers leaving", lambda: has_gone(readers), PATIENCE)
    one_is_left(world, writer, readers)


def they_have_ended(world, kind):
    """They end before the writer comes. The host still announces them to the writer, and our plugins announce their end."""
    readers = world.readers()
    world.until("the readers leaving", lambda: has_gone(readers), PATIENCE)
    writer = world.writer(kind)
    world.until("the two talking", lambda: len(samples(readers, HONEST)) >= 3, PATIENCE)
    one_is_left(world, writer, readers)


def process_ends(world, kind):
    writer, reader = world.writer(kind), world.honest("subscribe", True)
    world.until("the two talking", lambda: len(samples(reader, HONEST)) >= 3, PATIENCE)
    reader.stop()
    world.until("the writer hearing of the end", lambda: matched(writer) == 0, SOON if world.kind == "embedded" else ASKED)


def writer_ends(world, kind):
    writer, reader = world.writer(kind), world.honest("subscribe", True)
    world.until("the two talking", lambda: len(samples(reader, HONEST)) >= 3, PATIENCE)
    writer.stop()
    world.until("the reader hearing of the end", lambda: matched(reader) == 0, SOON)


def attempt(case):
    _, story, kind, governance, readers = case
    with tempfile.TemporaryDirectory(prefix="ddssec-reader-ends-") as folder, Ends(folder, readers, governance) as world:
        try:
            story(world, kind)
            return None, ""
        except AssertionError as one:
            said = [line for peer in world.peers for line in peer.lines if "atched" in line]
            return f"{one}; said: {said[-4:]}{world.logs()}", ""


def cases():
    for name, governance in GOVERNANCES.items():
        yield f"end/{name}/ddssec", they_end, "ddssec", governance, "ddssec"
        yield f"process/{name}/ddssec", process_ends, "ddssec", governance, "ddssec"
        yield f"end/{name}/embedded<stock", they_end, "embedded", governance, "stock"
        for readers in ("ddssec", "stock"):
            yield f"process/{name}/embedded<{readers}", process_ends, "embedded", governance, readers
    for name, governance in (GOVERNANCES | {"data": DATA_ONLY}).items():
        yield f"process/{name}/embedded<embedded", process_ends, "embedded", governance, "embedded"
        yield f"writer/{name}/embedded>embedded", writer_ends, "embedded", governance, "embedded"
    for name in ("sros2", "everything"):
        yield f"ended/{name}/ddssec", they_have_ended, "ddssec", GOVERNANCES[name], "ddssec"
    for kind in ("stock", "fast", "embedded"):
        yield f"end/sros2/{kind}", they_end, kind, SROS2, "ddssec"
        yield f"ended/sros2/{kind}", they_have_ended, kind, SROS2, "ddssec"


if __name__ == "__main__":
    sys.exit(stories.run(those_that_meet(cases(), lambda case: (case[2], case[4])), attempt, at_once=4))

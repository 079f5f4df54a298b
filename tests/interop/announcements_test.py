#!/usr/bin/env python3
"""Announcements that Cyclone DDS sends in fragments, of 1344 octets each: long partitions, and user data of a
participant and its endpoints. The endpoints that have them match, those made later do too, and no event accuses a peer.

Usage: announcements_test.py BUILD [FILTER]
"""

import json
import os
import pathlib
import selectors
import sys
import tempfile
import time

sys.dont_write_bytecode = True

import pair  # noqa: E402
import stories  # noqa: E402
from documents import Governance, Keys, Permissions, Side  # noqa: E402
from pki import Pki  # noqa: E402
from scenarios import GOVERNANCES, S, SROS2  # noqa: E402

BUILD = pathlib.Path(sys.argv[1]).resolve()
PATIENCE = 40.0  # seconds
WANTED = 5       # samples
LARGE = 100_000  # octets of a sample: metadata protection of fragments that are no announcements
PAIRS = (("ddssec", "ddssec"), ("stock", "ddssec"), ("ddssec", "stock"))
PARTITIONS = ("--partition", "p" * 1000, "--user-data", "600")  # longer names are refused


def user_data(octets):
    return "--user-data", str(octets)


def cases():
    """(name, publisher, subscriber, governance, words)"""
    for publisher, subscriber in PAIRS:
        pair_name = f"{publisher}>{subscriber}"
        yield f"partitions/{pair_name}", publisher, subscriber, SROS2, PARTITIONS
        for octets in (1400, 20_000):
            yield f"user-data-{octets}/{pair_name}", publisher, subscriber, SROS2, user_data(octets)
    yield "sign/ddssec>ddssec", "ddssec", "ddssec", Governance(discovery=S, read=False, write=False), user_data(20_000)
    yield "origin/ddssec>ddssec", "ddssec", "ddssec", GOVERNANCES["everything-encrypt-oa"], user_data(20_000)
    yield "samples/ddssec>ddssec", "ddssec", "ddssec", SROS2, (*user_data(3000), "--payload", str(LARGE))


def events(folder):
    found = []
    for path in pathlib.Path(folder).glob("*.events"):
        found += [json.loads(line) for line in path.read_text().splitlines()]
    return [event for event in found if event["name"].startswith("builtin_")]


def talk(case, folder, namespace, peers):
    _, publisher, subscriber, governance, words = case
    pki, keys, side = Pki(folder), Keys(), Side(governance, Permissions(partition="*"))
    logs = os.path.join(folder, "logs")
    os.mkdir(logs)
    programs = pair.Programs(str(BUILD / "bin"), str(BUILD / "dropin"), logs)
    for role, kind in (("subscribe", subscriber), ("publish", publisher)):
        arguments = ["--hold", "--" + role, *words, "--timeout", "60",
                     *side.arguments(pki, keys, role == "publish")]
        peers.append(pair.start(programs, namespace, kind, arguments, os.path.join(logs, role),
                                {"DDSSEC_EVENT_LOG": os.path.join(folder, role + ".events")}))
    with selectors.DefaultSelector() as selector:
        for peer in peers:
            selector.register(peer.process.stdout, selectors.EVENT_READ, peer)
        end = time.monotonic() + PATIENCE
        while sum(line.startswith("sample ") for line in peers[0].lines) < WANTED:
            for key, _ in selector.select(0.1):
                if not key.data.read():
                    raise AssertionError(f"{key.data.log} ended")
            if time.monotonic() > end:
                raise AssertionError("no samples came")
    if accused := events(folder):
        raise AssertionError(f"honest announcements are refused: {accused}")


def attempt(case):
    peers = []
    with tempfile.TemporaryDirectory(prefix="ddssec-announcements-") as folder:
        namespace = pair.Namespace()
        try:
            talk(case, folder, namespace, peers)
        except AssertionError as one:
            logs = [line[:300] for peer in peers for line in pathlib.Path(peer.log).read_text().splitlines()[1:][-8:]]
            return "\n    | ".join([str(one), *logs, *map(str, events(folder))]), ""
        finally:
            for peer in peers:
                peer.kill()
                peer.process.stdout.close()
            namespace.close()
    return None, ""


if __name__ == "__main__":
    sys.exit(stories.run(cases(), attempt))

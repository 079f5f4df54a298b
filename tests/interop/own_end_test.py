#!/usr/bin/env python3
"""The certificate or the permissions of a running process end, or its certificate is revoked. It is cut off: it hears no further
sample, and is refused every further topic, writer and reader. The process goes on, and ends as any other. Cyclone's core would delete
the participant beneath the application's entities, and end the process at the next call, so our plugins do not tell it. The same
holds for a process whose two participants have the same documents.

Usage: own_end_test.py BUILD [FILTER]
"""

import os
import sys
import tempfile
from dataclasses import replace

sys.dont_write_bytecode = True

import stories  # noqa: E402
from insider_test import EVERYTHING, HONEST, World, check, samples  # noqa: E402
from pki import STARTER  # noqa: E402
from scenarios import SROS2  # noqa: E402

LIVES = 9        # seconds that a document is valid; the process has to start meanwhile
LATE = 20        # seconds until the process makes further entities
PATIENCE = 40    # seconds
ON_ITS_WAY = 2   # seconds a sample may come after the end
REFUSED = "topic Not Allowed By Security, writer Not Allowed By Security, reader Not Allowed By Security"
PERMISSIONS, CERTIFICATE = "permissions_seconds", "identity_seconds"
ENDS = {"permissions": ((PERMISSIONS,), "grant_expired"), "certificate": ((CERTIFICATE,), "identity_ended"),
        "both": ((PERMISSIONS, CERTIFICATE), "identity_ended"), "revocation": ((), "certificate_revoked")}


def revoke(world):
    """A new list in the place of the one that the subscriber reads."""
    issuer = world.pki.ca("identity-main", world.keys.identity_ca)
    in_use = world.pki.crl(issuer, world.pki.leaf("stranger", world.keys.leaf, issuer), "in-use")
    new = world.pki.crl(issuer, world.pki.leaf(STARTER, world.keys.leaf, issuer), "new")
    return in_use, lambda: os.replace(new, in_use)


def companion(words):
    """Another participant of the process with the same documents."""
    names = ("identity_certificate", "private_key", "permissions")
    return ["--companion", ",".join([words[words.index("--" + name) + 1] for name in names] + ["1000000"])]


def story(world, what, publisher, two):
    ends, code = ENDS[what]
    more, end = ["--late", str(LATE)], lambda: None
    if not ends:
        in_use, end = revoke(world)
        more += ["--crl", in_use]
    words = world.side.arguments(world.pki, world.keys, False)
    world.start("publish", publisher, ["--publish", "--payload", str(HONEST), "--timeout", "200", *words], {})
    world.side = replace(world.side, **{name: LIVES for name in ends})
    own = world.side.arguments(world.pki, world.keys, True)
    subscriber = world.honest_with("subscribe", own, more + (companion(own) if two else []))
    world.until("the two talking", lambda: len(samples(subscriber, HONEST)) >= 12)
    end()
    world.until("the end", lambda: world.events(code), PATIENCE)
    world.passes(ON_ITS_WAY)
    heard = len(samples(subscriber, HONEST))
    world.until("the further entities", lambda: any(line.startswith("late: ") for line in subscriber.lines), PATIENCE)
    for one in ["late: ", "late companion: "] if two else ["late: "]:
        check(f"not refused: {[line for line in subscriber.lines if 'late' in line]}", one + REFUSED in subscriber.lines)
    world.passes(ON_ITS_WAY)
    check("samples came after the end", len(samples(subscriber, HONEST)) == heard)
    check("the process ended", not subscriber.ended)
    subscriber.stop()
    subscriber.process.wait(20)
    check(f"exit code {subscriber.process.returncode}", subscriber.process.returncode == 0)


def attempt(case):
    _, what, publisher, governance, two = case
    with tempfile.TemporaryDirectory(prefix="ddssec-own-end-") as folder, World(folder, "ddssec", governance) as world:
        try:
            story(world, what, publisher, two)
            return None, ""
        except AssertionError as one:
            return f"{one}{world.logs()}", ""


def cases():
    for what in ENDS:
        yield f"{what}/sros2/ddssec", what, "ddssec", SROS2, False
    yield "certificate/everything/ddssec", "certificate", "ddssec", EVERYTHING, False
    yield "permissions/sros2/stock", "permissions", "stock", SROS2, False
    for what in ("permissions", "certificate", "both"):
        yield f"{what} of two/sros2/ddssec", what, "ddssec", SROS2, True


if __name__ == "__main__":
    sys.exit(stories.run(cases(), attempt, at_once=5))

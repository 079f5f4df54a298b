#!/usr/bin/env python3
"""OCSP responses (ocsp_status) between real processes: our plugins in Cyclone DDS and the embedded participant, with a
policy that demands a response, and beside stock peers, which go on talking when they get one.

Usage: ocsp_test.py BUILD [FILTER]
"""

import os
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True

import stories  # noqa: E402
from insider_test import HONEST, World, check, said, samples, those_that_meet  # noqa: E402
from pki import STARTER, WAITER  # noqa: E402
from scenarios import SROS2  # noqa: E402

TALKING = 5       # samples
SILENCE = 4       # seconds in which nothing comes
PATIENCE = 60     # seconds; a handshake that was refused is tried again
OURS = ("ddssec", "embedded")


def openssl(*words):
    done = subprocess.run(["openssl", *words], capture_output=True, text=True)
    check(f"openssl {' '.join(words)}: {done.stderr}", done.returncode == 0)
    return done.stdout


class Responder:
    """The CA's responder, without a network: openssl ocsp answers a request that lies in a file."""

    def __init__(self, world):
        self.folder, self.ca = world.folder, world.pki.ca("identity-main", world.keys.identity_ca)
        self.world = world

    def certificate(self, name):
        return self.world.pki.leaf(name, self.world.keys.leaf, self.ca)

    def answer(self, name, is_revoked, to):
        certificate = self.certificate(name)
        serial = openssl("x509", "-in", certificate, "-noout", "-serial").strip().split("=")[1]
        index, request = f"{to}.index", f"{to}.request"
        with open(index, "w", encoding="ascii") as file:
            state = "R\t400101000000Z\t250101000000Z" if is_revoked else "V\t400101000000Z\t"
            file.write(f"{state}\t{serial}\tunknown\t/O=interop/CN={name}\n")
        openssl("ocsp", "-issuer", f"{self.ca}/cert.pem", "-cert", certificate, "-no_nonce", "-reqout", request)
        openssl("ocsp", "-index", index, "-CA", f"{self.ca}/cert.pem", "-rsigner", f"{self.ca}/cert.pem",
                "-rkey", f"{self.ca}/key.pem", "-rmd", "sha256", "-ndays", "1", "-reqin", request, "-respout", to + ".new")
        os.replace(to + ".new", to)


class Meeting(World):
    """A publisher and a subscriber with a policy; each may have a response."""

    def __init__(self, folder):
        super().__init__(folder, "ddssec", SROS2)
        self.responder = Responder(self)

    def response_of(self, role):
        return os.path.join(self.folder, role + ".ocsp")

    def put(self, role, starts, is_revoked=False):
        self.responder.answer(STARTER if starts else WAITER, is_revoked, self.response_of(role))

    def join(self, role, kind, starts, policy):
        properties = os.path.join(self.folder, role + ".properties")
        with open(properties, "w", encoding="utf-8") as file:
            file.write("org.ddssec.files_poll_interval = 1\n"
                       f"org.ddssec.auth.ocsp_response = file:{self.response_of(role)}\n"
                       f"org.ddssec.auth.ocsp = {policy}\n")
        variables = {"DDSSEC_PROPERTIES": properties,
                     "DDSSEC_EVENT_LOG": os.path.join(self.folder, role + ".events")} if kind in OURS else {}
        return self.start(role, kind, ["--" + role, "--payload", str(HONEST), "--timeout", "200",
                                       *self.side.arguments(self.pki, self.keys, starts)], variables)

    def talk(self, subscriber):
        before = len(samples(subscriber, HONEST))
        self.until("the two talking", lambda: len(samples(subscriber, HONEST)) >= before + TALKING, PATIENCE)

    def silent(self, subscriber):
        self.passes(SILENCE)
        check("samples came", not samples(subscriber, HONEST))

    def one_says(self, text):
        self.until(text, lambda: any(said(peer, text) for peer in self.peers))


def good(world, publisher, subscriber, starts, policy):
    """Both have a response: those that get one talk."""
    for role, kind, begins in (("publish", publisher, starts), ("subscribe", subscriber, not starts)):
        if kind in OURS:
            world.put(role, begins)
    hears = world.join("subscribe", subscriber, not starts, policy)
    says = world.join("publish", publisher, starts, policy)
    world.talk(hears)
    for peer in (hears, says):
        check("a response is not used", not said(peer, "ocsp_status_unused"))


def absent(world, publisher, subscriber, starts, policy):
    """The publisher has no response, and is refused until it has one."""
    world.put("subscribe", not starts)
    hears = world.join("subscribe", subscriber, not starts, policy)
    says = world.join("publish", publisher, starts, policy)
    world.one_says("ocsp_status_missing 1380")
    world.silent(hears)
    if publisher not in OURS:
        return
    world.put("publish", starts)
    if publisher == "embedded":  # it begins anew after 100 s only
        says.kill()
        world.join("publish", publisher, starts, policy)
    world.talk(hears)


def revoked(world, publisher, subscriber, starts, policy):
    """A participant whose own response says so does not start, and a running one ends."""
    world.put("subscribe", not starts)
    world.put("publish", starts)
    hears = world.join("subscribe", subscriber, not starts, policy)
    says = world.join("publish", publisher, starts, policy)
    world.talk(hears)
    world.put("publish", starts, True)
    world.until("the end", lambda: said(says, "ocsp_revoked 1187"))
    world.passes(2)
    heard = len(samples(hears, HONEST))
    world.passes(SILENCE)
    check("samples came after the end", len(samples(hears, HONEST)) == heard)
    says.kill()
    again = world.join("publish", publisher, starts, policy)
    world.until("the refusal", lambda: again.ended)
    check("no log says why", said(again, "ocsp_revoked 1187"))


def cases():
    for kind in OURS:
        yield f"hard/good/{kind}", good, kind, kind, "hard"
        yield f"hard/absent/{kind}", absent, kind, kind, "hard"
        yield f"soft/revoked/{kind}", revoked, kind, kind, "soft"
    yield "hard/good/ddssec with embedded", good, "ddssec", "embedded", "hard"
    for ours in OURS:
        for stock in ("stock", "fast"):
            yield f"soft/good/{ours} to {stock}", good, ours, stock, "soft"
            yield f"soft/good/{stock} to {ours}", good, stock, ours, "soft"
            yield f"hard/absent/{stock} to {ours}", absent, stock, ours, "hard"


def attempt(case):
    _, story, publisher, subscriber, policy = case
    for starts in (True, False):
        with tempfile.TemporaryDirectory(prefix="ddssec-ocsp-") as folder, Meeting(folder) as world:
            try:
                story(world, publisher, subscriber, starts, policy)
            except AssertionError as one:
                return f"publisher {'starts' if starts else 'waits'}: {one}{world.logs()}", ""
    return None, ""


if __name__ == "__main__":
    sys.exit(stories.run(those_that_meet(cases(), lambda case: case[2:4]), attempt, at_once=6))

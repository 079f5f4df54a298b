#!/usr/bin/env python3
"""A process with two secured participants of one domain on our plugins in Cyclone DDS, and another process
that talks to both: one of the two leaves, or comes to its end, and the other goes on without losing anything.
While both stay, the process takes no more memory with every message. If they admit unauthenticated participants, the second
one is not created.

Usage: two_participants_test.py BUILD [FILTER]    the filter "long/" runs what takes minutes
"""

import concurrent.futures
import os
import pathlib
import re
import selectors
import sys
import tempfile
import time
from dataclasses import replace

sys.dont_write_bytecode = True

import pair  # noqa: E402
from documents import COMPANION, Keys, Side  # noqa: E402
from pki import STARTER, Pki  # noqa: E402
from scenarios import GOVERNANCES, GUESTS_ENCRYPTED  # noqa: E402

BUILD = pathlib.Path(sys.argv[1]).resolve()
PATIENCE = 25.0  # seconds; the peers end by themselves after 27
FURTHER = 15     # samples that the other one must hear afterwards, at ten a second
LONG = "long/"
NEVER = 10 ** 6  # samples
VALID = (6, 16)  # seconds a companion's documents are valid; the first may be too few to be heard in
ENDED = re.compile(r"identity_ended|grant_expired")
REVOKED = re.compile(r"certificate_revoked")
OF_BOTH = 200  # seconds; 80, and more than the core's timer afterwards
ON_ITS_WAY = 1.0  # seconds a sample may come after that
# Large samples, as fast as the peers go: a result lost for each datagram is some 16 KiB a sample.
FAST = ("--interval", "1", "--payload", "16000")
WARM_UP, MEASURED = 200, 1000  # samples that both heard
GROWTH = 4096  # KiB the process may take more for MEASURED samples, of 15625 KiB in all
# What a host would be told if it used handles of a participant that is gone.
MISTAKES = re.compile(r"unknown_identity|crypto_handle_unknown|crypto_not_matched|unknown_permissions")


class TooLate(AssertionError):
    """The companion's documents ended before it heard anything."""


class Watched:
    """A publisher and the process of two, followed until something was said."""

    def __init__(self, publisher, subscriber):
        self.both = self.publisher, self.subscriber = publisher, subscriber
        self._selector = selectors.DefaultSelector()
        for peer in self.both:
            self._selector.register(peer.process.stdout, selectors.EVENT_READ, peer)

    def until(self, what, is_so):
        end = time.monotonic() + PATIENCE
        while not is_so():
            for key, _ in self._selector.select(0.05):
                if not key.data.read():
                    self._selector.unregister(key.fileobj)
            ended = [peer.process.returncode for peer in self.both if peer.ended]
            if ended or time.monotonic() > end:
                raise AssertionError(f"{what} did not happen; ended: {ended}")

    def logged(self, pattern):
        """The lines of both logs that the pattern fits."""
        texts = (pathlib.Path(peer.log).read_text(errors="replace") for peer in self.both)
        return [line for text in texts for line in text.splitlines() if pattern.search(line)]

    @property
    def samples(self):
        return [int(line.split()[1]) for line in self.subscriber.lines if line.startswith("sample ")]

    @property
    def kibibytes(self):
        """The memory that the process of two has at this moment."""
        status = pathlib.Path(f"/proc/{self.subscriber.process.pid}/status").read_text()
        return int(re.search(r"^VmRSS:\s+(\d+) kB", status, re.MULTILINE).group(1))

    @property
    def companions_last(self):
        """The number of the newest sample that the companion heard; -1 before the first."""
        return max((int(line.split()[2]) for line in self.subscriber.lines
                    if line.startswith("companion hears ")), default=-1)

    def stop(self):
        """The exit codes."""
        self._selector.close()
        for peer in self.both:
            peer.stop()
        for peer in self.both:
            peer.process.wait(pair.STOP_LIMIT)
            while peer.read():
                pass
        return [peer.process.returncode for peer in self.both]


def check(what, is_so):
    if not is_so:
        raise AssertionError(what)


def goes_on(watched):
    """The remaining participant gets every further sample in order, and no handle is used after its end."""
    before = len(watched.samples)
    watched.until("the other one hearing on", lambda: len(watched.samples) >= before + FURTHER)
    mistakes = watched.logged(MISTAKES)
    check(f"handles were mistaken: {mistakes[:3]}", not mistakes)
    codes = watched.stop()
    check(f"exit codes {codes}", codes == [0, 0])
    got = watched.samples
    check(f"lost some: {got}", got == list(range(got[0], got[0] + len(got))))


def leaves(watched):
    watched.until("the companion leaving", lambda: "companion left" in watched.subscriber.lines)
    watched.until("both being known to the publisher", lambda: "matched 2" in watched.publisher.lines)
    goes_on(watched)


def ends(watched):
    """Its permissions, or its certificate: it is cut off."""
    watched.until("its end", lambda: watched.logged(ENDED))
    if watched.companions_last < 0:
        raise TooLate("it ended before it heard anything")
    goes_on(watched)


def is_distrusted(watched, lists):
    """The one finds the publisher on a new revocation list. Cyclone's core knows it once for both and
    removes it; the companion, who has no such list, meets it again. (Not if it is Cyclone DDS: its core
    keeps to the handshake that it has finished.)"""
    watched.until("both hearing", lambda: watched.samples and watched.companions_last >= 0)
    in_use, new = lists
    os.replace(new, in_use)
    watched.until("its revocation", lambda: watched.logged(REVOKED))
    end = time.monotonic() + ON_ITS_WAY
    watched.until("a second passing", lambda: time.monotonic() > end)
    heard, last = len(watched.samples), watched.companions_last
    watched.until("the companion hearing on", lambda: watched.companions_last >= last + FURTHER)
    check("who distrusts it hears on", len(watched.samples) == heard)
    watched.stop()


def answers_one_alone(watched, times):
    """The publisher distrusts the companion, and answers it nothing. Cyclone DDS would end that handshake by a timer after
    100 seconds, and hang or end by a fault. Instead it stays, after the session of the other was begun again `times`."""
    begin = time.monotonic()
    watched.until("the publisher beginning", lambda: watched.samples)
    while time.monotonic() < begin + OF_BOTH:
        heard = len(watched.samples)
        watched.until("the other one hearing on", lambda: len(watched.samples) >= heard + FURTHER)
    log = pathlib.Path(watched.subscriber.log).read_text(errors="replace")
    check("the core's timer ended a handshake", "Timed out" not in log)
    said = [line for line in log.splitlines() if "another participant of this process" in line]
    check(f"it was begun again other than {times} times: {said}", len(said) == times)
    check("the companion heard something", watched.companions_last < 0)
    codes = watched.stop()
    check(f"exit codes {codes}", codes == [0, 0])


def stays_small(watched):
    """Cyclone's core asks for each message once for each of the two."""
    def both_heard(count):
        return len(watched.samples) >= count and watched.companions_last >= count - 1
    watched.until("a start", lambda: both_heard(WARM_UP))
    before, heard = watched.kibibytes, len(watched.samples)
    watched.until("both hearing much more", lambda: both_heard(heard + MEASURED))
    growth = watched.kibibytes - before
    check(f"{growth} KiB more for {MEASURED} samples", growth <= GROWTH)
    codes = watched.stop()
    check(f"exit codes {codes}", codes == [0, 0])
    got = watched.samples
    check("lost some", got == list(range(got[0], got[0] + len(got))))
    return f"{growth} KiB more for {len(got) - heard} samples"


def guests():
    """Two that admit unauthenticated participants: one datagram would end the process (tests of 1608)."""
    with tempfile.TemporaryDirectory(prefix="ddssec-two-") as folder:
        pki, keys, side = Pki(folder), Keys(), Side(GUESTS_ENCRYPTED)
        programs = pair.Programs(str(BUILD / "bin"), str(BUILD / "dropin"), folder)
        words = [*side.arguments(pki, keys, False), "--companion", side.companion(pki, keys, NEVER)]
        namespace = pair.Namespace()
        try:
            peer = pair.start(programs, namespace, "ddssec", ["--subscribe", *words], os.path.join(folder, "subscribe"))
            try:
                code = peer.process.wait(PATIENCE)
            finally:
                peer.kill()
                peer.process.stdout.close()
            log = pathlib.Path(peer.log).read_text(errors="replace")
            check(f"it ended with {code}: {log[-500:]}", code == 3 and "unauthenticated_peers_need_own_process" in log)
        finally:
            namespace.close()


def revocation_lists(pki, keys):
    """The list in use, which names a stranger, and one that names the publisher."""
    ca = pki.ca("identity-main", keys.identity_ca)
    return [pki.crl(ca, pki.leaf(name, keys.leaf, ca)) for name in ("stranger", STARTER)]


def run(story, publisher, side, companion, prepare=lambda pki, keys: None, publish_words=(), subscribe_words=(),
        publishers_list=""):
    """Runs one pair; raises what went wrong, with both logs. `story` gets what `prepare` made, too."""
    with tempfile.TemporaryDirectory(prefix="ddssec-two-") as folder:
        os.mkdir(os.path.join(folder, "logs"))
        pki, keys = Pki(folder), Keys()
        programs = pair.Programs(str(BUILD / "bin"), str(BUILD / "dropin"), os.path.join(folder, "logs"))
        publish = [*replace(side, crl=publishers_list).arguments(pki, keys, True), *publish_words]
        subscribe = [*side.arguments(pki, keys, False), *subscribe_words]
        prepared = prepare(pki, keys)
        # Made last: it may not be valid for long.
        subscribe += ["--companion", companion.companion(pki, keys, 5 if story is leaves else NEVER)]
        namespace, peers = pair.Namespace(), []
        try:
            for kind, role, words in (("ddssec", "--subscribe", subscribe), (publisher, "--publish", publish)):
                peers.append(pair.start(programs, namespace, kind, [role, "--hold", *words],
                                        os.path.join(programs.logs, role.strip("-"))))
            watched = Watched(peers[1], peers[0])
            try:
                return story(watched) if prepared is None else story(watched, prepared)
            except AssertionError as fault:
                lines = "".join(f"\n    | {line[:200]}" for line in watched.logged(re.compile(""))[-30:])
                raise type(fault)(f"{fault}{lines}") from None
        finally:
            for peer in peers:
                peer.kill()
                peer.process.stdout.close()
            namespace.close()


def run_to_the_end(side, what):
    """A companion whose certificate or permissions end while it talks."""
    soon, later = VALID
    try:
        run(ends, "ddssec", side, replace(side, **{what: soon}))
    except TooLate:
        run(ends, "ddssec", side, replace(side, **{what: later}))


def cases():
    everything = Side(GOVERNANCES["everything-encrypt-oa"])
    # Fast DDS 2.9.1 ends by a fault of its own now and then when two come at once.
    for publisher in ("ddssec", "stock", "embedded"):
        yield f"leaves/everything-encrypt-oa/{publisher}", lambda p=publisher: run(leaves, p, everything, everything)
    sros2 = Side(GOVERNANCES["sros2"])
    yield "leaves/sros2/ddssec", lambda: run(leaves, "ddssec", sros2, sros2)
    for name in ("rtps-encrypt", "rtps-sign", "everything-encrypt-oa"):
        side = Side(GOVERNANCES[name])
        yield f"memory/{name}", lambda s=side: run(stays_small, "ddssec", s, s, publish_words=FAST)
    yield "guests", guests
    listed = replace(everything, crl="stranger")
    yield "distrusted by one", lambda: run(is_distrusted, "embedded", listed, everything, revocation_lists)
    if LONG in sys.argv[2:]:
        patiently = ["--timeout", str(OF_BOTH + 60)]
        for publisher, times in (("ddssec", 1), ("stock", 0)):  # a stock publisher would keep its session
            yield f"{LONG}answers one alone/{publisher}", lambda p=publisher, t=times: run(
                lambda watched: answers_one_alone(watched, t), p, everything, everything,
                publish_words=patiently, subscribe_words=patiently, publishers_list=COMPANION)
    yield "permissions end", lambda: run_to_the_end(everything, "permissions_seconds")
    yield "identity ends", lambda: run_to_the_end(everything, "identity_seconds")


def tried(case):
    name, story = case
    begin, fault, said = time.monotonic(), None, None
    try:
        said = story()
    except AssertionError as one:
        fault = one
    print(f"{'FAILED' if fault else 'ok':8}{name} ({time.monotonic() - begin:.1f} s)"
          + (f": {fault or said}" if fault or said else ""), flush=True)
    return fault is None


def main():
    wanted = (sys.argv[2:] or [""])[0]
    with concurrent.futures.ThreadPoolExecutor(max_workers=4) as pool:  # they mostly wait
        outcomes = list(pool.map(tried, (case for case in cases() if wanted in case[0])))
    return 0 if outcomes and all(outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""The calendar of one of two Cyclone DDS processes on our plugins is set while they talk. If it is
wrong for some seconds, it parts no participants, as with stock plugins. If it stays, documents that have ended by it end
when the time of grace is over, but not those that are not valid yet at the time that it shows. A handshake that is under
way goes on.

Usage: clock_test.py BUILD
"""

import concurrent.futures
import os
import pathlib
import sys
import tempfile
import time
from dataclasses import replace

sys.dont_write_bytecode = True

import pair  # noqa: E402
from documents import COMPANION, Keys, Side  # noqa: E402
from pki import Pki  # noqa: E402
from scenarios import GOVERNANCES  # noqa: E402

BUILD = pathlib.Path(sys.argv[1]).resolve()
PATIENCE = 20.0    # seconds
WRONG_FOR = 6.0    # seconds
FURTHER = 15       # samples, at ten a second
NEVER = 10 ** 6    # samples
SILENCE = 2.0      # seconds in which some 20 samples would have come
YEARS = "+9000d"   # later than any certificate of the tests ends
BEYOND = "+200s"   # the core's timer of a handshake has 100 s
BEFORE = "-900d"   # before any of them began
FAKETIME = next(pathlib.Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"), None)


def check(is_so, what):
    if not is_so:
        raise AssertionError(what)


class Calendar:
    """The calendar of a process, set by a file; its other clocks go on."""

    def __init__(self, folder):
        self._path = pathlib.Path(folder) / "calendar"
        self.set("+0")

    def set(self, by):
        new = self._path.with_suffix(".new")
        new.write_text(by + "\n", encoding="utf-8")
        new.replace(self._path)

    @property
    def variables(self):
        return {"LD_PRELOAD": str(FAKETIME), "FAKETIME_TIMESTAMP_FILE": str(self._path), "FAKETIME_NO_CACHE": "1",
                "FAKETIME_DONT_FAKE_MONOTONIC": "1", "DONT_FAKE_MONOTONIC": "1"}


class Listening:
    def __init__(self, peer, events):
        self.peer, self._events = peer, events
        self.core_log = pathlib.Path(peer.log)
        os.set_blocking(peer.process.stdout.fileno(), False)

    @property
    def samples(self):
        try:
            self.peer.read()
        except BlockingIOError:
            pass
        return sum(line.startswith("sample ") for line in self.peer.lines)

    @property
    def log(self):
        return self._events.read_text(encoding="utf-8", errors="replace")

    def until(self, what, is_so):
        end = time.monotonic() + PATIENCE
        while not is_so():
            check(not self.peer.ended and time.monotonic() < end, f"{what} did not happen:\n{self.log}")
            time.sleep(0.05)

    def hears_on(self):
        before = self.samples
        self.until("hearing on", lambda: self.samples >= before + FURTHER)

    def falls_silent(self):
        """Silence shows only in time: waits until nothing has come for that long."""
        heard, since = self.samples, time.monotonic()

        def is_silent():
            nonlocal heard, since
            if self.samples != heard:
                heard, since = self.samples, time.monotonic()
            return time.monotonic() - since > SILENCE

        self.until("silence", is_silent)


def wrong_for_some_seconds(listening, calendar):
    calendar.set(YEARS)
    end = time.monotonic() + WRONG_FOR
    listening.until("the step being said", lambda: "clock_stepped 1621" in listening.log)
    while time.monotonic() < end:
        listening.hears_on()
    calendar.set("+0")
    listening.until("its undoing being said", lambda: "clock_step_undone 1622" in listening.log)
    listening.hears_on()
    check(listening.log.count("clock_stepped 1621") == 1, f"the step is said more than once:\n{listening.log}")
    check("identity_ended" not in listening.log and "grant_expired" not in listening.log,
          f"something ended:\n{listening.log}")


def set_to_stay(listening, calendar):
    calendar.set(YEARS)
    listening.until("its end", lambda: "identity_ended 1343" in listening.log)
    check("clock_step_followed 1623" in listening.log, f"why is not said:\n{listening.log}")
    calendar.set("+0")
    listening.falls_silent()  # with a certificate that has ended


def set_back_to_stay(listening, calendar):
    calendar.set(BEFORE)
    listening.until("the calendar being followed", lambda: "clock_step_followed 1623" in listening.log)
    end = time.monotonic() + WRONG_FOR
    while time.monotonic() < end:
        listening.hears_on()
    calendar.set("+0")
    listening.until("its being followed again", lambda: listening.log.count("clock_step_followed 1623") == 2)
    listening.hears_on()


def under_way(listening, calendar):
    """The publisher distrusts the companion, so that their handshake does not end. If the core's timer did, it could
    damage the core's memory."""
    calendar.set(BEYOND)
    listening.until("the step being said", lambda: "clock_stepped 1621" in listening.log)
    end = time.monotonic() + WRONG_FOR
    while time.monotonic() < end:
        listening.hears_on()
    check("Timed out" not in listening.core_log.read_text(encoding="utf-8", errors="replace"),
          "the core's timer ended a handshake")


def run(name, story, grace=None, distrusted=""):
    begin, fault = time.monotonic(), None
    with tempfile.TemporaryDirectory(prefix="ddssec-clock-") as folder:
        programs = pair.Programs(str(BUILD / "bin"), str(BUILD / "dropin"), folder)
        side, keys, pki = Side(GOVERNANCES["everything-encrypt-oa"]), Keys(), Pki(folder)
        publish = replace(side, crl=distrusted).arguments(pki, keys, True)
        subscribe = side.arguments(pki, keys, False)
        if distrusted:
            subscribe += ["--companion", side.companion(pki, keys, NEVER)]
        calendar = Calendar(folder)
        variables = dict(calendar.variables)
        if grace is not None:
            properties = pathlib.Path(folder) / "properties"
            properties.write_text(f"org.ddssec.clock_step_grace = {grace}\n", encoding="utf-8")
            variables["DDSSEC_PROPERTIES"] = str(properties)
        events = pathlib.Path(folder) / "events"  # the informational ones, too
        events.touch()
        variables["DDSSEC_EVENT_LOG"] = str(events)
        namespace, peers = pair.Namespace(), []
        try:
            for role, more, words in (("--subscribe", variables, subscribe), ("--publish", {}, publish)):
                peers.append(pair.start(programs, namespace, "ddssec", [role, "--hold", *words],
                                        os.path.join(folder, role.strip("-") + ".log"), more))
            listening = Listening(peers[0], events)
            listening.until("the first samples", lambda: listening.samples >= FURTHER)
            story(listening, calendar)
        except AssertionError as one:
            fault = one
        finally:
            for peer in peers:
                peer.kill()
                peer.process.stdout.close()
            namespace.close()
    print(f"{'FAILED' if fault else 'ok':8}{name} ({time.monotonic() - begin:.1f} s)" + (f": {fault}" if fault else ""),
          flush=True)
    return fault is None


def main():
    check(FAKETIME is not None, "libfaketime is not installed (scripts/bootstrap.sh --dev)")
    stories = (("wrong for some seconds", wrong_for_some_seconds), ("set to stay", set_to_stay, 3),
               ("set back to stay", set_back_to_stay, 3), ("under way", under_way, None, COMPANION))
    with concurrent.futures.ThreadPoolExecutor(max_workers=4) as pool:
        return 0 if all(list(pool.map(lambda story: run(*story), stories))) else 1


if __name__ == "__main__":
    sys.exit(main())

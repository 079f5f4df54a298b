#!/usr/bin/env python3
"""The calendar of an embedded participant is wrong for some seconds: peers still meet it, and what was done to the
clock is said. Run it in a network of its own.

Usage: clock_test.py BUILD
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

BUILD = pathlib.Path(sys.argv[1]).resolve()
FAKETIME = next(pathlib.Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"), None)
YEARS = "+9000d"  # later than any certificate here ends
PATIENCE = 30  # seconds


def check(is_so, what):
    if not is_so:
        raise AssertionError(what)


class World:
    def __init__(self, folder):
        self.at = pathlib.Path(folder)
        subprocess.run([BUILD / "bin/ddssec", "init", "demo"], cwd=self.at, check=True, stdout=subprocess.DEVNULL)
        self.set("+0")
        self.events = self.at / "events"
        self.events.touch()

    def set(self, by):
        new = self.at / "calendar.new"
        new.write_text(by + "\n", encoding="utf-8")
        new.replace(self.at / "calendar")

    def peer(self, role, folder, *more, **variables):
        return subprocess.Popen([BUILD / "bin/ddssec-peer", "--role", role, "--domain", "0", "--security", f"demo/{folder}", *more],
                                cwd=self.at, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env={**os.environ, **variables})

    def meets(self, when):
        """A participant that joins now writes samples to the one whose calendar is set."""
        writer = self.peer("pub", "talker", "--count", "20", "--timeout", "8")
        told = writer.communicate(timeout=2 * PATIENCE)[0]
        done = [json.loads(line) for line in told.splitlines() if line.startswith('{"event":"done"')]
        check(writer.returncode == 0 and done and done[0]["matched"], f"{when}: {told}\n{self.events.read_text()}")

    def until(self, code):
        end = time.monotonic() + PATIENCE
        while code not in self.events.read_text(encoding="utf-8"):
            check(time.monotonic() < end, f"{code} is not said:\n{self.events.read_text()}")
            time.sleep(0.05)


def main():
    check(FAKETIME is not None, "libfaketime is not installed (scripts/bootstrap.sh --dev)")
    with tempfile.TemporaryDirectory(prefix="ddssec-clock-") as folder:
        world = World(folder)
        reader = world.peer("sub", "listener", "--count", "1000", "--timeout", "300", LD_PRELOAD=str(FAKETIME),
                          FAKETIME_TIMESTAMP_FILE=str(world.at / "calendar"), FAKETIME_NO_CACHE="1",
                          FAKETIME_DONT_FAKE_MONOTONIC="1", DONT_FAKE_MONOTONIC="1", DDSSEC_EVENT_LOG=str(world.events))
        try:
            world.meets("at first")
            world.set(YEARS)  # read when something is judged by it
            world.meets("while the calendar is wrong")
            world.until("clock_stepped")
            world.set("+0")
            world.meets("after that")
            world.until("clock_step_undone")
            check("identity_ended" not in world.events.read_text(), world.events.read_text())
        finally:
            reader.kill()
            reader.communicate()
    print("ok")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Processes on our plugins that call exit() while their participants live: Cyclone DDS's threads and ours go on
calling the plugins while libraries are torn down. Each process ends with the status that it gave to exit().

In each of several namespaces a peer stays, and others come and call exit() at some time from the handshake to the
exchange of samples.

Usage: exit_test.py BUILD [RUNS]
"""

import collections
import concurrent.futures
import itertools
import os
import pathlib
import random
import sys
import tempfile

sys.dont_write_bytecode = True

import pair  # noqa: E402
from documents import Governance, Keys, Side  # noqa: E402
from pki import Pki  # noqa: E402
from scenarios import EO  # noqa: E402

BUILD = pathlib.Path(sys.argv[1]).resolve()
RUNS = int((sys.argv[2:] or ["300"])[0])
AT_ONCE = 4          # more than the machine has cores: a thread may be stopped anywhere
LATEST_EXIT = 400    # milliseconds after creation; the handshake is over within half of them
PATIENCE = 30        # seconds
SIDE = Side(Governance(discovery=EO, liveliness=EO, rtps=EO, metadata=EO))


def come_and_go(programs, namespace, words, log, exit_after):
    """The exit status of a process that calls exit() so many milliseconds after it made its entities."""
    peer = pair.start(programs, namespace, "ddssec", ["--publish", "--hold", "--interval", "2", "--payload", "2000",
                                                    "--exit-after", str(exit_after), *words], log)
    try:
        peer.process.communicate(timeout=PATIENCE)
    finally:
        peer.kill()
    return peer.process.returncode


def in_one_namespace(folder, number, times):
    """What the processes there ended with."""
    logs = os.path.join(folder, str(number))
    os.mkdir(logs)
    programs = pair.Programs(str(BUILD / "bin"), str(BUILD / "dropin"), logs)
    pki, keys, namespace = Pki(logs), Keys(), pair.Namespace()
    words = [SIDE.arguments(pki, keys, starts) for starts in (True, False)]
    staying = pair.start(programs, namespace, "ddssec",
                         ["--subscribe", "--hold", "--lease", "2", "--timeout", "900", *words[number % 2]],
                         os.path.join(logs, "staying"), {"DDSSEC_EVENT_LOG": "/dev/null"})
    with concurrent.futures.ThreadPoolExecutor(max_workers=1) as pool:  # its output must not fill the pipe
        reading = pool.submit(lambda: all(iter(staying.read, False)))
        try:
            return [(come_and_go(programs, namespace, words[1 - number % 2], os.path.join(logs, f"{time}-{turn}"), time),
                     time) for turn, time in enumerate(times)]
        finally:
            staying.kill()
            reading.result()
            namespace.close()


def main():
    dice = random.Random(1)
    times = [dice.randint(1, LATEST_EXIT) for _ in range(RUNS)]
    with tempfile.TemporaryDirectory(prefix="ddssec-exit-") as folder, \
            concurrent.futures.ThreadPoolExecutor(max_workers=AT_ONCE) as pool:
        jobs = [pool.submit(in_one_namespace, folder, number, times[number::AT_ONCE]) for number in range(AT_ONCE)]
        ends = list(itertools.chain.from_iterable(job.result() for job in jobs))
    for status, time in ends:
        if status != 0:
            print(f"FAILED  exit() after {time} ms: status {status}")
    print(f"{len(ends)} processes: {dict(collections.Counter(status for status, _ in ends))}")
    return 0 if len(ends) == RUNS and all(status == 0 for status, _ in ends) else 1


if __name__ == "__main__":
    sys.exit(main())

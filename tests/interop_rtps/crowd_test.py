#!/usr/bin/env python3
"""Ten secured processes, each in a network of its own, over a link that loses every fifth packet and
delays and repeats others: each is matched with all in bounded time. All are embedded participants;
then one is stock Cyclone DDS, whose name makes it the one that never starts a handshake (see
faults_test.py).
Usage: crowd_test.py BUILD [--seed N] [--processes N]"""

import argparse
import hashlib
import pathlib
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "interop"), str(HERE.parent / "bench")]
sys.dont_write_bytecode = True
from faulty_world import ADDRESSES, Link  # noqa: E402
from matching import Process, wait_for_all  # noqa: E402
from participants import start  # noqa: E402
from pki import der_name  # noqa: E402
from surroundings import ENCRYPT, make_folders  # noqa: E402

FAULTS = "loss 0.2 duplicate 0.05 delay 0.3 25"
LIMIT = 60  # seconds
EMBEDDED, CYCLONE = "bench_embedded_peer", "bench_cyclone_peer"


def crowd(build, folders, programs, seed):
    """How many are matched with all, after how many seconds, their CPU seconds, and what the link did."""
    link = Link(build, seed, len(folders))
    begin = time.monotonic()
    try:
        link.do(FAULTS)
        processes = [
            Process(start(build / "bin" / program, "matched", folder,
                          ["--count", str(len(folders)), "--timeout", str(LIMIT + 10), "--address", address],
                          errors=subprocess.DEVNULL, enter=space.enter))
            for program, folder, address, space in zip(programs, folders, ADDRESSES, link.spaces)]
        try:
            complete = wait_for_all(processes, begin + LIMIT)
        finally:
            cpu = sum(process.end() for process in processes)
    finally:
        did = link.close()
    return complete, time.monotonic() - begin, cpu, did


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=10)
    options = parser.parse_args()
    build, count = options.build.resolve(), options.processes
    names = sorted((f"robot-{n}" for n in range(count)), key=lambda name: hashlib.sha256(der_name(name)).digest())
    failed = 0
    with tempfile.TemporaryDirectory() as base:
        folders = make_folders(base, names, ENCRYPT)
        for last in (EMBEDDED, CYCLONE):
            programs = [EMBEDDED] * (count - 1) + [last]
            complete, took, cpu, did = crowd(build, folders, programs, options.seed)
            print(f"{count - 1} of ours and {last}: {complete} of {count} matched with all in {took:.1f} s, "
                  f"{cpu:.1f} s of CPU\n  {did}", flush=True)
            failed += complete != count
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""How long processes need until each is matched with all, and what it costs: the embedded
participant, Cyclone DDS with its own plugins and with ours, Fast DDS; in turns in one run.

Every process has a secured participant (everything ENCRYPT) with a writer and a reader of one topic;
all find each other by multicast in a network namespace of their own. Shown are the seconds from the
start of the first process until the last one is matched with all writers and all readers, and the
CPU seconds (user and system) of all processes until then, a process's start included. CPU per
handshake is what goes beyond the same processes without security and beyond making a secured
participant, divided by the number of pairs: discovery under protection, keys and permissions are in
it. Beside it stand the public-key operations that a handshake consists of, both sides, by OpenSSL
alone: twice a signature, a verified signature, a verified certificate, verified permissions, a key
and a derivation.
"""

import argparse
import json
import os
import pathlib
import selectors
import signal
import statistics
import subprocess
import tempfile
import time
from dataclasses import dataclass

from participants import start
from surroundings import ENCRYPT, in_own_namespace, machine, make_folders, many_topics

MAKES = {"embedded": ("bench_embedded_peer", None), "Cyclone": ("bench_cyclone_peer", None),
         "Cyclone, our plugins": ("bench_cyclone_peer", "dropin"), "Fast DDS": ("bench_fastdds_peer", None)}


@dataclass
class Outcome:
    """One row's run: `complete` of the processes were matched with all after `seconds`."""
    seconds: float
    cpu: float
    created_cpu: float
    complete: int


class Process:
    """One of them; `line` is what it said when it was matched."""

    def __init__(self, command):
        self.popen, self.text, self.line = command, "", None

    def read(self):
        """False at the end of what it says."""
        octets = os.read(self.popen.stdout.fileno(), 65536)
        self.text += octets.decode(errors="replace")
        said = [json.loads(line) for line in self.text.splitlines() if line.endswith("}")]
        self.line = next((line for line in said if line["event"] == "matched"), None)
        return bool(octets) and self.line is None

    def end(self):
        """Its CPU seconds."""
        os.kill(self.popen.pid, signal.SIGKILL)  # not yet waited for
        _, self.popen.returncode, used = os.wait4(self.popen.pid, 0)
        self.popen.stdout.close()
        return used.ru_utime + used.ru_stime


def wait_for_all(processes, deadline):
    """How many of them were matched with all at the deadline, by time.monotonic()."""
    with selectors.DefaultSelector() as selector:
        for process in processes:
            selector.register(process.popen.stdout, selectors.EVENT_READ, process)
        while selector.get_map() and (left := deadline - time.monotonic()) > 0:
            for key, _ in selector.select(left):
                if not key.data.read():
                    selector.unregister(key.fileobj)
    return sum(process.line is not None for process in processes)


def match(build, make, folders, limit):
    """All processes of one row, from the first's start to the last's match."""
    name, plugins = MAKES[make]
    arguments = ["--count", str(len(folders)), "--timeout", str(limit + 10)]
    begin = time.monotonic()
    processes = [Process(start(build / "bin" / name, "matched", folder, arguments, plugins and build / plugins,
                               subprocess.DEVNULL))
                 for folder in folders]
    complete = wait_for_all(processes, begin + limit)
    took = time.monotonic() - begin
    cpu = sum(process.end() for process in processes)
    lines = [process.line for process in processes if process.line]
    if complete == len(folders):
        took = max(line["at_s"] for line in lines) - begin
    return Outcome(took, cpu, sum(line["created_cpu_s"] for line in lines), complete)


def raw_microseconds(build, count=200):
    """OpenSSL's public-key operations of one handshake."""
    text = subprocess.run([build / "bin" / "bench_openssl_operations", str(count)], capture_output=True, text=True,
                          check=True).stdout
    return 1e6 * float(dict(line.split() for line in text.splitlines())["handshake"]) / count


def per_handshake(secured, plain, processes):
    """Microseconds of CPU."""
    beyond = (secured.cpu - secured.created_cpu) - (plain.cpu - plain.created_cpu)
    return 1e6 * beyond / (processes * (processes - 1) / 2)


def measure(options, makes, folders):
    """{make: [(secured, plain, raw microseconds)]}; a make that did not get there is not tried again."""
    runs = {make: [] for make in makes}
    for _ in range(options.rounds):
        for make, done in runs.items():
            if done and done[-1][0].complete < len(folders):
                continue
            plain = match(options.build, make, ["off"] * len(folders), options.limit)
            raw = raw_microseconds(options.build)
            done.append((match(options.build, make, folders, options.limit), plain, raw))
    return runs


def record(make, runs, processes):
    """Medians of the rounds; what was not reached is None."""
    def median(value, reached=lambda run: run.complete == processes):
        values = [value(*run) for run in runs if all(map(reached, run[:2]))]
        return statistics.median(values) if len(values) == len(runs) else None
    return {"make": make, "processes": processes, "complete": min(run[0].complete for run in runs),
            "seconds": median(lambda secured, *_: secured.seconds),
            "cpu": median(lambda secured, *_: secured.cpu),
            "plain_cpu": median(lambda _, plain, *__: plain.cpu),
            "handshake_us": median(lambda secured, plain, _: per_handshake(secured, plain, processes)),
            "raw_us": statistics.median(run[2] for run in runs),
            "all": [[vars(secured), vars(plain), raw] for secured, plain, raw in runs]}


def row(one, cyclone, limit):
    def cell(value, form):
        return format(value, form) if value is not None else "-"

    def ratio(key):
        return one[key] / cyclone[key] if cyclone and one[key] and cyclone[key] else None
    matched = cell(one["seconds"], ".2f") + " s" if one["seconds"] is not None else (
        f"{one['complete']} of {one['processes']} in {limit:.0f} s")
    over_raw = one["handshake_us"] / one["raw_us"] if one["handshake_us"] is not None else None
    return "| " + " | ".join([str(one["processes"]), one["make"], matched, cell(ratio("seconds"), ".2f"),
                              cell(one["cpu"], ".2f"), cell(one["plain_cpu"], ".2f"), cell(one["handshake_us"], ".0f"),
                              cell(over_raw, ".2f"), cell(ratio("handshake_us"), ".2f")]) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default="build/release")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--processes", type=int, nargs="*", default=[2, 5, 10, 20, 40])
    parser.add_argument("--makes", nargs="*", choices=list(MAKES), default=list(MAKES))
    parser.add_argument("--topics", type=int, default=40, help="in the permissions of each")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds to wait for all to match")
    parser.add_argument("--json", help="write the figures there")
    options = parser.parse_args()
    in_own_namespace()
    options.build = options.build.resolve()
    records = []
    with tempfile.TemporaryDirectory(prefix="ddssec-bench-") as base:
        folders = make_folders(base, [f"p{n}" for n in range(max(options.processes))], ENCRYPT,
                               many_topics(options.topics))
        size = os.path.getsize(os.path.join(folders[0], "permissions.p7s"))
        print(f"Everything ENCRYPT, permissions of {size} octets, medians of {options.rounds}; {machine()}\n\n"
              "| processes | make | all matched | / Cyclone | CPU, s | not secured, s | CPU per handshake, us "
              "| / OpenSSL | / Cyclone |\n|---:|---|" + "---:|" * 7, flush=True)
        for processes in options.processes:
            runs = measure(options, options.makes, folders[:processes])
            these = {make: record(make, done, processes) for make, done in runs.items()}
            for one in these.values():
                print(row(one, these.get("Cyclone"), options.limit), flush=True)
            records += these.values()
    print(f"\nOpenSSL's operations of a handshake: {statistics.median(one['raw_us'] for one in records):.0f} us")
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps({"machine": machine(), "results": records}, indent=1))


if __name__ == "__main__":
    main()

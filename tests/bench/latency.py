#!/usr/bin/env python3
"""How long a sample takes: round trips of ours and of Cyclone DDS, best effort and reliable, unsecured and
secured (the governance of sros2), received by waiting and in a listener, beside plain blocking UDP sockets.

The variants take turns within one run, over the loopback of a network namespace of its own. Each figure is the
median of the rounds. Only ratios of one run compare: a shared machine's clock drifts.

With --memory, the participants are ours with org.ddssec.shm on, and the floor is a futex in memory that two processes
share. Sizes from 64 octets to 4 MiB take turns, with the governance of sros2 and with one that protects nothing.
"""

import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
from typing import NamedTuple

import latency_plot
from participants import LIMIT, start
from surroundings import SROS2, Governance, in_own_namespace, machine, make_folders

PROGRAMS = {"UDP": "bench_udp_peer", "futex": "bench_futex_peer", "ddssec": "bench_embedded_peer",
            "Cyclone": "bench_cyclone_peer"}
FLOORS = ("UDP", "futex")  # they have neither topics nor QoS
MEMORY_SIZES = (64, 1024, 8192, 65536, 1 << 20, 4 << 20)  # octets of payload
NOTHING = Governance()
COLUMNS = (("median_us", "p50"), ("p90_us", "p90"), ("p99_us", "p99"), ("p999_us", "p99.9"), ("p9999_us", "p99.99"),
           ("jitter_us", "jitter"), ("cpu_us", "CPU"))


class Variant(NamedTuple):
    make: str
    secured: bool
    reliable: bool
    mode: str  # "wait" or "listener"

    def __str__(self):
        return ", ".join([self.make, *(["secured"] if self.secured else []),
                          *([] if self.make in FLOORS else ["reliable" if self.reliable else "best effort"]), self.mode])

    def arguments(self):
        return (["--waiting"] if self.mode == "wait" else ["--listener"]) + ([] if self.reliable else ["--best-effort"])

    def of(self, make):
        return self._replace(make=make)


MANY_OCTETS = 65536  # larger samples make fewer round trips, so that each size takes about as long
FLOOR = Variant("UDP", False, False, "wait")
MEMORY_FLOOR = FLOOR.of("futex")


def memory_variants(options):
    ours = [Variant("ddssec", secured, reliable, mode) for secured in (False, True) for mode in ("wait", "listener")
            for reliable in (False, True)]
    return [v for v in (MEMORY_FLOOR, *ours) if re.search(options.only, str(v))]


def variants(options):
    out = [Variant(make, secured, reliable, mode) for secured in (False, True) for mode in ("wait", "listener")
           for reliable in (False, True) for make in ("ddssec", "Cyclone")]
    if options.loss:  # a best-effort answer that is lost ends a listener's chain
        out = [v for v in out if v.reliable or v.mode == "wait"]
    else:
        out.insert(0, FLOOR)
    return [v for v in out if re.search(options.only, str(v))]


class Loopback:
    """Both processes on the loopback of this namespace."""

    def places(self):
        return [([], lambda command: command)] * 2

    def close(self):
        pass


class LossyLink:
    """Each process in a namespace of its own, and a link between them that loses packets."""

    def __init__(self, build, loss):
        sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop_rtps"))
        from faulty_world import ADDRESSES, Link
        self._addresses, self._link = ADDRESSES, Link(build, 1)
        self._link.do(f"loss {loss}")

    def places(self):
        return [(["--address", address], space.enter) for address, space in zip(self._addresses, self._link.spaces)]

    def close(self):
        self._link.close()


def round_trips(variant, options, size, folders, network):
    """The rtt line of the process that asks; None if it does not end as it should."""
    program = options.build / "bin" / PROGRAMS[variant.make]
    count = max(min(options.count, options.count * MANY_OCTETS // size), 100)
    arguments = ["--count", str(count), "--size", str(size), "--interval", str(options.interval),
                 *variant.arguments()]
    if variant.make == "ddssec" and options.busy_wait:
        arguments += ["--busy-wait", str(options.busy_wait)]
    (where_ping, enter_ping), (where_pong, enter_pong) = network.places()
    first = ["chrt", "--fifo", "10"] if options.realtime else []
    pong = start(program, "pong", folders[1], [*arguments, *where_pong], errors=subprocess.DEVNULL,
                 enter=lambda command: enter_pong([*first, *command]))
    ping = start(program, "ping", folders[0], [*arguments, *where_ping], errors=subprocess.DEVNULL,
                 enter=lambda command: enter_ping([*first, *command]))
    try:
        text, _ = ping.communicate(timeout=LIMIT + 10)
    except subprocess.TimeoutExpired:
        text = ""
    finally:
        ping.kill()
        pong.terminate()
        pong.communicate()
    lines = [json.loads(line) for line in text.splitlines() if line.startswith("{")]
    found = [line for line in lines if line["event"] == "rtt"]
    # 4: it did not get all answers in time, which a link that loses packets may not allow.
    if ping.returncode not in ((0, 4) if options.loss else (0,)) or not found:
        print(f"latency.py: {variant}: {text.strip()[-300:]}", file=sys.stderr)
        return None
    return found[0]


def medians(lines):
    return {key: statistics.median(line[key] for line in lines) for key in [k for k, _ in COLUMNS] + ["lost"]}


def measure(options, folders, network):
    """{variant: {key: median of the rounds}}"""
    lines = {}
    for _ in range(options.rounds):
        for variant in variants(options):
            if line := round_trips(variant, options, options.size, folders[variant.secured], network):
                lines.setdefault(variant, []).append(line)
    return {variant: medians(of_one) for variant, of_one in lines.items()}


def measure_memory(options, folders, network):
    """{size: {variant: {key: median of the rounds}}}"""
    lines = {}
    for _ in range(options.rounds):
        for size in MEMORY_SIZES:
            for variant in memory_variants(options):
                if line := round_trips(variant, options, size, folders[variant.secured], network):
                    lines.setdefault(size, {}).setdefault(variant, []).append(line)
    return {size: {variant: medians(of_one) for variant, of_one in found.items()} for size, found in lines.items()}


def make_memory_folders(base, name, governance):
    """Folders of two participants that share memory."""
    folder = pathlib.Path(base) / name
    folder.mkdir()
    out = make_folders(str(folder), governance=governance)
    for one in out:
        with open(pathlib.Path(one) / "security.properties", "a") as properties:
            properties.write("org.ddssec.shm = on\n")
    return out


def ratio(figures, variant, other, key):
    return f"{figures[variant][key] / figures[other][key]:.2f}" if other in figures else "-"


def table(figures):
    out = ["| | " + " | ".join(title for _, title in COLUMNS) + " | p50, p99 / Cyclone | p50 / UDP |",
           "|---|" + "---:|" * (len(COLUMNS) + 2)]
    for variant, found in figures.items():
        cells = [f"{found[key]:.1f}" for key, _ in COLUMNS]
        ours = variant.make == "ddssec"
        cells.append(", ".join(ratio(figures, variant, variant.of("Cyclone"), key) for key in ("median_us", "p99_us"))
                     if ours else "")
        cells.append(ratio(figures, variant, FLOOR, "median_us"))
        lost = f" ({found['lost']:.0f} lost)" if found["lost"] else ""
        out.append(f"| {variant}{lost} | " + " | ".join(cells) + " |")
    return out


def memory_table(figures):
    """A row for each size and variant."""
    keys = (("median_us", "p50"), ("p99_us", "p99"), ("cpu_us", "CPU"))
    out = ["| octets | | " + " | ".join(title for _, title in keys) + " | p50 / futex |", "|---:|---|" + "---:|" * (len(keys) + 1)]
    for size, of_size in figures.items():
        for variant, found in of_size.items():
            lost = f" ({found['lost']:.0f} lost)" if found["lost"] else ""
            out.append(f"| {size} | {variant}{lost} | " + " | ".join(f"{found[key]:.1f}" for key, _ in keys)
                       + f" | {ratio(of_size, variant, MEMORY_FLOOR, 'median_us')} |")
    return out


def load(count):
    """Processes that compute until they are killed."""
    return [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]


def parse():
    parser = argparse.ArgumentParser(prog="latency.sh", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default="build/release")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--count", type=int, default=10000, help="round trips of one measurement")
    parser.add_argument("--size", type=int, default=64, help="octets of payload")
    parser.add_argument("--memory", action="store_true", help="measure shared memory, with sizes up to 4 MiB")
    parser.add_argument("--interval", type=int, default=0, metavar="US",
                        help="microseconds from one ping to the next; 0: the next follows the answer")
    parser.add_argument("--busy-wait", type=int, default=0, metavar="US",
                        help="ddssec looks for messages for so many microseconds before it sleeps")
    parser.add_argument("--loss", type=float, default=0, metavar="P", help="a link that loses this share, such as 0.2")
    parser.add_argument("--load", type=int, default=0, metavar="N", help="so many processes compute meanwhile")
    parser.add_argument("--realtime", action="store_true", help="with SCHED_FIFO, before all else on the machine; as root")
    parser.add_argument("--only", default="", metavar="REGEX", help="variants whose names match, such as 'wait'")
    parser.add_argument("--svg", type=pathlib.Path, help="draw the percentiles into this file")
    parser.add_argument("--json", type=pathlib.Path, help="write the figures into this file")
    return parser.parse_args()


def describe(options, what):
    return (f"Round trips in microseconds, {what}, medians of {options.rounds} rounds of {options.count}; "
            f"{machine()}, load average {os.getloadavg()[0]:.1f}"
            + (f", ddssec with a busy wait of {options.busy_wait} us" if options.busy_wait else "")
            + (", SCHED_FIFO" if options.realtime else "") + (f", {options.load} processes compute" if options.load else "")
            + (f", {options.loss:.0%} of packets lost each way" if options.loss else ""))


def report_memory(options, base, network):
    """Prints the table of shared memory. Returns true if each variant was measured with each size."""
    folders = [make_memory_folders(base, "nothing", NOTHING), make_memory_folders(base, "sros2", SROS2)]
    figures = measure_memory(options, folders, network)
    print(describe(options, "shared memory") + "\n")
    print("\n".join(memory_table(figures)), flush=True)
    write_json(options, [{**variant._asdict(), "size": size, **found} for size, of_size in figures.items()
                         for variant, found in of_size.items()])
    return sum(len(of_size) for of_size in figures.values()) == len(MEMORY_SIZES) * len(memory_variants(options))


def report_network(options, base, network):
    """Prints the table, and draws it. Returns true if each variant was measured."""
    figures = measure(options, [("off", "off"), make_folders(base)], network)
    title = describe(options, f"{options.size} octets")
    print(title + "\n")
    print("\n".join(table(figures)), flush=True)
    if options.svg:
        options.svg.write_text(latency_plot.draw(title, figures))
    write_json(options, [{**variant._asdict(), **found} for variant, found in figures.items()])
    return len(figures) == len(variants(options))


def write_json(options, results):
    if options.json:
        options.json.write_text(json.dumps({"machine": machine(), "results": results}, indent=1))


def main():
    options = parse()
    options.build = options.build.resolve()
    missing = [p for p in PROGRAMS.values() if not (options.build / "bin" / p).exists()]
    if missing:
        sys.exit(f"latency.py: no {', '.join(missing)} in {options.build}/bin; configure with -DDDSSEC_BUILD_BENCH=ON")
    in_own_namespace()
    network = LossyLink(options.build, options.loss) if options.loss else Loopback()
    busy = load(options.load)
    report = report_memory if options.memory else report_network
    try:
        with tempfile.TemporaryDirectory(prefix="ddssec-latency-") as base:
            is_whole = report(options, base, network)
    finally:
        for process in busy:
            process.kill()
        network.close()
    sys.exit(0 if is_whole else 1)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Participants end to end over loopback UDP: ours, Cyclone DDS and Fast DDS, each with one of its own
make, unsecured and secured (AES-256, the governance of sros2), in turns in one run.

Round trips, samples and octets a second between two processes, in a network namespace of its own.
Only ratios of one run compare: a shared machine's clock drifts. Each figure is a median of rounds.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

from surroundings import DOMAIN, in_own_namespace, machine, make_folders

MAKES = {"ddssec": "ddssec-peer", "Cyclone": "bench_cyclone_peer", "Fast DDS": "bench_fastdds_peer"}
LIMIT = 30  # seconds a pair may take


class Failed(Exception):
    """A pair did not do what it should."""


def start(program, role, security, arguments, libraries=None, errors=subprocess.PIPE,
          enter=lambda command: command):
    """`libraries`: the folder of plugins that stand before the stock ones; `enter` makes the command
    one that runs somewhere else."""
    command = [str(program), "--role", role, "--domain", str(DOMAIN), "--timeout", str(LIMIT),
               "--security", security, *arguments]
    environment = {k: v for k, v in os.environ.items()
                   if k not in ("CYCLONEDDS_URI", "LD_LIBRARY_PATH", "FASTRTPS_DEFAULT_PROFILES_FILE")}
    if libraries:
        environment["LD_LIBRARY_PATH"] = str(libraries)
    environment["TZ"] = "UTC"  # Fast DDS reads the dates of permissions as local time
    return subprocess.Popen(enter(command), env=environment, text=True, stdin=subprocess.DEVNULL,
                            stdout=subprocess.PIPE, stderr=errors)


def run_pair(program, roles, folders, arguments):
    """What the first role measured: its rtt or tput line."""
    pair = [start(program, role, folder, arguments) for role, folder in zip(roles, folders)][::-1]
    try:
        texts = [peer.communicate(timeout=LIMIT + 10) for peer in pair][::-1]
    except subprocess.TimeoutExpired:
        raise Failed(f"{os.path.basename(program)} {roles}: did not end") from None
    finally:
        for peer in pair:
            peer.kill()
    lines = [json.loads(line) for out, _ in texts for line in out.splitlines() if line.startswith("{")]
    found = [line for line in lines if line["event"] in ("rtt", "tput")]
    if any(peer.returncode != 0 for peer in pair) or not found:
        said = "\n".join(text.strip()[-400:] for texts_of_one in texts for text in texts_of_one)
        raise Failed(f"{os.path.basename(program)} {roles}: {said}")
    return found[0]


def measurements(options):
    """(name, roles, arguments, [(row title, unit, key, scale)])"""
    rounds = ["--count", str(options.count)]
    seconds = ["--duration", str(options.seconds)]
    yield (("ping", "pong"), [*rounds, "--size", "64"],
           [("round trip median, 64 octets", "us", "median_us", 1), ("round trip p99, 64 octets", "us", "p99_us", 1)])
    for size, title, unit, key, scale in ((64, "samples, 64 octets", "k/s", "samples_per_s", 1e-3),
                                          (8192, "8 KiB", "Mbit/s", "mbit_per_s", 1),
                                          (1 << 20, "1 MiB", "Mbit/s", "mbit_per_s", 1)):
        yield ("tput-sub", "tput-pub"), [*seconds, "--size", str(size)], [(title, unit, key, scale)]


def measure(options, programs, folders):
    """{(title, unit): {(make, secured): [values]}}, in the order of measurements."""
    variants = [(make, secured) for secured in (False, True) for make in programs]
    figures = {}
    for roles, arguments, rows in measurements(options):
        for _ in range(options.rounds):
            for make, secured in variants:
                try:
                    line = run_pair(programs[make], roles, folders if secured else ("off", "off"), arguments)
                except Failed as reason:
                    print(f"participants.py: {reason}", file=sys.stderr)
                    continue
                for title, unit, key, scale in rows:
                    cell = figures.setdefault((title, unit), {}).setdefault((make, secured), [])
                    cell.append(line[key] * scale)
    return figures


def ratio(medians, over, under):
    return medians[over] / medians[under] if medians.get(over) and medians.get(under) else None


def table(figures, makes):
    """Text lines, and the same for JSON."""
    lines = ["| | " + " | ".join([*makes, "ddssec/Cyclone", *(f"{make}, secured" for make in makes),
                                   "ddssec/Cyclone, secured", "ddssec secured/unsecured"]) + " |",
             "|---|" + "---:|" * (2 * len(makes) + 3)]
    records = []
    for (title, unit), cells in figures.items():
        medians = {variant: statistics.median(values) for variant, values in cells.items()}
        pairs = [ratio(medians, ("ddssec", False), ("Cyclone", False)), ratio(medians, ("ddssec", True), ("Cyclone", True)),
                 ratio(medians, ("ddssec", True), ("ddssec", False))]
        shown = [f"{x:.2f}" if x else "-" for x in pairs]
        values = {secured: [f"{medians[make, secured]:.4g}" if (make, secured) in medians else "-" for make in makes]
                  for secured in (False, True)}
        lines.append(f"| {title} ({unit}) | " + " | ".join(
            [*values[False], shown[0], *values[True], shown[1], shown[2]]) + " |")
        records.append({"title": title, "unit": unit, "values": [
            {"make": make, "secured": secured, "median": medians[make, secured], "all": values}
            for (make, secured), values in cells.items()],
            "ours_over_cyclone": pairs[0], "ours_over_cyclone_secured": pairs[1], "ours_secured_over_unsecured": pairs[2]})
    return lines, records


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build/release")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--count", type=int, default=10000, help="round trips of one measurement")
    parser.add_argument("--seconds", type=float, default=3, help="a writer writes in one measurement")
    parser.add_argument("--json", help="write the figures there")
    options = parser.parse_args()
    programs = {make: os.path.join(options.build, "bin", name) for make, name in MAKES.items()}
    for program in programs.values():
        if not os.path.exists(program):
            sys.exit(f"participants.py: no {program}; build it with -DDDSSEC_BUILD_BENCH=ON")
    in_own_namespace()
    with tempfile.TemporaryDirectory(prefix="ddssec-bench-") as base:
        figures = measure(options, programs, make_folders(base))
    lines, records = table(figures, list(MAKES))
    print(f"Two processes of one make, loopback UDP, medians of {options.rounds}; {machine()}\n")
    print("\n".join(lines), flush=True)
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps({"machine": machine(), "results": records}, indent=1))


if __name__ == "__main__":
    main()

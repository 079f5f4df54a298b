#!/usr/bin/env python3
"""Cyclone DDS end to end: not secured, on its own plugins ("stock") and on ours, in turns in one run.

ddsperf measures round trips and samples per second between two processes, in a network namespace of
its own; matching.py measures how long and how much CPU processes need to find each other.
Only ratios of one run compare: a shared machine's clock drifts.
"""

import argparse
import json
import os
import pathlib
import re
import statistics
import subprocess
import tempfile

from surroundings import DOMAIN, ENCRYPT, in_own_namespace, machine, make_folders, many_topics

URI = """<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo" multicast="true"/>
</Interfaces></General>{security}</Domain></CycloneDDS>"""
SECURITY = """<Security><Authentication>
<Library path="dds_security_auth" initFunction="init_authentication" finalizeFunction="finalize_authentication"/>
<IdentityCA>file:{d}/identity_ca.pem</IdentityCA><IdentityCertificate>file:{d}/cert.pem</IdentityCertificate>
<PrivateKey>file:{d}/key.pem</PrivateKey></Authentication>
<Cryptographic><Library path="dds_security_crypto" initFunction="init_crypto" finalizeFunction="finalize_crypto"/></Cryptographic>
<AccessControl><Library path="dds_security_ac" initFunction="init_access_control" finalizeFunction="finalize_access_control"/>
<PermissionsCA>file:{d}/permissions_ca.pem</PermissionsCA><Governance>file:{d}/governance.p7s</Governance>
<Permissions>file:{d}/permissions.p7s</Permissions></AccessControl></Security>"""

class Variant:
    """How the processes of one measurement are secured."""

    def __init__(self, name, folders, library_folder=None):
        self.name, self.folders, self.library_folder = name, folders, library_folder

    def environment(self, n):
        environment = dict(os.environ)
        environment.pop("LD_LIBRARY_PATH", None)
        security = SECURITY.format(d=self.folders[n]) if self.folders else ""
        environment["CYCLONEDDS_URI"] = URI.format(security=security)
        if self.library_folder:
            environment["LD_LIBRARY_PATH"] = str(self.library_folder)
        return environment

    def start(self, n, *words):
        return subprocess.Popen(words, env=self.environment(n), text=True, stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


def ddsperf(variant, seconds, reader, writer, pattern):
    """The median over the run's seconds (the first left out) of what `pattern` finds."""
    common = ("ddsperf", f"-i{DOMAIN}", f"-D{seconds}", "-Qminmatch:1", "-Qinitwait:10")
    other, one = variant.start(0, *common, *reader.split()), variant.start(1, *common, *writer.split())
    texts = [p.communicate(timeout=seconds + 30)[0] for p in (one, other)]
    found = [tuple(map(float, m)) for text in texts for m in re.findall(pattern, text)]
    if len(found) < 2:
        raise SystemExit(f"end_to_end.py: {variant.name}: ddsperf measured nothing:\n" + "\n".join(texts))
    columns = list(zip(*found[1:]))
    return [statistics.median(c) for c in columns]


def round_trip(variant, size, seconds):
    pattern = r"50% ([\d.]+)us 90% ([\d.]+)us 99% ([\d.]+)us"
    return ddsperf(variant, seconds, "pong", f"ping size {size}", pattern)[0]


def samples_per_second(variant, size, seconds):
    return ddsperf(variant, seconds, "sub", f"pub size {size}", r"rate ([\d.]+) kS/s ([\d.]+) Mb/s")[0]


def show(title, unit, rows, ratio):
    medians = {name: statistics.median(values) for name, values in rows.items()}
    cells = "".join(f"{medians[name]:>12.4g}" for name in ("off", "stock", "ddssec"))
    print(f"{title:<34}{cells}  {ratio(medians):>6.2f}x  {unit}", flush=True)
    return {"title": title, "unit": unit, **medians, "ratio": ratio(medians)}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, default="build/release")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=int, default=4, help="of each ddsperf run")
    parser.add_argument("--json", help="write the figures there")
    options = parser.parse_args()
    in_own_namespace()
    options.build = options.build.resolve()
    results = []
    with tempfile.TemporaryDirectory() as pki:
        # ddsperf's endpoints are in partitions of their own.
        folders = make_folders(pki, governance=ENCRYPT, topics=many_topics(420), partition="*")
        variants = [Variant("off", None), Variant("stock", folders), Variant("ddssec", folders, options.build / "dropin")]
        print(f"Cyclone DDS, everything ENCRYPT; {machine()}\n"
              f"{'median of ' + str(options.rounds) + ' rounds':<34}{'off':>12}{'stock':>12}{'ddssec':>12}   ratio")
        measurements = [
            ("round trip p50, 12 octets", "us", lambda v: round_trip(v, 12, options.seconds)),
            ("round trip p50, 1 KiB", "us", lambda v: round_trip(v, 1024, options.seconds)),
            ("samples, 128 octets", "k/s", lambda v: samples_per_second(v, 128, options.seconds)),
            ("samples, 1 KiB", "k/s", lambda v: samples_per_second(v, 1024, options.seconds)),
            ("samples, 8 KiB", "k/s", lambda v: samples_per_second(v, 8192, options.seconds))]
        for title, unit, measure in measurements:
            rows = {v.name: [] for v in variants}
            for _ in range(options.rounds):
                for v in variants:
                    rows[v.name].append(measure(v))
            results.append(show(title, unit, rows, lambda m: m["ddssec"] / m["stock"]))
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps({"machine": machine(), "results": results}, indent=1))


if __name__ == "__main__":
    main()

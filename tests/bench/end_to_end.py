#!/usr/bin/env python3
"""Cyclone DDS end to end: not secured, on its own plugins ("stock") and on ours, in turns in one run.

ddsperf measures round trips and samples per second between two processes, `matched` how long and
how much CPU a number of processes need to find each other, all in a network namespace of its own.
Only ratios of one run compare: a shared machine's clock drifts.
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
import time

BUILD = pathlib.Path("build/release")
URI = """<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo" multicast="true"/>
</Interfaces></General>{security}</Domain></CycloneDDS>"""
SECURITY = """<Security><Authentication>
<Library path="dds_security_auth" initFunction="init_authentication" finalizeFunction="finalize_authentication"/>
<IdentityCA>file:{d}/identity_ca.pem</IdentityCA><IdentityCertificate>file:{d}/p{n}.pem</IdentityCertificate>
<PrivateKey>file:{d}/p{n}.key</PrivateKey></Authentication>
<Cryptographic><Library path="dds_security_crypto" initFunction="init_crypto" finalizeFunction="finalize_crypto"/></Cryptographic>
<AccessControl><Library path="dds_security_ac" initFunction="init_access_control" finalizeFunction="finalize_access_control"/>
<PermissionsCA>file:{d}/permissions_ca.pem</PermissionsCA><Governance>file:{d}/governance.p7s</Governance>
<Permissions>file:{d}/p{n}.p7s</Permissions></AccessControl></Security>"""
GOVERNANCE = """<?xml version="1.0" encoding="UTF-8"?>
<dds><domain_access_rules><domain_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<allow_unauthenticated_participants>false</allow_unauthenticated_participants>
<enable_join_access_control>true</enable_join_access_control>
<discovery_protection_kind>ENCRYPT</discovery_protection_kind>
<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
<rtps_protection_kind>ENCRYPT</rtps_protection_kind>
<topic_access_rules><topic_rule><topic_expression>*</topic_expression>
<enable_discovery_protection>true</enable_discovery_protection>
<enable_liveliness_protection>true</enable_liveliness_protection>
<enable_read_access_control>true</enable_read_access_control>
<enable_write_access_control>true</enable_write_access_control>
<metadata_protection_kind>ENCRYPT</metadata_protection_kind>
<data_protection_kind>ENCRYPT</data_protection_kind></topic_rule></topic_access_rules>
</domain_rule></domain_access_rules></dds>
"""
PERMISSIONS = """<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions><grant name="p{n}"><subject_name>CN=p{n},O=bench</subject_name>
<validity><not_before>2020-01-01T00:00:00</not_before><not_after>2035-01-01T00:00:00</not_after></validity>
<allow_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<publish><topics><topic>*</topic></topics><partitions><partition>*</partition></partitions></publish>
<subscribe><topics><topic>*</topic></topics><partitions><partition>*</partition></partitions></subscribe>
</allow_rule>{padding}<default>DENY</default></grant></permissions></dds>
"""
# 23 kB of permissions, as a system with a few hundred topics has.
PADDING = "".join(
    f"<deny_rule><domains><id>{230 - i % 7}</id></domains><publish><topics><topic>unused/{i:04}"
    "</topic></topics></publish></deny_rule>\n" for i in range(180))


def run(*words, cwd):
    subprocess.run(words, cwd=cwd, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def make_pki(folder, participants):
    """With the openssl program: nothing of ours makes what ours is measured on."""
    folder = pathlib.Path(folder)
    for ca in ("identity_ca", "permissions_ca"):
        run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
            "-days", "30", "-subj", f"/O=bench/CN={ca}", "-keyout", f"{ca}.key", "-out", f"{ca}.pem", cwd=folder)
    (folder / "governance.xml").write_text(GOVERNANCE)
    for n in range(participants):
        run("openssl", "req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-subj",
            f"/O=bench/CN=p{n}", "-keyout", f"p{n}.key", "-out", f"p{n}.csr", cwd=folder)
        run("openssl", "x509", "-req", "-in", f"p{n}.csr", "-CA", "identity_ca.pem", "-CAkey", "identity_ca.key",
            "-set_serial", str(n + 1), "-days", "30", "-sha256", "-out", f"p{n}.pem", cwd=folder)
        (folder / f"p{n}.xml").write_text(PERMISSIONS.format(n=n, padding=PADDING))
    for document in ["governance"] + [f"p{n}" for n in range(participants)]:
        run("openssl", "smime", "-sign", "-text", "-in", f"{document}.xml", "-out", f"{document}.p7s",
            "-signer", "permissions_ca.pem", "-inkey", "permissions_ca.key", cwd=folder)


class Variant:
    """How the processes of one measurement are secured."""

    def __init__(self, name, pki, library_folder=None):
        self.name, self.pki, self.library_folder = name, pki, library_folder

    def environment(self, n):
        environment = dict(os.environ)
        environment.pop("LD_LIBRARY_PATH", None)
        security = SECURITY.format(d=self.pki, n=n) if self.pki else ""
        environment["CYCLONEDDS_URI"] = URI.format(security=security)
        if self.library_folder:
            environment["LD_LIBRARY_PATH"] = str(self.library_folder.resolve())
        return environment

    def start(self, n, *words, log=subprocess.STDOUT):
        return subprocess.Popen(words, env=self.environment(n), text=True, stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, stderr=log)


def ddsperf(variant, seconds, reader, writer, pattern):
    """The median over the run's seconds (the first left out) of what `pattern` finds."""
    common = ("ddsperf", f"-D{seconds}", "-Qminmatch:1", "-Qinitwait:10")
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


def matching(variant, processes, limit):
    """(seconds until all are matched or None, CPU seconds of all, how many are complete)"""
    program = str(BUILD / "bin/bench_matched")
    all_of_them = [variant.start(n, program, str(processes), str(limit), log=subprocess.DEVNULL) for n in range(processes)]
    lines = [p.stdout.readline().split() for p in all_of_them]
    complete = [line for line in lines if line and line[0] == "matched"]
    cpu = 0.0
    for p in all_of_them:
        p.stdin.close()
    for p in all_of_them:
        last = [line for line in p.stdout.read().splitlines() if line.startswith("cpu ")]
        cpu += float(last[0].split()[1]) if last else 0.0
        p.wait()
    everybody = len(complete) == processes
    return (max(float(line[3]) for line in complete) if everybody else None), cpu, len(complete)


def in_own_namespace():
    """Runs this program again where only its own processes are on the loopback interface."""
    if os.environ.get("DDSSEC_BENCH_NAMESPACE") == "1":
        subprocess.run("ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo", shell=True, check=True)
        return
    unshare = ["unshare", "--net"] if os.geteuid() == 0 else ["unshare", "--net", "--map-root-user"]
    os.environ["DDSSEC_BENCH_NAMESPACE"] = "1"
    os.execvp("unshare", unshare + [sys.executable, *sys.argv])


def machine():
    model = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{model.group(1) if model else 'unknown CPU'}, {os.cpu_count()} cores, {time.strftime('%Y-%m-%d')}"


def show(title, unit, rows, ratio):
    medians = {name: statistics.median(values) for name, values in rows.items()}
    cells = "".join(f"{medians[name]:>12.4g}" for name in ("off", "stock", "ours"))
    print(f"{title:<34}{cells}  {ratio(medians):>6.2f}x  {unit}", flush=True)
    return {"title": title, "unit": unit, **medians, "ratio": ratio(medians)}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=int, default=4, help="of each ddsperf run")
    parser.add_argument("--processes", type=int, nargs="*", default=[20])
    parser.add_argument("--limit", type=float, default=60.0, help="seconds to wait for all to match")
    parser.add_argument("--only", choices=["ddsperf", "matching"])
    parser.add_argument("--json", help="write the figures there")
    options = parser.parse_args()
    in_own_namespace()
    results = []
    with tempfile.TemporaryDirectory() as pki:
        make_pki(pki, max([2, *options.processes]))
        variants = [Variant("off", None), Variant("stock", pki), Variant("ours", pki, BUILD / "dropin")]
        print(f"Cyclone DDS, everything ENCRYPT; {machine()}\n"
              f"{'median of ' + str(options.rounds) + ' rounds':<34}{'off':>12}{'stock':>12}{'ours':>12}   ratio")
        measurements = []
        if options.only != "matching":
            measurements += [
                ("round trip p50, 12 octets", "us", lambda v: round_trip(v, 12, options.seconds), "ours/stock"),
                ("round trip p50, 1 KiB", "us", lambda v: round_trip(v, 1024, options.seconds), "ours/stock"),
                ("samples, 128 octets", "k/s", lambda v: samples_per_second(v, 128, options.seconds), "ours/stock"),
                ("samples, 1 KiB", "k/s", lambda v: samples_per_second(v, 1024, options.seconds), "ours/stock"),
                ("samples, 8 KiB", "k/s", lambda v: samples_per_second(v, 8192, options.seconds), "ours/stock")]
        for title, unit, measure, _ in measurements:
            rows = {v.name: [] for v in variants}
            for _ in range(options.rounds):
                for v in variants:
                    rows[v.name].append(measure(v))
            results.append(show(title, unit, rows, lambda m: m["ours"] / m["stock"]))
        for processes in options.processes if options.only != "ddsperf" else []:
            seconds, cpu = {v.name: [] for v in variants}, {v.name: [] for v in variants}
            for _ in range(options.rounds):
                for v in variants:
                    took, used, complete = matching(v, processes, options.limit)
                    if took is None:
                        print(f"  {v.name}: {complete} of {processes} complete after {options.limit:.0f} s")
                    seconds[v.name].append(took if took is not None else options.limit)
                    cpu[v.name].append(used)
            results.append(show(f"{processes} processes matched, time", "s", seconds, lambda m: m["ours"] / m["stock"]))
            results.append(show(f"{processes} processes matched, CPU", "s", cpu, lambda m: m["ours"] / m["stock"]))
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps({"machine": machine(), "results": results}, indent=1))


if __name__ == "__main__":
    main()

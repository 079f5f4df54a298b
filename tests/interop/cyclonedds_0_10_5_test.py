#!/usr/bin/env python3
"""Our plugins inside Debian 13's Cyclone DDS 0.10.5, with its OpenSSL and C library, and stock 0.10.5 against
ours: the chosen pairs of runner.py without Fast DDS. On Debian 12 the plugins are those built there, and 0.10.5
is on both sides, on the publisher's or on the subscriber's in turn; its packages come into BUILD/debian13 and stay
there. On Debian 13 the installed Cyclone DDS is 0.10.5, and both sides have it.

Usage: cyclonedds_0_10_5_test.py BUILD [FILTER]     Exit 77: the packages cannot be had.
"""

import concurrent.futures
import pathlib
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace

sys.dont_write_bytecode = True

import debian13  # noqa: E402
import pair  # noqa: E402
import runner  # noqa: E402
import scenarios  # noqa: E402
from pki import Pki  # noqa: E402

BUILD = pathlib.Path(sys.argv[1]).resolve()
ROOT = BUILD / "debian13"
NEWER = "@0.10.5"
LIBRARIES = ROOT / "root/usr/lib/x86_64-linux-gnu"
STOCK_PLUGINS = LIBRARIES / "libddsc0debian"
LOADER = LIBRARIES / "ld-linux-x86-64.so.2"
PLACES = ((NEWER, NEWER), (NEWER, ""), ("", NEWER))
NATIVE = debian13.is_installed()


@dataclass(frozen=True)
class Programs(pair.Programs):
    """Kinds that end with NEWER are run by Debian 13's loader and libraries: on Debian 13 all kinds are."""

    def command(self, kind):
        program = super().command(kind.removesuffix(NEWER))
        if NATIVE or not kind.endswith(NEWER):
            return program
        plugins = self.dropin if kind.startswith("ddssec") else STOCK_PLUGINS
        return loader(plugins, *program)

    def environment(self, kind):
        if NATIVE:
            return super().environment(kind.removesuffix(NEWER))
        return super().environment("stock" if kind.endswith(NEWER) else kind)


def loader(plugins, *command):
    path = ":".join(map(str, (plugins, LIBRARIES)))
    return [str(LOADER), "--library-path", path, *map(str, command)]


def listed(command):
    """The libraries that a loader finds for a program or library, name to path or None."""
    lines = subprocess.run(command, capture_output=True, text=True, check=False).stdout.splitlines()
    found = (re.match(r"\s*(\S+) => (?:(/\S+)|not found)", line) for line in lines)
    return {match[1]: match[2] for match in found if match}


def check_installed():
    found = listed(["ldd", BUILD / "bin/cyclone_peer"]).get("libddsc.so.0debian")
    if not pathlib.Path(found or "/nowhere").resolve().name.endswith(".0.10.5"):
        raise AssertionError(f"the installed Cyclone DDS is not 0.10.5: {found}")


def check_versions():
    """Debian 13's Cyclone DDS and OpenSSL are used; what it has under other names only (libfmt) is
    Debian 12's, by the loader's cache."""
    for file, name in ((BUILD / "bin/cyclone_peer", "libddsc.so.0debian"),
                       (BUILD / "dropin/libdds_security_crypto.so", "libcrypto.so.3")):
        found = listed(loader(BUILD / "dropin", "--list", file)).get(name)
        if pathlib.Path(found or "/nowhere").parent != LIBRARIES:
            raise AssertionError(f"{file} would have {name} from {found}")
    if not (LIBRARIES / "libddsc.so.0debian").resolve().name.endswith(".0.10.5"):
        raise AssertionError(f"{LIBRARIES} has another Cyclone DDS than 0.10.5")


def cases():
    chosen = [case for case in scenarios.all_cases()
              if case.chosen and {case.publisher, case.subscriber} <= {"ddssec", "stock"}]
    for number, case in enumerate(chosen):
        publisher, subscriber = PLACES[number % len(PLACES)]
        yield replace(case, publisher=case.publisher + publisher,
                      subscriber=case.subscriber + subscriber)


def prepare():
    """Everything that Programs needs; the exit status if it cannot be had."""
    if NATIVE:
        check_installed()
        return 0
    status = debian13.Packages(ROOT).fetch(*debian13.CYCLONE)
    if status != 0:
        print("NOT RUN: Debian 13's packages of Cyclone DDS 0.10.5 cannot be had; the reason is above")
        return 77 if status == 77 else 1
    check_versions()
    return 0


def main():
    status = prepare()
    if status != 0:
        return status
    wanted = re.compile(sys.argv[2] if len(sys.argv) > 2 else "")
    with tempfile.TemporaryDirectory(prefix="ddssec-0.10.5-") as folder:
        programs, pki = Programs(str(BUILD / "bin"), str(BUILD / "dropin"), folder), Pki(folder)
        some = [case for case in cases() if wanted.search(f"{case.name} {case.pair}")]
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            results = list(pool.map(lambda one: runner.attempt(one, programs, pki), enumerate(some)))
    bad = [case for case, outcome in results
           if outcome is None or runner.verdict(case, outcome) == "FAIL"]
    print(f"{len(results)} pairs with Cyclone DDS 0.10.5, {len(bad)} not as required")
    return 1 if bad or not results else 0


if __name__ == "__main__":
    sys.exit(main())

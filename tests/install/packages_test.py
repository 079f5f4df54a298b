#!/usr/bin/env python3
"""Holds what the pages say of packages on another machine (`apt install lib...`) to what the binaries need.
The pages have the names of Debian 12; on another release their versions do not count.
Usage: packages_test.py SOURCE BUILD"""

import pathlib
import re
import subprocess
import sys

source, build = map(pathlib.Path, sys.argv[1:])
EVERYWHERE = {"libc6", "libgcc-s1", "libstdc++6"}
DROPIN = [f"dropin/libdds_security_{name}.so" for name in ("auth", "ac", "crypto")]
TOOL, APPLICATION = ["bin/ddssec"], ["bin/ddssec-peer"]
PAGES = {
    "docs/secure-two-cyclone-applications.md": [DROPIN, TOOL],
    "docs/secure-a-ros2-robot.md": [DROPIN, TOOL],
    "docs/write-an-application.md": [APPLICATION],
    "examples/README.md": [APPLICATION],
}


def output_of(*command):
    return subprocess.run(command, check=True, text=True, capture_output=True).stdout


def libraries_of(files):
    """Where the libraries are that the files name themselves."""
    out = set()
    for file in files:
        places = dict(re.findall(r"(\S+) => (/\S+)", output_of("ldd", build / file)))
        names = re.findall(r"NEEDED\s+(\S+)", output_of("objdump", "-p", build / file))
        out |= {places[name] for name in names if name in places}
    return out


def packages_of(libraries):
    """One search for all, since dpkg reads its whole database for each. /lib may be a link to /usr/lib, and dpkg knows
    only one of them."""
    lines = output_of("dpkg", "-S", *(f"*{library}" for library in sorted(libraries))).splitlines()
    packages = {line.split(": ")[1]: line.split(":")[0] for line in lines}
    return {library: next(name for file, name in packages.items() if file.endswith(library)) for library in libraries}


PACKAGES = packages_of(libraries_of(DROPIN + TOOL + APPLICATION))


def needed(files):
    return {PACKAGES[library] for library in libraries_of(files)} - EVERYWHERE


def comparable(packages):
    release = pathlib.Path("/etc/os-release").read_text(encoding="utf-8")
    if 'VERSION_ID="12"' in release:
        return sorted(packages)
    return sorted(re.sub(r"-?[\d.]+(t64)?$", "", package) for package in packages)


failed = False
for page, programs in PAGES.items():
    said = re.findall(r"apt install ((?:lib[a-z0-9.+-]+ ?)+)", (source / page).read_text(encoding="utf-8"))
    said = [comparable(words.rstrip(" .").split()) for words in said]
    true = [comparable(needed(files)) for files in programs]
    print(f"{page}: {said}")
    if said != true:
        print(f"  but the binaries need {true}")
        failed = True
sys.exit(failed)

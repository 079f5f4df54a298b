"""Programs under Debian 13's loader, C library and DDS, from packages that debian_packages.sh unpacked."""

import os
import pathlib
import subprocess

FETCH = pathlib.Path(__file__).resolve().parent.parent / "support/debian_packages.sh"
CYCLONE = ("cyclonedds-tools", "iceoryx", "libssl3t64")


def is_installed():
    """Whether this machine runs Debian 13 itself."""
    return "VERSION_CODENAME=trixie" in pathlib.Path("/etc/os-release").read_text()


class Packages:
    """A folder of unpacked packages."""

    def __init__(self, folder):
        self.root = pathlib.Path(folder)
        self.libraries = self.root / "root/usr/lib/x86_64-linux-gnu"
        self.stock_plugins = self.libraries / "libddsc0debian"

    def fetch(self, *packages):
        """The exit status of debian_packages.sh: 77, they cannot be had."""
        return subprocess.run([FETCH, "trixie", "amd64", self.root, *packages], check=False).returncode

    def loader(self, plugins, *command):
        """The command line that runs a program with these libraries; `plugins` come first."""
        path = ":".join(map(str, filter(None, (plugins, self.libraries))))
        return [str(self.libraries / "ld-linux-x86-64.so.2"), "--library-path", path, *map(str, command)]


def build_fastdds_peer(source, packages, program):
    """Fast DDS 3's peer, with this machine's compiler and those headers: it runs under that loader alone."""
    if program.exists():
        return
    program.parent.mkdir(parents=True, exist_ok=True)
    include = packages.root / "root/usr/include"
    peers = source / "tests/interop/peers"
    common = ["-O1", "-I", str(source / "tests"), "-isystem", str(include),
              "-isystem", str(include / packages.libraries.name)]
    subprocess.run(["gcc", "-c", *common, str(peers / "peer.c"), "-o", f"{program}.peer.o"], check=True)
    draft = program.with_suffix(".new")
    subprocess.run(["g++", "-std=c++20", *common, "-DDDSSEC_FASTDDS=3", str(peers / "fastdds_peer.cpp"), f"{program}.peer.o",
                    "-o", str(draft), "-L", str(packages.libraries), "-lfastdds", "-lfastcdr",
                    "-Wl,--allow-shlib-undefined"], check=True)
    os.replace(draft, program)

#!/usr/bin/env python3
"""Nothing goes around the plugins: Cyclone DDS with its shared memory switched on, by RouDi of iceoryx.

A protected endpoint is refused, in a sentence that names the setting; an unprotected one works; a
property allows the protected one, and then its plaintext is in /dev/shm, where this test finds it.
Without shared memory it finds none. Needs a /dev/shm of its own (own_shared_memory.sh).

Usage: shared_memory_test.py BUILD [--newer] [FILTER]     --newer: Cyclone DDS 0.10.5 and iceoryx of Debian 13.
Exit 77: it cannot run here, and says why.
"""

import os
import pathlib
import re
import selectors
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass

sys.dont_write_bytecode = True

import cyclonedds_0_10_5_test as newer  # noqa: E402
import pair  # noqa: E402
from documents import Governance, Keys, Side  # noqa: E402
from pki import Pki  # noqa: E402

BUILD = pathlib.Path(sys.argv[1]).resolve()
SHARED_MEMORY = "/dev/shm"
ENABLED = {"PEER_CYCLONEDDS_SETTINGS": "<SharedMemory><Enable>true</Enable></SharedMemory>"}
ALLOWED = ["--property", "org.ddssec.access.allow_shared_memory=true"]
PLAINTEXT = bytes(range(256))  # a payload of peer.c is this, again and again
PAYLOAD = 4000
PATIENCE = 20.0
# Samples that must arrive. Those that are written before RouDi has connected both sides are lost, so which ones is
# not known.
SAMPLES = 3
OPEN = Governance(join=False, read=False, write=False)
PROTECTED = {
    "data_protection_kind ENCRYPT": Governance(data="ENCRYPT"),
    "metadata_protection_kind ENCRYPT": Governance(metadata="ENCRYPT", read=False, write=False),
    "rtps_protection_kind ENCRYPT": Governance(rtps="ENCRYPT", read=False, write=False),
}
SENTENCE = ("Cyclone DDS's configuration, <SharedMemory><Enable>",
            "/dev/shm/iceoryx_mgmt is mapped", "org.ddssec.access.allow_shared_memory",
            "[shared_memory_bypasses_protection 1630]")
ROUDI = """[general]
version = 1
[[segment]]
[[segment.mempool]]
size = 8192
count = 200
"""


class Here:
    """The namespaces that this test runs in, in the form that pair.start asks for."""

    @staticmethod
    def enter(command):
        return command


class RouDi:
    """iceoryx's daemon, with segments of shared memory of its own."""

    def __init__(self, command, folder):
        configuration, log = folder / "roudi.toml", folder / "roudi.log"
        configuration.write_text(ROUDI)
        with open(log, "wb") as output:
            self._process = subprocess.Popen(
                [*command, "--config-file", configuration, "--monitoring-mode", "off"],
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=output, text=True)
        with selectors.DefaultSelector() as selector:
            selector.register(self._process.stdout, selectors.EVENT_READ)
            end = time.monotonic() + PATIENCE
            while selector.select(max(0.0, end - time.monotonic())):
                line = self._process.stdout.readline()
                if "RouDi is ready" in line:
                    return
                if not line:
                    break
        self.stop()
        raise AssertionError(f"iox-roudi does not start: {log.read_text(errors='replace')}")

    def stop(self):
        self._process.terminate()
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()


@dataclass(frozen=True)
class Product:
    """What is run: a Cyclone DDS with our plugins, and RouDi."""
    kind: str
    programs: type
    roudi: list


INSTALLED = Product("ddssec", pair.Programs, ["iox-roudi"])
NEWER = Product("ddssec" + newer.NEWER, newer.Programs,
                INSTALLED.roudi if newer.NATIVE else
                newer.loader(newer.STOCK_PLUGINS, newer.ROOT / "root/usr/bin/iox-roudi"))


class World:
    """Peers of our plugins in Cyclone DDS, beside a fresh RouDi."""

    def __init__(self, product, pki, folder):
        self._pki, self._folder, self._kind = pki, folder, product.kind
        self._programs = product.programs(str(BUILD / "bin"), str(BUILD / "dropin"), str(folder))
        self._roudi = RouDi(product.roudi, folder)
        self._peers = []

    def start(self, role, governance, more=(), variables=None):
        arguments = Side(governance).arguments(self._pki, Keys(), role == "publish")
        log = self._folder / f"{len(self._peers)}-{role}.log"
        hold = ["--hold"] if role == "publish" else []
        peer = pair.start(self._programs, Here, self._kind,
                          [f"--{role}", *hold, "--keep-last", "16", "--payload", str(PAYLOAD),
                           *arguments, *more], str(log),
                          ENABLED if variables is None else variables)
        self._peers.append(peer)
        return peer

    def follow(self, peer):
        """Reads what the peer says until samples have come, or to its end."""
        end = time.monotonic() + PATIENCE
        with selectors.DefaultSelector() as selector:
            selector.register(peer.process.stdout, selectors.EVENT_READ)
            while time.monotonic() < end and len(samples(peer)) < SAMPLES:
                if selector.select(0.1) and not peer.read():
                    peer.process.wait()
                    return

    def close(self):
        for peer in self._peers:
            peer.stop()
        for peer in self._peers:
            try:
                peer.process.wait(pair.STOP_LIMIT)
            except subprocess.TimeoutExpired:
                pass
            peer.kill()
            peer.process.stdout.close()
        self._roudi.stop()


def samples(peer):
    """The different samples that came, each whole and unchanged."""
    lines = {line for line in peer.lines if line.startswith("sample ")}
    wrong = [line for line in lines if not re.fullmatch(rf"sample \d+ {PAYLOAD}", line)]
    assert not wrong, f"{wrong}\n{log_of(peer)}"
    return lines


def plaintext():
    """How often the payload is in shared memory."""
    return sum(file.read_bytes().count(PLAINTEXT) for file in pathlib.Path(SHARED_MEMORY).iterdir())


def log_of(peer):
    return pathlib.Path(peer.log).read_text(errors="replace")


def exchange(world, governance, **settings):
    """Both sides, until samples have come; how often the plaintext is in shared memory then."""
    subscriber = world.start("subscribe", governance, **settings)
    publisher = world.start("publish", governance, **settings)
    world.follow(subscriber)
    assert len(samples(subscriber)) >= SAMPLES, (
        f"fewer than {SAMPLES} samples: {subscriber.lines[-3:]}\n{log_of(subscriber)}{log_of(publisher)}")
    return plaintext()


def refused(world, promise):
    governance = PROTECTED[promise]
    for role in ("publish", "subscribe"):
        peer = world.start(role, governance)
        world.follow(peer)
        log = log_of(peer)
        assert peer.process.returncode == 3, f"{role}: {peer.lines} instead of a refusal\n{log}"
        wanted = f"governance promises {promise} for topic Square"
        for part in (wanted, *SENTENCE):
            assert part in log, f"{role}: {part!r} is not in\n{log}"
    assert plaintext() == 0, "plaintext in shared memory"


def unprotected_works(world):
    assert exchange(world, OPEN) > 0, "the samples of an unprotected topic did not go through it"


def property_allows(world):
    found = exchange(world, PROTECTED["data_protection_kind ENCRYPT"], more=ALLOWED)
    assert found > 0, "allowed, and yet not used: this test would find nothing anywhere"


def off_is_protected(world):
    found = exchange(world, PROTECTED["data_protection_kind ENCRYPT"], variables={})
    assert found == 0, f"plaintext in shared memory: {found} times"


def cases():
    yield "unprotected", unprotected_works
    yield "allowed by a property", property_allows
    yield "off", off_is_protected
    for promise in PROTECTED:
        yield promise, lambda world, promise=promise: refused(world, promise)


def choose(words):
    """The product to run, or the exit status if it cannot be."""
    if not os.path.ismount(SHARED_MEMORY) or any(os.scandir(SHARED_MEMORY)):
        print("NOT RUN: this needs an empty /dev/shm of its own: own_shared_memory.sh")
        return 77
    if "--newer" in words:
        words.remove("--newer")
        return newer.prepare() or NEWER
    if shutil.which("iox-roudi") is None:
        print("NOT RUN: iox-roudi is not installed (Debian: iceoryx; scripts/bootstrap.sh --dev)")
        return 77
    return INSTALLED


def main():
    words = sys.argv[2:]
    product = choose(words)
    if isinstance(product, int):
        return product
    wanted = words[0] if words else ""
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        pki = Pki(folder)
        for number, (name, check) in enumerate(cases()):
            if wanted not in name:
                continue
            own = pathlib.Path(folder) / str(number)
            own.mkdir()
            world = World(product, pki, own)
            try:
                check(world)
                print(f"ok      {name}", flush=True)
            except AssertionError as error:
                failures += 1
                print(f"FAILED  {name}: {error}", flush=True)
            finally:
                world.close()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())

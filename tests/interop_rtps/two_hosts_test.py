#!/usr/bin/env python3
"""Two hosts on one Ethernet: network namespaces joined by a veth pair. Nothing is said of networks to
either program, and they find each other and talk: the embedded participant with Cyclone DDS, secured,
with Fast DDS and with itself; also where the hosts have further networks with the same numbers, as
Docker makes them; and an embedded participant that keeps to its host is not heard.
Usage: two_hosts_test.py BUILD [FILTER]; exit 77: this system makes no such namespaces."""

import os
import pathlib
import subprocess
import sys
import tempfile
import time

from shapes_process import Case, check  # puts the folders of what follows in place
from documents import DOMAIN, TOPIC, Keys, Permissions, Side
from faulty_world import Peer
from pair import Namespace
from pki import Pki
from scenarios import GOVERNANCES
from surroundings import ENCRYPT, make_folder

SKIPPED = 77
PATIENCE = 15   # seconds until two that meet must have exchanged samples
SILENCE = 4     # seconds after which one that must not be heard would have been
SAMPLES = 10


class Host(Namespace):
    """As a system boots: a loopback interface that does no multicast, and no routes of ours."""
    SETUP = "ip link set lo up && echo ready && exec sleep 120"


class Ethernet:
    """Two hosts, 10.90.0.1 and 10.90.0.2, interface "net0" each."""

    def __init__(self):
        self.hosts = [Host()]
        try:
            self.hosts.append(Host(beside=self.hosts[0]))
            one, other = self.hosts
            one.run(f"ip link add net0 type veth peer name net0 netns {other.pid}")
            for number, host in enumerate(self.hosts, 1):
                host.run(f"ip addr add 10.90.0.{number}/24 dev net0")
                host.run("ip link set net0 up")
        except (RuntimeError, subprocess.CalledProcessError):
            self.close()
            raise

    def add_bridges(self):
        """On both hosts the network that Docker makes, and on the first one that leads nowhere else."""
        for host in self.hosts:
            self._add(host, "docker0", "172.17.0.1/16")
        self._add(self.hosts[0], "lab0", "10.91.0.1/24")

    @staticmethod
    def _add(host, name, address):
        host.run(f"ip link add {name} type veth peer name {name}-end")
        host.run(f"ip addr add {address} dev {name}")
        host.run(f"ip link set {name} up")
        host.run(f"ip link set {name}-end up")

    def close(self):
        for host in self.hosts:
            host.close()


class World:
    """What a scenario is written in."""

    def __init__(self, build, folder):
        self.build, self.folder = build, pathlib.Path(folder)
        self.net = Ethernet()
        self.pki = Pki(folder)
        self.shapes = Case(self.net.hosts[0], build / "bin/ddssec-shapes", DOMAIN)
        self.peers = []

    def peer(self, host, program, role, settings="<CycloneDDS/>"):
        """A secured peer that knows nothing of the network; a stock Cyclone DDS has empty settings."""
        documents = Side(governance=GOVERNANCES["sros2"]).arguments(self.pki, Keys(), role == "publish")
        command = [str(self.build / "bin" / program), f"--{role}", "--topic", TOPIC, "--domain", str(DOMAIN),
                   "--samples", str(SAMPLES), "--timeout", str(PATIENCE), *documents]
        if program == "embedded_peer":
            command += ["--address", "default"]
        environment = {**os.environ, "CYCLONEDDS_URI": settings, "LD_LIBRARY_PATH": ""}
        peer = Peer(self.net.hosts[host].enter(command), environment, self.folder / f"{program}-{role}.log")
        self.peers.append(peer)
        return peer

    def exchange(self, publisher, subscriber, hosts=(0, 1)):
        """Both programs, the subscriber first: all samples arrive and are acknowledged."""
        sub = self.peer(hosts[1], subscriber, "subscribe")
        pub = self.peer(hosts[0], publisher, "publish")
        came = sub.wait(lambda peer: len(peer.samples) >= SAMPLES, PATIENCE)
        check(f"{publisher} -> {subscriber}: {len(sub.samples)} samples in {PATIENCE} s\n{self.logs()}",
              came is not None)
        check(f"{publisher} has no acknowledgement",
              pub.wait(lambda peer: peer.times("acknowledged"), PATIENCE) is not None)

    def logs(self):
        return "\n".join(f"  {path.stem}: {line[:300]}" for path in sorted(self.folder.glob("*.log"))
                         for line in path.read_text(errors="replace").splitlines()[-6:])

    def close(self):
        for peer in self.peers:
            peer.kill()
        self.shapes.close()
        self.net.close()


def cyclone_hears_embedded(world):
    world.exchange("embedded_peer", "cyclone_peer")


def embedded_hears_cyclone(world):
    world.exchange("cyclone_peer", "embedded_peer")


def networks_of_the_same_numbers(world):
    world.net.add_bridges()
    world.exchange("embedded_peer", "cyclone_peer")
    world.exchange("cyclone_peer", "embedded_peer")
    embedded_and_itself(world)


def on_one_host(world):
    world.net.add_bridges()
    world.exchange("embedded_peer", "cyclone_peer", (0, 0))


def embedded_and_itself(world):
    folders = [make_folder(world.pki, name, ENCRYPT, Permissions((TOPIC,), (TOPIC,))) for name in ("one", "other")]
    shapes, (here, there) = world.shapes, world.net.hosts
    sub = shapes.start(f"-S -v d --security {folders[0]}", space=there)
    sub.says(r"joins its domain.* net0 \(10\.90\.0\.2\).*with multicast")
    shapes.start(f"-P --security {folders[1]}", space=here)
    sub.hears(3, PATIENCE)


def fast_dds(world):
    here, there = world.net.hosts
    program = world.build / "bin/shapes_fastdds"
    there.run("ip route add default dev net0")  # without one Fast DDS 2.9 keeps to the loopback
    heard = world.shapes.start("-S --final -t FromFast", space=here)
    world.shapes.vendor(f"-P {DOMAIN} FromFast", program, there)
    heard.hears(3, PATIENCE)


def an_interface_by_its_name(world):
    world.net.add_bridges()
    shapes, (here, there) = world.shapes, world.net.hosts
    sub = shapes.start("-S -v d --interface net0", space=here)
    check("only net0 is used", "lab0" not in sub.says(r"joins its domain.*").group())
    shapes.start("-P", space=there)
    sub.hears(3, PATIENCE)
    wrong = shapes.start("-S --interface net1", space=here)
    wrong.says(r"no such interface.*net0 \(10\.90\.0\.1\).*found net1")


def who_keeps_to_the_loopback(world):
    shapes, (here, there) = world.shapes, world.net.hosts
    far = shapes.start("-P -c RED", space=there)
    alone = shapes.start("-S -v d --interface lo", space=here)
    alone.says("no other machine is reached")
    check("heard from another host", not alone.says_within(r"\[\d+\]", SILENCE))
    check("the other host found it", not far.says_within("matched", 0.1))
    shapes.start("-P -c GREEN", space=here)
    check("not heard on its own host", {color for _, color, *_ in alone.hears(5, PATIENCE)} == {"GREEN"})


SCENARIOS = [cyclone_hears_embedded, embedded_hears_cyclone, networks_of_the_same_numbers, on_one_host,
             embedded_and_itself, fast_dds, an_interface_by_its_name, who_keeps_to_the_loopback]


def tried(build, scenario, make_world):
    """What went wrong, or nothing."""
    with tempfile.TemporaryDirectory() as folder:
        world = make_world(build, folder)
        try:
            scenario(world)
        except AssertionError as fault:
            return str(fault)
        finally:
            world.close()
    return ""


def main(scenarios, make_world):
    build, wanted = pathlib.Path(sys.argv[1]).resolve(), (sys.argv[2:] or [""])[0]
    try:
        Ethernet().close()
    except (RuntimeError, subprocess.CalledProcessError) as refusal:
        print(f"SKIPPED: no two hosts can be made here: {refusal}")
        return SKIPPED
    failed = 0
    for scenario in [each for each in scenarios if wanted in each.__name__]:
        begin = time.monotonic()
        fault = tried(build, scenario, make_world)
        print(f"{'FAILED' if fault else 'ok':8}{scenario.__name__.replace('_', ' ')} "
              f"({time.monotonic() - begin:.1f} s){': ' if fault else ''}{fault}", flush=True)
        failed += bool(fault)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(SCENARIOS, World))

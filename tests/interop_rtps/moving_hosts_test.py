#!/usr/bin/env python3
"""Hosts whose addresses change while embedded participants talk: they go on, at the new addresses. Two hosts on one Ethernet, as in
two_hosts_test.py.
Usage: moving_hosts_test.py BUILD [FILTER]; exit 77: this system makes no such namespaces."""

import os
import sys
import time

import two_hosts_test as two_hosts
from documents import DOMAIN, TOPIC, Keys, Side
from faulty_world import Peer
from scenarios import GOVERNANCES
from shapes_process import check

SOON = 6      # seconds; shorter than a lease, which is 10 s
PATIENCE = two_hosts.PATIENCE
PUBLISHER, SUBSCRIBER = 0, 1


class World(two_hosts.World):
    def embedded(self, host, role):
        documents = Side(governance=GOVERNANCES["sros2"]).arguments(self.pki, Keys(), role == "publish")
        command = [str(self.build / "bin/embedded_peer"), f"--{role}", "--topic", TOPIC, "--domain", str(DOMAIN), "--address", "default",
                   "--samples", "100000", "--interval", "100", "--hold", "--timeout", "100", *documents]
        peer = Peer(self.net.hosts[host].enter(command), {**os.environ}, self.folder / f"{role}.log")
        self.peers.append(peer)
        return peer

    def pair(self, hosts=(PUBLISHER, SUBSCRIBER)):
        subscriber, publisher = self.embedded(hosts[1], "subscribe"), self.embedded(hosts[0], "publish")
        self.flows(subscriber, PATIENCE)
        return subscriber, publisher

    def flows(self, subscriber, patience=SOON):
        before = len(subscriber.samples)
        came = subscriber.wait(lambda peer: len(peer.samples) >= before + 10, patience)
        check(f"{len(subscriber.samples) - before} samples in {patience} s\n{self.logs()}", came is not None)

    def does(self, host, *commands):
        for command in commands:
            self.net.hosts[host].run(command)

    def move(self, host, number):
        """As a DHCP server does that gives another address."""
        self.does(host, "ip addr flush dev net0", f"ip addr add 10.90.0.{number}/24 dev net0")


def goes_on(subscriber, publisher):
    """No sample was lost, and neither side took the other for gone."""
    check(f"{subscriber.times('unmatched')} and {publisher.times('unmatched')} times unmatched",
          not subscriber.times("unmatched") and not publisher.times("unmatched"))
    numbers = subscriber.numbers()
    check(f"{len(numbers)} samples from {numbers[0]} to {numbers[-1]}", len(numbers) == numbers[-1] - numbers[0] + 1)


def the_host_of_the_subscriber_moves(world):
    pair = world.pair()
    world.move(SUBSCRIBER, 7)
    world.flows(pair[0])
    world.move(SUBSCRIBER, 8)
    world.flows(pair[0])
    goes_on(*pair)


def the_host_of_the_publisher_moves(world):
    pair = world.pair()
    world.move(PUBLISHER, 7)
    world.flows(pair[0])
    goes_on(*pair)


def both_hosts_move(world):
    pair = world.pair()
    world.move(SUBSCRIBER, 7)
    world.move(PUBLISHER, 8)
    world.flows(pair[0], 2 * PATIENCE)


def the_network_comes_later(world):
    world.does(SUBSCRIBER, "ip addr flush dev net0", "ip link set net0 down")
    subscriber, _ = world.embedded(SUBSCRIBER, "subscribe"), world.embedded(PUBLISHER, "publish")
    world.does(SUBSCRIBER, "sleep 1", "ip link set net0 up", "ip addr add 10.90.0.2/24 dev net0")
    world.flows(subscriber, PATIENCE)


def a_named_interface_comes_back_as_another_device(world):
    here, there = world.net.hosts
    heard = world.shapes.start("-S --interface net0", space=there)
    world.shapes.start("-P -c RED", space=here)
    heard.hears(5, PATIENCE)
    world.does(SUBSCRIBER, "ip link del net0", "sleep 1")
    here.run(f"ip link add net0 type veth peer name net0 netns {there.pid}")
    for number, host in enumerate((PUBLISHER, SUBSCRIBER), 1):
        world.does(host, f"ip addr add 10.90.0.{number}/24 dev net0", "ip link set net0 up")
    world.shapes.start("-P -c GREEN", space=here)  # it is only found by multicast
    end = time.monotonic() + PATIENCE
    while "GREEN" not in {color for _, color, *_ in heard.hears(5, PATIENCE)}:
        check("the new publisher is not heard", time.monotonic() < end)


def two_on_a_host_that_loses_its_network(world):
    pair = world.pair((SUBSCRIBER, SUBSCRIBER))
    world.does(SUBSCRIBER, "ip addr flush dev net0", "ip link set net0 down")
    world.flows(pair[0])
    world.does(SUBSCRIBER, "ip link set net0 up", "ip addr add 10.90.0.9/24 dev net0")
    world.flows(pair[0])
    goes_on(*pair)


def without_security(world):
    here, there = world.net.hosts
    heard = world.shapes.start("-S", space=there)
    world.shapes.start("-P", space=here)
    heard.hears(5, PATIENCE)
    world.move(SUBSCRIBER, 7)
    heard.hears(20, PATIENCE)


SCENARIOS = [the_host_of_the_subscriber_moves, the_host_of_the_publisher_moves, both_hosts_move, the_network_comes_later,
             a_named_interface_comes_back_as_another_device, two_on_a_host_that_loses_its_network, without_security]

if __name__ == "__main__":
    sys.exit(two_hosts.main(SCENARIOS, World))

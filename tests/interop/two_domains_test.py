#!/usr/bin/env python3
"""Participants of two domains whose documents hold in both, and a stranger that copies the announcement of each to the
other with the other's domain in it. Announcements are not signed. The participants refuse each other by the domain that
they sign. Without the stranger's help, and in one domain, the same two talk. With domain tags, they do not authenticate.

Usage: two_domains_test.py BUILD"""

import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True

import pair  # noqa: E402
from documents import Permissions, Side  # noqa: E402
from insider_test import EVERYTHING, HONEST, World, samples  # noqa: E402

STRANGER = pathlib.Path(__file__).resolve().parent / "stranger.py"
REFUSED = "rtps_domain_differs"
TAGGED = "domain_not_covered"
QUIET = 3.0  # seconds after the refusal, in which no sample may come
URI = ('<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>'
       "<AllowMulticast>false</AllowMulticast></General><Discovery><Tag>{}</Tag><Peers><Peer address=\"127.0.0.1\"/></Peers>"
       "<ParticipantIndex>auto</ParticipantIndex><SPDPInterval>500ms</SPDPInterval></Discovery></Domain></CycloneDDS>")


class BothDomains(Permissions):
    def xml(self, name):
        return super().xml(name).replace("<id>7</id>", "<id>7</id><id>8</id>")


def meet(name, domains, tags, refused):
    """The two have these domain ids and tags, and `refused` is the event that is due, or None if they are to talk."""
    with tempfile.TemporaryDirectory(prefix="ddssec-domains-") as folder, World(folder, "ddssec", EVERYTHING) as world:
        world.side = Side(EVERYTHING, BothDomains())
        stranger = None
        if len({*domains}) > 1 or len({*tags}) > 1:
            stranger = subprocess.Popen(world.namespace.enter([sys.executable, str(STRANGER), "joining", *tags]),
                                        stdout=subprocess.PIPE, text=True)
            stranger.stdout.readline()  # it listens
        try:
            peers = []
            for role, starts, domain, tag in (("subscribe", False, domains[0], tags[:1]), ("publish", True, domains[1], tags[-1:])):
                pair.DOMAIN = domain
                if tag:
                    world.settings["CYCLONEDDS_URI"] = URI.format(tag[0])
                peers.append(world.honest(role, starts))
            if refused:
                world.until(f"{name}: {refused}", lambda: world.events(refused))
                world.passes(QUIET)
                assert not samples(peers[0], HONEST), f"{name}: samples of another domain{world.logs()}"
            else:
                world.until(f"{name}: a sample", lambda: samples(peers[0], HONEST))
                assert not world.events(REFUSED, TAGGED), f"{name}: {world.events(REFUSED, TAGGED)}"
        finally:
            if stranger:
                stranger.kill()
                stranger.communicate()
    print(f"{name}: {refused or 'talk'}")


def main():
    meet("one domain, no stranger", (7, 7), (), None)
    meet("one domain, one tag, no stranger", (7, 7), ("real",), TAGGED)
    meet("two domains", (7, 8), (), REFUSED)
    meet("two tags", (7, 7), ("real", "simu"), TAGGED)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""inspect, listening to the real products: who authenticates, and why who does not.

Usage: inspect_live_test.py DDSSEC; the peers of tests/interop stand beside it.
"""

import pathlib
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))

from pair import Namespace  # noqa: E402
from products import start  # noqa: E402
from transcript import PROGRAM, Transcript, main  # noqa: E402

import json  # noqa: E402

PRODUCTS = {"cyclonedds": "Cyclone DDS", "fastdds": "Fast DDS", "embedded": "ddssec"}


class InspectLive(Transcript):
    def setUp(self):
        super().setUp()
        self.namespace = Namespace()
        self.addCleanup(self.namespace.close)
        self.run_program("init", "demo")

    def heard(self, a, b, seconds, exit):
        """What inspect says of two (product, folder) that meet meanwhile; and of its own recording."""
        command = [PROGRAM, "inspect", "--listen", "lo", "--for", str(seconds), "--save", self.at / "heard.pcap",
                   "--format", "json"]
        listener = subprocess.Popen(self.namespace.enter([str(word) for word in command]), text=True,
                                    stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(0.5)
        peers = [start(self.namespace, product, self.at / folder, role, seconds - 1)
                 for (product, folder), role in ((a, "--publish"), (b, "--subscribe"))]
        out, said = listener.communicate(timeout=60)
        for peer in peers:
            peer.communicate(timeout=60)
        self.assertEqual(listener.returncode, exit, out + said)
        live, again = json.loads(out), self.json("inspect", "heard.pcap", exit=exit)
        (self.at / "heard.pcap").unlink()
        for answer in (live, again):
            answer["result"].pop("source")
            for finding in answer["diagnostics"]:
                finding.pop("file")
        self.assertEqual(live, again)
        return live

    def test_products_that_authenticate(self):
        for product, vendor in PRODUCTS.items():
            with self.subTest(product):
                out = self.heard((product, "demo/talker"), (product, "demo/listener"), 5, exit=0)
                self.assertEqual({one["vendor"] for one in out["result"]["participants"]}, {vendor})
                self.assertEqual([pair["state"] for pair in out["result"]["pairs"]], ["authenticated"])
                for one in out["result"]["participants"]:
                    self.assertTrue(one["secured"])
                    self.assertIn(one["name"], ("CN=talker", "CN=listener"))
                    self.assertEqual(one["certificate"],
                                     {"subject": one["name"], "issuer": "CN=demo Identity CA"})
                    self.assertEqual(one["domain"], 0)
                    self.assertEqual(one["protection"],
                                     {"rtps": "SIGN", "discovery": "ENCRYPT", "liveliness": "ENCRYPT"})
                    self.assertIn("AES256-GCM", one["kinds"])
                    self.assertEqual((one["clear_samples"], one["clear_topics"]), (0, []))

    def test_the_other_ones_ca(self):
        self.run_program("init", "other", "--participant", "stranger")
        for product in PRODUCTS:
            with self.subTest(product):
                out = self.heard((product, "demo/talker"), (product, "other/stranger"), 6, exit=1)
                self.assertEqual([pair["state"] for pair in out["result"]["pairs"]], ["apart"])
                # Cyclone DDS does not say before the handshake who issued its certificate.
                self.assertEqual([d["id"] for d in out["diagnostics"] if d["severity"] == "error"],
                                 ["CAP010" if product == "cyclonedds" else "CAP002"])

    def test_another_governance(self):
        self.run_program("init", "open", "--profile", "balanced")
        for product in PRODUCTS:
            with self.subTest(product):
                out = self.heard((product, "demo/talker"), (product, "open/listener"), 6, exit=1)
                self.assertIn("apart", [pair["state"] for pair in out["result"]["pairs"]])


if __name__ == "__main__":
    main()

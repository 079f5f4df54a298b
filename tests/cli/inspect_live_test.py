#!/usr/bin/env python3
"""inspect, listening to the real products: which participants authenticate, and why the others do not.

Usage: inspect_live_test.py DDSSEC; the peers of tests/interop stand beside it.
"""

import json
import pathlib
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))

from pair import Namespace  # noqa: E402
from products import start  # noqa: E402
from transcript import PROGRAM, Transcript, main  # noqa: E402

PRODUCTS = {"cyclonedds": "Cyclone DDS", "fastdds": "Fast DDS", "embedded": "ddssec"}


class InspectLive(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo")

    def heard(self, product, a, b, seconds, exit):
        """What inspect says of two folders' participants that meet meanwhile; and of its own recording. It
        listens until the participants have ended."""
        namespace, recording = Namespace(), f"{product}.pcap"
        command = [PROGRAM, "inspect", "--listen", "lo", "--for", "60", "--save", self.at / recording,
                   "--format", "json"]
        try:
            listener = subprocess.Popen(namespace.enter([str(word) for word in command]), text=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            time.sleep(0.5)
            peers = [start(namespace, product, self.at / folder, role, seconds)
                     for folder, role in ((a, "--publish"), (b, "--subscribe"))]
            for peer in peers:
                peer.communicate(timeout=60)
            time.sleep(0.5)
            listener.send_signal(signal.SIGINT)
            out, said = listener.communicate(timeout=60)
        finally:
            namespace.close()
        self.assertEqual(listener.returncode, exit, out + said)
        live, again = json.loads(out), self.json("inspect", recording, exit=exit)
        self.assertEqual([written["path"] for written in live["files_written"]], [str(self.at / recording)])
        self.assertEqual(again["files_written"], [])
        for answer in (live, again):
            answer.pop("files_written")
            answer["result"].pop("source")
            for finding in answer["diagnostics"]:
                finding.pop("file")
        self.assertEqual(live, again)
        return live

    def of_each(self, a, b, seconds, exit):
        """(product, what is heard), of all products at once."""
        with ThreadPoolExecutor() as pool:
            return zip(PRODUCTS, pool.map(lambda product: self.heard(product, a, b, seconds, exit), PRODUCTS))

    def test_products_that_authenticate(self):
        for product, out in self.of_each("demo/talker", "demo/listener", 20, exit=0):
            self.assertEqual({one["vendor"] for one in out["result"]["participants"]}, {PRODUCTS[product]})
            self.assertEqual([pair["state"] for pair in out["result"]["pairs"]], ["authenticated"])
            for one in out["result"]["participants"]:
                self.assertTrue(one["secured"])
                self.assertIn(one["name"], ("CN=talker", "CN=listener"))
                self.assertEqual(one["certificate"], {"subject": one["name"], "issuer": "CN=demo Identity CA"})
                self.assertEqual(one["domain"], 0)
                self.assertEqual(one["protection"],
                                 {"rtps": "SIGN", "discovery": "ENCRYPT", "liveliness": "ENCRYPT"})
                self.assertIn("AES256-GCM", one["kinds"])
                self.assertEqual((one["clear_samples"], one["clear_topics"]), (0, []))

    def test_the_other_ones_ca(self):
        self.run_program("init", "other", "--participant", "stranger")
        for product, out in self.of_each("demo/talker", "other/stranger", 5, exit=1):
            self.assertEqual([pair["state"] for pair in out["result"]["pairs"]], ["apart"])
            # Cyclone DDS does not say before the handshake who issued its certificate.
            self.assertEqual([d["id"] for d in out["diagnostics"] if d["severity"] == "error"],
                             ["CAP010" if product == "cyclonedds" else "CAP002"])

    def test_another_governance(self):
        self.run_program("init", "open", "--profile", "balanced")
        for _, out in self.of_each("demo/talker", "open/listener", 5, exit=1):
            self.assertEqual([pair["state"] for pair in out["result"]["pairs"]], ["apart"])


if __name__ == "__main__":
    main()

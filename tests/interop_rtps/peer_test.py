#!/usr/bin/env python3
"""The interface of ddssec-peer: events, exit codes, end on SIGTERM. Usage: peer_test.py BUILD"""

import dataclasses
import pathlib
import shutil
import signal
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
from documents import Governance, Keys, Permissions, Side  # noqa: E402
from peer_processes import PeerProcesses  # noqa: E402
from pki import Pki  # noqa: E402

PEER = pathlib.Path(sys.argv.pop(1)).resolve() / "bin" / "ddssec-peer"


class PeerTest(PeerProcesses):
    def start(self, *arguments):
        return self.launch([str(PEER), *arguments], 20)

    def wait_for(self, process, name):
        end = time.monotonic() + 20
        while not self.events(self.lines(process), name):
            self.assertLess(time.monotonic(), end, f"no {name}: {self.lines(process)}")
            time.sleep(0.02)

    def end(self, process):
        return process.wait(timeout=30), self.lines(process)

    def events(self, lines, name):
        return [line for line in lines if line["event"] == name]

    def test_shapes(self):
        sub, pub = self.start("--role", "sub", "--count", "15"), self.start("--role", "pub", "--count", "15",
                                                                            "--color", "RED")
        code, lines = self.end(sub)
        self.assertEqual(code, 0)
        self.assertEqual([(s["color"], s["x"], s["y"], s["shapesize"])
                          for s in self.events(lines, "sample")], [("RED", 0, 7, 30), ("RED", 14, 49, 30)])
        self.assertEqual([line["event"] for line in lines][-2:], ["done", "exit"])
        done = self.events(lines, "done")[0]
        self.assertEqual((done["matched"], done["received"], done["corrupt"], done["auth_failed"]),
                         (True, 15, 0, 0))
        code, lines = self.end(pub)
        self.assertEqual((code, self.events(lines, "done")[0]["written"]), (0, 15))
        self.assertEqual([m["current"] for m in self.events(lines, "matched")], [1, 0])

    def test_two_publishers_on_one_topic(self):
        sub = self.start("--role", "sub", "--count", "20")
        self.start("--role", "pub", "--count", "10", "--color", "RED")
        self.start("--role", "pub", "--count", "10", "--color", "GREEN")
        self.assertEqual(self.end(sub)[0], 0)

    def test_round_trips(self):
        pong = self.start("--role", "pong")
        code, lines = self.end(self.start("--role", "ping", "--count", "300", "--size", "1000"))
        self.assertEqual(code, 0)
        rtt = self.events(lines, "rtt")[0]
        self.assertEqual((rtt["size"], rtt["n"]), (1000, 300))
        self.assertTrue(0 < rtt["min_us"] <= rtt["median_us"] <= rtt["p90_us"] <= rtt["p99_us"])
        self.assertEqual(self.end(pong)[0], 0)

    def test_throughput_loses_nothing(self):
        for size in ("64", "100000"):
            sub = self.start("--role", "tput-sub", "--size", size)
            code, lines = self.end(self.start("--role", "tput-pub", "--size", size, "--duration", "0.5"))
            self.assertEqual(code, 0)
            code, received = self.end(sub)
            self.assertEqual(code, 0)
            tput = self.events(received, "tput")[0]
            self.assertEqual(tput["samples"], tput["sent"])
            self.assertEqual(tput["sent"], self.events(lines, "done")[0]["written"])

    def test_largest_sample(self):
        size = str(64 * 1024 * 1024 - 64)
        pong = self.start("--role", "tput-sub", "--size", size)
        code, lines = self.end(self.start("--role", "tput-pub", "--size", size, "--duration", "0.01"))
        self.assertEqual(code, 0)
        self.assertEqual(self.end(pong)[0], 0)

    def test_usage(self):
        for arguments in ((), ("--role", "king"), 
                          ("--role", "pub", "--size", "-1"), ("--role", "pub", "--secure", "x")):
            self.assertEqual(self.end(self.start(*arguments))[0], 2, arguments)

    def test_never_matched(self):
        for role in ("pub", "sub", "ping", "tput-pub", "tput-sub", "pong"):
            code, lines = self.end(self.start("--role", role, "--timeout", "1"))
            self.assertEqual(code, 1, role)
            self.assertEqual(self.events(lines, "exit")[0]["code"], 1)

    def test_other_partition_does_not_match(self):
        self.start("--role", "pub", "--partition", "a")
        self.assertEqual(self.end(self.start("--role", "sub", "--partition", "b", "--timeout", "2"))[0], 1)

    def test_missing_samples(self):
        self.start("--role", "pub", "--count", "5")
        code, _ = self.end(self.start("--role", "sub", "--count", "50", "--timeout", "3"))
        self.assertEqual(code, 4)

    def test_sigterm_ends_it(self):
        sub = self.start("--role", "sub", "--count", "1000")
        self.wait_for(sub, "participant_created")
        begin = time.monotonic()
        sub.send_signal(signal.SIGTERM)
        self.assertEqual(self.end(sub)[0], 1)
        self.assertLess(time.monotonic() - begin, 4)

    def test_a_killed_publisher_is_replaced_by_a_new_one(self):
        sub = self.start("--role", "sub", "--count", "30")
        first = self.start("--role", "pub", "--count", "1000")
        self.wait_for(sub, "sample")
        first.kill()
        self.start("--role", "pub", "--count", "30", "--color", "GREEN")
        self.assertEqual(self.end(sub)[0], 0)


FILES = {"--identity_ca": "identity_ca.pem", "--identity_certificate": "cert.pem",
         "--private_key": "key.pem", "--permissions_ca": "permissions_ca.pem",
         "--governance": "governance.p7s", "--permissions": "permissions.p7s", "--crl": "crl.pem"}
ENCRYPT = Governance(discovery="ENCRYPT", liveliness="ENCRYPT", rtps="SIGN", metadata="ENCRYPT",
                     data="ENCRYPT")
# The domain of the other tests, and the topics of all roles.
ALLOWED = Permissions(domain=3, publish=("*",), subscribe=("*",), partition="*")


class SecuredTest(PeerTest):
    """Every test above once more, all with security, and what only security can refuse."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.pki = Pki(cls.folder.name)
        cls.good = [cls.make(cls, name, Side(ENCRYPT, ALLOWED), starts)
                    for name, starts in (("first", True), ("second", False))]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def make(self, name, side, starts):
        """A participant's folder."""
        folder = pathlib.Path(self.folder.name) / name
        folder.mkdir()
        options = side.arguments(self.pki, Keys(), starts)
        for option, path in zip(options[::2], options[1::2]):
            shutil.copy(path, folder / FILES[option])
        return str(folder)

    def start(self, *arguments):
        if "--security" not in arguments:
            arguments += ("--security", self.good[len(self.running) % 2])
        return super().start(*arguments)

    def test_authentication_is_told(self):
        sub = self.start("--role", "sub", "--count", "5")
        code, lines = self.end(self.start("--role", "pub", "--count", "5"))
        self.assertEqual(code, 0)
        self.assertEqual([line["ok"] for line in self.events(lines, "auth")], [True])
        self.assertEqual(self.events(lines, "done")[0]["auth_failed"], 0)
        self.assertEqual(self.end(sub)[0], 0)

    def test_a_peer_of_another_ca_fails_and_is_told(self):
        strange = self.make("strange", Side(ENCRYPT, ALLOWED, signed_by="other", trusts="other"),
                            False)
        sub = self.start("--role", "sub", "--timeout", "3", "--security", self.good[0])
        code, lines = self.end(self.start("--role", "pub", "--timeout", "3", "--security", strange))
        self.assertEqual(code, 1)
        self.assertEqual(self.events(lines, "done")[0]["auth_failed"], 1)
        self.assertEqual(self.end(sub)[0], 1)

    def test_a_plain_peer_never_matches(self):
        sub = self.start("--role", "sub", "--timeout", "2")
        code, _ = self.end(self.start("--role", "pub", "--timeout", "2", "--security", "off"))
        self.assertEqual((code, self.end(sub)[0]), (1, 1))

    def test_further_properties_come_from_a_file_in_the_folder(self):
        for name, code in (("org.ddssec.ChaCha20-Poly1305", 0), ("Rijndael", 3)):
            folders = []
            for starts in (True, False):
                folder = self.make(f"{name}-{starts}", Side(ENCRYPT, ALLOWED), starts)
                with open(folder + "/security.properties", "w") as file:
                    for what in ("dds.sec", "org.ddssec"):
                        middle = "message_" if what == "org.ddssec" else ""
                        file.write(f"{what}.crypto.{middle}symmetric_cipher_algorithm = {name}\n")
                folders.append(folder)
            sub = self.start("--role", "sub", "--count", "5", "--security", folders[0])
            pub = self.start("--role", "pub", "--count", "5", "--security", folders[1])
            self.assertEqual((self.end(sub)[0], self.end(pub)[0]), (code, code))

    def start_hidden(self, *phrases, psk="ENCRYPT"):
        """A subscriber and a publisher under a governance with pre-shared keys."""
        governance = dataclasses.replace(ENCRYPT, psk=psk)
        running = []
        for role, phrase in zip(("sub", "pub"), phrases):
            folder = self.make(f"{self.id()}-{psk}-{role}-{len(self.running)}",
                               Side(governance, ALLOWED), role == "sub")
            if phrase:
                file = pathlib.Path(folder) / "domain.psk"
                file.touch(mode=0o600)
                file.write_text(phrase + "\n")
                (pathlib.Path(folder) / "security.properties").write_text(
                    f"dds.sec.crypto.rtps_psk_secret_passphrase = file:{file}\n")
            running.append(self.start("--role", role, "--count", "5", "--timeout", "4",
                                      "--security", folder))
        return [self.end(process) for process in running]

    def test_pre_shared_keys(self):
        good = "5632:castle super radar denial"
        for psk in ("SIGN", "ENCRYPT"):
            self.assertEqual([code for code, _ in self.start_hidden(good, good, psk=psk)], [0, 0])
        self.assertEqual([code for code, _ in self.start_hidden(good, good + "!")], [1, 1])
        (first, _), (second, lines) = self.start_hidden(good, "")
        self.assertEqual((first, second), (1, 3))
        self.assertIn("dds.sec.crypto.rtps_psk_secret_passphrase",
                      self.events(lines, "error")[0]["what"])

    def test_what_cannot_be_created_is_refused_by_name(self):
        silent = self.make("silent", Side(ENCRYPT, Permissions(domain=3, publish=())), True)
        for folder in ("/nowhere", silent):
            code, lines = self.end(self.start("--role", "pub", "--security", folder))
            self.assertEqual(code, 3)
            self.assertTrue(self.events(lines, "error")[0]["what"])

    def test_a_revocation_list_counts(self):
        careful = self.make("careful", Side(ENCRYPT, ALLOWED, crl="peer"), True)
        sub = self.start("--role", "sub", "--timeout", "3", "--security", careful)
        code, _ = self.end(self.start("--role", "pub", "--timeout", "3", "--security",
                                      self.good[1]))
        self.assertEqual((code, self.end(sub)[0]), (1, 1))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""inspect: what a capture shows, and captures that are broken."""

import hashlib
import struct
import subprocess

from transcript import DATA, PROGRAM, Transcript, library_path, main

CAPTURE = DATA / "captures/two_participants.pcap"


def packets(octets):
    """(seconds, fraction, octets) of each in a pcap file."""
    at = 24
    while at < len(octets):
        seconds, fraction, size, _ = struct.unpack_from("<IIII", octets, at)
        yield seconds, fraction, octets[at + 16:at + 16 + size]
        at += 16 + size


def pcap(of, lost=lambda octets: 0):
    """`lost` says how many octets the capturing program cut off each packet."""
    out = CAPTURE.read_bytes()[:24]
    for seconds, fraction, octets in of:
        left = octets[:len(octets) - lost(octets)]
        out += struct.pack("<IIII", seconds, fraction, len(left), len(octets)) + left
    return out


class Inspect(Transcript):
    def capture(self, *arguments):
        (self.at / "some.pcap").write_bytes(pcap(*arguments))

    def test_two_that_authenticate(self):
        out = self.json("inspect", CAPTURE)
        result = out["result"]
        self.assertEqual(out["diagnostics"], [])
        self.assertEqual([(one["name"], one["secured"], one["certificate"]["issuer"], one["domain"])
                          for one in result["participants"]],
                         [("CN=talker", True, "CN=demo Identity CA", 0),
                          ("CN=listener", True, "CN=demo Identity CA", 0)])
        (pair,) = result["pairs"]
        self.assertEqual(pair["state"], "authenticated")
        self.assertLess(pair["milliseconds"], 1000)
        steps = [pair["a_to_b"], pair["b_to_a"]]
        for step in ("request", "reply", "final"):
            self.assertEqual(sorted(flow[step] for flow in steps), [0, 1], step)
        self.assertTrue(all(flow["keys"] > 0 for flow in steps))
        text = self.run_program("inspect", CAPTURE).stdout
        self.assertIn("protection   rtps SIGN, discovery ENCRYPT, liveliness ENCRYPT", text)
        self.assertRegex(text, r"CN=talker and CN=listener: authenticated within \d+ ms\n$")

    def test_cyclone_dds_and_fast_dds(self):
        """Fast DDS does not announce its version, so what its later versions do is a note."""
        vendors, with_others = {}, []
        for seconds, fraction, octets in packets(CAPTURE.read_bytes()):
            at = octets.find(b"RTPS")
            prefix = octets[at + 8:at + 20]
            vendor = vendors.setdefault(prefix, b"\x01\x0f" if not vendors else b"\x01\x10")
            with_others.append((seconds, fraction, octets[:at + 6] + vendor + octets[at + 8:]))
        self.assertEqual(len(vendors), 2)
        self.capture(with_others)
        out = self.json("inspect", "some.pcap")
        self.assertEqual(sorted(one["vendor"] for one in out["result"]["participants"]), ["Cyclone DDS", "Fast DDS"])
        self.assertEqual([(d["id"], d["severity"]) for d in out["diagnostics"]], [("CAP014", "note")])
        self.assertRegex(out["diagnostics"][0]["message"], r"CN=\w+ is of Fast DDS, CN=\w+ of Cyclone DDS")

    def test_standard_input(self):
        with CAPTURE.open("rb") as capture:
            done = subprocess.run([PROGRAM, "inspect", "-"], stdin=capture, capture_output=True, text=True,
                                  timeout=60, check=True)
        self.assertIn("CN=talker and CN=listener: authenticated", done.stdout)

    def test_where_a_handshake_stops(self):
        told = list(packets(CAPTURE.read_bytes()))
        begin, _, first = told[0]
        late = (begin + 9, 0, first)
        for token, code, words in (("1.0+Reply", "CAP010", "does not reply"),
                                   ("1.0+Final", "CAP011", "which sends no final")):
            upto = next(i for i, packet in enumerate(told) if token.encode() in packet[2])
            self.capture([*told[:upto], late])
            out = self.json("inspect", "some.pcap", exit=1)
            self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"]], [(code, "some.pcap")])
            self.assertIn(words, out["diagnostics"][0]["message"])
            self.assertEqual(out["result"]["pairs"][0]["state"], "apart")
            self.assertIn("they do NOT talk", self.run_program("inspect", "some.pcap", exit=1).stdout)

    def test_too_short_to_judge(self):
        told = list(packets(CAPTURE.read_bytes()))
        upto = next(i for i, packet in enumerate(told) if b"1.0+Reply" in packet[2])
        self.capture(told[:upto])
        self.assertEqual([pair["state"] for pair in self.json("inspect", "some.pcap")["result"]["pairs"]],
                         ["under way"])

    def test_packets_and_files_that_are_cut(self):
        told = list(packets(CAPTURE.read_bytes()))
        self.capture(told, lambda octets: max(0, len(octets) - 96))
        self.assertEqual([d["id"] for d in self.json("inspect", "some.pcap")["diagnostics"]], ["CAP030"])
        whole = CAPTURE.read_bytes()
        for size in (len(whole) - 1, len(whole) // 2, 24 + 16 + len(told[0][2]) + 3):
            (self.at / "some.pcap").write_bytes(whole[:size])
            self.assertIn("CAP030", [d["id"] for d in self.json("inspect", "some.pcap")["diagnostics"]])

    def test_participants_of_different_domains(self):
        """Neither announces itself to the other, so that nothing but their domains explains the silence."""
        of_domain = b"\x0f\x00\x04\x00"
        first, other = None, []
        for seconds, fraction, octets in packets(CAPTURE.read_bytes()):
            at = octets.find(b"RTPS")
            first = first or octets[at + 8:at + 20]
            if octets[at + 8:at + 20] == first:
                octets = octets.replace(of_domain + bytes(4), of_domain + b"\x07\x00\x00\x00")
            other.append((seconds, fraction, octets))
        self.capture(other)
        told = [d for d in self.json("inspect", "some.pcap")["diagnostics"] if d["id"] == "CAP005"]
        self.assertEqual(len(told), 1)
        for words in ("CN=talker in domain 0", "CN=listener in domain 7"):
            self.assertIn(words, told[0]["message"])
        text = self.run_program("inspect", "some.pcap").stdout
        self.assertRegex(text, "ddssec at [^\n]*, domain 7, GUID prefix")
        self.assertNotIn("CAP005", [d["id"] for d in self.json("inspect", CAPTURE)["diagnostics"]])

    def test_nothing_in_it(self):
        self.capture([])
        out = self.json("inspect", "some.pcap")
        self.assertEqual((out["result"]["participants"], out["result"]["rtps_messages"]), ([], 0))

    def test_every_octet_may_be_another(self):
        """A capture may hold other octets than participants send."""
        whole = bytearray(CAPTURE.read_bytes()[:6000])
        for at in range(24, len(whole), 97):
            changed = bytearray(whole)
            changed[at] ^= 0xff
            (self.at / "some.pcap").write_bytes(changed)
            done = subprocess.run([PROGRAM, "inspect", self.at / "some.pcap"], capture_output=True, timeout=60,
                                  check=False)
            self.assertIn(done.returncode, (0, 1, 3), at)

    def test_what_cannot_be_read(self):
        (self.at / "words.txt").write_text("no capture\n" * 10)
        self.refused("capture_unreadable", 3, "inspect", "words.txt")
        self.refused("capture_unreadable", 3, "inspect", "nowhere.pcap")
        self.refused("capture_unreadable", 3, "inspect", "--listen", "no such interface")
        radio = bytearray(CAPTURE.read_bytes())
        radio[20:24] = struct.pack("<I", 105)
        (self.at / "radio.pcap").write_bytes(radio)
        self.refused("capture_unreadable", 3, "inspect", "radio.pcap")

    def test_libpcap_is_loaded_by_inspect_alone(self):
        needed = subprocess.run(["readelf", "-dW", PROGRAM], text=True, stdout=subprocess.PIPE, check=True).stdout
        self.assertIn("libcrypto", needed)
        self.assertNotIn("libpcap", needed)
        for name in ("libpcap.so.0.8", "libpcap.so.1"):
            (self.at / name).write_text("no library\n")
        without = {"LD_LIBRARY_PATH": f"{self.at}:{library_path()}"}
        self.run_program("version", environment=without)
        self.assertIn("apt install libpcap0.8", self.refused(
            "capture_unreadable", 3, "inspect", CAPTURE, environment=without)["hint"])

    def test_the_command_line(self):
        self.refused("usage", 2, "inspect")
        self.refused("usage", 2, "inspect", CAPTURE, "--listen", "lo")
        self.refused("usage", 2, "inspect", "--listen", "lo", "--for", "0")
        (self.at / "kept.pcap").write_text("")
        self.refused("would_overwrite", 4, "inspect", CAPTURE, "--save", "kept.pcap")
        would = self.json("inspect", CAPTURE, "--save", "copy.pcap", "--dry-run")["files_written"]
        self.assertEqual([(file["path"], file["mode"]) for file in would], [("copy.pcap", "0600")])
        self.assertNotIn("copy.pcap", self.files())
        self.refused("would_overwrite", 4, "inspect", CAPTURE, "--save", "kept.pcap", "--dry-run")
        (written,) = self.json("inspect", CAPTURE, "--save", "copy.pcap")["files_written"]
        self.assertEqual(self.files()["copy.pcap"], 0o600)
        self.assertEqual(written["sha256"], hashlib.sha256((self.at / "copy.pcap").read_bytes()).hexdigest())
        self.assertEqual(self.json("inspect", "copy.pcap")["result"]["pairs"],
                         self.json("inspect", CAPTURE)["result"]["pairs"])


if __name__ == "__main__":
    main()

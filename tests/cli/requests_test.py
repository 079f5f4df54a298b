#!/usr/bin/env python3
"""identity sign-csr: which subjects a request may ask for, and what is said of the answer to its question."""

import hashlib
import json
import os
import pty
import subprocess

from transcript import NOW, PROGRAM, Transcript, main


def read_all(terminal):
    """What was written to a terminal whose other side is closed."""
    octets = b""
    try:
        while more := os.read(terminal, 65536):
            octets += more
    except OSError:  # EIO: the end
        pass
    return octets.decode()


class Requests(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)

    def request(self, subject):
        self.openssl("req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", "r.key",
                     "-subj", subject, "-out", "r.pem")
        return ("identity", "sign-csr", "r.pem", "--ca", "demo", "-o", "cert.pem", *NOW)

    def test_no_participant_gets_the_name_of_a_ca(self):
        for subject in ("/CN=demo Identity CA", "/CN=demo Permissions CA"):
            for more in ((), ("--another-key",)):
                told = self.refused("subject_taken", 4, *self.request(subject), "--yes", *more)
                self.assertIn("which is a CA's", told["message"])

    # Measured: every host refuses it as a self-signed certificate.
    def test_nor_a_participant_that_is_issued(self):
        for subject in ("CN=demo Identity CA", "CN=demo Permissions CA"):
            told = self.refused("subject_taken", 4, "identity", "issue", "x", "--subject", subject, "--publish", "T", "--ca",
                                "demo", "-o", "x", *NOW)
            self.assertIn("which is a CA's", told["message"])

    def test_nor_none(self):
        self.refused("subject_name_malformed", 2, *self.request("/"), "--yes")

    # Measured: Cyclone DDS's own plugins give O=acme the permissions of O=acme,CN=talker, and /a those of /a/b.
    def test_no_part_of_another_subject(self):
        for subject, other in (("/O=acme/CN=robot", "/O=acme"), ("/CN=one", "/CN=one/OU=x"), ("/CN=\\/a\\/b", "/CN=\\/a")):
            (self.at / "cert.pem").unlink(missing_ok=True)
            self.run_program(*self.request(subject), "--yes")
            (self.at / "cert.pem").unlink()
            told = self.refused("subject_taken", 4, *self.request(other), "--yes")
            self.assertIn("compare the certificate's attributes only", told["message"])
            self.run_program(*self.request(other), "--yes", "--another-key")
        (self.at / "cert.pem").unlink()
        self.run_program(*self.request("/O=plant/CN=robot7"), "--yes")  # one attribute in common is no matter

    def compressed_request(self, key, subject="/CN=thief"):
        self.openssl("ec", "-in", key, "-conv_form", "compressed", "-out", "compressed.key")
        self.openssl("req", "-new", "-key", "compressed.key", "-subj", subject, "-out", "compressed.pem")
        return ("identity", "sign-csr", "compressed.pem", "--ca", "demo", "-o", "cert.pem", "--yes", *NOW)

    def test_a_revoked_key_gets_no_certificate_in_another_encoding(self):
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)
        told = self.refused("certificate_revoked", 1, *self.compressed_request("demo/talker/key.pem"))
        self.assertIn("has the same key", told["message"])

    def test_a_key_that_was_logged_in_another_encoding_counts_as_revoked(self):
        self.run_program(*self.request("/CN=device"), "--yes")
        (self.at / "cert.pem").unlink()
        self.run_program(*self.compressed_request("r.key", "/CN=device"))  # the same key: no other participant
        log = self.at / "demo/ca/identity/issued.jsonl"
        lines = [json.loads(line) for line in log.read_text().splitlines()]
        of_device = [line for line in lines if line["subject"] == "CN=device"]
        self.assertEqual(of_device[0]["key"], of_device[1]["key"])
        # As an earlier version logged the compressed key.
        self.openssl("ec", "-in", "r.key", "-pubout", "-conv_form", "compressed", "-outform", "DER", "-out", "public.der")
        octets = (self.at / "public.der").read_bytes()
        of_device[1]["key"] = hashlib.sha256(octets).hexdigest()
        log.write_text("".join(json.dumps(line) + "\n" for line in lines if line is not of_device[0]))
        self.run_program("identity", "revoke", of_device[1]["serial"], "--ca", "demo", *NOW)
        (self.at / "cert.pem").unlink()
        self.openssl("req", "-new", "-key", "r.key", "-subj", "/CN=thief", "-out", "r.pem")
        self.refused("certificate_revoked", 1, "identity", "sign-csr", "r.pem", "--ca", "demo", "-o", "cert.pem", "--yes",
                     *NOW)

    def forget(self, name):
        """The CA's log has no line of the participant, as when another tool issued it."""
        log = self.at / "demo/ca/identity/issued.jsonl"
        log.write_text("".join(line for line in log.read_text().splitlines(True) if f"CN={name}" not in line))

    def test_the_key_of_a_certificate_that_the_log_lacks_is_revoked_too(self):
        self.forget("talker")
        revoke = ("identity", "revoke", "demo/talker", "--ca", "demo", "--subject", "CN=talker", *NOW)
        self.run_program(*revoke)
        self.openssl("req", "-new", "-key", "demo/talker/key.pem", "-subj", "/CN=thief", "-out", "r.pem")
        sign = ("identity", "sign-csr", "r.pem", "--ca", "demo", "-o", "cert.pem", "--yes", *NOW)
        self.refused("certificate_revoked", 1, *sign)
        self.refused("certificate_revoked", 1, *self.compressed_request("demo/talker/key.pem"))
        out = self.json(*revoke)
        self.assertEqual((out["result"]["serials"], out["files_written"]), ([], []))
        # An earlier version logged no key: revoking it once more does.
        log = self.at / "demo/ca/identity/issued.jsonl"
        log.write_text("".join(json.dumps({k: v for k, v in json.loads(line).items() if k != "key"}) + "\n"
                               for line in log.read_text().splitlines()))
        self.assertIn("the log did not have its key", self.run_program(*revoke).stdout)
        self.refused("certificate_revoked", 1, *sign)

    def test_nor_is_a_certificate_of_that_key_renewed(self):
        self.openssl("req", "-new", "-key", "demo/talker/key.pem", "-subj", "/CN=device", "-out", "r.pem")
        self.run_program("identity", "sign-csr", "r.pem", "--ca", "demo", "-o", "device.pem", "--yes", *NOW)
        self.forget("talker")
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", "--subject", "CN=talker", *NOW)
        (self.at / "device").mkdir()
        (self.at / "device.pem").rename(self.at / "device/cert.pem")
        (self.at / "demo/talker/key.pem").rename(self.at / "device/key.pem")
        self.refused("certificate_revoked", 1, "identity", "renew", "device", "--ca", "demo", "--subject", "CN=device", *NOW)

    def test_nor_for_a_participant_that_is_issued(self):
        issue = ("identity", "issue", "x", "--ca", "demo", *NOW)
        self.refused("subject_taken", 4, *issue, "-o", "x", "--subject", "CN=talker,O=acme")
        self.run_program(*issue, "-o", "x", "--subject", "CN=x,O=acme")
        self.run_program(*issue, "-o", "x", "--subject", "CN=x", "--replace")  # its own one does not count
        self.refused("subject_taken", 4, *issue, "-o", "y", "--subject", "CN=x,O=other")
        (self.at / "fleet.toml").write_text('[[participant]]\nname = "a"\n[[participant]]\nname = "b"\nsubject = "CN=a,O=b"\n')
        self.refused("subject_taken", 4, "identity", "issue", "--from", "fleet.toml", "--ca", "demo", "-o", "fleet", *NOW)

    def sign_robots(self):
        """Requests of three devices, and their certificates in one folder."""
        (self.at / "issued").mkdir()
        for robot in ("robot1", "robot2", "robot3"):
            self.run_program("identity", "csr", robot, "-o", robot)
            self.run_program("identity", "sign-csr", robot, "--ca", "demo", "-o", f"issued/{robot}.pem", "--yes", *NOW)

    def serial_of(self, certificate):
        return self.json("identity", "show", certificate, *NOW)["result"]["serial"]

    def test_certificates_in_one_folder_are_of_several_participants(self):
        self.sign_robots()
        log = [json.loads(line) for line in (self.at / "demo/ca/identity/issued.jsonl").read_text().splitlines()]
        self.assertEqual([(line["folder"], line["file"]) for line in log if "file" in line],
                         [(f"{self.at}/issued", f"robot{i}.pem") for i in (1, 2, 3)])
        out = self.json("identity", "revoke", "issued/robot2.pem", "--ca", "demo", *NOW)["result"]
        self.assertEqual((out["subject"], out["serials"]), ("CN=robot2", [self.serial_of("issued/robot2.pem")]))
        self.assertEqual(out["elsewhere"], [f"{self.at}/issued/robot1.pem", f"{self.at}/issued/robot3.pem"])
        third = self.serial_of("issued/robot3.pem")
        self.json("identity", "revoke", third, "--ca", "demo", *NOW)
        self.run_program("identity", "renew", "issued/robot1.pem", "--ca", "demo", *NOW)
        for robot in ("robot2", "robot3"):
            self.refused("certificate_revoked", 1, "identity", "renew", f"issued/{robot}.pem", "--ca", "demo", *NOW)

    def test_nor_does_an_earlier_log_make_them_one(self):
        self.sign_robots()
        log = self.at / "demo/ca/identity/issued.jsonl"
        lines = [json.loads(line) for line in log.read_text().splitlines()]
        log.write_text("".join(json.dumps({k: v for k, v in line.items() if k != "file"}) + "\n" for line in lines))
        out = self.json("identity", "revoke", "issued/robot2.pem", "--ca", "demo", *NOW)["result"]
        self.assertEqual(out["serials"], [self.serial_of("issued/robot2.pem")])

    def test_each_participant_is_named_when_the_ca_is_rotated(self):
        self.sign_robots()
        out = self.json("ca", "rotate", "demo", "--role", "identity", "--dry-run", *NOW)
        self.assertIn(f"{self.at}/issued/robot3.pem", json.dumps(out))

    def request_with_key_of_talker(self):
        self.openssl("req", "-new", "-key", "demo/talker/key.pem", "-subj", "/CN=third", "-out", "third.csr")
        done = self.run_program("identity", "sign-csr", "third.csr", "--ca", "demo", "-o", "third.pem", "--yes", *NOW)
        return done.stdout

    def test_a_key_that_is_in_use_is_said_to_be(self):
        told = self.request_with_key_of_talker()
        self.assertIn(f"note: of the same key: serial {self.serial_of('demo/talker')}  CN=talker", told)

    def test_a_stolen_key_ends_all_its_certificates(self):
        self.request_with_key_of_talker()
        serials = [self.serial_of("demo/talker"), self.serial_of("third.pem")]
        out = self.json("identity", "revoke", "demo/talker", "--ca", "demo", "--reason", "keyCompromise", *NOW)["result"]
        self.assertEqual((out["serials"], out["same_key"]), (serials, []))
        listed = self.json("crl", "show", "demo")["result"]["revoked"]
        self.assertCountEqual([one["serial"] for one in listed], serials)

    def test_for_another_reason_the_certificate_of_the_same_key_is_named(self):
        self.request_with_key_of_talker()
        third = self.serial_of("third.pem")
        told = self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW).stdout
        self.assertIn(f"stays valid:\n  serial {third}  CN=third\n", told)
        again = self.json("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)["result"]
        self.assertEqual((again["serials"], again["same_key"]), ([], [third]))
        out = self.json("identity", "revoke", self.serial_of("demo/talker"), "--ca", "demo", "--reason", "keyCompromise",
                        *NOW)["result"]
        self.assertEqual(out["serials"], [third])

    def test_the_ca_of_one_role_is_no_permissions_ca(self):
        self.request("/CN=device")
        told = self.run_program("identity", "sign-csr", "r.pem", "--ca", "demo/ca/identity", "-o", "cert.pem", "--yes",
                                *NOW).stdout
        self.assertIn("--ca PERMISSIONS_CA -o permissions.xml", told)
        self.assertIn("the permissions CA's certificate as permissions_ca.pem", told)

    def test_an_answer_that_is_not_yes_is_called_so(self):
        words = self.request("/CN=device")
        for answer, exit in ((b"n\n", 4), (b"\n", 4), (b"y\n", 0)):
            ours, theirs = pty.openpty()
            os.write(ours, answer)
            done = subprocess.Popen([PROGRAM, *words], cwd=self.at, stdin=theirs, stdout=theirs, stderr=theirs)
            os.close(theirs)
            self.assertEqual(done.wait(timeout=60), exit)
            text = read_all(ours)
            os.close(ours)
            self.assertEqual("error[not_confirmed]" in text, exit != 0, text)


if __name__ == "__main__":
    main()

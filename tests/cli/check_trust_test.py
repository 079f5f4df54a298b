#!/usr/bin/env python3
"""check: certificates, lists and folders that keep two participants apart, and who starts the handshake."""

import hashlib
import shutil
import ssl

from check_participants import ONE_WAY, CheckTest
from transcript import main
from workshop import GOVERNANCE, grant, permissions


class Trust(CheckTest):
    def test_one_subject_on_both_sides_starts_the_handshake_by_chance(self):
        shutil.copytree(self.at / "talker", self.at / "again")
        told = [d["message"] for d in self.json("check", "talker", "again", "--vendor", "A=fastdds", "--vendor", "B=cyclonedds",
                                                exit=1)["diagnostics"] if d["id"] == "DOC083"]
        self.assertEqual(len(told), 1)
        self.assertIn('because both have the subject "CN=talker"', told[0])
        self.assertNotIn("by the hashes", told[0])

    def test_another_identity_ca(self):
        shutil.rmtree(self.at / "listener")
        made = self.participant("listener", "subscribe", label="stranger", ca=self.shop.ca("foreign"))
        made.put("identity_ca.pem", self.shop.ca("foreign") / "cert.pem")
        self.apart("DOC080", "CN=listener", 'issued by "CN=foreign CA"', '"CN=identity CA"',
                   document="identity_ca.pem")

    def test_another_ca_of_the_same_name(self):
        shutil.rmtree(self.at / "listener")
        ca = self.shop.ca("impostor", "/CN=identity CA")
        self.participant("listener", "subscribe", label="impostor", ca=ca).put(
            "identity_ca.pem", ca / "cert.pem")
        self.apart("DOC080", "talker does not accept", "CN=listener", "CN=identity CA",
                   "the CA of that name that is configured has another key")

    def test_a_revoked_peer(self):
        self.talker.put("crl.pem", self.shop.crl("listener", self.talker.identity_ca,
                                                 self.listener.certificate))
        self.apart("DOC080", "CN=listener serial", "revoked", document="crl.pem")
        self.assertIn("issue the participant again", self.hint)

    def test_a_list_that_is_none_is_not_taken_for_nobody_was_revoked(self):
        for text in ("no list", "", "-----BEGIN X509 CRL-----\n"):
            (self.at / "talker/crl.pem").write_text(text)
            out = self.check(exit=1)
            self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"] if d["severity"] == "error"],
                             [("DOC090", "talker/crl.pem")])
            out = self.json("doctor", "talker", exit=1)
            self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"] if d["severity"] == "error"],
                             [("DOC002", "talker/crl.pem")])
            self.assertEqual(out["result"]["verdicts"]["ddssec"], "fail")

    def test_a_list_of_another_ca(self):
        self.talker.put("crl.pem", self.shop.crl("foreign", self.shop.ca("foreign")))
        self.apart("DOC080", "CN=listener serial", "no revocation list", document="crl.pem")

    def test_the_hint_is_for_the_cause(self):
        self.apart("DOC080", "CN=listener serial", "expired", words=("--now", "2050-01-01T00:00:00Z"))
        self.assertIn("ddssec identity renew FOLDER --ca CA", self.hint)
        self.listener.sign("permissions", permissions(grant("CN=somebody", ONE_WAY.format("subscribe"))))
        self.apart("DOC081", "no grant for the subject", "CN=somebody")
        self.assertIn("write the subject name exactly", self.hint)

    def test_a_file_that_is_missing_is_said_once_of_whose_it_is(self):
        (self.at / "listener/cert.pem").unlink()
        out = self.check(exit=1)
        self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"] if d["severity"] == "error"],
                         [("DOC090", "listener/cert.pem")])
        self.assertEqual([a["ok"] for a in out["result"]["authentication"]], [True, False])

    def test_permissions_signed_by_another_ca(self):
        ca = self.shop.ca("foreign")
        signer = (ca / "cert.pem", ca / "key.pem")
        self.listener.put("permissions_ca.pem", ca / "cert.pem")
        self.listener.own_permissions(signer=signer)
        self.listener.sign("governance", GOVERNANCE, signer=signer)
        for words in ((), ("--vendor", "A=cyclonedds"), ("--vendor", "A=fastdds")):
            self.apart("DOC081", "listener's permissions", "the signer is not one of", "CN=foreign CA", '"CN=permissions CA"',
                       document="permissions.p7s", words=words)

    def test_a_folder_of_participants_is_no_participant(self):
        for words in (("check", "talker", "."), ("doctor", ".")):
            told = self.refused("file_not_found", 3, *words)
            self.assertIn(". is no participant's folder", told["message"])
            self.assertEqual(told["hint"], "it holds participants: ./listener, ./talker")

    def test_a_folder_of_a_ca_is_no_participant(self):
        for half in ("identity", "permissions"):
            (self.at / "ca" / half).mkdir(parents=True)
            shutil.copy(self.at / "talker" / "identity_ca.pem", self.at / "ca" / half / "ca.pem")
        for folder in ("ca", "ca/", "ca/identity", "./ca/permissions"):
            told = self.refused("file_not_found", 3, "doctor", folder)
            self.assertIn(f"{folder} is the folder of a CA", told["message"])
            self.assertEqual(told["hint"], "participants of it may be listener, talker")

    def test_a_peer_without_security(self):
        shutil.rmtree(self.at / "listener")
        (self.at / "listener").mkdir()
        self.apart("DOC087", "listener runs without security and talker with it")

    def test_a_participant_that_does_not_come_up(self):
        (self.at / "talker/key.pem").unlink()
        self.apart("DOC090", "talker cannot start on its own", "key.pem is missing")

    def test_one_subject_for_both(self):
        shutil.rmtree(self.at / "listener")
        shutil.copytree(self.at / "talker", self.at / "listener")
        self.listener.path = self.at / "listener"
        self.listener.sign("permissions", permissions(grant("CN=talker")))
        self.talker.sign("permissions", permissions(grant("CN=talker")))
        out = self.check(exit=0)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC089"])
        self.assertEqual(out["result"]["handshake"], {"starts": None, "ok": True})

    def test_who_starts_the_handshake_decides_between_the_products(self):
        """DDS-Security 1.2, clause 10.3.3 in openssl's words: the lower hash of the DER subject starts."""
        starts = "A" if self.subject_hash("talker") < self.subject_hash("listener") else "B"
        waits = "B" if starts == "A" else "A"
        out = self.check(exit=0)
        self.assertEqual(out["result"]["handshake"], {"starts": starts, "ok": True})
        self.assertEqual(out["diagnostics"], [])  # of Fast DDS 2.9.1 only if it is asked for
        out = self.check("--explain", exit=0)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC083"])
        for product in ("ddssec", "cyclonedds"):
            out = self.check("--explain", "--vendor", product, exit=0)
            self.assertNotIn("DOC083", [d["id"] for d in out["diagnostics"]])
        self.apart("DOC083", "CN=talker", "CN=listener",
                   words=("--vendor", f"{starts}=fastdds", "--vendor", f"{waits}=cyclonedds"))
        self.check("--vendor", f"{starts}=cyclonedds", "--vendor", f"{waits}=fastdds", exit=0)
        self.check("--vendor", f"{starts}=fastdds", "--vendor", f"{waits}=ddssec", exit=0)

    def subject_hash(self, name):
        def block(tag, content):
            return bytes([tag, len(content)]) + content
        common_name = block(0x06, b"\x55\x04\x03") + block(0x0C, name.encode())
        subject = block(0x30, block(0x31, block(0x30, common_name)))
        certificate = (self.at / name / "cert.pem").read_text()
        self.assertIn(subject, ssl.PEM_cert_to_DER_cert(certificate))
        return hashlib.sha256(subject).digest()

    def test_payload_protection_alone_between_the_products(self):
        xml = GOVERNANCE.replace("<metadata_protection_kind>ENCRYPT", "<metadata_protection_kind>NONE")
        for one in (self.talker, self.listener):
            one.sign("governance", xml)
        starter = "A" if self.subject_hash("talker") < self.subject_hash("listener") else "B"
        products = ("--vendor", "A=fastdds", "--vendor", "B=cyclonedds")
        out = self.check(*products, exit=1)
        self.assertIn("DOC085", [d["id"] for d in out["diagnostics"]])
        obstacle = out["result"]["topics"][0]["directions"][0]["obstacle"]
        self.assertIn("data_protection_kind ENCRYPT with metadata_protection_kind NONE", obstacle)
        self.check("--vendor", "A=fastdds", "--vendor", "B=ddssec", exit=0)
        self.check("--vendor", "fastdds", exit=0)
        if starter == "A":  # Cyclone DDS starts: the other direction works
            self.check("--vendor", "A=cyclonedds", "--vendor", "B=fastdds", exit=0)


if __name__ == "__main__":
    main()

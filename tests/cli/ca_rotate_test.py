#!/usr/bin/env python3
"""ca rotate: a new CA and key, and the participants' folders that go with it."""

import json
import shutil

from transcript import AT_THAT_TIME, NOW, Transcript, main

SECRET = {"SECRET": "correct horse"}


class Rotate(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "--participant", "talker", "--participant", "listener", *NOW)

    def rotate(self, role, *more, exit=0, at="demo"):
        return self.json("ca", "rotate", at, "--role", role, *more, *NOW, exit=exit)

    def text(self, path):
        return (self.at / path).read_text()

    def folders(self, *names):
        return [str(self.at / "demo" / name) for name in names]

    def meet(self, a, b, exit=0):
        self.json("check", a, b, *NOW, exit=exit)

    def test_an_identity_ca_gets_a_new_key_and_everybody_a_new_certificate(self):
        before = {path: self.text(path) for path in ("demo/ca/identity/ca.key.pem", "demo/ca/identity/ca.pem",
                                                     "demo/talker/cert.pem", "demo/talker/identity_ca.pem")}
        own_key, end = self.text("demo/talker/key.pem"), self.json("identity", "show", "demo/talker", *NOW)
        shutil.copytree(self.at / "demo/talker", self.at / "old")
        out = self.rotate("identity")["result"]
        self.assertEqual((out["folders"], out["revoked"], out["elsewhere"]),
                         (self.folders("talker", "listener"), [], []))
        for path, text in before.items():
            self.assertNotEqual(self.text(path), text, path)
        self.assertEqual(self.text("demo/talker/identity_ca.pem"), self.text("demo/ca/identity/ca.pem"))
        self.assertEqual(self.text("demo/talker/key.pem"), own_key)
        shown = self.json("identity", "show", "demo/talker", *NOW)["result"]
        for same in ("subject", "not_after", "guid_start"):
            self.assertEqual(shown[same], end["result"][same])
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "demo/ca/identity/ca.pem", "demo/talker/cert.pem")
        self.meet("demo/talker", "demo/listener")
        self.meet("old", "demo/listener", exit=1)
        self.assertEqual(self.files()["demo/ca/identity/ca.key.pem"], 0o600)
        self.run_program("identity", "issue", "radar", "--ca", "demo", "-o", "demo/radar", "--publish", "x",
                         "--governance", "demo/governance.p7s", *NOW)
        self.meet("demo/radar", "demo/listener")

    def test_of_a_copy_only_its_own_folders_follow(self):
        shutil.copytree(self.at / "demo", self.at / "copy")
        shutil.rmtree(self.at / "copy/listener")
        before = {p: p.read_bytes() for p in (self.at / "demo").rglob("*") if p.is_file()}
        out = self.rotate("identity", at="copy")["result"]
        self.assertEqual((out["folders"], out["elsewhere"]), ([str(self.at / "copy/talker")], self.folders("listener")))
        self.assertEqual({p: p.read_bytes() for p in before}, before)
        for file in (self.at / "copy/talker").glob("*dds.xml"):
            file.write_text(file.read_text().replace(str(self.at / "demo"), str(self.at / "copy")))
        self.json("doctor", "copy/talker", *NOW)

    def test_a_permissions_ca_gets_a_new_key_and_every_document_is_signed_anew(self):
        rights = self.json("can", "demo/talker", "publish", "x", *NOW)["result"]["because"]
        certificate = self.text("demo/talker/cert.pem")
        out = self.rotate("permissions")["result"]
        self.assertEqual(out["folders"], self.folders("talker", "listener"))
        for document in ("demo/talker/governance.p7s", "demo/governance.p7s"):
            self.json("governance", "verify", document, "--ca", "demo/ca/permissions/ca.pem", *NOW)
        self.assertEqual(self.json("can", "demo/talker", "publish", "x", *NOW)["result"]["because"], rights)
        self.assertEqual(self.text("demo/talker/cert.pem"), certificate)
        self.meet("demo/talker", "demo/listener")
        self.json("doctor", "demo/listener", *NOW)

    def test_nobody_comes_back_in_also_at_the_second_time(self):
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)
        self.run_program("crl", "distribute", "--ca", "demo", *NOW)
        out = self.rotate("identity")["result"]
        self.assertEqual((out["folders"], out["revoked"]),
                         (self.folders("listener"), self.folders("talker")))
        self.json("crl", "verify", "demo/listener", "--ca", "demo", *NOW)
        self.meet("demo/talker", "demo/listener", exit=1)
        self.assertEqual(self.rotate("identity")["result"]["folders"], self.folders("listener"))
        out = self.rotate("identity", "demo/talker", "demo/listener")["result"]
        self.assertEqual(out["revoked"], ["demo/talker"])

    def test_who_is_not_here_is_named(self):
        (self.at / "demo/talker").rename(self.at / "moved")
        (self.at / "moved/cyclonedds.xml").unlink()  # it names the former place
        self.run_program("ca", "create", "below", "--role", "identity", "--no-passphrase", "--days", "100",
                         "--intermediate-of", "demo/ca/identity", *NOW)
        before = self.files(), self.text("demo/ca/identity/ca.pem")
        out = self.rotate("identity", "--dry-run")["result"]
        self.assertEqual((self.files(), self.text("demo/ca/identity/ca.pem")), before)
        self.assertEqual((out["folders"], out["elsewhere"]),
                         (self.folders("listener"), [*self.folders("talker"), "CN=below Identity CA"]))
        told = self.run_program("ca", "rotate", "demo", "--role", "identity", "--dry-run", *NOW).stderr
        for place in out["elsewhere"]:
            self.assertIn(f"keeps what the old CA gave it (found {place})\n", told)
        self.assertEqual(told.count("warning[participant_elsewhere]"), 2)
        self.assertEqual(self.rotate("identity", "moved", "demo/listener")["result"]["elsewhere"], [])
        self.meet("moved", "demo/listener")

    def test_places_of_a_permissions_ca_are_in_the_log_from_then_on(self):
        (self.at / "demo/talker").rename(self.at / "moved")
        (self.at / "moved/cyclonedds.xml").unlink()  # it names the former place
        moved = str(self.at / "moved")
        self.rotate("permissions", "moved", "demo/listener")
        for role in ("permissions", "identity", "permissions"):
            out = self.rotate(role)["result"]
            self.assertEqual((sorted(out["folders"]), out["elsewhere"]), (sorted([moved, *self.folders("listener")]), []))
        self.meet("moved", "demo/listener")
        self.run_program("identity", "revoke", "demo/listener", "--ca", "demo", *NOW)
        out = self.json("crl", "distribute", "--ca", "demo", *NOW)["result"]
        self.assertEqual((out["folders"], out["elsewhere"]), ([moved], []))

    def test_folders_that_are_not_named_are_warned_of_and_follow_as_the_hint_says(self):
        for role in ("identity", "permissions"):
            told = self.rotate(role, "demo/talker")["diagnostics"]
            self.assertEqual([(d["id"], d["file"]) for d in told], [("rotation_unfinished", self.folders("listener")[0])])
            self.assertTrue(told[0]["hint"].startswith("ddssec ca rotate CA --role ROLE --end"))
            self.meet("demo/talker", "demo/listener", exit=1)
            self.assertEqual(self.rotate(role, "--end")["result"]["folders"], self.folders("listener"))
            self.meet("demo/talker", "demo/listener")

    def test_place_of_a_copy_is_not_recorded(self):
        shutil.copytree(self.at / "demo/talker", self.at / "copy")
        (self.at / "copy/cyclonedds.xml").unlink()
        before = self.text("demo/ca/identity/issued.jsonl")
        self.rotate("permissions", "copy", "demo/talker", "demo/listener", exit=None)
        self.assertEqual(self.text("demo/ca/identity/issued.jsonl"), before)

    def test_expired_cas_are_replaced(self):
        later = ("--now", "2040-01-01T00:00:00Z")
        told = self.json("doctor", "demo/talker", *later, exit=1)["diagnostics"]
        self.assertEqual({d["hint"].split(" gives")[0] for d in told if d["id"] == "DOC022"},
                         {"ddssec ca rotate CA --role ROLE"})
        for role in ("identity", "permissions"):
            self.json("ca", "rotate", "demo", "--role", role, "--clock-is-right", *later)
        for name in ("talker", "listener"):
            self.run_program("identity", "renew", f"demo/{name}", "--ca", "demo", "--permissions", "--ended-permissions",
                             *later)
        self.json("check", "demo/talker", "demo/listener", *later)

    def test_unreadable_overlap_is_ended_by_a_rotation_at_once(self):
        self.rotate("identity", "--overlap", "30d")
        (self.at / "demo/ca/identity/ca.overlap.json").write_text("{")
        told = self.refused("overlap_unreadable", 1, "ca", "rotate", "demo", "--role", "identity", "--move", *NOW)
        self.assertTrue(told["hint"].startswith("ddssec ca rotate CA --role ROLE replaces the CA at once"), told)
        out = self.rotate("identity")["result"]
        self.assertEqual(sorted(out["folders"]), sorted(self.folders("talker", "listener")))
        self.meet("demo/talker", "demo/listener")
        self.assertFalse((self.at / "demo/ca/identity/ca.overlap.json").exists())

    def test_an_encrypted_key_stays_encrypted_and_of_its_kind(self):
        secret = ("--passphrase-env", "SECRET", *NOW)
        self.json("ca", "create", "ca", "--key", "rsa2048", *secret, environment=SECRET)
        self.json("identity", "issue", "a", "--ca", "ca", "-o", "a", "--publish", "x", *secret, environment=SECRET)
        for role in ("identity", "permissions"):
            self.refused("passphrase_needed", 4, "ca", "rotate", "ca", "--role", role)
            self.json("ca", "rotate", "ca", "--role", role, *secret, environment=SECRET)
            shown = self.json("ca", "show", "ca", "--role", role, *NOW)["result"]
            self.assertEqual((shown["algorithm"], shown["key"]), ("RSA-2048", {"encrypted": True, "mode": "0600"}))
        self.json("permissions", "verify", "a/permissions.p7s", "--ca", "ca/permissions/ca.pem", *NOW)

    def test_an_intermediate_ca_is_signed_by_the_one_above(self):
        self.run_program("ca", "create", "plant", "--role", "identity", "--no-passphrase", "--days", "100",
                         "--intermediate-of", "demo/ca/identity", *NOW)
        self.run_program("identity", "issue", "a", "--ca", "plant", "-o", "a", "--days", "9", *NOW)
        self.refused("usage", 2, "ca", "rotate", "plant", "--role", "identity", *NOW)
        self.rotate("identity", "--issuer", "demo", at="plant")
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "demo/ca/identity/ca.pem", "-untrusted", "a/identity_ca.pem",
                     "a/cert.pem")

    def test_folders_with_the_names_of_ros_are_followed_too(self):
        for role in ("identity", "permissions"):
            (self.at / f"demo/talker/{role}_ca.pem").rename(self.at / f"demo/talker/{role}_ca.cert.pem")
            self.rotate(role)
        (self.at / "demo/talker/cyclonedds.xml").unlink()  # it names the files as they were
        self.meet("demo/talker", "demo/listener")

    def test_what_is_of_another_ca_is_neither_signed_nor_issued(self):
        self.run_program("init", "other", *NOW)
        self.refused("issuer_unknown", 1, "ca", "rotate", "demo", "other/talker", "--role", "identity", *NOW)
        self.refused("smime_signer_not_permissions_ca", 1, "ca", "rotate", "demo", "other/talker", "--role",
                     "permissions", *NOW)

    def test_what_is_no_ca_with_folders_is_told_what_to_do(self):
        self.run_program("keystore", "create", "ks", "--no-passphrase", *NOW)
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        for words, told in ((("ca", "rotate", "ks"), "ddssec keystore rotate"),
                            (("ca", "rotate", "demo/talker"), "it is a participant's folder"),
                            (("ca", "rotate", "ca"), "ddssec ca create"),
                            (("keystore", "rotate", "demo"), "ddssec ca rotate")):
            self.assertIn(told, self.refused("usage", 2, *words, "--role", "identity", *NOW)["message"])
        self.refused("usage", 2, "ca", "rotate", "demo", "--role", "both")
        self.refused("file_not_found", 3, "ca", "rotate", "nothing", "--role", "identity")

    def test_the_log_has_the_new_certificates(self):
        self.rotate("identity")
        lines = [json.loads(line) for line in self.text("demo/ca/identity/issued.jsonl").splitlines()]
        self.assertEqual([line["subject"] for line in lines], ["CN=talker", "CN=listener"] * 2)
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)
        self.run_program("crl", "distribute", "--ca", "demo", *NOW)
        self.meet("demo/talker", "demo/listener", exit=1)


if __name__ == "__main__":
    main()

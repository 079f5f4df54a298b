#!/usr/bin/env python3
"""The lists of renewed certificates and permissions: what commands write into them, and where they go."""

import re

from agent_folders import checked_events
from transcript import Transcript, main

PEM = re.compile(r"-----BEGIN ([A-Z ]+)-----.*?-----END \1-----\n", re.DOTALL)
CERTIFICATE, PERMISSIONS = "CERTIFICATE", "SIGNED PERMISSIONS"


class RenewalList(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "--participant", "talker", "--participant", "listener")

    def labels(self, path):
        file = self.at / path
        return [found[1] for found in PEM.finditer(file.read_text())] if file.exists() else []

    def renew(self, name="talker", *words):
        self.run_program("identity", "renew", f"demo/{name}", "--ca", "demo", "--days", "700", *words)

    def distribute(self, *words):
        return self.json("crl", "distribute", "--ca", "demo", *words)

    def test_Renewed_IsInTheListsOfItsCas_AndInEachFolderAfterDistribute(self):
        self.assertEqual(self.labels("demo/ca/identity/renewed.pem"), [])
        self.renew("talker", "--permissions")
        self.assertEqual(self.labels("demo/ca/identity/renewed.pem"), [CERTIFICATE])
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS])
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [])
        out = self.distribute()
        self.assertEqual(out["result"]["renewals"], {"certificates": 1, "permissions": 1})
        for name in ("talker", "listener"):
            self.assertEqual(self.labels(f"demo/{name}/renewed.pem"), [CERTIFICATE, PERMISSIONS])
        certificate = (self.at / "demo/talker/cert.pem").read_text()
        self.assertIn(certificate.strip(), (self.at / "demo/listener/renewed.pem").read_text())

    def test_ALaterRenewal_TakesThePlaceOfTheFormerOfItsSubjectAlone(self):
        for name in ("talker", "listener", "talker"):
            self.renew(name, "--permissions")
        self.assertEqual(self.labels("demo/ca/identity/renewed.pem"), [CERTIFICATE] * 2)
        self.assertIn((self.at / "demo/talker/cert.pem").read_text(),
                      (self.at / "demo/ca/identity/renewed.pem").read_text())

    def test_Distribute_SaysWhatTheListHas_AndWritesItOnce(self):
        self.renew()
        done = self.run_program("crl", "distribute", "--ca", "demo")
        self.assertIn("renewal list with 1 certificate and 0 permissions documents\n", done.stdout)
        written = [file["path"] for file in self.distribute()["files_written"]]
        self.assertNotIn("demo/listener/renewed.pem", " ".join(written), "it is there already")

    def test_Revoked_IsNotDistributed(self):
        self.renew()
        self.distribute()
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo")
        self.renew("listener")
        self.distribute()
        certificate = (self.at / "demo/talker/cert.pem").read_text()
        self.assertEqual(self.distribute()["result"]["renewals"]["certificates"], 1)
        self.assertNotIn(certificate, (self.at / "demo/listener/renewed.pem").read_text())
        self.assertIn(certificate, (self.at / "demo/ca/identity/renewed.pem").read_text())

    def test_PermissionsSign_ListsTheDocument_UnlessToldNotTo(self):
        words = ("permissions", "sign", "demo/talker/permissions.xml", "--ca", "demo", "-o", "signed.p7s", "--replace")
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "Square",
                         "-o", "demo/talker/permissions.xml", "--replace")
        self.run_program(*words, "--unlisted")
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [])
        self.run_program(*words)
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS])
        self.run_program("governance", "sign", "demo/governance.xml", "--ca", "demo", "--replace")
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS])

    def test_OfAnotherCa_StaysWhereTheFolderTrustsIt_AndGoesWhereItDoesNot(self):
        self.run_program("init", "other", "--participant", "foreign")
        self.run_program("identity", "renew", "other/foreign", "--ca", "other", "--days", "700")
        foreign = (self.at / "other/ca/identity/renewed.pem").read_text()
        trusted = self.at / "demo/listener/identity_ca.pem"
        trusted.write_text(trusted.read_text() + (self.at / "other/ca/identity/ca.pem").read_text())
        for name in ("talker", "listener"):
            (self.at / f"demo/{name}/renewed.pem").write_text(foreign)
        self.renew()
        self.distribute()
        self.assertEqual(self.labels("demo/talker/renewed.pem"), [CERTIFICATE])
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE] * 2)

    def test_ADamagedList_IsMadeAnew(self):
        for file in ("demo/ca/identity/renewed.pem", "demo/listener/renewed.pem"):
            (self.at / file).write_text("garbage")
        self.renew()
        self.distribute()
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE])

    def test_AMove_ListsWhatTheSuccessorIssuesAndSigns_AndATheftNothing(self):
        for role, label in (("identity", CERTIFICATE), ("permissions", PERMISSIONS)):
            self.run_program("ca", "rotate", "demo", "--role", role, "--overlap", "1d")
            self.assertEqual(self.labels(f"demo/ca/{role}/renewed.pem"), [])
            self.run_program("ca", "rotate", "demo", "--role", role, "--move")
            self.assertEqual(self.labels(f"demo/ca/{role}/renewed.pem"), [label] * 2)
        self.distribute()
        self.assertEqual(self.labels("demo/talker/renewed.pem"), [CERTIFICATE] * 2 + [PERMISSIONS] * 2)
        before = (self.at / "demo/ca/identity/renewed.pem").read_bytes()
        self.run_program("ca", "rotate", "demo", "--role", "identity", "--end")
        self.run_program("ca", "rotate", "demo", "--role", "identity")
        self.assertEqual((self.at / "demo/ca/identity/renewed.pem").read_bytes(), before)
        self.distribute()

    def test_Expiry_PassesOverTheList(self):
        self.renew()
        self.distribute()
        entries = self.json("expiry", "demo")["result"]["entries"]
        self.assertFalse([one for one in entries if one["file"].endswith("renewed.pem")])

    def test_TheAgent_PutsTheListIntoItsFolders(self):
        out = self.run_program("agent", "demo/talker", "demo/listener", "--ca", "demo", "--permissions", "--once",
                               "--now", "+300d").stdout
        self.assertEqual([event["event"] for event in checked_events(out)], ["renewed"] * 2)
        self.run_program("agent", "demo/talker", "demo/listener", "--ca", "demo", "--once", "--now", "+300d")
        for name in ("talker", "listener"):
            self.assertEqual(self.labels(f"demo/{name}/renewed.pem"), [CERTIFICATE] * 2 + [PERMISSIONS] * 2)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The lists of renewed certificates and permissions: what commands write into them, and where they go."""

import re
import time

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

    def test_PermissionsSign_ListsTheDocument_IfToldTo(self):
        words = ("permissions", "sign", "demo/talker/permissions.xml", "--ca", "demo", "-o", "signed.p7s", "--replace")
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "Square",
                         "-o", "demo/talker/permissions.xml", "--replace")
        self.run_program(*words)
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [])
        self.run_program(*words, "--listed")
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS])
        self.run_program("governance", "sign", "demo/governance.xml", "--ca", "demo", "--replace")
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS])

    def sign(self, name, topic, to, *words, exit=0, listed=True):
        self.run_program("permissions", "new", "--cert", f"demo/{name}/cert.pem", "--publish", topic, "-o", f"{to}.xml")
        return self.run_program("permissions", "sign", f"{to}.xml", "--ca", "demo", "-o", f"{to}.p7s",
                                *(["--listed"] if listed else []), *words, exit=exit)

    def test_RightsThatTheListTookAway_AreNotSignedAgain(self):
        time.sleep(1.1)  # signing times have seconds
        self.sign("talker", "Square", "narrow")
        self.distribute()
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [PERMISSIONS])
        before = (self.at / "demo/listener/renewed.pem").read_bytes()
        words = ("identity", "renew", "demo/talker", "--ca", "demo", "--days", "700", "--permissions")
        self.assertIn("document_superseded", self.run_program(*words, exit=(1, 3, 4)).stderr)
        out = self.run_program("agent", "demo/talker", "--ca", "demo", "--permissions", "--once", "--now", "+300d",
                               exit=(0, 1)).stdout
        self.assertIn("document_superseded", out)
        self.run_program("ca", "rotate", "demo", "--role", "permissions", "--overlap", "1d")
        moved = self.run_program("ca", "rotate", "demo", "--role", "permissions", "--move", exit=(1, 3, 4))
        self.assertIn("document_superseded", moved.stdout + moved.stderr)
        self.distribute()
        narrow = PEM.search(before.decode())[0]
        self.assertIn(narrow, (self.at / "demo/listener/renewed.pem").read_text())
        (self.at / "demo/talker/permissions.p7s").write_bytes((self.at / "narrow.p7s").read_bytes())
        self.run_program("ca", "rotate", "demo", "--role", "permissions", "--move")

    def test_LaterPermissionsThatAreNotListed_AreExtended(self):
        self.sign("talker", "Square", "narrow")
        time.sleep(1.1)
        self.sign("talker", "Circle", "later", listed=False)
        (self.at / "demo/talker/permissions.p7s").write_bytes((self.at / "later.p7s").read_bytes())
        self.renew("talker", "--permissions")

    def test_PermissionsThatHaveEnded_StayInTheList_UntilTheyAreReplaced(self):
        self.sign("talker", "Square", "narrow")
        xml = (self.at / "narrow.xml").read_text()
        ended = re.sub(r"<not_after>.*?</not_after>", "<not_after>2020-01-02T00:00:00</not_after>",
                       re.sub(r"<not_before>.*?</not_before>", "<not_before>2020-01-01T00:00:00</not_before>", xml))
        (self.at / "demo/ca/permissions/renewed.pem").unlink()
        (self.at / "ended.xml").write_text(ended)
        self.run_program("permissions", "sign", "ended.xml", "--ca", "demo", "--no-lint", "--listed")
        self.renew("listener", "--permissions")
        self.distribute()
        for file in ("demo/ca/permissions/renewed.pem", "demo/listener/renewed.pem"):
            self.assertEqual(self.labels(file).count(PERMISSIONS), 2)
        self.sign("talker", "Square", "next")
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS] * 2)

    def test_PermissionsForAnotherDomain_ReplaceNone(self):
        self.sign("talker", "Square", "narrow")
        xml = (self.at / "narrow.xml").read_text()
        (self.at / "other.xml").write_text(re.sub(r"<domains>.*?</domains>", "<domains><id>7</id></domains>", xml,
                                                  flags=re.DOTALL))
        self.run_program("permissions", "sign", "other.xml", "--ca", "demo", "--no-lint", "--listed")
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS] * 2)

    def revoke_and_distribute(self, exit):
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", exit=(0, 1, 3, 4))
        out = self.run_program("crl", "distribute", "--ca", "demo", exit=exit)
        self.assertEqual((self.at / "demo/listener/crl.pem").read_bytes(),
                         (self.at / "demo/ca/identity/crl.pem").read_bytes())
        return out

    def test_ADamagedListOfTheCa_KeepsNoRevocationBack_AndIsNotTakenForAnEmptyOne(self):
        file = self.at / "demo/ca/permissions/renewed.pem"
        self.sign("listener", "Square", "narrow")
        self.distribute()
        before = (self.at / "demo/listener/renewed.pem").read_bytes()
        for octets, code in ((b"x" * (9 << 20), "file_too_large"), (file.read_bytes()[:300], "renewal_list_malformed")):
            file.write_bytes(octets)
            self.assertIn(code, self.revoke_and_distribute(exit=(1, 3, 4)).stderr)
            self.assertIn(code, self.sign("listener", "Square", f"after_{code}", exit=(1, 3, 4)).stderr)
            self.assertEqual(file.read_bytes(), octets)
            self.assertEqual((self.at / "demo/listener/renewed.pem").read_bytes(), before)
        file.unlink()
        self.distribute()
        self.assertEqual((self.at / "demo/listener/renewed.pem").read_bytes(), before)

    def test_AListOfAFolderThatCannotBeWritten_KeepsNoRevocationFromIt(self):
        self.renew("listener")
        list_ = self.at / "demo/listener/renewed.pem"
        list_.mkdir()
        self.assertIn("would_overwrite", self.revoke_and_distribute(exit=(1, 3, 4)).stderr)
        list_.rmdir()
        list_.write_bytes(b"")
        self.distribute()
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE])

    def test_TheListOfACa_HasNoMoreOctetsThanAreRead(self):
        self.sign("listener", "Square", "one")
        xml = (self.at / "one.xml").read_text()
        subject = re.search(r"<subject_name>(.*?)</subject_name>", xml)[1]
        for i in range(9):
            (self.at / f"p{i}.xml").write_text(xml.replace(subject, f"CN=x{i}").replace(
                "<publish>", "<!--" + "x" * 730_000 + "--><publish>", 1))
            done = self.run_program("permissions", "sign", f"p{i}.xml", "--ca", "demo", "--no-lint", "--listed", exit=(0, 3))
        self.assertIn("left out", done.stderr)
        self.assertLessEqual((self.at / "demo/ca/permissions/renewed.pem").stat().st_size, 8 << 20)
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS] * 8)
        self.distribute()

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

    def test_ADamagedListOfAFolder_IsMadeAnew(self):
        (self.at / "demo/listener/renewed.pem").write_text("garbage")
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

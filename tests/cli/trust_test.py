#!/usr/bin/env python3
"""What lies in a participant's folder is the participant's word: the commands that sign or revoke go by the CA's log
and by the CA's own certificates."""

import json
import os
import shutil
import unittest

from transcript import NOW, Transcript, main

LATER = ("--now", "2027-11-01T00:00:00Z")
AFTER = ("--now", "2028-01-01T00:00:00Z")
GRANT = """<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions>{}</permissions></dds>
"""
ONE = """<grant name="{name}"><subject_name>{subject}</subject_name>
<validity><not_before>2025-01-01T00:00:00Z</not_before><not_after>{end}</not_after></validity>
<allow_rule><domains><id>0</id></domains><publish><topics><topic>{topic}</topic></topics></publish></allow_rule>
<default>DENY</default></grant>
"""


def grant(subject="CN=a", topic="Narrow", end="2026-12-01T00:00:00Z", name="a"):
    return ONE.format(subject=subject, topic=topic, end=end, name=name)


class Trust(Transcript):
    """CAs and the participants a and admin; each test plays the device of a."""

    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "--participant", "a", "--participant", "admin", *NOW)

    def sign(self, *grants, ca="demo/ca/permissions/ca"):
        (self.at / "p.xml").write_text(GRANT.format("".join(grants)))
        self.openssl("smime", "-sign", "-text", "-in", "p.xml", "-out", "demo/a/permissions.p7s", "-signer",
                     f"{ca}.pem", "-inkey", f"{ca}.key.pem")

    def signed(self):
        return (self.at / "demo/a/permissions.p7s").read_text()

    def own_ca(self):
        self.openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", "/CN=Own",
                     "-days", "3650", "-keyout", "own.key.pem", "-out", "own.pem")

    def renew(self, *more, exit=0, now=NOW):
        return self.json("identity", "renew", "demo/a", "--ca", "demo", *more, *now, exit=exit)

    def steal(self, *files):
        for file in files or ("cert.pem",):
            shutil.copy(self.at / "demo/admin" / file, self.at / "demo/a" / file)

    def log(self):
        lines = (self.at / "demo/ca/identity/issued.jsonl").read_text().splitlines()
        return [json.loads(line) for line in lines]

    def subject(self, folder="demo/a"):
        return self.json("identity", "show", folder, exit=None, *NOW)["result"]["subject"]


class Permissions(Trust):
    RENEW = ("identity", "renew", "demo/a", "--ca", "demo", "--permissions")

    def test_what_a_ca_of_the_devices_own_signed_is_not_signed(self):
        self.own_ca()
        self.sign(grant(topic="*"), ca="own")
        self.refused("smime_signer_not_permissions_ca", 1, *self.RENEW, *NOW)
        shutil.copy(self.at / "own.pem", self.at / "demo/a/permissions_ca.pem")
        before = self.signed()
        self.refused("smime_signer_not_permissions_ca", 1, *self.RENEW, *NOW)
        self.assertEqual(self.signed(), before)
        told = self.run_program(*self.RENEW[:-1], *NOW).stdout  # of the certificate alone
        self.assertIn("permissions.p7s is not what this permissions CA signed for CN=a", told)

    def test_another_ca_in_the_folder_is_told_though_the_document_is_the_cas(self):
        self.own_ca()
        shutil.copy(self.at / "own.pem", self.at / "demo/a/permissions_ca.pem")
        self.sign(grant())
        told = self.refused("smime_signer_not_permissions_ca", 1, *self.RENEW, *NOW)
        self.assertEqual(told["file"], "demo/a/permissions_ca.pem")
        self.assertIn("CN=Own", told["message"])

    def test_rights_that_have_ended_come_back_only_by_an_option(self):
        self.sign(grant(topic="*", end="2025-06-01T00:00:00Z"))
        told = self.refused("grant_expired", 1, *self.RENEW, *NOW)
        self.assertIn("--ended-permissions", told["hint"])
        self.renew()  # of the certificate alone
        out = self.renew("--permissions", "--ended-permissions")["result"]
        self.assertEqual(out["permissions_until"], "2027-11-21T00:00:00Z")
        self.json("can", "demo/a", "publish", "Any", *NOW)

    def test_ended_permissions_given_again_need_a_start_of_the_participant(self):
        self.sign(grant(end="2025-06-01T00:00:00Z"))
        renew = ("identity", "renew", "demo/a", "--ca", "demo")
        for more in ((), ("--permissions", "--ended-permissions")):
            told = self.run_program(*renew, *more, *NOW).stdout
            self.assertNotIn("takes it while it runs", told)
        self.assertIn("the permissions had ended, and with them all connections: start the participant again", told)
        self.assertIn("takes it while it runs", self.run_program(*renew, "--permissions", *NOW).stdout)

    def test_only_the_participants_own_grant_is_signed_and_told(self):
        self.sign(grant("CN=admin", "Others"), grant())
        told = self.run_program(*self.RENEW, *NOW).stdout
        self.assertIn("  signed for CN=a: allow publish Narrow; default DENY; all of it: ddssec permissions show "
                      "demo/a\n", told)
        self.assertNotIn("Others", self.signed())
        self.json("permissions", "verify", "demo/a", "--ca", "demo", *NOW)
        self.json("can", "demo/a", "publish", "Narrow", *NOW)


class Certificates(Trust):
    def test_the_certificate_of_another_is_not_renewed(self):
        self.steal("cert.pem", "permissions.p7s")
        for more in ((), ("--rekey",), ("--permissions",)):
            told = self.refused("certificate_of_another_folder", 1, "identity", "renew", "demo/a", "--ca", "demo", *more, *NOW)
            self.assertIn("CN=a, serial", told["message"])
            self.assertIn("CN=admin, serial", told["message"])
            self.assertIn("demo/admin", told["message"])
        self.refused("certificate_of_another_folder", 1, "identity", "renew", "demo/a", "--ca", "demo", "--subject", "CN=a", *NOW)

    def test_a_key_that_does_not_fit_is_told(self):
        self.steal("key.pem")
        told = self.refused("key_mismatch", 1, "identity", "renew", "demo/a", "--ca", "demo", *NOW)
        self.assertIn("the key of CN=a", told["message"])
        self.refused("key_mismatch", 1, "identity", "renew", "demo/a", "--ca", "demo", "--rekey", *NOW)
        self.json("identity", "issue", "a", "--ca", "demo", "-o", "demo/a", "--publish", "x", "--replace", *NOW)
        self.json("doctor", "demo/a", *NOW)

    def test_a_folder_that_moved_needs_the_participants_name_once(self):
        (self.at / "demo/a").rename(self.at / "demo/b")
        renew = ("identity", "renew", "demo/b", "--ca", "demo")
        self.refused("certificate_of_another_folder", 1, *renew, *NOW)
        self.json(*renew, "--subject", "CN=a", *NOW)
        self.json(*renew, *NOW)
        self.json("identity", "revoke", "demo/b", "--ca", "demo", *NOW)

    def test_with_its_ca_a_folder_may_move(self):
        (self.at / "demo").rename(self.at / "moved")
        self.json("identity", "renew", "moved/a", "--ca", "moved", *NOW)

    def test_what_the_log_does_not_have_needs_the_participants_name(self):
        log = self.at / "demo/ca/identity/issued.jsonl"
        log.unlink()
        renew = ("identity", "renew", "demo/a", "--ca", "demo")
        self.refused("certificate_unlogged", 1, *renew, *NOW)
        self.refused("certificate_unlogged", 1, "identity", "revoke", "demo/a", "--ca", "demo", *NOW)
        self.refused("certificate_of_another_folder", 1, *renew, "--subject", "CN=admin", *NOW)
        self.json(*renew, "--subject", "CN=a", *NOW)
        self.json(*renew, *NOW)

    def test_another_certificate_of_a_logged_serial_number_is_none_of_the_log(self):
        log = self.at / "demo/ca/identity/issued.jsonl"
        lines = self.log()
        lines[0]["sha256"] = "00" * 32
        log.write_text("".join(json.dumps(line) + "\n" for line in lines))
        for more in ((), ("--subject", "CN=a")):
            self.refused("certificate_unlogged", 1, "identity", "renew", "demo/a", "--ca", "demo", *more, *NOW)


class Revocation(Trust):
    def test_the_folder_is_revoked_and_not_the_certificate_put_into_it(self):
        self.steal()
        told = self.refused("certificate_of_another_folder", 1, "identity", "revoke", "demo/a", "--ca", "demo", *NOW)
        self.assertIn(self.log()[0]["serial"], told["message"])
        self.json("identity", "revoke", self.log()[0]["serial"], "--ca", "demo", *NOW)
        self.json("identity", "renew", "demo/admin", "--ca", "demo", *NOW)

    def test_what_was_revoked_is_said(self):
        self.renew()
        told = self.run_program("identity", "revoke", "demo/a", "--ca", "demo", *NOW).stdout
        serials = [line["serial"] for line in self.log() if line.get("subject") == "CN=a"]
        self.assertEqual(len(set(serials)), 2)
        for serial in serials:
            self.assertIn(f"  serial {serial}  CN=a\n", told)

    def test_an_earlier_certificate_does_not_bring_a_revoked_participant_back(self):
        shutil.copy(self.at / "demo/a/cert.pem", self.at / "first.pem")
        self.renew(now=LATER)
        self.json("identity", "revoke", "demo/a", "--ca", "demo", *AFTER)
        shutil.copy(self.at / "first.pem", self.at / "demo/a/cert.pem")
        for more in ((), ("--rekey",), ("--subject", "CN=a")):
            self.refused("certificate_revoked", 1, "identity", "renew", "demo/a", "--ca", "demo", *more, *AFTER)
        self.refused("certificate_revoked", 1, "identity", "issue", "a", "--ca", "demo", "-o", "demo/a", "--publish", "x", *AFTER)

    def test_a_new_key_is_not_revoked_with_the_old_one(self):
        serial = self.log()[0]["serial"]
        self.run_program("identity", "issue", "a", "--ca", "demo", "-o", "demo/a", "--replace", *NOW)
        self.json("identity", "revoke", serial, "--ca", "demo", *NOW)
        self.renew()

    def test_nor_does_another_certificate_of_its_key(self):
        self.renew()
        self.json("identity", "revoke", self.log()[0]["serial"], "--ca", "demo", *NOW)
        self.refused("certificate_revoked", 1, "identity", "renew", "demo/a", "--ca", "demo", *NOW)
        self.renew("--rekey")

    def test_a_second_key_for_a_subject_must_be_asked_for(self):
        self.run_program("identity", "csr", "admin", "-o", "evil")
        sign = ("identity", "sign-csr", "evil", "--ca", "demo", "--yes")
        told = self.refused("subject_taken", 4, *sign, *NOW)
        self.assertIn("CN=admin, serial", told["message"])
        self.json(*sign, "--another-key", *NOW)

    def test_a_request_of_the_same_key_is_no_second_participant(self):
        self.run_program("identity", "csr", "device", "-o", "device")
        for file in ("device/cert.pem", "again.pem"):
            self.json("identity", "sign-csr", "device", "--ca", "demo", "--yes", "-o", file, *NOW)


    def request_with(self, names):
        """A request of a new key, with a common name for each."""
        wanted = "".join(f"{i}.CN = {name}\n" for i, name in enumerate(names))
        (self.at / "names.cnf").write_text("[req]\ndistinguished_name = n\nprompt = no\nutf8 = yes\nstring_mask = utf8only\n[n]\n" + wanted)
        self.openssl("req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", "k.pem",
                     "-config", "names.cnf", "-out", "r.pem")

    def test_a_name_that_the_log_could_not_hold_is_not_certified(self):
        sign = ("identity", "sign-csr", "r.pem", "--ca", "demo", "--yes", "-o", "out.pem")
        self.request_with(["\u00a0" * 60] * 6)  # each octet of it is written as \\C2 or \\A0
        told = self.refused("name_too_long", 1, *sign, *NOW)
        self.assertIn("at most 2048 octets", told["message"])
        self.request_with(["\u00a0" * 60] * 5)
        self.json(*sign, *NOW)
        self.json("identity", "revoke", "out.pem", "--ca", "demo", *NOW)
        for words in (("identity", "csr", "x", "-o", "x"), ("identity", "issue", "x", "--ca", "demo", "-o", "x")):
            self.refused("name_too_long", 1, *words, "--subject", ",".join(["CN=" + "x" * 64] * 31), *NOW)

    def test_the_key_of_a_revoked_certificate_is_not_certified_again(self):
        self.run_program("identity", "csr", "device", "-o", "device")
        sign = ("identity", "sign-csr", "device", "--ca", "demo", "--yes", "-o")
        self.json(*sign, "first.pem", *NOW)
        listed = (self.at / "demo/ca/identity/issued.jsonl").read_text()
        self.json("identity", "revoke", "first.pem", "--ca", "demo", "--reason", "keyCompromise", *NOW)
        for more in ((), ("--another-key",)):
            self.refused("certificate_revoked", 1, *sign, "second.pem", *more, *NOW)
        (self.at / "demo/ca/identity/issued.jsonl").write_text(listed)  # an earlier copy: the list still says so
        told = self.refused("certificate_revoked", 1, *sign, "second.pem", *NOW)
        self.assertIn("ddssec identity csr", told["hint"])


class Rotation(Trust):
    def forge(self):
        """CN=admin for a key of the device's own, signed with the CA's stolen key."""
        self.run_program("identity", "csr", "admin", "-o", "evil")
        self.openssl("x509", "-req", "-in", "evil/request.pem", "-CA", "demo/ca/identity/ca.pem", "-CAkey",
                     "demo/ca/identity/ca.key.pem", "-days", "365", "-set_serial", "0x4711", "-out", "demo/a/cert.pem")

    def rotate(self, *more, exit=1):
        return self.json("ca", "rotate", "demo", *more, "--role", "identity", exit=exit)

    def test_what_the_old_key_signed_besides_is_left_out_and_named(self):
        self.forge()
        before = (self.at / "demo/a/cert.pem").read_bytes()
        out = self.rotate(*NOW)
        self.assertEqual(out["result"]["folders"], [str(self.at / "demo/admin")])
        self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"]],
                         [("certificate_unlogged", str(self.at / "demo/a/cert.pem"))])
        self.assertEqual((self.at / "demo/a/cert.pem").read_bytes(), before)

    def test_the_certificate_of_another_is_not_issued_for_this_folder(self):
        self.steal()
        for more in ((), ("demo/a", "demo/admin")):
            out = self.rotate(*more, "--dry-run", *NOW)
            self.assertEqual(len(out["result"]["folders"]), 1)
            self.assertEqual([d["id"] for d in out["diagnostics"]], ["certificate_of_another_folder"])

    def test_without_a_log_nothing_is_issued_unasked(self):
        (self.at / "demo/ca/identity/issued.jsonl").unlink()
        rotate = ("ca", "rotate", "demo", "demo/a", "demo/admin", "--role", "identity")
        told = self.refused("certificate_unlogged", 1, *rotate, *NOW)
        self.assertIn("--unlogged", told["hint"])
        self.assertEqual(len(self.json(*rotate, "--unlogged", *NOW)["result"]["folders"]), 2)


class PermissionsRotation(Trust):
    """The permissions CA's key was stolen: what its signature is under may be the thief's."""

    def rotate(self, *more, exit=1, at="demo"):
        return self.json("ca", "rotate", at, *more, "--role", "permissions", *NOW, exit=exit)

    def told(self, out):
        return [(d["id"], d["file"]) for d in out["diagnostics"]]

    def governance(self, profile):
        self.run_program("governance", "new", "--profile", profile, "--domain", "0", "-o", f"{profile}.xml")
        self.openssl("smime", "-sign", "-text", "-in", f"{profile}.xml", "-out", f"{profile}.p7s", "-signer",
                     "demo/ca/permissions/ca.pem", "-inkey", "demo/ca/permissions/ca.key.pem")

    def test_a_document_of_the_thief_is_refused_by_name_and_its_folder_left_alone(self):
        self.sign(grant(topic="*", end="2126-01-01T00:00:00Z"))
        before = {p: p.read_bytes() for p in (self.at / "demo/a").iterdir()}
        out = self.rotate()
        self.assertEqual(self.told(out), [("document_unlogged", str(self.at / "demo/a/permissions.p7s"))])
        self.assertEqual((out["result"]["folders"], out["result"]["unlogged"]), ([str(self.at / "demo/admin")], []))
        self.assertEqual({p: p.read_bytes() for p in before}, before)
        self.json("doctor", "demo/admin", *NOW)
        self.json("permissions", "verify", "demo/a", "--ca", "demo", *NOW, exit=1)

    def test_a_governance_of_the_thief_is_refused_too(self):
        self.governance("open")
        shutil.copy(self.at / "open.p7s", self.at / "demo/a/governance.p7s")
        self.assertEqual(self.told(self.rotate()), [("document_unlogged", str(self.at / "demo/a/governance.p7s"))])
        self.setUp()
        self.governance("open")
        self.sign(grant(topic="*"))
        shutil.copy(self.at / "open.p7s", self.at / "demo/a/governance.p7s")
        self.assertEqual(self.told(self.rotate()), [("document_unlogged", str(self.at / f"demo/a/{name}.p7s"))
                                                    for name in ("permissions", "governance")])
        self.setUp()
        self.governance("open")
        shutil.copy(self.at / "open.p7s", self.at / "demo/governance.p7s")
        self.assertEqual(self.told(self.rotate()), [("document_unlogged", "demo/governance.p7s")])

    def test_what_the_owner_signed_is_signed_again_by_every_way_of_signing(self):
        self.run_program("identity", "issue", "b", "--ca", "demo", "-o", "demo/b", "--publish", "x", "--governance",
                         "demo/governance.p7s", *NOW)
        self.run_program("permissions", "new", "--cert", "demo/a", "--publish", "y", "-o", "demo/a/permissions.xml", "--replace",
                         "--sign", "--ca", "demo", *NOW)
        self.run_program("permissions", "sign", "demo/a/permissions.xml", "--ca", "demo", "--replace", *NOW)
        self.run_program("identity", "renew", "demo/admin", "--ca", "demo", "--permissions", "--days", "700", *NOW)
        (self.at / "fleet.toml").write_text('publish = ["x"]\n[[participant]]\nname = "c"\n')
        self.run_program("identity", "issue", "--from", "fleet.toml", "--ca", "demo", "-o", "fleet", "--governance",
                         "demo/governance.p7s", *NOW)
        names = [*(f"demo/{name}" for name in ("a", "admin", "b")), "fleet/c"]
        for _ in range(2):
            self.assertEqual(sorted(self.rotate(exit=0)["result"]["folders"]), [str(self.at / name) for name in names])
            for name in names:
                self.json("doctor", name, *NOW)

    def test_an_earlier_document_does_not_come_back(self):
        before = (self.at / "demo/governance.p7s").read_bytes(), self.signed()
        for words in (("governance", "new", "--profile", "balanced", "-o", "demo/governance.xml"),
                      ("permissions", "new", "--cert", "demo/a", "--publish", "y", "-o", "demo/a/permissions.xml")):
            self.run_program(*words, "--replace", "--sign", "--ca", "demo", *NOW)
        shutil.copy(self.at / "demo/governance.p7s", self.at / "demo/admin/governance.p7s")
        (self.at / "demo/a/governance.p7s").write_bytes(before[0])
        told = self.refused("document_superseded", 1, "ca", "rotate", "demo", "demo/a", "--role", "permissions", *NOW)
        self.assertEqual(told["file"], "demo/a/governance.p7s")
        self.assertEqual(self.told(self.rotate()), [("document_superseded", str(self.at / "demo/a/governance.p7s"))])

    def test_renew_of_permissions_that_were_put_back_does_not_give_them_again(self):
        before = self.signed()
        for text in ("y", "z"):
            self.run_program("permissions", "new", "--cert", "demo/a", "--publish", text, "-o", "demo/a/permissions.xml",
                             "--replace", "--sign", "--ca", "demo", *NOW)
        last = (self.at / "demo/a/permissions.p7s").read_bytes()
        (self.at / "demo/a/permissions.p7s").write_text(before)
        renew = ("identity", "renew", "demo/a", "--ca", "demo", "--days", "700", *NOW)
        told = self.refused("document_superseded", 1, *renew, "--permissions")
        self.assertEqual(told["file"], "demo/a/permissions.p7s")
        self.run_program(*renew)  # the certificate alone
        (self.at / "demo/a/permissions.p7s").write_bytes(last)
        self.assertIn("permissions extended to", self.run_program(*renew, "--permissions").stdout)

    def test_a_ca_that_was_renewed_still_knows_what_it_signed(self):
        self.run_program("ca", "renew", "demo", "--role", "permissions", "--days", "3000", *NOW)
        for folder in ("a", "admin"):
            shutil.copy(self.at / "demo/ca/permissions/ca.pem", self.at / f"demo/{folder}/permissions_ca.pem")
            self.run_program("permissions", "new", "--cert", f"demo/{folder}", "--publish", "y", "--replace", "--sign", "--ca",
                             "demo", "-o", f"demo/{folder}/permissions.xml", *NOW)
        self.run_program("governance", "sign", "demo/governance.xml", "--ca", "demo", "--replace", *NOW)
        for folder in ("a", "admin"):
            shutil.copy(self.at / "demo/governance.p7s", self.at / f"demo/{folder}/governance.p7s")
        self.rotate(exit=0)

    def test_without_a_log_everything_is_read_first_and_taken_knowingly(self):
        (self.at / "demo/ca/permissions/signed.jsonl").unlink()
        told = self.refused("document_unlogged", 1, "ca", "rotate", "demo", "--role", "permissions", *NOW)
        self.assertIn("ddssec permissions show", told["hint"])
        out = self.rotate("--unlogged", exit=0)["result"]
        self.assertEqual((len(out["folders"]), len(out["unlogged"])), (2, 5))
        self.rotate(exit=0)

    def test_a_line_of_the_log_that_cannot_be_read_counts_for_nothing(self):
        log = self.at / "demo/ca/permissions/signed.jsonl"
        lines = log.read_text().splitlines()
        log.write_text("\n".join([lines[0], "nonsense", *lines[1:]]) + "\n")
        out = self.rotate(exit=0)
        self.assertEqual([(d["id"], d["line"]) for d in out["diagnostics"]], [("log_line_unreadable", 2)])

    def test_a_document_that_no_key_of_the_ca_signed_is_not_taken_even_so(self):
        self.own_ca()
        self.sign(grant(), ca="own")
        out = self.rotate("--unlogged")
        self.assertEqual(self.told(out), [("smime_signer_not_permissions_ca", str(self.at / "demo/a/permissions.p7s"))])


@unittest.skipUnless(os.geteuid() == 0, "only root can make files of another user")
class Unfinished(Trust):
    """A list of unfinished writes that another user made, in a folder that is that user's."""
    OTHER = 65534
    WITHIN = ("identity", "renew", "demo/a", "--ca", "demo", "--within", "1d", *NOW)

    def setUp(self):
        super().setUp()
        (self.at / "shared").mkdir()
        (self.at / "shared").chmod(0o1777)
        (self.at / "shared/important").write_text("root's")

    def tearDown(self):
        for left in [*self.at.rglob("*.new"), *self.at.rglob(".ddssec-unfinished")]:
            left.unlink()
        super().tearDown()

    def put(self, target, list_owner=0, draft_owner=0, folder_owner=0, list_mode=0o600, folder_mode=0o755):
        path = self.at / target if "/" in target else self.at / "demo/a" / target
        draft = path.with_name(path.name + ".1.new")
        draft.write_text("another's")
        os.chown(draft, draft_owner, draft_owner)
        list_ = self.at / "demo/a/.ddssec-unfinished"
        name = str(path) if "/" in target else target
        list_.write_bytes(name.encode() + b"\0.1.new\0end\0")
        list_.chmod(list_mode)
        os.chown(list_, list_owner, list_owner)
        os.chown(self.at / "demo/a", folder_owner, folder_owner)
        (self.at / "demo/a").chmod(folder_mode)
        return path

    def test_ones_own_is_finished(self):
        path = self.put("notes")
        self.json(*self.WITHIN)
        self.assertEqual(path.read_text(), "another's")
        self.assertFalse((self.at / "demo/a/.ddssec-unfinished").exists())

    def test_what_others_may_have_made_is_refused(self):
        other = self.OTHER
        for why in ({"list_owner": other}, {"draft_owner": other}, {"folder_owner": other}, {"list_mode": 0o622},
                    {"folder_mode": 0o777}):
            path = self.put("notes", **why)
            self.refused("unfinished_untrusted", 4, *self.WITHIN)
            self.assertFalse(path.exists(), why)

    def test_no_list_reaches_out_of_its_folder(self):
        path = self.put("shared/important")
        self.refused("unfinished_untrusted", 4, *self.WITHIN)
        self.assertEqual(path.read_text(), "root's")

    def test_links_and_further_names_are_refused(self):
        self.put("notes")
        list_ = self.at / "demo/a/.ddssec-unfinished"
        os.link(list_, self.at / "further")
        self.refused("unfinished_untrusted", 4, *self.WITHIN)
        list_.unlink()
        list_.symlink_to(self.at / "further")
        self.json(*self.WITHIN)
        self.assertFalse((self.at / "demo/a/notes").exists())

    def test_the_cas_list_is_given_to_all_and_no_list_of_theirs_is_read(self):
        path = self.put("shared/important", list_owner=self.OTHER, folder_owner=self.OTHER)
        out = self.json("crl", "distribute", "--ca", "demo", *NOW)["result"]
        self.assertEqual(len(out["folders"]), 2)
        self.assertEqual(path.read_text(), "root's")


if __name__ == "__main__":
    main()

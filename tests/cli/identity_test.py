#!/usr/bin/env python3
"""identity issue and show: a participant's folder, whole or not at all."""

import hashlib
import os
import re
import shutil
import xml.etree.ElementTree as xml

from transcript import AT_THAT_TIME, NOW, Transcript, main


class Identity(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "ca", "--passphrase-env", "SECRET", *NOW,
                         environment={"SECRET": "x"})

    def issue(self, *more):
        return ("identity", "issue", "talker", "--ca", "ca", "-o", "talker", *NOW, *more)

    def run_with_secret(self, function, *words):
        return function(*words, "--passphrase-env", "SECRET", environment={"SECRET": "x"})

    def test_issue_makes_a_complete_folder(self):
        self.run_with_secret(self.run_program, "governance", "new", "--domain", "7", "--sign", "--ca", "ca",
                             "-o", "governance.xml", *NOW)
        out = self.run_with_secret(self.json, *self.issue(
            "--publish", "rt/chatter", "--publish", "rt/<a>&", "--subscribe", "*",
            "--domain", "7", "--governance", "governance.p7s"))
        made = {f["path"]: f["mode"] for f in out["files_written"]}
        self.assertEqual(made, {"talker/identity_ca.pem": "0644", "talker/cert.pem": "0644",
                                "talker/key.pem": "0600", "talker/permissions_ca.pem": "0644",
                                "talker/permissions.p7s": "0644", "talker/governance.p7s": "0644",
                                "talker/crl.pem": "0644", "talker/cyclonedds.xml": "0644", "talker/fastdds.xml": "0644"})
        self.assertEqual((out["result"]["subject"], out["result"]["not_after"]),
                         ("CN=talker", "2027-11-21T00:00:00Z"))
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "talker/identity_ca.pem",
                     "talker/cert.pem")
        permissions = self.openssl("smime", "-verify", "-text", *AT_THAT_TIME, "-in",
                                   "talker/permissions.p7s", "-CAfile", "talker/permissions_ca.pem",
                                   "-purpose", "any")
        for text in ("<subject_name>CN=talker<", "<id>7<", "rt/&lt;a&gt;&amp;",
                     "<not_after>2027-11-21T00:00:00Z<", "<default>DENY<"):
            self.assertIn(text, permissions)

    def test_only_a_governance_document_that_will_be_believed_is_copied(self):
        self.run_program("init", "other", *NOW)
        for file, code, exit in (("other/governance.xml", "smime_not_multipart", 3),
                                 ("other/governance.p7s", "smime_signer_not_permissions_ca", 1)):
            told = self.refused(code, exit, *self.issue("--governance", file))
            self.assertEqual(told["file"], file)

    def test_show_says_what_the_certificate_says(self):
        self.run_with_secret(self.run_program, *self.issue("--subject", "CN=/a/b,O=Example"))
        shown = self.json("identity", "show", "talker", *NOW)["result"]
        self.assertEqual((shown["subject"], shown["issuer"], shown["valid_now"]),
                         ("CN=/a/b,O=Example", "CN=ca Identity CA", True))
        self.assertEqual(shown, self.json("identity", "show", "talker/cert.pem", *NOW)["result"])
        for time, code in (("2026-11-19T23:00:00Z", "certificate_not_yet_valid"),
                           ("2028-01-01T00:00:00Z", "certificate_expired")):
            late = self.json("identity", "show", "talker", "--now", time, exit=1)
            self.assertEqual([d["id"] for d in late["diagnostics"]], [code])

    def test_a_ca_key_that_others_can_read_is_refused(self):
        key = self.at / "ca/identity/ca.key.pem"
        key.chmod(0o640)
        told = self.run_with_secret(lambda *w, **m: self.refused("key_readable_by_others", 4, *w, **m),
                                    *self.issue())
        self.assertIn("expected mode 0600, found mode 0640", told["message"])
        self.run_with_secret(self.run_program, *self.issue("--insecure-key-mode"))

    def test_wrong_and_missing_passphrases(self):
        self.refused("passphrase_needed", 4, *self.issue())
        told = self.refused("passphrase_wrong", 1, *self.issue("--passphrase-env", "SECRET"),
                            environment={"SECRET": "y"})
        self.assertEqual(told["file"], "ca/identity/ca.key.pem")
        self.assertEqual(told["message"], "the passphrase does not open the private key")

    def test_names_cannot_leave_the_folder(self):
        for name in ("../evil", "a/b", "", ".hidden", "a" * 65, "a\nb", "ä"):
            self.refused("name_unusable", 2, "identity", "issue", name, "--ca", "ca", "-o", "x")

    def test_nothing_outlives_its_ca_unless_clamped(self):
        self.run_with_secret(lambda *w, **m: self.refused("outlives_ca", 4, *w, **m),
                             *self.issue("--days", "5000"))
        out = self.run_with_secret(self.json, *self.issue("--days", "5000", "--clamp"))
        self.assertEqual(out["result"]["not_after"], "2036-11-18T00:00:00Z")

    def test_nothing_ends_before_its_ca_begins(self):
        early = [word if word != NOW[1] else "2026-11-01T00:00:00Z" for word in self.issue("--days", "1")]
        told = self.run_with_secret(lambda *w, **m: self.refused("ends_before_ca", 4, *w, **m), *early)
        self.assertIn("expected an end after 2026-11-20T00:00:00Z, found 2026-11-02T00:00:00Z", told["message"])
        self.assertIn("--days", told["hint"])

    def test_a_device_keeps_its_key_and_gets_a_certificate(self):
        out = self.json("identity", "csr", "device", "-o", "device")
        self.assertEqual({f["path"]: f["mode"] for f in out["files_written"]},
                         {"device/key.pem": "0600", "device/request.pem": "0644"})
        sign = ("identity", "sign-csr", "device/request.pem", "--ca", "ca", *NOW)
        asked = self.run_with_secret(lambda *w, **m: self.refused("confirmation_needed", 4, *w, **m),
                                     *sign)
        self.assertIn('issue a certificate for "CN=device", key EC-prime256v1?', asked["message"])
        out = self.run_with_secret(self.json, *sign, "--yes")["result"]
        self.assertEqual((out["file"], out["subject"]), ("device/cert.pem", "CN=device"))
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "ca/identity/ca.pem",
                     "device/cert.pem")
        public = self.openssl("pkey", "-in", "device/key.pem", "-pubout")
        self.assertEqual(public, self.openssl("x509", "-in", "device/cert.pem", "-noout", "-pubkey"))
        self.run_with_secret(lambda *w, **m: self.refused("would_overwrite", 4, *w, **m), *sign, "--yes")
        self.assertEqual(self.json("ca", "show", "ca", *NOW)["result"]["issued"], 1)

    def test_what_a_device_needs_besides_is_told_and_is_all(self):
        self.run_program("identity", "csr", "device", "-o", "device")
        done = self.run_with_secret(self.run_program, "identity", "sign-csr", "device", "--ca", "ca", "--yes", *NOW)
        first, permissions, rest = done.stdout.splitlines()
        self.assertIn("device/cert.pem  CN=device", first)
        command = permissions.split("ddssec ")[1].replace("TOPIC", "Square").split()
        self.run_with_secret(self.run_program, *command, *NOW)
        for source, name in re.findall(r"(\S+) as (\w+\.pem)", rest):
            shutil.copy(self.at / source, self.at / "device" / name)
        self.run_with_secret(self.run_program, "governance", "new", "-o", "governance.xml", "--sign", "--ca", "ca", *NOW)
        shutil.copy(self.at / "governance.p7s", self.at / "device")
        self.json("doctor", "device", *NOW)

    def test_issue_says_what_is_not_in_the_folder_yet(self):
        done = self.run_with_secret(self.run_program, *self.issue())
        self.assertRegex(done.stdout, "no governance.p7s is in it yet: --governance FILE.*\nno permissions are in it yet")
        self.run_with_secret(self.run_program, "governance", "new", "-o", "governance.xml", "--sign", "--ca", "ca", *NOW)
        done = self.run_with_secret(self.run_program, "identity", "issue", "whole", "--ca", "ca", "-o", "whole", "--publish",
                                    "x", "--governance", "governance.p7s", *NOW)
        self.assertEqual([line.split("  ")[0] for line in done.stdout.splitlines()[:1]], ["whole"])
        self.assertNotIn("yet", done.stdout)
        self.json("doctor", "whole", *NOW)

    def test_issue_with_governance_and_no_rights_writes_the_permissions_ca_so_that_the_hints_suffice(self):
        self.governance()
        out = self.run_with_secret(self.json, *self.issue("--governance", "governance.p7s"))
        self.assertIn("talker/permissions_ca.pem", [f["path"] for f in out["files_written"]])
        hint = self.json("can", "talker", "publish", "x", *NOW, exit=3)["diagnostics"][0]["hint"]
        found = re.search(r"ddssec (permissions new .*)", hint)
        self.assertIsNotNone(found, hint)
        words = found[1].replace("TOPIC", "x").replace("--ca CA", "--ca ca").split()
        self.run_with_secret(self.run_program, *words, *NOW)
        self.json("doctor", "talker", *NOW)
        self.json("can", "talker", "publish", "x", *NOW)

    def test_issue_of_a_fleet_without_rights_writes_the_permissions_ca(self):
        (self.at / "fleet.toml").write_text('[[participant]]\nname = "a"\n[[participant]]\nname = "b"\npublish = ["x"]\n')
        self.run_with_secret(self.run_program, "identity", "issue", "--from", "fleet.toml", "--ca", "ca", "-o", "fleet", *NOW)
        for name in ("a", "b"):
            self.assertEqual((self.at / f"fleet/{name}/permissions_ca.pem").read_bytes(),
                             (self.at / "ca/permissions/ca.pem").read_bytes())

    def test_issue_with_an_identity_ca_alone_says_that_the_permissions_ca_is_missing(self):
        done = self.run_with_secret(self.run_program, "identity", "issue", "x", "--ca", "ca/identity", "-o", "x", *NOW)
        self.assertIn("no permissions_ca.pem is in it yet, since --ca has no permissions CA: copy ca.pem", done.stdout)
        self.assertFalse((self.at / "x/permissions_ca.pem").exists())
        shutil.copy(self.at / "ca/identity/ca.pem", self.at / "x/permissions_ca.pem")
        out = self.run_with_secret(self.json, "identity", "issue", "x", "--ca", "ca", "-o", "x", "--replace", *NOW)
        self.assertNotIn("x/permissions_ca.pem", [f["path"] for f in out["files_written"]], "it may be of documents to come")

    def test_can_and_check_of_a_folder_without_permissions_ca_advise_as_doctor_does(self):
        self.governance()
        self.run_with_secret(self.run_program, *self.issue("--governance", "governance.p7s", "--publish", "x"))
        (self.at / "talker/permissions_ca.pem").unlink()
        told = self.json("can", "talker", "publish", "x", *NOW, exit=3)["diagnostics"][0]
        self.assertEqual((told["id"], told["file"]), ("file_not_found", "talker/permissions_ca.pem"))
        hints = [told["hint"]] + [d["hint"] for d in self.json("check", "talker", "talker", *NOW, exit=1)["diagnostics"]
                                  if d["id"] == "DOC090"]
        advice = self.json("explain", "DOC001")["result"]["hint"]
        self.assertEqual(hints, [advice] * 3)
        self.json(*self.issue())  # as the hint says, this adds what is missing
        self.json("can", "talker", "publish", "x", *NOW)

    def test_a_request_that_its_key_did_not_sign_gets_nothing(self):
        self.run_program("identity", "csr", "device", "-o", "device")
        request = self.at / "device/request.pem"
        lines = request.read_text().splitlines()
        lines[3] = lines[3].swapcase()
        request.write_text("\n".join(lines))
        sign = ("identity", "sign-csr", "device/request.pem", "--ca", "ca", "--yes")
        self.refused("request_invalid", 1, *sign)
        request.unlink()
        self.refused("file_not_found", 3, *sign)

    def test_renew_of_a_certificate_that_began_less_than_a_day_ago_does_not_begin_before_it(self):
        self.run_with_secret(self.run_program, "identity", "issue", "talker", "--ca", "ca", "-o", "talker", "--publish", "x",
                             "--now", "2026-12-21T00:00:00Z")
        before = (self.at / "talker/cert.pem").read_text()
        told = self.run_with_secret(self.run_program, "identity", "renew", "talker", "--ca", "ca", "--days", "400",
                                    "--now", "2026-12-20T12:00:00Z")
        self.assertNotIn("renewal_not_taken", told.stderr)
        self.assertNotEqual((self.at / "talker/cert.pem").read_text(), before)
        shown = self.json("identity", "show", "talker", "--now", "2026-12-21T00:00:00Z")["result"]
        self.assertEqual(shown["not_before"], "2026-12-20T00:00:00Z")

    def renewed_but_not_taken(self, *words):
        told = self.run_with_secret(self.run_program, "identity", "renew", "talker", "--ca", "ca", *words, *NOW)
        self.assertIn("warning[renewal_not_taken]", told.stderr)
        self.assertNotIn("takes it while it runs", told.stdout)
        return told.stderr

    def test_renew_that_a_running_participant_does_not_take_says_so(self):
        self.run_with_secret(self.run_program, *self.issue("--publish", "x"))
        told = self.renewed_but_not_taken("--days", "5", "--dry-run")
        self.assertIn("expected an end not before 2027-11-21T00:00:00Z, found 2026-11-26T00:00:00Z", told)
        self.assertIn("restart the participant to take the shorter one", told)
        key = self.at / "talker/key.pem"
        key.rename(self.at / "kept.pem")
        self.assertIn("the private key is not in the folder", self.renewed_but_not_taken("--days", "500"))
        self.renewed_but_not_taken("--days", "500", "--permissions")
        (self.at / "kept.pem").rename(key)
        told = self.run_with_secret(self.run_program, "identity", "renew", "talker", "--ca", "ca", "--days", "500", *NOW)
        self.assertEqual(told.stderr, "")

    def test_renew_keeps_key_and_subject_and_says_when_permissions_end(self):
        self.run_with_secret(self.run_program, *self.issue("--publish", "x"))
        key = (self.at / "talker/key.pem").read_bytes()
        renew = ("identity", "renew", "talker", "--ca", "ca", "--days", "400", *NOW)
        out = self.run_with_secret(self.json, *renew)
        self.assertEqual([f["path"] for f in out["files_written"]], ["talker/cert.pem"])
        self.assertEqual((out["result"]["subject"], out["result"]["not_after"], out["result"]["permissions_until"]),
                         ("CN=talker", "2027-12-26T00:00:00Z", "2027-11-21T00:00:00Z"))
        self.assertEqual(key, (self.at / "talker/key.pem").read_bytes())
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "talker/identity_ca.pem",
                     "talker/cert.pem")
        self.assertIn("a participant on ddssec's plugins takes it while it runs; with stock plugins, restart it\n",
                      self.run_with_secret(self.run_program, *renew).stdout)
        out = self.run_with_secret(self.json, *renew, "--permissions")
        self.assertEqual(out["result"]["permissions_until"], "2027-12-26T00:00:00Z")
        seen = self.openssl("smime", "-verify", "-text", *AT_THAT_TIME, "-in",
                            "talker/permissions.p7s", "-CAfile", "talker/permissions_ca.pem",
                            "-purpose", "any")
        self.assertIn("<not_after>2027-12-26T00:00:00Z<", seen)
        self.assertIn("<topic>x</topic>", seen)
        late = self.run_with_secret(self.run_program, *renew[:-2], "--now", "2029-01-01T00:00:00Z")
        self.assertIn("the identity had ended, and with it all connections: start the participant again\n", late.stdout)

    def test_renew_with_permissions_that_stay_says_so(self):
        self.run_with_secret(self.run_program, *self.issue("--publish", "x"))
        renew = ("identity", "renew", "talker", "--ca", "ca", "--permissions", *NOW)
        told = self.run_with_secret(self.run_program, *renew, "--days", "400").stdout
        self.assertIn("permissions extended to 2027-12-26\n", told)
        told = self.run_with_secret(self.run_program, *renew, "--days", "399").stdout
        self.assertIn("permissions stay as they are: they end on 2027-12-26, not before the certificate\n", told)
        told = self.run_program(*renew, "--within", "30d").stdout
        self.assertIn("permissions stay as they are: they end on 2027-12-26\n", told)
        self.run_with_secret(self.run_program, *(word for word in renew if word != "--permissions"), "--days", "500")
        told = self.run_program(*renew, "--within", "30d").stdout
        self.assertIn("they end on 2027-12-26, before the certificate; without --within they are extended\n", told)
        (self.at / "talker/permissions.p7s").unlink()
        told = self.run_with_secret(self.run_program, *renew, "--days", "500").stdout
        self.assertIn("no permissions are in the folder, so none were extended", told)

    def test_renew_with_a_new_key_or_only_when_needed(self):
        self.run_with_secret(self.run_program, *self.issue())
        key = (self.at / "talker/key.pem").read_bytes()
        early = self.json("identity", "renew", "talker", "--ca", "ca", "--within", "30", *NOW)
        self.assertEqual((early["result"]["renewed"], early["files_written"]), (False, []))
        for time in ("30d", "48h", "4w"):  # as expiry takes it
            out = self.json("identity", "renew", "talker", "--ca", "ca", "--within", time, *NOW)
            self.assertFalse(out["result"]["renewed"])
        self.refused("usage", 2, "identity", "renew", "talker", "--ca", "ca", "--within", "soon", *NOW)
        renew = ("identity", "renew", "talker/cert.pem", "--ca", "ca", "--within", "30", "--rekey",
                 "--now", "2027-11-01T00:00:00Z")
        out = self.run_with_secret(self.json, *renew)
        self.assertEqual({f["path"]: f["mode"] for f in out["files_written"]},
                         {"talker/key.pem": "0600", "talker/cert.pem": "0644"})
        self.assertNotEqual(key, (self.at / "talker/key.pem").read_bytes())
        public = self.openssl("pkey", "-in", "talker/key.pem", "-pubout")
        self.assertEqual(public, self.openssl("x509", "-in", "talker/cert.pem", "-noout", "-pubkey"))

    def test_a_revoked_certificate_is_not_renewed(self):
        self.run_with_secret(self.run_program, *self.issue())
        self.run_with_secret(self.run_program, "identity", "revoke", "talker", "--ca", "ca", *NOW)
        self.run_with_secret(lambda *w, **m: self.refused("certificate_revoked", 1, *w, **m),
                             "identity", "renew", "talker", "--ca", "ca", *NOW)

    def test_a_permissions_document_of_ones_own_must_grant_the_subject(self):
        self.run_with_secret(self.run_program, *self.issue("--publish", "x"))
        signed = (self.at / "talker/permissions.p7s").read_text()
        xml = signed[signed.index("<?xml"):signed.index("</dds>") + 7]
        (self.at / "own.xml").write_text(xml)
        own = ("--ca", "ca", "-o", "b", "--permissions", "own.xml", *NOW)
        self.run_with_secret(lambda *w, **m: self.refused("no_grant_for_subject", 1, *w, **m),
                             "identity", "issue", "b", *own)
        self.run_with_secret(self.json, "identity", "issue", "talker", *own)
        self.json("can", "b", "publish", "x", *NOW, exit=3)  # no governance yet
        self.refused("usage", 2, "identity", "issue", "c", *own, "--publish", "x")
        (self.at / "own.xml").write_text("<dds>")
        told = self.run_with_secret(lambda *w, **m: self.refused("xml_not_well_formed", 3, *w, **m),
                                    "identity", "issue", "c", "--ca", "ca", "-o", "c",
                                    "--permissions", "own.xml")
        self.assertEqual(told["file"], "own.xml")

    def governance(self):
        self.run_with_secret(self.run_program, "governance", "new", "-o", "governance.xml", "--sign", "--ca", "ca", *NOW)

    def octets(self, folder="talker"):
        return {p.name: p.read_bytes() for p in (self.at / folder).iterdir()}

    def test_issue_completes_a_folder_and_leaves_key_and_certificate(self):
        self.run_with_secret(self.run_program, *self.issue())
        self.governance()
        before = self.octets()
        out = self.json(*self.issue("--governance", "governance.p7s"))  # no key is needed for that
        self.assertEqual({f["path"] for f in out["files_written"]}, {"talker/governance.p7s"})
        out = self.run_with_secret(self.json, *self.issue("--publish", "x", "--subscribe", "y"))
        self.assertEqual({f["path"] for f in out["files_written"]}, {"talker/permissions.p7s"})
        self.assertEqual({name: self.octets()[name] for name in before}, before)
        self.json("doctor", "talker", *NOW)
        self.json("can", "talker", "subscribe", "y", *NOW)
        (self.at / "talker/crl.pem").unlink()
        (self.at / "talker/identity_ca.pem").unlink()
        out = self.json(*self.issue())
        self.assertEqual({f["path"] for f in out["files_written"]}, {"talker/crl.pem", "talker/identity_ca.pem"})
        self.assertEqual(self.json("ca", "show", "ca", *NOW)["result"]["issued"], 1)
        self.json("doctor", "talker", *NOW)

    def test_issue_writes_the_configurations_that_init_writes(self):
        self.governance()
        done = self.run_with_secret(self.run_program, *self.issue("--publish", "x", "--governance", "governance.p7s"))
        self.run_program("init", "demo", *NOW)
        for file in ("cyclonedds.xml", "fastdds.xml"):
            made = (self.at / "talker" / file).read_text()
            self.assertEqual(made.replace("/talker/", "/demo/talker/"), (self.at / "demo/talker" / file).read_text())
            named = [e.text for e in xml.fromstring(made).iter() if (e.text or "").startswith("file:")]
            self.assertEqual(len(named), 7)
            for one in named:
                self.assertTrue(os.path.isfile(one.removeprefix("file:").removeprefix("//")), one)
        self.assertIn(f"talker with Cyclone DDS: export CYCLONEDDS_URI=file://{self.at}/talker/cyclonedds.xml\n", done.stdout)

    def test_issue_adds_a_missing_configuration_and_keeps_a_changed_one(self):
        self.governance()
        self.run_with_secret(self.run_program, *self.issue("--publish", "x", "--governance", "governance.p7s"))
        written = (self.at / "talker/fastdds.xml").read_text()
        (self.at / "talker/fastdds.xml").unlink()
        (self.at / "talker/cyclonedds.xml").write_text("<changed/>")
        out = self.json(*self.issue())
        self.assertEqual({f["path"] for f in out["files_written"]}, {"talker/fastdds.xml"})
        self.assertEqual((self.at / "talker/fastdds.xml").read_text(), written)
        (self.at / "talker/fastdds.xml").unlink()
        self.run_with_secret(self.run_program, *self.issue("--replace", "--publish", "y"))
        self.assertEqual((self.at / "talker/fastdds.xml").read_text(), written)
        self.assertEqual((self.at / "talker/cyclonedds.xml").read_text(), "<changed/>")

    def libraries(self):
        text = (self.at / "talker/cyclonedds.xml").read_text()
        return {os.path.dirname(e.get("path")) for e in xml.fromstring(text).iter("Library")}

    def test_a_configuration_without_the_plugins_folder_says_so(self):
        text = "cyclonedds.xml does not say where ddssec's plugins are"
        self.assertIn(text, self.run_with_secret(self.run_program, *self.issue("--publish", "x")).stdout)
        replaced = ("--replace", "--publish", "x")
        named = self.run_with_secret(self.run_program, *self.issue(*replaced, "--dropin", "/opt/a")).stdout
        self.assertNotIn(text, named)
        self.assertNotIn(text, self.run_with_secret(self.run_program, *self.issue(*replaced)).stdout)

    def test_a_folder_that_is_there_gets_the_drop_in_folder(self):
        self.run_with_secret(self.run_program, *self.issue("--publish", "x"))
        key = (self.at / "talker/key.pem").read_bytes()
        for folder in ("/opt/a", "/opt/b"):
            out = self.json(*self.issue("--dropin", folder))
            self.assertEqual([f["path"] for f in out["files_written"]], ["talker/cyclonedds.xml"])
            self.assertEqual(self.libraries(), {folder})
        self.refused("would_overwrite", 4, *self.issue("--dropin", "/opt/b"))  # nothing is missing
        self.assertEqual((self.at / "talker/key.pem").read_bytes(), key)
        self.run_with_secret(self.run_program, *self.issue("--replace", "--publish", "x", "--dropin", "/opt/c"))
        self.assertEqual(self.libraries(), {"/opt/c"})
        self.run_with_secret(self.run_program, *self.issue("--replace", "--publish", "x"))
        self.assertEqual(self.libraries(), {"/opt/c"})
        file = self.at / "talker/cyclonedds.xml"
        file.write_text(file.read_text().replace("<Security>", "<General><Interfaces/></General><Security>"))
        for more in ((), ("--replace", "--publish", "x")):
            told = self.run_with_secret(lambda *w, **m: self.refused("would_overwrite", 4, *w, **m),
                                        *self.issue(*more, "--dropin", "/opt/d"))
            self.assertIn("not as ddssec wrote it", told["message"])
            self.assertIn("<Library path=...>", told["hint"])
        self.assertEqual(self.libraries(), {"/opt/c"})

    def test_issue_completes_nothing_that_is_of_another(self):
        self.run_with_secret(self.run_program, *self.issue("--publish", "x"))
        self.governance()
        told = self.refused("would_overwrite", 4, *self.issue())
        self.assertIn("nothing is missing in it", told["message"])
        self.assertIn("--replace", told["hint"])
        told = self.run_with_secret(lambda *w, **m: self.refused("would_overwrite", 4, *w, **m), *self.issue("--publish", "y"))
        self.assertEqual(told["file"], "talker/permissions.p7s")
        self.refused("would_overwrite", 4, "identity", "issue", "other", "--ca", "ca", "-o", "talker",
                     "--governance", "governance.p7s", *NOW)
        self.run_program("ca", "create", "else", "--no-passphrase", *NOW)
        self.refused("would_overwrite", 4, "identity", "issue", "talker", "--ca", "else", "-o", "talker", *NOW)
        for missing in ("key.pem", "cert.pem"):
            kept = (self.at / "talker" / missing).read_bytes()
            (self.at / "talker" / missing).unlink()
            self.refused("would_overwrite", 4, *self.issue("--governance", "governance.p7s"))
            (self.at / "talker" / missing).write_bytes(kept)
        self.run_with_secret(self.run_program, "identity", "revoke", "talker", "--ca", "ca", *NOW)
        self.refused("certificate_revoked", 1, *self.issue("--governance", "governance.p7s"))

    def test_issue_replaces_on_request_and_keeps_the_rest(self):
        self.governance()
        self.run_with_secret(self.run_program, *self.issue("--publish", "x", "--governance", "governance.p7s"))
        (self.at / "talker/security.properties").write_text("org.ddssec.files_poll_interval = 7\n")
        before = self.octets()
        done = self.run_with_secret(self.run_program, *self.issue("--replace", "--publish", "y"))
        self.assertRegex(done.stdout, "the certificate before it is valid until 2027-11-21; .* identity revoke [0-9A-F]+ --ca ca")
        after = self.octets()
        self.assertEqual({n for n in after if after[n] != before[n]}, {"cert.pem", "key.pem", "permissions.p7s"})
        self.assertEqual(after.keys(), before.keys())
        self.assertEqual((self.at / "talker/key.pem").stat().st_mode & 0o777, 0o600)
        self.json("doctor", "talker", *NOW)
        self.json("can", "talker", "publish", "y", *NOW)
        self.assertEqual(self.json("ca", "show", "ca", *NOW)["result"]["issued"], 2)
        self.run_with_secret(self.run_program, "identity", "revoke", "talker", "--ca", "ca", *NOW)
        done = self.run_with_secret(self.run_program, *self.issue("--replace", "--publish", "y"))
        self.assertNotIn("identity revoke", done.stdout)
        (self.at / "talker/permissions.xml").write_text("old")
        self.run_with_secret(self.run_program, *self.issue("--replace", "--publish", "z"))
        self.assertIn("<topic>z</topic>", (self.at / "talker/permissions.xml").read_text())

    def test_issue_into_an_empty_folder_and_never_through_a_link(self):
        (self.at / "talker").mkdir()
        self.run_with_secret(self.run_program, *self.issue("--publish", "x"))
        self.assertEqual((self.at / "talker/key.pem").stat().st_mode & 0o777, 0o600)
        (self.at / "real").mkdir()
        (self.at / "link").symlink_to("real")
        self.run_with_secret(lambda *w, **m: self.refused("would_overwrite", 4, *w, **m), "identity", "issue",
                             "b", "--ca", "ca", "-o", "link", "--replace", *NOW)

    def test_partitions_of_what_is_issued(self):
        self.governance()
        self.run_with_secret(self.run_program, *self.issue("--publish", "x", "--partition", "yard*", "--governance", "governance.p7s"))
        self.json("can", "talker", "publish", "x", "--partition", "yard1", *NOW)
        told = self.json("can", "talker", "publish", "x", "--partition", "street", *NOW, exit=1)
        self.assertEqual([d["id"] for d in told["diagnostics"]], ["publish_not_allowed"])
        self.assertIn('allows the topic, but only in "yard*"', told["result"]["because"])
        self.assertIn('the topic is allowed, but not in partition "street": add it to <partitions>',
                      told["diagnostics"][0]["hint"])
        told = self.json("can", "talker", "publish", "x", *NOW, exit=1)
        self.assertIn("not without a partition", told["diagnostics"][0]["hint"])
        self.refused("usage", 2, *self.issue("--partition", "a"))

    def test_what_is_allowed_in_some_partitions_only_is_not_said_to_be_allowed_everywhere(self):
        self.governance()
        because = lambda *more: self.json("can", "talker", "publish", "x", *more, *NOW)["result"]["because"]
        whole = 'an allow_rule of grant "talker"'
        for partitions, limit in (((), ', but only without a partition (or in "")'),
                                  (("", "yard*"), ', but only in "", "yard*"'), (("*",), "")):
            words = [word for one in partitions for word in ("--partition", one)]
            self.run_with_secret(self.run_program, *self.issue("--replace", "--publish", "x", *words,
                                                               "--governance", "governance.p7s"))
            self.assertEqual(because(), whole + limit)
            self.assertEqual(because("--partition", ""), whole)

    def test_a_name_that_is_close_to_an_allowed_one_is_proposed(self):
        self.governance()
        self.run_with_secret(self.run_program, *self.issue("--publish", "rt/chatter", "--governance", "governance.p7s"))
        for typed in ("chatter", "/chatter", "rt/chater", "rt/Chatter"):
            told = self.json("can", "talker", "publish", typed, *NOW, exit=1)
            self.assertIn('is "rt/chatter" meant?', told["diagnostics"][0]["hint"], typed)
        for typed in ("rt/camera", "c", "rt/chatter/more"):
            told = self.json("can", "talker", "publish", typed, *NOW, exit=1)
            self.assertNotIn("meant?", told["diagnostics"][0]["hint"], typed)
        told = self.json("can", "talker", "subscribe", "rt/chatter", *NOW, exit=1)
        self.assertIn("add the topic to <subscribe>", told["diagnostics"][0]["hint"])

    def test_show_says_how_the_guid_begins(self):
        self.run_with_secret(self.run_program, *self.issue())
        value = b"\x0c\x06talker"
        one = b"\x30" + bytes([len(value) + 5]) + b"\x06\x03\x55\x04\x03" + value
        of_set = b"\x31" + bytes([len(one)]) + one
        digest = hashlib.sha256(b"\x30" + bytes([len(of_set)]) + of_set).digest()
        begins = (int.from_bytes(digest[:6], "big") >> 1) | 1 << 47  # DDS-Security 1.2, clause 10.3.3
        shown = self.json("identity", "show", "talker", *NOW)["result"]
        self.assertEqual(shown["guid_start"], f"{begins:012x}")

    def test_existing_folders_and_foreign_keys_are_refused(self):
        self.run_with_secret(self.run_program, *self.issue())
        self.refused("would_overwrite", 4, *self.issue())
        (self.at / "ca/identity/ca.pem").write_bytes((self.at / "ca/permissions/ca.pem").read_bytes())
        self.run_with_secret(lambda *w, **m: self.refused("key_mismatch", 1, *w, **m),
                             "identity", "issue", "b", "--ca", "ca", "-o", "b", *NOW)


if __name__ == "__main__":
    main()

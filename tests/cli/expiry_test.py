#!/usr/bin/env python3
"""expiry: one table of everything that ends."""

import os
import re
import subprocess

from transcript import NOW, Transcript, main


class Expiry(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)
        self.run_program("crl", "new", "--ca", "demo", *NOW)
        self.run_program("crl", "distribute", "--ca", "demo", *NOW)

    def entries(self, *words, exit=0):
        return self.json("expiry", *words, exit=exit)["result"]["entries"]

    def test_every_kind_is_in_the_table_once_soonest_first(self):
        rows = [(e["kind"], e["subject"], e["not_after"], e["places"]) for e in self.entries("demo", *NOW)]
        self.assertEqual(rows[0], ("revocation list", "CN=demo Identity CA", "2027-05-20T00:00:00Z", 3))
        self.assertEqual(sorted(rows[1:5]),
                         [(kind, f"CN={name}", "2027-11-21T00:00:00Z", 1)
                          for kind in ("certificate", "permissions") for name in ("listener", "talker")])
        self.assertEqual(sorted(rows[5:]),
                         [("CA", f"CN=demo {role} CA", "2036-11-18T00:00:00Z", 3)
                          for role in ("Identity", "Permissions")])

    def test_verbose_names_each_file_that_has_it(self):
        ca = self.entries("demo", *NOW)[-1]
        self.assertEqual((ca["kind"], ca["places"], len(ca["also_in"])), ("CA", 3, 2))
        plain, whole = (self.run_program("expiry", "demo", *more, *NOW).stdout for more in ((), ("-v",)))
        self.assertNotIn("also in", plain)
        for file in ca["also_in"]:
            self.assertIn(f"  also in {file}\n", whole)

    def test_after_a_renewal_it_says_which_folder_has_the_new_certificate(self):
        self.run_program("ca", "renew", "demo", "--role", "identity", "--days", "5000", *NOW)
        new = (self.at / "demo/ca/identity/ca.pem").read_text()
        (self.at / "demo/listener/identity_ca.pem").write_text(new)
        old, = [e for e in self.entries("demo", *NOW) if e["kind"] == "CA" and "Identity" in e["subject"]
                and e["not_after"] < "2037"]
        new, = [e for e in self.entries("demo", *NOW) if e["kind"] == "CA" and e["not_after"] > "2037"]
        self.assertEqual(sorted([old["file"], *old["also_in"]]),
                         ["demo/ca/identity/ca.pem", "demo/listener/identity_ca.pem", "demo/talker/identity_ca.pem"])
        self.assertEqual(sorted([new["file"], *new["also_in"]]), ["demo/ca/identity/ca.pem", "demo/listener/identity_ca.pem"])

    def test_the_exit_code_says_whether_something_ends_within_the_time(self):
        self.entries("demo", *NOW)
        soon = self.entries("demo", "--within", "52w", "--now", "2026-12-01T00:00:00Z", exit=1)
        self.assertEqual([e["state"] for e in soon], ["soon"] * 5 + ["ok"] * 2)
        late = self.entries("demo", "--now", "2027-11-21T00:00:00Z", exit=1)
        self.assertEqual([e["state"] for e in late], ["expired"] * 5 + ["ok"] * 2)
        self.assertEqual(late[0]["days_left"], -185)
        self.entries("demo/talker/cert.pem", "--within", "0d", *NOW)
        self.entries("demo/talker/cert.pem", "--within", "24h", "--now", "2027-11-20T00:00:01Z", exit=1)

    def test_a_certificate_that_begins_later_is_not_well(self):
        early = self.entries("demo/talker/cert.pem", "--now", "2026-11-19T00:00:00Z", exit=1)
        self.assertEqual([e["state"] for e in early], ["not yet"])

    def test_permissions_that_begin_later_are_not_well(self):
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "-o", "p.xml", *NOW)
        xml = (self.at / "p.xml").read_text()
        (self.at / "p.xml").write_text(re.sub("(<not_before>)[^<]*", r"\g<1>2027-03-01T00:00:00Z", xml))
        self.run_program("permissions", "sign", "p.xml", "--ca", "demo", "-o", "permissions.p7s", *NOW)
        early = self.entries("permissions.p7s", *NOW, exit=1)
        self.assertEqual([(e["kind"], e["state"]) for e in early if e["state"] != "ok"], [("permissions", "not yet")])
        self.entries("permissions.p7s", "--now", "2027-03-02T00:00:00Z")

    def test_each_kind_that_begins_later_is_not_well(self):
        early = self.entries("demo", "--now", "2026-11-19T00:00:00Z", exit=1)
        self.assertEqual({(e["kind"], e["state"]) for e in early},
                         {(kind, "not yet") for kind in ("CA", "certificate", "permissions", "revocation list")})

    def test_a_folder_behind_a_link_is_no_reason_for_success(self):
        """In the fleet there is only a link to the folder of a robot whose documents have ended."""
        late = ("--now", "2027-11-22T00:00:00Z")
        (self.at / "fleet").mkdir()
        (self.at / "demo/ca").rename(self.at / "fleet/ca")
        (self.at / "fleet/old.robot").symlink_to("../demo/talker")
        for words in ((), ("-q",), late):
            told = self.json("expiry", "fleet", *words, *(() if words == late else NOW), exit=1 if words == late else 3)
            link, = told["diagnostics"]
            self.assertEqual((link["id"], link["file"]), ("file_unreadable", "fleet/old.robot"))
            self.assertIn(f"search {self.at.resolve()}/demo/talker as well", link["message"])
        for paths in (("fleet", "demo"), ("demo", "fleet"), ("fleet", "fleet/old.robot"), ()):
            self.assertEqual(self.json("expiry", *paths, *NOW)["diagnostics"], [])
            self.json("expiry", *paths, *late, exit=1)

    def test_a_link_that_once_led_to_a_folder_is_told(self):
        (self.at / "demo/old").symlink_to("gone")
        out = self.json("expiry", "demo", *NOW, exit=3)
        self.assertEqual([d["file"] for d in out["diagnostics"]], ["demo/old"])
        self.assertIn("leads nowhere", out["diagnostics"][0]["message"])

    def test_a_link_to_a_folder_above_ends(self):
        (self.at / "demo/up").symlink_to("..")
        (self.at / "demo/all").symlink_to("/")
        out = self.json("expiry", "demo", *NOW, exit=3)
        self.assertEqual([d["file"] for d in out["diagnostics"]], ["demo/all", "demo/up"])

    def test_quiet_shows_only_what_ends(self):
        self.assertEqual(self.run_program("expiry", "-q", "demo", *NOW).stdout, "")
        told = self.run_program("expiry", "-q", "demo", "--now", "2027-05-01T00:00:00Z", exit=1).stdout
        self.assertEqual(len(told.splitlines()), 1)
        self.assertIn("ends soon revocation list 2027-05-20T00:00:00Z, in 19 days     CN=demo Identity CA  ", told)

    def test_the_time_left_is_in_the_words_of_the_events(self):
        # tests/unit/base/time_left_test.cpp has the words; plugins put them into "ends soon" of 1369, 1370 and 1434.
        for now, state, words in (("2027-11-14T23:00:00Z", "ends soon", "in 6 days"),
                                  ("2027-11-20T00:00:01Z", "ends soon", "in 23 hours"),
                                  ("2027-11-20T23:58:01Z", "ends soon", "in 1 minute"),
                                  ("2027-11-24T01:00:00Z", "ended", "3 days ago"), ("2026-12-01T00:00:00Z", "ok", "in 355 days")):
            line = self.run_program("expiry", "demo/talker/cert.pem", "--now", now, exit=0 if state == "ok" else 1).stdout
            self.assertRegex(line, rf"^{state} +certificate +2027-11-21T00:00:00Z, {words} +CN=talker  demo/talker/cert\.pem\n$")
        for code in ("1369", "1370", "permissions_end_soon"):
            self.assertRegex(self.run_program("explain", code).stdout, "ends? soon")

    def test_without_a_path_this_folder_and_links_count_once(self):
        (self.at / "again").symlink_to("demo")
        (self.at / "cert.pem").symlink_to("demo/talker/cert.pem")
        self.assertEqual(len(self.entries(*NOW)), 7)

    def test_what_cannot_be_read_is_told_and_no_reason_to_stop(self):
        (self.at / "demo/bad.pem").write_text("-----BEGIN CERTIFICATE-----\nxx\n-----END CERTIFICATE-----\n")
        out = self.json("expiry", "demo", *NOW, exit=3)
        self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"]],
                         [("certificate_malformed", "demo/bad.pem")])
        self.assertEqual(len(out["result"]["entries"]), 7)
        self.json("expiry", "demo", "--now", "2028-01-01T00:00:00Z", exit=1)
        with open(self.at / "demo/huge.pem", "wb") as huge:
            huge.truncate(100 * 1024 * 1024)
        out = self.json("expiry", "demo", *NOW, exit=3)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["certificate_malformed", "file_too_large"])

    def test_a_participant_whose_documents_are_not_read_is_an_error(self):
        folder = self.at / "demo/talker"
        certificate, permissions = folder / "cert.pem", folder / "permissions.p7s"
        right, signed = certificate.read_bytes(), permissions.read_bytes()

        def refused(file, *more):
            for words in ((), ("-q",), ("--now", "2027-01-01T00:00:00Z")):
                told = self.json("expiry", "demo/talker", *words, *(() if "--now" in words else NOW), exit=3)["diagnostics"]
                self.assertIn(str(file), {one["file"] for one in told})

        der = subprocess.run(["openssl", "x509", "-outform", "DER"], input=right, capture_output=True, check=True).stdout
        for text in (b"garbage", b"", der, (folder / "key.pem").read_bytes()):
            with self.subTest(text=text[:20]):
                certificate.write_bytes(text)
                refused("demo/talker/cert.pem")
        certificate.unlink()
        refused("demo/talker/cert.pem")
        for make in (lambda: os.mkfifo(certificate), certificate.mkdir, lambda: certificate.symlink_to("/dev/zero"),
                     lambda: certificate.symlink_to(self.at)):
            make()
            refused("demo/talker/cert.pem")
            certificate.rmdir() if certificate.is_dir() and not certificate.is_symlink() else certificate.unlink()
        certificate.write_bytes(right)
        for text in (b"garbage", signed[:200], (folder / "governance.p7s").read_bytes()):
            with self.subTest(text=text[:20]):
                permissions.write_bytes(text)
                refused("demo/talker/permissions.p7s")
        permissions.write_bytes(signed)
        self.entries("demo/talker", *NOW)

    def test_odd_times_and_missing_paths(self):
        for time in ("", "30", "soon", "-1d", "30m", "1000000d"):
            if time != "30":
                self.refused("usage", 2, "expiry", "demo", "--within", time)
        self.refused("file_not_found", 3, "expiry", "nothing")
        (self.at / "empty").mkdir()
        (self.at / "empty/notes.txt").write_text("no certificate")
        told = self.json("expiry", "demo", "empty", "empty/notes.txt", *NOW, exit=3)
        self.assertEqual([(d["id"], d["file"]) for d in told["diagnostics"]],
                         [("file_unreadable", "empty"), ("file_unreadable", "empty/notes.txt")])
        kinds = "a certificate, a revocation list or permissions"
        self.assertIn(f"{kinds} is expected in the folder, and there is none", told["diagnostics"][0]["message"])
        self.assertIn("name the folder of a participant", told["diagnostics"][0]["hint"])
        self.assertNotIn("meant?", told["diagnostics"][0].get("hint", ""))
        self.assertIn(f"expected {kinds}", told["diagnostics"][1]["message"])
        self.assertEqual(len(told["result"]["entries"]), 7)
        self.assertEqual(len(self.entries("demo", "demo", "demo/talker/cert.pem", *NOW)), 7)

    def test_what_ends_at_once_stands_in_the_order_of_the_files(self):
        files = [e["file"] for e in self.entries("demo", *NOW)]
        self.assertEqual(files[1:5], sorted(files[1:5]))
        self.assertEqual(files[5:], sorted(files[5:]))

    def close(self, folder):
        (self.at / folder).chmod(0)
        self.addCleanup((self.at / folder).chmod, 0o700)

    def test_who_may_not_look_is_not_told_that_all_is_well(self):
        self.at.chmod(0o755)
        (self.at / "demo").chmod(0o755)
        out = self.json_as_nobody("expiry", "demo/talker", "demo/listener", *NOW, exit=0)
        self.assertEqual(len(out["result"]["entries"]), 7)  # the keys are closed, and have no end
        self.close("demo/listener")
        out = self.json_as_nobody("expiry", "demo", *NOW, exit=3)
        self.assertIn(("file_unreadable", "demo/listener"), [(d["id"], d["file"]) for d in out["diagnostics"]])
        self.assertIn("CN=talker", [e["subject"] for e in out["result"]["entries"]])
        self.close("demo")
        for path in ("demo", "demo/talker"):
            out = self.json_as_nobody("expiry", path, *NOW, exit=3)
            self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"]], [("file_unreadable", path)])
            self.assertIn("Permission denied", out["diagnostics"][0]["message"])
        for command in (("doctor", "demo/talker"), ("check", "demo/talker", "demo/listener")):
            out = self.json_as_nobody(*command, *NOW, exit=3)
            self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"]],
                             [("file_unreadable", "demo/talker")])


    # The permissions CA is in no file of its own here.
    def test_who_signed_a_document_is_listed_where_no_file_holds_the_certificate(self):
        (self.at / "alone").mkdir()
        for name in ("governance.p7s", "permissions.p7s"):
            (self.at / "alone" / name).write_bytes((self.at / "demo/talker" / name).read_bytes())
        signer = ("CA", "CN=demo Permissions CA", "2036-11-18T00:00:00Z", "alone/governance.p7s", 1)
        rows = [tuple(e[k] for k in ("kind", "subject", "not_after", "file", "places"))
                for e in self.entries("alone/governance.p7s", *NOW)]
        self.assertEqual(rows, [signer])
        (self.at / "alone/governance.p7s").unlink()
        self.assertEqual([(e["kind"], e["file"]) for e in self.entries("alone", *NOW)],
                         [("permissions", "alone/permissions.p7s"), ("CA", "alone/permissions.p7s")])
        self.assertIn("CN=demo Permissions CA", self.run_program("expiry", "-q", "alone", "--within", "4000d", *NOW, exit=1).stdout)

    # Signed as openssl does, by a certificate that the permissions CA issued for it.
    def test_a_signer_that_is_not_the_ca_is_listed(self):
        openssl = lambda *words: subprocess.run(("openssl", *words), cwd=self.at, check=True, capture_output=True)
        openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", "signer.key",
                "-out", "signer.pem", "-subj", "/CN=signing office", "-days", "7", "-addext", "basicConstraints=CA:FALSE")
        (self.at / "plain.xml").write_text("<dds><domain_access_rules/></dds>")
        openssl("smime", "-sign", "-text", "-in", "plain.xml", "-out", "governance.p7s", "-signer", "signer.pem",
                "-inkey", "signer.key")
        (row,) = self.entries("governance.p7s", exit=1)
        self.assertEqual((row["state"], row["kind"], row["subject"]), ("soon", "certificate", "CN=signing office"))
        openssl("smime", "-sign", "-text", "-nocerts", "-in", "plain.xml", "-out", "governance.p7s", "-signer",
                "signer.pem", "-inkey", "signer.key")
        self.refused("file_unreadable", 3, "expiry", "governance.p7s")

    def test_every_label_of_a_certificate_counts(self):
        text = (self.at / "demo/talker/cert.pem").read_text().replace("CERTIFICATE-----", "x")
        (self.at / "other.pem").write_text(text.replace("BEGIN x", "BEGIN X509 CERTIFICATE-----")
                                           .replace("END x", "END X509 CERTIFICATE-----"))
        self.assertEqual([e["subject"] for e in self.entries("other.pem", *NOW)], ["CN=talker"])

    def test_a_link_that_leads_nowhere_and_a_folder_too_deep_are_told(self):
        (self.at / "demo/gone.pem").symlink_to("nothing")
        (self.at / "demo/loop.pem").symlink_to("loop.pem")
        deep = self.at / "demo"
        for _ in range(17):
            deep /= "x"
        deep.mkdir(parents=True)
        out = self.json("expiry", "demo", *NOW, exit=3)
        self.assertEqual(sorted(d["file"] for d in out["diagnostics"]),
                         ["demo/gone.pem", "demo/loop.pem", "demo" + "/x" * 17])
        self.assertEqual(len(out["result"]["entries"]), 7)


if __name__ == "__main__":
    main()

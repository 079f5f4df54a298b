#!/usr/bin/env python3
"""ddssec agent: when it renews a certificate and permissions with the CA beside it."""

import datetime
import json
import pathlib

from agent_folders import AgentTest
from transcript import main


class OwnCa(AgentTest):
    def renew(self, *words, exit=0):
        return self.once("--ca", "demo", *self.LATER, *words, exit=exit)

    def test_renews_at_two_thirds_and_a_little_later(self):
        event, = self.once("--ca", "demo")
        self.assertEqual(event["event"], "current")
        begin, end = self.dates()
        part = (datetime.datetime.fromisoformat(event["next"][:-1]) - begin) / (end - begin)
        self.assertTrue(0.666 < part < 0.718, part)
        self.assertEqual(self.once("--ca", "demo", "--now", "+240d")[0]["event"], "current")
        self.assertEqual(self.renew("--dry-run")[0]["event"], "due")
        self.assertEqual(self.dates(), [begin, end])

    def test_key_and_length_stay_and_the_folder_is_well(self):
        key, old = self.public_key(), self.dates()
        event, = self.renew()
        self.assertEqual((event["event"], event["rekeyed"], event["permissions_extended"]), ("renewed", False, False))
        self.assertEqual([pathlib.Path(file["path"]).name for file in event["files"]], ["cert.pem"])
        self.assertEqual(self.public_key(), key)
        new = self.dates()
        self.assertEqual(new[1] - new[0], old[1] - old[0])
        self.run_program("doctor", "demo/talker", "--now", "+301d")
        self.assertEqual(self.once("--ca", "demo", "--now", "+301d")[0]["event"], "current")
        self.run_program("identity", "renew", "demo/talker", "--ca", "demo", "--now", "+302d")  # the log knows it

    def test_renewed_with_a_warning_of_the_cas_files_has_it_as_problem(self):
        log = self.ca / "issued.jsonl"
        log.write_text("no line\n" + log.read_text())
        event, = self.renew(exit=1)
        self.assertEqual((event["event"], event["problem"]["code"]), ("renewed", "log_line_unreadable"))

    def test_days_of_the_command_line(self):
        self.renew("--days", "500")
        self.assertAlmostEqual((self.dates()[1] - datetime.datetime.now()).days, 800, delta=2)

    def test_days_that_end_before_the_certificate_in_place_are_said_to_go_back(self):
        event = self.refused("renewal_goes_back", "--ca", "demo", "--days", "5", *self.LATER)
        self.assertIn("identity renew FOLDER --days N", event["hint"])
        self.assertNotIn("ca renew", event["hint"])
        self.assertEqual(self.once("--ca", "demo", "--days", "5", "--now", "+362d")[0]["event"], "renewed")

    def test_from_a_year_to_days_by_identity_renew_goes_on_in_days(self):
        self.run_program("identity", "renew", "demo/talker", "--ca", "demo", "--days", "5")
        self.assertEqual(self.once("--ca", "demo")[0]["event"], "current")
        event, = self.once("--ca", "demo", "--now", "+4d")
        self.assertEqual((event["event"], event["restart_needed"]), ("renewed", False))
        self.assertAlmostEqual((self.dates()[1] - datetime.datetime.now()).days, 9, delta=1)

    def test_renewed_after_the_end_says_that_a_restart_is_needed(self):
        event, = self.once("--ca", "demo", "--now", "+366d")
        self.assertEqual((event["event"], event["restart_needed"]), ("renewed", True))

    def test_missing_certificate_is_said_in_the_words_of_the_command(self):
        (self.talker / "cert.pem").unlink()
        event = self.refused("file_not_found", "--ca", "demo", exit=3)
        self.assertIn("no certificate to renew", event["message"])
        self.assertEqual(event["file"], "demo/talker/cert.pem")
        self.assertIn("ddssec identity issue", event["hint"])
        self.assertNotIn("/proc/", json.dumps(event))

    def test_permissions_are_extended_with_it(self):
        event, = self.renew("--permissions")
        self.assertTrue(event["permissions_extended"])
        self.run_program("doctor", "demo/talker", "--now", "+600d")

    def test_permissions_that_end_first_are_extended_in_time(self):
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "100", "--sign",
                         "--ca", "demo", "-o", "demo/talker/permissions.xml", "--replace")
        self.assertEqual(self.once("--ca", "demo", "--now", "+20d")[0]["event"], "current")
        event, = self.once("--ca", "demo", "--permissions", "--now", "+20d")
        self.assertTrue(event["permissions_extended"])
        self.assertEqual(self.once("--ca", "demo", "--permissions", "--now", "+21d")[0]["event"], "current")

    def test_permissions_that_were_replaced_do_not_live_on(self):
        """The owner of a folder puts back a document that gives more."""
        wide = (self.talker / "permissions.p7s").read_bytes()
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--sign", "--ca", "demo",
                         "-o", "demo/talker/permissions.xml", "--replace")
        (self.talker / "permissions.p7s").write_bytes(wide)
        event, = self.renew("--permissions", exit=1)
        self.assertFalse(event["permissions_extended"])
        self.assertIn(event["problem"]["code"], ("document_superseded", "document_unlogged"))

    def test_permissions_that_are_due_alone_and_cannot_be_extended_cost_no_certificate(self):
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "100", "-o",
                         "alone.xml")
        ca = self.at / "demo/ca/permissions"
        self.openssl("smime", "-sign", "-text", "-signer", ca / "ca.pem", "-inkey", ca / "ca.key.pem", "-in", "alone.xml",
                     "-out", self.talker / "permissions.p7s")
        before = (self.ca / "issued.jsonl").read_text()
        self.refused("document_unlogged", "--ca", "demo", "--permissions", "--now", "+20d")
        self.assertEqual((self.ca / "issued.jsonl").read_text(), before)
        event, = self.renew("--permissions", exit=1)  # the certificate is due, too
        self.assertEqual((event["event"], event["problem"]["code"]), ("renewed", "document_unlogged"))

    def test_rights_that_have_ended_are_not_given_again(self):
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "100", "--sign",
                         "--ca", "demo", "-o", "demo/talker/permissions.xml", "--replace")
        event, = self.renew("--permissions", exit=1)
        self.assertEqual((event["event"], event["permissions_extended"]), ("renewed", False))
        self.assertEqual(event["problem"]["code"], "grant_expired")
        event, = self.once("--ca", "demo", "--permissions", "--now", "+301d", exit=1)
        self.assertEqual((event["event"], event["problem"]["code"]), ("current", "grant_expired"))

    def test_rights_that_have_ended_are_not_given_again_by_a_clock_that_was_set_back(self):
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "100", "--sign",
                         "--ca", "demo", "-o", "demo/talker/permissions.xml", "--replace")
        self.run_program("identity", "renew", "demo/listener", "--ca", "demo", "--now", "+101d")  # a line of the log
        event, = self.once("--ca", "demo", "--permissions", "--now", "+99d", exit=1)
        self.assertEqual((event["event"], event["code"]), ("failed", "grant_expired"))
        self.assertRegex(event["message"], "before .*Z, the latest time in the CA's log demo/ca/identity/issued.jsonl, and")
        self.assertIn("set the clock; if it is right, ", event["hint"])
        self.run_program("identity", "renew", "demo/talker", "--ca", "demo", "--permissions", "--ended-permissions", "--now",
                         "+99d")
        self.assertEqual(self.once("--ca", "demo", "--permissions", "--now", "+99d")[0]["event"], "current")

    def test_current_with_permissions_that_have_ended_has_a_problem(self):
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "2", "--sign",
                         "--ca", "demo", "-o", "demo/talker/permissions.xml", "--replace")
        for more in ((), ("--dry-run",)):
            event, = self.once("--ca", "demo", "--permissions", "--now", "+5d", *more, exit=1)
            self.assertEqual((event["event"], event["problem"]["code"]), ("current", "grant_expired"))
            self.assertIn("ddssec identity renew demo/talker --ca CA --permissions --ended-permissions",
                          event["problem"]["hint"])
        self.assertNotIn("problem", self.once("--ca", "demo", "--now", "+5d")[0])  # the permissions are not the agent's

    def test_current_with_files_that_do_not_fit_has_a_problem(self):
        for file, code in (("key.pem", "key_mismatch"), ("permissions.p7s", "no_grant_for_subject")):
            right = (self.talker / file).read_bytes()
            (self.talker / file).write_bytes((self.at / "demo/listener" / file).read_bytes())
            event, = self.once("--ca", "demo", "--permissions", exit=1)
            self.assertEqual((event["event"], event["problem"]["code"]), ("current", code))
            (self.talker / file).write_bytes(right)
        (self.talker / "identity_ca.pem").write_bytes((self.talker / "permissions_ca.pem").read_bytes())
        event, = self.once("--ca", "demo", exit=1)
        self.assertEqual((event["event"], event["problem"]["code"]), ("current", "issuer_unknown"))
        self.assertNotIn("answered", event["problem"]["message"])

    def test_current_with_a_list_that_ends_has_a_problem(self):
        """A participant with an expired list authenticates no peer."""
        self.run_program("identity", "revoke", "demo/listener", "--ca", "demo")
        (self.talker / "crl.pem").write_bytes((self.ca / "crl.pem").read_bytes())
        self.assertNotIn("problem", self.once("--ca", "demo", "--now", "+100d")[0])
        for now, code in (("+160d", "crl_ends_soon"), ("+200d", "crl_expired")):
            event, = self.once("--ca", "demo", "--now", now, exit=0 if code == "crl_ends_soon" else (1, 3))
            self.assertEqual((event["event"], event["problem"]["code"]), ("current", code))
            self.assertEqual(event["problem"]["file"], "demo/talker/crl.pem")
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "2", "--sign",
                         "--ca", "demo", "-o", "demo/talker/permissions.xml", "--replace")
        event, = self.once("--ca", "demo", "--permissions", "--now", "+160d", exit=1)
        self.assertEqual(event["problem"]["code"], "grant_expired")  # the warning does not hide it
        self.assertEqual(self.once("--ca", "demo", *self.LATER)[0]["event"], "renewed")

    def test_a_new_key_on_request(self):
        key = self.public_key()
        event, = self.renew("--rekey")
        self.assertTrue(event["rekeyed"])
        self.assertNotEqual(self.public_key(), key)
        self.assertEqual(self.public_key(), self.openssl("pkey", "-in", self.talker / "key.pem", "-pubout"))
        self.run_program("doctor", "demo/talker", "--now", "+301d")

    def test_modes_stay(self):
        (self.talker / "key.pem").chmod(0o640)
        (self.talker / "cert.pem").chmod(0o640)
        self.renew("--rekey")
        self.assertEqual({name: (self.talker / name).stat().st_mode & 0o777 for name in ("key.pem", "cert.pem")},
                         {"key.pem": 0o640, "cert.pem": 0o640})

    def test_no_revoked_participant(self):
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo")
        self.refused("certificate_revoked", "--ca", "demo", *self.LATER)

    def test_no_certificate_of_another_folder(self):
        (self.talker / "cert.pem").write_bytes((self.at / "demo/listener/cert.pem").read_bytes())
        (self.talker / "key.pem").write_bytes((self.at / "demo/listener/key.pem").read_bytes())
        self.refused("certificate_of_another_folder", "--ca", "demo", *self.LATER)

    def test_no_key_that_does_not_belong_to_it(self):
        (self.talker / "key.pem").write_bytes((self.at / "demo/listener/key.pem").read_bytes())
        self.refused("key_mismatch", "--ca", "demo", *self.LATER)

    def test_a_ca_that_ends_first(self):
        self.run_program("identity", "issue", "talker", "--ca", "demo", "-o", "demo/talker", "--replace", "--clamp", "--days",
                         "20000", "--publish", "x")
        self.refused("outlives_ca", "--ca", "demo", "--now", "+3000d", exit=4)

    def test_permissions_that_end_before_a_certificate_without_a_later_end_are_extended_alone(self):
        self.run_program("identity", "issue", "talker", "--ca", "demo", "-o", "demo/talker", "--replace", "--clamp", "--days",
                         "20000", "--publish", "x")
        certificate, key = ((self.talker / name).read_bytes() for name in ("cert.pem", "key.pem"))
        for words in ((), ("--rekey",)):
            self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "100", "--sign",
                             "--ca", "demo", "-o", "demo/talker/permissions.xml", "--replace")
            event, = self.once("--ca", "demo", "--permissions", *words, "--now", "+20d")
            self.assertEqual((event["event"], event["permissions_extended"], event["rekeyed"]), ("renewed", True, False))
            self.assertEqual({pathlib.Path(file["path"]).name for file in event["files"]}, {"permissions.xml", "permissions.p7s"})
            self.assertEqual((self.talker / "cert.pem").read_bytes(), certificate)
            self.assertEqual((self.talker / "key.pem").read_bytes(), key)
            self.run_program("doctor", "demo/talker", "--now", "+3000d")
            self.assertEqual(self.once("--ca", "demo", "--permissions", *words, "--now", "+21d")[0]["event"], "current")
        self.refused("outlives_ca", "--ca", "demo", "--permissions", "--now", "+3000d", exit=4)

    def test_several_folders_and_json(self):
        (self.at / "demo/listener").chmod(0o777)
        told = self.json("agent", "demo/listener", "demo/talker", "--ca", "demo", "--once", *self.LATER, exit=4)
        self.assertEqual([event["event"] for event in told["result"]["events"]], ["failed", "renewed"])
        self.assertEqual([d["id"] for d in told["diagnostics"]], ["folder_untrusted"])
        self.assertEqual([pathlib.Path(file["path"]).name for file in told["files_written"]], ["cert.pem"])

    def test_options_that_do_not_fit(self):
        for words in ((), ("--ca", "demo", "--hook", "/bin/true"), ("--hook", "/bin/true", "--permissions"),
                      ("--hook", "/bin/true", "--days", "3"), ("--ca", "demo", "--hook-env", "HOME"), ("--ca", "demo", "--trust", "x"),
                      ("--ca", "demo", "--now", "+1d"), ("--ca", "demo", "--dry-run"),
                      ("--ca", "demo", "--format", "json")):
            done = self.run_program("agent", "demo/talker", *words, exit=2)
            self.assertIn("usage", done.stderr + done.stdout)


if __name__ == "__main__":
    main()

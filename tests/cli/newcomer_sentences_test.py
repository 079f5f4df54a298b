#!/usr/bin/env python3
"""Sentences that were written for newcomers: what they say, and that what they advise works."""

from transcript import Transcript, main

MADE = ("--now", "2026-11-20T00:00:00Z")
SOON_AFTER = ("--now", "2026-11-20T00:00:01Z")
LATE = ("--now", "2028-01-01T00:00:00Z")
RENEWAL = ("--permissions", "--ended-permissions")


class Expired(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *MADE)

    def check(self, *words, exit=0):
        return self.json("check", "demo/talker", "demo/listener", *words, exit=exit)

    def findings(self, rule):
        return [d for d in self.check(*LATE, exit=1)["diagnostics"] if d["id"] == rule]

    def test_check_points_at_the_certificate_that_expired_and_names_the_whole_command(self):
        told = self.findings("DOC080")
        self.assertEqual([d["file"] for d in told], ["demo/talker/cert.pem", "demo/listener/cert.pem"])
        for finding, name in zip(told, ("talker", "listener")):
            self.assertRegex(finding["message"], f"does not accept {name}'s certificate \\(CN={name} serial .*has expired")
            self.assertIn("ddssec identity renew FOLDER --ca CA, with --permissions --ended-permissions if the permissions "
                          "have expired too", finding["hint"])

    def test_check_says_how_expired_permissions_come_back(self):
        told = self.findings("DOC081")
        self.assertEqual(len(told), 2)
        for finding in told:
            self.assertIn("ddssec identity renew FOLDER --ca CA --permissions --ended-permissions", finding["hint"])

    def test_what_the_hint_names_is_enough(self):
        for name in ("talker", "listener"):
            self.run_program("identity", "renew", f"demo/{name}", "--ca", "demo", *RENEWAL, *LATE)
        self.check(*LATE)

    def test_check_says_who_sends_the_first_message_and_that_the_handshake_fails(self):
        line = "handshake        talker sends the first message"
        lines = self.run_program("check", "demo/talker", "demo/listener", *MADE).stdout.splitlines()
        self.assertIn(line, lines)
        lines = self.run_program("check", "demo/talker", "demo/listener", *LATE, exit=1).stdout.splitlines()
        self.assertIn(f"{line}; the handshake fails (authentication: NO)", lines)

    def test_renew_says_what_differs_between_two_ends_on_one_day(self):
        told = self.run_program("identity", "renew", "demo/talker", "--ca", "demo", *SOON_AFTER).stdout
        self.assertIn("permissions end before it, on 2027-11-20T00:00:00Z, and the certificate on 2027-11-20T00:00:01Z\n"
                      "  --permissions extends them as well\n", told)

    def test_renew_says_the_day_alone_where_the_days_differ(self):
        told = self.run_program("identity", "renew", "demo/listener", "--ca", "demo", "--now", "2026-12-01T00:00:00Z").stdout
        self.assertIn("permissions end before it, on 2027-11-20\n", told)


class OfDdsperf(Transcript):
    def test_explain_knows_how_ddsperf_fails(self):
        told = self.run_program("explain", "[1234] 5.000  failed to match in 5.000s").stdout
        self.assertIn('the line "new" before it comes before security', " ".join(told.split()))


class Rotated(Transcript):
    def test_rotate_says_that_a_ca_of_the_same_name_has_a_new_key_and_that_copies_need_the_files(self):
        self.run_program("keystore", "create", "keystore", "--no-passphrase", *MADE)
        self.run_program("keystore", "enclave", "keystore", "/talker", "--allow-all", *MADE)
        for role in ("identity", "permissions"):
            told = self.run_program("keystore", "rotate", "keystore", "--role", role, *MADE).stdout
            self.assertRegex(told, f"{role} CA is CN=.* now, with a new key; .* signed again\n")
            self.assertIn("Copies of enclaves on other machines need the new files, too. Every participant must start "
                          "again with them, unless it runs on ddssec's plugins", told)


if __name__ == "__main__":
    main()

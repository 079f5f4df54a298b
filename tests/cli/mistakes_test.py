#!/usr/bin/env python3
"""Mistakes that a new user makes: a wrong folder, a wrong word, a wrong CA. Each answer names what was meant."""

import pathlib
import shlex
import shutil

from transcript import NOW, Transcript, main

SIGNED = ("--governance", "demo/governance.p7s")


class Mistakes(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "-q", *NOW)

    def answer(self, code, exit, *words, **more):
        """Message and hint in one."""
        before = self.files()
        told = self.refused(code, exit, *words, *NOW, **more)
        self.assertEqual(self.files(), before, "something was written")
        return f"{told['message']} | {told['hint']}"

    def test_a_participant_that_is_elsewhere_is_named(self):
        for words in (("doctor", "talker"), ("check", "demo/listener", "talker"), ("can", "talker", "publish", "x"),
                      ("identity", "show", "talker"), ("permissions", "new", "--cert", "talker", "-o", "p.xml"),
                      ("identity", "renew", "talker", "--ca", "demo"), ("crl", "distribute", "talker", "--ca", "demo")):
            self.assertIn("participants here: demo/talker, demo/listener",
                          self.answer("file_not_found", 3, *words), words)
        self.assertIn("participants here: demo/listener, demo/talker",
                      self.answer("file_not_found", 3, "doctor", "demo/taker"))

    def test_a_folder_of_another_kind_is_named(self):
        for words in (("doctor", "demo"), ("can", "demo", "publish", "x"), ("identity", "show", "demo")):
            told = self.answer("file_not_found", 3, *words)
            self.assertIn("demo is no participant's folder | it holds participants: demo/listener, demo/talker", told)
        told = self.answer("file_not_found", 3, "doctor", "demo/ca")
        self.assertIn("demo/ca is the folder of a CA | participants of it may be demo/listener, demo/talker", told)
        self.assertIn("it holds a private key | name the certificate, cert.pem beside it",
                      self.answer("certificate_malformed", 3, "identity", "show", "demo/talker/key.pem"))

    def test_a_ca_that_is_elsewhere_is_named(self):
        issue = ("identity", "issue", "x", "-o", "x", "--ca")
        self.assertIn("CAs here: demo", self.answer("file_not_found", 3, *issue, "ca"))
        self.assertIn("it is a participant's folder | the CA may be demo",
                      self.answer("file_not_found", 3, *issue, "demo/talker"))
        self.assertIn("name the folder: demo/ca/identity",
                      self.answer("file_unreadable", 3, *issue, "demo/ca/identity/ca.pem"))
        for words in (("ca", "show"), ("ca", "renew"), ("crl", "new", "--ca"), ("crl", "distribute", "--ca")):
            self.assertIn("the CA may be demo", self.answer("file_not_found", 3, *words, "demo/talker"), words)

    def test_the_other_one_of_two_cas_signs_nothing(self):
        self.run_program("governance", "new", "-o", "g.xml")
        for words, wrong, right in (
                (("identity", "issue", "x", "-o", "x"), "permissions", "identity"),
                (("identity", "renew", "demo/talker"), "permissions", "identity"),
                (("identity", "revoke", "demo/talker"), "permissions", "identity"),
                (("identity", "issue", "x", "-o", "x", *SIGNED), "identity", "permissions"),
                (("identity", "issue", "x", "-o", "x", "--publish", "a"), "identity", "permissions"),
                (("governance", "sign", "g.xml"), "identity", "permissions")):
            told = self.answer("usage", 2, *words, "--ca", f"demo/ca/{wrong}/")
            self.assertIn(f"expected the folder of the {right} CA, demo/ca/{right}, or of both, demo/ca", told)
        self.run_program("governance", "sign", "g.xml", "--ca", "demo/ca/permissions", *NOW)
        self.run_program("identity", "issue", "y", "-o", "y", "--ca", "demo/ca/identity", *NOW)
        # A single CA for both may be called as it likes.
        shutil.copytree(self.at / "demo/ca/permissions", self.at / "permissions")
        self.run_program("identity", "issue", "z", "-o", "z", "--ca", "permissions", "--publish", "a", *NOW)

    def test_a_participant_is_not_put_among_others(self):
        for more in ((), ("--replace",)):
            told = self.answer("would_overwrite", 4, "identity", "issue", "x", "--ca", "demo", "-o", "demo", *more)
            self.assertIn("it holds participants: demo/listener, demo/talker | -o demo/x makes", told)
            told = self.answer("would_overwrite", 4, "identity", "issue", "x", "--ca", "demo", "-o", "demo/ca", *more)
            self.assertIn("it is the folder of a CA | -o demo/ca/x makes", told)

    def test_revoking_by_name_proposes_what_the_log_knows(self):
        told = self.answer("file_not_found", 3, "identity", "revoke", "talker", "--ca", "demo")
        self.assertIn(f"ddssec identity revoke {self.at}/demo/talker --ca demo", told)
        shutil.rmtree(self.at / "demo/talker")
        told = self.answer("file_not_found", 3, "identity", "revoke", "CN=talker", "--ca", "demo")
        self.assertRegex(told, r"ddssec identity revoke [0-9A-F]{32} --ca demo$")
        self.run_program(*told.split("ddssec ")[1].split(), *NOW)
        told = self.answer("file_not_found", 3, "identity", "revoke", "nobody", "--ca", "demo")
        self.assertIn("participants here: demo/listener", told)
        told = self.answer("issuer_unknown", 1, "identity", "revoke", "demo/listener", "--ca", self.other_ca())
        self.assertIn("name the folder of the CA that issued it", told)

    def other_ca(self):
        self.run_program("ca", "create", "other", "--no-passphrase", *NOW)
        return "other"

    def test_a_document_of_the_other_kind(self):
        self.assertIn("it is a permissions document: ddssec permissions --help",
                      self.answer("document_kind", 3, "governance", "lint", "demo/talker/permissions.p7s"))
        self.assertIn("it is a governance document: ddssec governance --help",
                      self.answer("document_kind", 3, "permissions", "diff", "demo/governance.p7s", "demo/governance.p7s"))
        self.run_program("identity", "issue", "x", "--ca", "demo", "-o", "x", "--publish", "a", "--governance",
                         "demo/talker", *NOW)

    def test_arguments_that_are_not_right(self):
        for words, told in (
                (("doctor", "demo/talker", "demo/listener"), "ddssec check compares two participants"),
                (("governance", "show", "demo", "rt/x"), "--topic names a topic"),
                (("governance", "new", "-o", "g.xml", "--topic", "rt/x=ENCRYPT"),
                 "expected a colon behind the expression, such as rt/camera*:data=ENCRYPT"),
                (("can", "demo/talker", "publish", "x", "--partition"), 'no value follows "--partition"'),
                (("permissions", "new", "--subject", "CN=x", "-o", "p.xml"), 'did you mean "--cert"?')):
            before = self.files()
            done = self.run_program(*words, exit=2)
            self.assertIn(told, done.stderr, words)
            self.assertEqual(self.files(), before)
        self.run_program("governance", "new", "-o", "g.xml", "--topic", "rt/[[=a=]]:data=NONE")
        told = self.answer("passphrase_unusable", 4, "ca", "create", "c", "--passphrase-env", "DDSSEC_NO_SUCH_NAME")
        self.assertIn("the environment variable DDSSEC_NO_SUCH_NAME is not set", told)

    def test_a_wrong_command_line_is_told_what_is_wrong_with_it(self):
        for words, told in (
                (("frobnicate",), '"frobnicate" is unknown here'),
                ((), "no command is given"),
                (("init",), "missing argument DIR; for example: ddssec init demo"),
                (("init", "x", "--layout", "round"), "--layout: expected flat or sros2, found round"),
                (("ca", "create", "x", "--subject", "CN=x"), "--subject: two CAs need two names"),
                (("permissions", "new", "--cert", "demo/talker", "-o", "p.xml", "--partition", "a"),
                 "--partition: it needs --publish or --subscribe"),
                (("identity", "issue", "x", "--ca", "demo", "-o", "x", "--days", "soon"), "--days: expected a number from 1 to 36500, found")):
            done = self.run_program(*words, exit=2)
            self.assertTrue(done.stderr.startswith(f"error[usage]: {told}"), done.stderr)

    def test_times_may_be_dates_and_distances(self):
        shown = self.run_program("doctor", "demo/talker", "--now", "2031-02-03", exit=1).stderr
        self.assertIn("now it is 2031-02-03T00:00:00Z", shown)
        self.run_program("doctor", "demo/talker", "--now", "+4000d", exit=1)
        for early in (("--now", "-4000d"), ("--now=-4000d",)):
            self.assertIn("notBefore is", self.run_program("doctor", "demo/talker", *early, exit=1).stderr)
        self.run_program("permissions", "new", "--cert", "demo/talker", "-o", "p.xml", "--publish", "a", "--not-after",
                         "2027-01-01", *NOW)
        self.assertIn("<not_after>2027-01-01T00:00:00Z<", (self.at / "p.xml").read_text())
        for wrong in ("tomorrow", "+4000y", "2031-02-30", "31-02-03", "+", "-", "-2y"):
            self.assertIn("+30d or -2d", self.run_program("doctor", "demo/talker", "--now", wrong, exit=2).stderr)

    def test_topics_that_are_probably_meant_otherwise(self):
        issued = self.run_program("identity", "issue", "x", "--ca", "demo", "-o", "x", "--publish", "/chatter",
                                  "--subscribe", "[z-a]", *NOW)
        self.assertIn('note[PERM034]: "/chatter" begins with a slash', issued.stderr)
        self.assertIn('warning[PERM012]: to subscribe "[z-a]" can never apply', issued.stderr)
        self.run_program("keystore", "create", "ks", "--no-passphrase", *NOW)
        made = self.run_program("keystore", "enclave", "ks", "/talker", "--publish", "chatter", *NOW)
        self.assertIn("ROS 2 topic /chatter is rt/chatter in DDS", made.stderr)
        made = self.run_program("keystore", "permission", "ks", "/talker", "--publish", "rt/chatter", *NOW)
        self.assertNotIn("PERM034", made.stderr)
        made = self.run_program("permissions", "new", "--cert", "demo/talker", "-o", "p.xml", *NOW)
        self.assertIn("it lets the participant join and use no topic", made.stdout)
        told = self.answer("keystore_incomplete", 3, "keystore", "list", "ks/enclaves/talker")
        self.assertIn("name the keystore: ks", told)
        self.assertIn("expected a keystore", self.answer("file_not_found", 3, "keystore", "list", "keystore"))

    def test_a_folder_that_is_missing_is_named_with_the_way_to_make_it(self):
        (self.at / "plain").write_text("")
        sign = ("governance", "sign", "demo/governance.xml", "--ca", "demo")
        for words in (("init", "x/y/z"), ("init", "x/y/z", "--dry-run"), ("ca", "create", "x/y/ca", "--no-passphrase"),
                      ("identity", "issue", "b", "--ca", "demo", "-o", "x/y/b"), ("governance", "new", "-o", "x/y/g.xml"),
                      (*sign, "-o", "x/y/g.p7s"), ("keystore", "create", "x/y/ks", "--no-passphrase"),
                      ("permissions", "new", "--cert", "demo/talker", "-o", "x/y/p.xml", "--publish", "a"),
                      ("identity", "csr", "b", "-o", "x/y/b")):
            self.assertIn("the folder x/y does not exist | make it first: mkdir -p x/y; or choose another place",
                          self.answer("file_unwritable", 5, *words), words)
        for words in (("init", "plain/z"), ("governance", "new", "-o", "plain/g.xml"), ("init", "plain/z", "--dry-run")):
            self.assertIn("plain is not a folder | choose a place in a folder",
                          self.answer("file_unwritable", 5, *words), words)

    def test_an_enclave_that_is_missing_is_told_with_what_may_be_meant(self):
        self.run_program("init", "ks", "--layout", "sros2", *NOW)
        give = ("keystore", "permission", "ks")
        self.assertIn("the keystore has no such enclave | is /talker meant?",
                      self.answer("file_not_found", 3, *give, "/talkr", "--allow-all"))
        self.assertIn("the keystore has no such enclave | ddssec keystore list ks lists them",
                      self.answer("file_not_found", 3, *give, "/elsewhere", "--allow-all"))

    def test_a_file_that_is_missing_is_told_with_what_may_be_meant(self):
        for words in (("governance", "lint"), ("governance", "show"), ("permissions", "lint"), ("governance", "sign", "--ca", "demo"),
                      ("permissions", "sign", "--ca", "demo"), ("identity", "sign-csr", "--ca", "demo", "-o", "x.pem")):
            self.assertIn("the folder dem does not exist", self.answer("file_not_found", 3, *words, "dem/g.xml"), words)
            self.assertIn("is demo/governance.xml meant?",
                          self.answer("file_not_found", 3, *words, "demo/govrnance.xml"), words)
            self.assertTrue(self.answer("file_not_found", 3, *words, "demo/elsewhere.txt").endswith("| check the path"))

    def test_looking_around_is_bounded_and_follows_no_link(self):
        many = self.at / "many"
        for i in range(3000):
            (many / str(i)).mkdir(parents=True)
        self.assertIn("check the path", self.answer("file_not_found", 3, "doctor", "many/x"))
        (self.at / "loop").mkdir()
        (self.at / "loop/again").symlink_to(pathlib.Path(".."))
        self.assertNotIn("again", self.answer("file_not_found", 3, "doctor", "loop/x"))


class Proposals(Transcript):
    def test_a_link_that_leads_nowhere_is_not_proposed_for_itself(self):
        (self.at / "link.xml").symlink_to("nowhere.xml")
        for words in (("permissions", "show"), ("governance", "show"), ("expiry",), ("crl", "show")):
            told = self.refused("file_not_found", 3, *words, "link.xml")
            self.assertEqual(told["hint"], "check the path: it is a link to nowhere.xml, which does not exist")

    def test_a_participant_that_is_not_here_is_revoked_as_the_hint_says(self):
        self.run_program("keystore", "create", "a ks", "--no-passphrase", *NOW)
        self.run_program("keystore", "enclave", "a ks", "/a", "--allow-all", *NOW)
        shutil.move(self.at / "a ks/enclaves/a", self.at / "gone")
        for what in ("a ks/enclaves/a", "a ks/enclaves/a/", "/a", "CN=/a"):
            told = self.refused("file_not_found", 3, "identity", "revoke", what, "--ca", "a ks", *NOW)
            words = shlex.split(told["hint"].removeprefix("the CA's log has it: ddssec "))
            self.assertIn("a ks/public/identity_ca.crl.pem", self.run_program(*words, "--dry-run", *NOW).stdout)
        self.assertIn("revoked (1 certificate)", self.run_program(*words, *NOW).stdout)

    def test_a_file_of_another_kind_is_not_said_to_be_missing(self):
        (self.at / "file").write_text("text")
        self.assertIn("found another file", self.refused("file_unreadable", 3, "expiry", "file")["message"])


if __name__ == "__main__":
    main()

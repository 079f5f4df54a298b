#!/usr/bin/env python3
"""ddssec agent: when it renews, from where, what it checks and whose files it touches."""

import datetime
import fcntl
import json
import os
import pathlib
import signal
import time
import unittest

from agent_folders import SIGN, AgentTest, Running, ShortLived
from transcript import main

NEEDS_ROOT = unittest.skipUnless(os.geteuid() == 0, "only root can make files of another user")
OTHER = 65534
ROOT = 0


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

    def test_days_of_the_command_line(self):
        self.renew("--days", "500")
        self.assertAlmostEqual((self.dates()[1] - datetime.datetime.now()).days, 800, delta=2)

    def test_Days_ThatEndBeforeTheCertificateInPlace_AreSaidToGoBack(self):
        event = self.refused("renewal_goes_back", "--ca", "demo", "--days", "5", *self.LATER)
        self.assertIn("identity renew FOLDER --days N", event["hint"])
        self.assertNotIn("ca renew", event["hint"])
        self.assertEqual(self.once("--ca", "demo", "--days", "5", "--now", "+362d")[0]["event"], "renewed")

    def test_FromAYearToDays_ByIdentityRenew_GoesOnInDays(self):
        self.run_program("identity", "renew", "demo/talker", "--ca", "demo", "--days", "5")
        self.assertEqual(self.once("--ca", "demo")[0]["event"], "current")
        event, = self.once("--ca", "demo", "--now", "+4d")
        self.assertEqual((event["event"], event["restart_needed"]), ("renewed", False))
        self.assertAlmostEqual((self.dates()[1] - datetime.datetime.now()).days, 9, delta=1)

    def test_Renewed_AfterTheEnd_SaysThatARestartIsNeeded(self):
        event, = self.once("--ca", "demo", "--now", "+366d")
        self.assertEqual((event["event"], event["restart_needed"]), ("renewed", True))

    def test_MissingCertificate_IsSaidInTheWordsOfTheCommand(self):
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

    def test_rights_that_have_ended_are_not_given_again(self):
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "100", "--sign",
                         "--ca", "demo", "-o", "demo/talker/permissions.xml", "--replace")
        event, = self.renew("--permissions", exit=1)
        self.assertEqual((event["event"], event["permissions_extended"]), ("renewed", False))
        self.assertEqual(event["problem"]["code"], "grant_expired")
        event, = self.once("--ca", "demo", "--permissions", "--now", "+301d", exit=1)
        self.assertEqual((event["event"], event["problem"]["code"]), ("current", "grant_expired"))

    def test_Current_WithPermissionsThatHaveEnded_HasAProblem(self):
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "2", "--sign",
                         "--ca", "demo", "-o", "demo/talker/permissions.xml", "--replace")
        for more in ((), ("--dry-run",)):
            event, = self.once("--ca", "demo", "--permissions", "--now", "+5d", *more, exit=1)
            self.assertEqual((event["event"], event["problem"]["code"]), ("current", "grant_expired"))
            self.assertIn("ddssec identity renew demo/talker --ca CA --permissions --ended-permissions",
                          event["problem"]["hint"])
        self.assertNotIn("problem", self.once("--ca", "demo", "--now", "+5d")[0])  # the permissions are not the agent's

    def test_Current_WithFilesThatDoNotFit_HasAProblem(self):
        for file, code in (("key.pem", "key_mismatch"), ("permissions.p7s", "no_grant_for_subject")):
            right = (self.talker / file).read_bytes()
            (self.talker / file).write_bytes((self.at / "demo/listener" / file).read_bytes())
            event, = self.once("--ca", "demo", "--permissions", exit=1)
            self.assertEqual((event["event"], event["problem"]["code"]), ("current", code))
            (self.talker / file).write_bytes(right)
        (self.talker / "identity_ca.pem").write_bytes((self.talker / "permissions_ca.pem").read_bytes())
        event, = self.once("--ca", "demo", exit=1)
        self.assertEqual((event["event"], event["problem"]["code"]), ("current", "issuer_unknown"))

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


class Hooks(AgentTest):
    def test_a_hook_signs_the_request(self):
        key = self.public_key()
        event, = self.once("--hook", self.signing_hook(), *self.LATER)
        self.assertEqual(event["event"], "renewed")
        self.assertEqual(self.public_key(), key)
        self.run_program("doctor", "demo/talker", "--now", "+301d")

    def test_its_answer_may_have_a_chain(self):
        self.once("--hook", self.hook(SIGN.format(ca=self.ca) + f" -days 400\ncat {self.ca}/ca.pem"), *self.LATER)
        self.assertEqual((self.talker / "cert.pem").read_text().count("BEGIN"), 1)

    def test_a_new_key_for_a_hook(self):
        key = self.public_key()
        self.once("--hook", self.signing_hook(), "--rekey", *self.LATER)
        self.assertNotEqual(self.public_key(), key)
        self.run_program("doctor", "demo/talker", "--now", "+301d")

    def test_it_gets_words_and_few_variables(self):
        hook = self.signing_hook(before=f'env >{self.at}/env; echo "$@" >{self.at}/words; pwd >{self.at}/pwd; '
                                 f'ls /proc/self/fd >{self.at}/fds')
        self.once("--hook", hook + " plant  7", "--hook-env", "COLOUR", *self.LATER,
                  environment={"COLOUR": "blue green", "SECRET": "x"})
        names = {line.split("=")[0] for line in (self.at / "env").read_text().splitlines()}
        self.assertEqual(names - {"PWD", "_", "SHLVL", "OLDPWD"},
                         {"PATH", "LC_ALL", "DDSSEC_FOLDER", "DDSSEC_SUBJECT", "COLOUR"})
        self.assertIn("COLOUR=blue green\n", (self.at / "env").read_text())
        self.assertEqual(((self.at / "words").read_text(), (self.at / "pwd").read_text()), ("plant 7\n", "/\n"))
        self.assertLessEqual(len((self.at / "fds").read_text().split()), 4)  # and the one that ls opens

    def test_no_shell_reads_it(self):
        for hook in ("true", "/bin/sh -c 'x'", "/bin/echo $HOME", "/bin/a;/bin/b", "/bin/a|b", ""):
            done = self.run_program("agent", "demo/talker", "--once", "--hook=" + hook, exit=2)
            self.assertEqual(done.stdout, "")

    def test_a_program_that_others_can_change(self):
        self.refused("hook_unsafe", "--hook", self.hook("true", 0o777), *self.LATER, exit=4)

    def test_one_that_fails(self):
        event = self.refused("hook_failed", "--hook", self.hook("echo secret; exit 3"), *self.LATER)
        self.assertIn("exit code 3", event["message"])
        self.assertNotIn("secret", str(event))
        self.refused("hook_failed", "--hook", "/no/such/program", *self.LATER)
        self.refused("hook_failed", "--hook", self.hook("kill -9 $$"), *self.LATER)

    def test_one_that_hangs_is_ended_with_all_that_it_started(self):
        hook = self.hook(f"sleep 300 & echo $! >{self.at}/pid; sleep 300")
        begin = time.monotonic()
        self.refused("hook_too_slow", "--hook", hook, "--hook-timeout", "1", *self.LATER)
        self.assertLess(time.monotonic() - begin, 20)
        pid = int((self.at / "pid").read_text())
        status = pathlib.Path(f"/proc/{pid}/stat")
        while status.exists() and ") Z" not in status.read_text() and time.monotonic() - begin < 40:
            time.sleep(0.05)  # a killed process needs a moment to end
        self.assertRegex(status.read_text() if status.exists() else ") Z", r"\) Z")

    def test_one_that_writes_without_end(self):
        self.refused("hook_too_long", "--hook", self.hook("exec yes"), *self.LATER)

    def test_answers_that_are_none(self):
        self.refused("certificate_malformed", "--hook", self.hook("echo hello"), *self.LATER, exit=3)
        self.refused("certificate_malformed", "--hook", self.hook("true"), *self.LATER, exit=3)

    def test_another_subject(self):
        event = self.refused("renewal_unfit", "--hook", self.signing_hook("-days", "400", "-subj",
                                                                         "/CN=admin"), *self.LATER)
        self.assertIn("CN=admin", event["message"])

    def test_the_same_subject_in_another_encoding(self):
        request = self.at / "other.csr"
        (self.at / "cnf").write_text("[req]\nprompt=no\nstring_mask=pkix\ndistinguished_name=dn\n[dn]\nCN=talker\n")
        self.openssl("req", "-new", "-config", "cnf", "-key", self.talker / "key.pem", "-out", request)
        event = self.refused("renewal_unfit", "--hook", self.signing_hook("-days", "400", "-in", str(request)), *self.LATER)
        self.assertIn("encoding", event["message"])

    def test_another_key(self):
        request = self.at / "other.csr"
        self.openssl("req", "-new", "-key", self.at / "demo/listener/key.pem", "-subj", "/CN=talker", "-out", request)
        self.refused("key_mismatch", "--hook", self.signing_hook("-days", "400", "-in", str(request)), *self.LATER)

    def test_a_certificate_of_a_ca(self):
        (self.at / "ext").write_text("basicConstraints=critical,CA:TRUE\n")
        self.refused("renewal_unfit", "--hook", self.signing_hook("-days", "400", "-extfile", f"{self.at}/ext"), *self.LATER)

    def test_another_issuer(self):
        self.run_program("ca", "create", "other", "--role", "identity", "--no-passphrase")
        self.ca = self.at / "other"
        self.refused("issuer_unknown", "--hook", self.signing_hook(), *self.LATER)

    def test_a_revoked_one(self):
        """By a list that has expired, too."""
        hook = self.signing_hook("-days", "400")
        text = (self.at / "hook").read_text().replace("$(openssl rand -hex 16)", "77")
        (self.at / "hook").write_text(text)
        (self.at / "one.csr").write_text(self.openssl("req", "-new", "-key", self.talker / "key.pem", "-subj", "/CN=talker"))
        (self.at / "bad.pem").write_text(self.openssl("x509", "-req", "-in", "one.csr", "-CA", self.ca / "ca.pem", "-CAkey",
                                                      self.ca / "ca.key.pem", "-set_serial", "0x77", "-days", "400"))
        self.run_program("identity", "revoke", "bad.pem", "--ca", "demo", "--subject", "CN=talker")
        (self.talker / "crl.pem").write_bytes((self.ca / "crl.pem").read_bytes())  # ends before self.LATER
        self.refused("certificate_revoked", "--hook", hook, *self.LATER)

    def test_one_that_ends_no_later(self):
        self.refused("renewal_goes_back", "--hook", self.signing_hook("-days", "320"), *self.LATER)
        self.refused("renewal_goes_back", "--hook", self.hook(f"cat {self.talker}/cert.pem"), *self.LATER)

    def test_one_that_is_not_valid_now(self):
        self.refused("certificate_expired", "--hook", self.signing_hook("-days", "30"), *self.LATER)


class Folders(AgentTest):
    def test_others_may_write(self):
        for mode in (0o775, 0o757, 0o1777):
            self.talker.chmod(mode)
            self.refused("folder_untrusted", "--ca", "demo", *self.LATER, exit=4)

    def test_links(self):
        (self.at / "link").symlink_to(self.talker)
        for name in ("link", "link/"):
            self.refused("file_unreadable", "--ca", "demo", *self.LATER, folder=name, exit=3)
        certificate = self.talker / "cert.pem"
        certificate.rename(self.at / "elsewhere.pem")
        certificate.symlink_to(self.at / "elsewhere.pem")
        self.refused("would_overwrite", "--ca", "demo", *self.LATER, exit=4)

    def test_no_folder(self):
        self.refused("file_not_found", "--ca", "demo", folder="nothing", exit=3)

    def test_a_lock_of_another_agent(self):
        with open(self.talker / ".ddssec-agent", "w", opener=lambda *words: os.open(*words, 0o600), encoding="utf-8") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            self.refused("agent_is_running", "--ca", "demo", *self.LATER)
        self.once("--ca", "demo", *self.LATER)
        self.assertFalse((self.talker / ".ddssec-agent").exists())

    def test_something_else_in_place_of_the_lock(self):
        for make in (lambda path: os.mkfifo(path, 0o600), lambda path: path.write_text("x"),
                     lambda path: os.link(self.talker / "key.pem", path)):
            make(self.talker / ".ddssec-agent")
            self.refused("folder_untrusted", "--ca", "demo", *self.LATER, exit=4)
            (self.talker / ".ddssec-agent").unlink()
        (self.talker / ".ddssec-agent").symlink_to(self.at / "precious")
        self.refused("file_unwritable", "--ca", "demo", *self.LATER, exit=5)
        (self.talker / ".ddssec-agent").unlink()
        self.assertFalse((self.at / "precious").exists())

    @NEEDS_ROOT
    def test_files_of_another_user_stay_that_users(self):
        self.at.chmod(0o755)
        for path in (self.talker, *self.talker.iterdir()):
            os.chown(path, OTHER, OTHER)
        self.once("--ca", "demo", "--permissions", *self.LATER)
        self.assertEqual({(p.stat().st_uid, p.stat().st_gid) for p in self.talker.iterdir()}, {(OTHER, OTHER)})
        self.assertEqual((self.talker / "key.pem").stat().st_mode & 0o777, 0o600)
        self.run_program("doctor", "demo/talker", "--now", "+301d")

    @NEEDS_ROOT
    def test_a_user_gets_no_new_key_for_a_name(self):
        """The owner puts another participant's certificate into the folder, which is no secret."""
        self.at.chmod(0o755)
        self.run_program("identity", "issue", "admin", "--ca", "demo", "-o", "demo/admin")
        (self.talker / "cert.pem").write_bytes((self.at / "demo/admin/cert.pem").read_bytes())
        for path in (self.talker, *self.talker.iterdir()):
            os.chown(path, OTHER, OTHER)
        self.refused("key_mismatch", "--ca", "demo", "--rekey", *self.LATER)
        (self.talker / "key.pem").write_bytes((self.at / "demo/admin/key.pem").read_bytes())
        event = self.refused("folder_untrusted", "--ca", "demo", "--rekey", *self.LATER, exit=4)
        self.assertIn("with --rekey", event["message"])

    def test_a_certificate_that_a_fast_clock_made_is_replaced(self):
        self.assertEqual(self.once("--ca", "demo", *self.LATER)[0]["event"], "renewed")
        self.assertEqual(self.once("--ca", "demo")[0]["event"], "renewed")
        self.run_program("doctor", "demo/talker")
        self.assertEqual(self.once("--ca", "demo")[0]["event"], "current")

    def test_permissions_move_to_a_successor_of_their_ca_first(self):
        before = (self.talker / "permissions.p7s").read_bytes()
        self.run_program("ca", "rotate", "demo", "--role", "permissions", "--overlap", "30d")
        event, = self.once("--ca", "demo", "--permissions", *self.LATER, exit=None)
        self.assertEqual(event["problem"]["code"], "not_moved_yet")
        self.assertEqual((self.talker / "permissions.p7s").read_bytes(), before)

    def test_a_revoked_certificate_gets_no_next_one_by_a_hook(self):
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", exit=None)
        (self.talker / "crl.pem").write_bytes((self.ca / "crl.pem").read_bytes())
        hook = self.signing_hook(before=f"echo >{self.at}/asked")
        self.refused("certificate_revoked", "--hook", hook, *self.LATER)
        self.assertFalse((self.at / "asked").exists(), "the CA was asked first")

    def test_a_folder_without_the_list_gets_no_next_one_by_a_hook_if_the_agent_has_it(self):
        """Before, an owner who removed the list from the folder got a certificate that no list names."""
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", exit=None)
        (self.talker / "crl.pem").unlink()
        lists = self.at / "lists.pem"
        lists.write_bytes((self.ca / "crl.pem").read_bytes())
        hook = self.signing_hook(before=f"echo >{self.at}/asked")
        trust = ("--trust", self.ca / "ca.pem")  # its crl.pem is beside it
        self.refused("certificate_revoked", "--hook", hook, *trust, *self.LATER)
        alone = self.at / "trust.pem"
        alone.write_bytes((self.ca / "ca.pem").read_bytes())
        self.refused("certificate_revoked", "--hook", hook, "--trust", alone, "--crl", lists, *self.LATER)
        self.refused("file_unreadable", "--hook", hook, "--trust", alone, "--crl", "nowhere", *self.LATER, exit=3)
        self.assertFalse((self.at / "asked").exists())
        self.run_program("agent", "demo/talker", "--once", "--hook", hook, "--crl", lists, exit=2)

    def test_a_hook_in_a_folder_that_others_can_change_is_not_run(self):
        hook = self.signing_hook()
        self.at.chmod(0o777)
        event = self.refused("hook_unsafe", "--hook", hook, *self.LATER, exit=4)
        self.assertIn("/hook is in it", event["message"])

    @NEEDS_ROOT
    def test_files_are_read_with_the_rights_of_the_folders_owner(self):
        """The owner's link leads to a key that only root can read."""
        self.at.chmod(0o755)
        secret = self.at / "root.key"
        secret.write_bytes((self.talker / "key.pem").read_bytes())
        secret.chmod(0o600)
        (self.talker / "key.pem").unlink()
        (self.talker / "key.pem").symlink_to(secret)
        for path in (self.talker, *self.talker.iterdir()):
            os.chown(path, OTHER, OTHER, follow_symlinks=False)
        self.refused("file_unreadable", "--ca", "demo", *self.LATER, exit=3)

    @NEEDS_ROOT
    def test_a_user_gets_no_name_that_the_ca_has_not_given(self):
        """The owner puts a certificate of another name, made by the owner, into the folder."""
        self.at.chmod(0o755)
        hook = self.signing_hook(before=f"echo >{self.at}/asked")
        trust = ("--trust", "demo/ca/identity/ca.pem")

        def give():
            for path in (self.talker, *self.talker.iterdir()):
                os.chown(path, OTHER, OTHER)
        give()
        event = self.refused("folder_untrusted", "--hook", hook, *self.LATER, exit=4)
        self.assertIn("--trust", event["message"])
        event = self.refused("folder_untrusted", "--hook", hook, *trust, "--rekey", *self.LATER, exit=4)
        own = (self.talker / "cert.pem").read_bytes()
        self.openssl("req", "-x509", "-new", "-key", self.talker / "key.pem", "-subj", "/CN=admin", "-days", "30",
                     "-out", self.talker / "cert.pem")
        give()
        self.refused("issuer_unknown", "--hook", hook, *trust, *self.LATER)
        (self.talker / "cert.pem").write_bytes((self.at / "demo/listener/cert.pem").read_bytes())
        self.refused("key_mismatch", "--hook", hook, *trust, *self.LATER)
        (self.talker / "cert.pem").write_bytes(own)
        file = self.at / "demo/ca/identity/ca.pem"
        for path, mode in ((file, 0o666), (file.parent, 0o777)):
            before = path.stat().st_mode & 0o777
            path.chmod(mode)
            event = self.refused("trust_unsafe", "--hook", hook, *trust, *self.LATER, exit=4)
            self.assertIn(f"mode {mode:04o}", event["message"])
            path.chmod(before)
        self.assertFalse((self.at / "asked").exists())
        self.assertEqual(self.once("--hook", hook, *trust, *self.LATER)[0]["event"], "renewed")

    @NEEDS_ROOT
    def test_a_folder_of_root_keeps_the_owners_of_its_files(self):
        for path in self.talker.iterdir():
            os.chown(path, OTHER, OTHER)
        self.once("--ca", "demo", "--rekey", *self.LATER)
        self.assertEqual({p.stat().st_uid for p in self.talker.iterdir()}, {OTHER})

    @NEEDS_ROOT
    def test_a_user_keeps_no_folder_of_another(self):
        for path in (self.at, self.at / "demo", self.talker):
            path.chmod(0o755)
        told = self.json_as_nobody("agent", "demo/talker", "--hook", "/bin/true", "--once", exit=4)
        self.assertEqual([d["id"] for d in told["diagnostics"]], ["folder_untrusted"])


class Daemon(AgentTest):
    def start(self, *words, **environment):
        agent = Running(self.at, *words, **environment)
        self.addCleanup(agent.end, signal.SIGKILL)
        return agent

    def short_lived(self, seconds):
        short = ShortLived(self.at, self.ca)
        short.put_into(self.talker, seconds)
        return short, self.hook(short.script(seconds))

    def test_renews_again_and_again_and_ends_cleanly(self):
        _, hook = self.short_lived(9)
        agent = self.start("demo/talker", "--hook", hook)
        first, second = agent.wait_for("renewed", 1), agent.wait_for("renewed", 2)
        self.assertNotEqual(first["serial"], second["serial"])
        self.assertEqual(agent.events("failed"), [])
        self.assertTrue((self.talker / ".ddssec-agent").exists())
        self.assertEqual(agent.end(), 0)
        self.assertEqual([e["event"] for e in agent.lines][0::len(agent.lines) - 1], ["started", "stopped"])
        self.assertFalse((self.talker / ".ddssec-agent").exists())

    def test_the_ca_here_issues_for_as_long(self):
        self.short_lived(27)
        log = self.ca / "issued.jsonl"
        line = json.loads(log.read_text().splitlines()[0])
        line["serial"] = self.openssl("x509", "-in", self.talker / "cert.pem", "-noout", "-serial").strip().split("=")[1]
        line["folder"] = str(self.talker)
        for name in ("sha256", "key", "file"):
            line.pop(name, None)
        line["subject"] = "CN=talker"
        log.write_text(log.read_text() + json.dumps(line) + "\n")
        agent = self.start("demo/talker", "--ca", "demo")
        agent.wait_for("renewed")
        begin, end = self.dates()
        self.assertEqual((end - begin).total_seconds(), 27)
        agent.wait_for("renewed", 2)
        self.assertEqual(agent.end(), 0)

    def test_tries_again_later_each_time_and_on_sighup(self):
        _, hook = self.short_lived(3600)
        self.hook("exit 1")
        agent = self.start("demo/talker", "--hook", hook)
        agent.wait_for("current")
        self.assertEqual(agent.events("failed"), [])
        short, _ = ShortLived.__new__(ShortLived), None
        short.at = self.at / "short"
        short.put_into(self.talker, 1)
        agent.process.send_signal(signal.SIGHUP)
        third = agent.wait_for("failed", 3)
        waits = [event["again_in"] for event in agent.events("failed")][:3]
        self.assertEqual(third["failures"], 3)
        self.assertEqual(waits, sorted(waits))
        self.hook(short.script(3600))
        agent.process.send_signal(signal.SIGHUP)
        agent.wait_for("renewed", seconds=20)
        self.assertEqual(agent.end(signal.SIGINT), 0)

    def test_a_stop_does_not_wait_for_a_hook(self):
        self.short_lived(1)
        agent = self.start("demo/talker", "--hook", self.hook(f"echo >{self.at}/began; exec sleep 300"))
        while not (self.at / "began").exists():
            time.sleep(0.05)
        begin = time.monotonic()
        self.assertEqual(agent.end(), 0)
        self.assertLess(time.monotonic() - begin, 10)
        self.assertEqual(agent.events("failed"), [])

    def test_a_wrong_passphrase_is_tried_once(self):
        self.run_program("ca", "create", "locked", "--role", "identity", "--passphrase-env", "PASS",
                         environment={"PASS": "right horse"})
        self.run_program("identity", "issue", "x", "--ca", "locked", "-o", "x", "--days", "1", "--passphrase-env", "PASS",
                         "--now", "-1d", environment={"PASS": "right horse"})
        os.mkfifo(self.at / "pipe")  # which can be read only once, when it is needed
        agent = self.start("x", "--ca", "locked", "--passphrase-file", "pipe")
        (self.at / "pipe").write_text("wrong horse\n")
        event = agent.wait_for("failed")
        self.assertIn("--passphrase-file", event["hint"])
        self.assertEqual((event["code"], event["again_in"]), ("passphrase_wrong", None))
        time.sleep(2)  # in which nothing may be tried: a first repetition comes sooner
        self.assertEqual(len(agent.events("failed")), 1)
        self.assertEqual(agent.end(), 0)

    def test_AWrongPassphrase_IsFoundAtTheStart(self):
        right, wrong = {"PASS": "right horse"}, {"PASS": "wrong horse"}
        self.run_program("ca", "create", "locked", "--passphrase-env", "PASS", environment=right)
        self.run_program("identity", "issue", "x", "--ca", "locked", "-o", "x", "--passphrase-env", "PASS", environment=right)
        words = ("agent", "x", "--ca", "locked", "--passphrase-env", "PASS")
        for more in ((), ("--once",), ("--once", "--dry-run"), ("--once", "--dry-run", "--permissions")):
            done = self.run_program(*words, *more, exit=1, environment=wrong)
            self.assertEqual(done.stdout, "")
            self.assertIn("error[passphrase_wrong]", done.stderr)
            self.assertIn("check what --passphrase-file or --passphrase-env gives", done.stderr)
        self.assertEqual(self.once(*words[2:], folder="x", environment=right)[0]["event"], "current")
        self.run_program(*words[:4], "--once", exit=4)


if __name__ == "__main__":
    main()

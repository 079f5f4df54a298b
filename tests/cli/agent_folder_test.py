#!/usr/bin/env python3
"""ddssec agent: whose folders and files it touches."""

import fcntl
import os
import unittest

from agent_folders import AgentTest
from transcript import main

NEEDS_ROOT = unittest.skipUnless(os.geteuid() == 0, "only root can make files of another user")
OTHER = 65534


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
        self.run_program("ca", "rotate", "demo", "--role", "permissions", "--overlap", "400d")
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
        """Otherwise an owner who removes the list from the folder would get a certificate that no list names."""
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

    def test_expired_certificate_is_not_renewed_by_a_hook_unless_asked(self):
        """The CA's list may not name it any more."""
        hook, later = self.signing_hook(), ("--now", "+366d")
        trust = ("--hook", hook, "--trust", self.ca / "ca.pem")
        (self.ca / "crl.pem").unlink()
        event = self.refused("certificate_expired", *trust, *later, exit=None)
        self.assertIn("--expired", event["hint"])
        self.run_program("agent", "demo/talker", "--once", "--hook", hook, "--expired", exit=2)
        (self.talker / "crl.pem").unlink()
        self.assertEqual(self.once(*trust, "--expired", *later)[0]["event"], "renewed")

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
        before = list(self.talker.iterdir())
        for path in before:
            os.chown(path, OTHER, OTHER)
        self.once("--ca", "demo", "--rekey", *self.LATER)
        self.assertEqual({p.stat().st_uid for p in before}, {OTHER})
        self.assertEqual({p.name for p in self.talker.iterdir() if p not in before}, {"renewed.pem"})
        self.assertEqual((self.talker / "renewed.pem").stat().st_mode & 0o777, 0o644)

    @NEEDS_ROOT
    def test_a_user_keeps_no_folder_of_another(self):
        for path in (self.at, self.at / "demo", self.talker):
            path.chmod(0o755)
        told = self.json_as_nobody("agent", "demo/talker", "--hook", "/bin/true", "--once", exit=4)
        self.assertEqual([d["id"] for d in told["diagnostics"]], ["folder_untrusted"])


if __name__ == "__main__":
    main()

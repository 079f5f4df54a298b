#!/usr/bin/env python3
"""ddssec agent --documents-hook: what it is asked for, and what of its answers is put into the folder."""

import datetime
import os
import shutil
import signal
import time
import unittest

from agent_folders import AgentTest, Running, ShortLived
from transcript import main

# Signs with `openssl smime`, as a CA elsewhere would.
SIGN = """case $DDSSEC_WANTED in
permissions) sed "s,@FROM@,{begin}," {at}/rights.xml | sed "s,@TO@,$(date -u -d "+{seconds} seconds" +%FT%TZ)," |
  openssl smime -sign -text -signer {ca}/ca.pem -inkey {ca}/ca.key.pem ;;
crl) cat {at}/lists.pem 2>/dev/null ;;
renewals) cat {at}/renewed.pem 2>/dev/null ;;
esac
exit 0"""


class Documents(AgentTest):
    def setUp(self):
        super().setUp()
        self.permissions_ca = self.at / "demo/ca/permissions"
        self.rights("talker")

    def rights(self, name, folder="talker"):
        """What the hook signs: as in the folder, for that subject."""
        text = self.openssl("smime", "-verify", "-text", "-CAfile", self.permissions_ca / "ca.pem", "-in",
                            f"demo/{folder}/permissions.p7s").replace("\r", "")
        for word, sign in (("not_before", "@FROM@"), ("not_after", "@TO@")):
            begin, end = text.index(f"<{word}>") + len(word) + 2, text.index(f"</{word}>")
            text = text[:begin] + sign + text[end:]
        (self.at / "rights.xml").write_text(text.replace("CN=talker", f"CN={name}"))

    def documents_hook(self, seconds=400 * 86400, ca=None, begin="$(date -u +%FT%TZ)", text=None):
        path = self.at / "documents"
        path.write_text("#!/bin/sh\n" + (text or SIGN.format(at=self.at, ca=ca or self.permissions_ca, seconds=seconds,
                                                             begin=begin)) + "\n")
        path.chmod(0o755)
        return ("--hook", self.signing_hook(), "--documents-hook", str(path))

    def short_permissions(self, seconds=100, options=("-noattr",)):
        """In the folder, signed by hand: two thirds of their time are over. Without options they say when they were
        signed, and their time counts from then on."""
        text = (self.at / "rights.xml").read_text()
        now = datetime.datetime.now(datetime.timezone.utc)
        for sign, offset in (("@FROM@", -seconds * 4), ("@TO@", seconds)):
            text = text.replace(sign, (now + datetime.timedelta(seconds=offset)).strftime("%FT%TZ"))
        (self.talker / "permissions.xml").write_text(text)
        self.openssl("smime", "-sign", "-text", *options, "-signer", self.permissions_ca / "ca.pem", "-inkey",
                     self.permissions_ca / "ca.key.pem", "-in", self.talker / "permissions.xml", "-out",
                     self.talker / "permissions.p7s")

    def look(self, *words, exit=0):
        """The event about documents, or None."""
        events = [event for event in self.once(*words, exit=exit) if event["event"] == "documents_fetched"]
        return events[0] if events else None

    def names(self, event):
        return sorted(file["path"].rsplit("/", 1)[1] for file in event["files"])

    def refuses(self, code, *words, exit=1):
        before = self.contents()
        event = self.look(*words, exit=exit)
        self.assertEqual((event["files"], event["problem"]["code"]), ([], code), event)
        self.assertEqual({p: o for p, o in self.contents().items() if "cert.pem" not in p},
                         {p: o for p, o in before.items() if "cert.pem" not in p})

    def test_permissions_that_last_are_not_asked_for(self):
        self.assertIsNone(self.look(*self.documents_hook()))

    def test_permissions_after_two_thirds_are_renewed_with_their_text(self):
        self.short_permissions()
        event = self.look(*self.documents_hook())
        self.assertEqual(self.names(event), ["permissions.p7s", "permissions.xml"])
        self.assertNotIn("problem", event)
        self.run_program("doctor", "demo/talker", "--now", "+300d")
        self.assertIsNone(self.look(*self.documents_hook()))

    def test_permissions_that_have_ended_are_asked_for_too(self):
        self.short_permissions(-100)
        self.assertEqual(self.names(self.look(*self.documents_hook())), ["permissions.p7s", "permissions.xml"])

    def test_bad_permissions_are_refused_and_the_old_stay(self):
        self.short_permissions()
        self.run_program("ca", "create", "other", "--role", "permissions", "--no-passphrase")
        self.refuses("smime_signer_not_permissions_ca", *self.documents_hook(ca=self.at / "other"))
        self.refuses("renewal_goes_back", *self.documents_hook(seconds=50))
        self.refuses("grant_expired", *self.documents_hook(seconds=-50, begin='$(date -u -d "-100 seconds" +%FT%TZ)'))
        self.refuses("renewal_goes_back", *self.documents_hook(begin="2020-01-01T00:00:00Z"))
        self.refuses("renewal_goes_back", *self.documents_hook(text=f"[ $DDSSEC_WANTED != permissions ] || cat {self.talker}/permissions.p7s"))
        self.rights("admin")
        self.refuses("no_grant_for_subject", *self.documents_hook())
        self.refuses("hook_failed", *self.documents_hook(text="[ $DDSSEC_WANTED != permissions ] || exit 3"))
        self.refuses("hook_too_long", *self.documents_hook(text="[ $DDSSEC_WANTED != permissions ] || exec yes"))
        self.refuses("hook_too_slow", *self.documents_hook(text="[ $DDSSEC_WANTED != permissions ] || sleep 60"),
                     "--hook-timeout", "1")

    def test_document_that_was_signed_earlier_is_refused_though_it_lasts_longer(self):
        """It may have given more."""
        self.short_permissions(200, options=())
        wide = self.at / "wide.p7s"
        words = self.documents_hook(text=f"[ $DDSSEC_WANTED != permissions ] || cat {wide}")
        shutil.copy(self.talker / "permissions.p7s", wide)
        time.sleep(1.1)
        self.short_permissions(100, options=())  # signed later, and it ends earlier
        later = datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(seconds=90)
        event = self.look(*words, "--now", later.strftime("%FT%TZ"), exit=1)
        self.assertEqual(event["problem"]["code"], "renewal_goes_back")

    def signed_grants(self, name, *spans):
        """A document with a grant for each span, in seconds from now."""
        text = (self.at / "rights.xml").read_text()
        begin, end = text.index("<grant"), text.index("</grant>") + len("</grant>")
        now = datetime.datetime.now(datetime.timezone.utc)
        grants = ""
        for span in spans:
            grants += text[begin:end].replace('name="', f'name="from {span[0]} ', 1)
            for sign, seconds in zip(("@FROM@", "@TO@"), span):
                grants = grants.replace(sign, (now + datetime.timedelta(seconds=seconds)).strftime("%FT%TZ"))
        (self.at / "grants.xml").write_text(text[:begin] + grants + text[end:])
        self.openssl("smime", "-sign", "-text", "-signer", self.permissions_ca / "ca.pem", "-inkey",
                     self.permissions_ca / "ca.key.pem", "-in", "grants.xml", "-out", name)
        return f"[ $DDSSEC_WANTED != permissions ] || cat {self.at / name}"

    def test_permissions_that_plan_others_are_not_replaced_by_earlier_ones(self):
        """Such a document cannot be extended, but it counts like any other."""
        hour = 3600
        wide = self.documents_hook(text=self.signed_grants("wide.p7s", (-400, 40 * hour)))
        self.signed_grants("demo/talker/permissions.p7s", (-400, 5 * hour), (5 * hour, 20 * hour))
        event = self.look(*wide, "--now", "+16h", exit=1)
        self.assertEqual(event["problem"]["code"], "renewal_goes_back")
        follow = self.documents_hook(text=self.signed_grants("next.p7s", (5 * hour, 30 * hour), (30 * hour, 60 * hour)))
        self.assertEqual(self.names(self.look(*follow, "--now", "+16h")), ["permissions.p7s"])

    def test_permissions_whose_begin_stays_are_due_by_their_signature(self):
        self.short_permissions(20 * 86400)
        begin = (datetime.datetime.now(datetime.timezone.utc) - datetime.timedelta(days=60)).strftime("%FT%TZ")
        words = self.documents_hook(seconds=30 * 86400, begin=begin)
        self.assertEqual(self.names(self.look(*words)), ["permissions.p7s", "permissions.xml"])
        self.assertIsNone(self.look(*words))
        self.assertIsNone(self.look(*words, "--now", "+19d"))
        self.assertIsNotNone(self.look(*words, "--now", "+21d", exit=None))

    def test_hook_without_permissions_is_a_problem_once_they_are_due(self):
        words = self.documents_hook(text="exit 0")
        self.assertIsNone(self.look(*words))
        self.short_permissions()
        event = self.look(*words, exit=1)
        self.assertEqual((event["files"], event["problem"]["code"]), ([], "no_new_permissions"))
        self.assertIn("permissions that end on ", event["problem"]["message"])
        self.short_permissions(-100)
        self.assertEqual(self.look(*words, exit=1)["problem"]["code"], "no_new_permissions")
        (self.talker / "permissions.p7s").unlink()
        told = self.run_program("agent", "demo/talker", "--once", *words, exit=1).stderr
        self.assertIn("error[no_new_permissions]", told)
        self.assertIn("no permissions that can be used", " ".join(told.split()))

    def test_daemon_hook_without_permissions_is_asked_rarely_and_reported_once(self):
        self.short_permissions(24)  # of 120 s: asked again after 2 s
        asked = self.at / "asked"
        words = self.documents_hook(text=f"[ $DDSSEC_WANTED != permissions ] || echo >>{asked}")
        agent = Running(self.at, "demo/talker", *words)
        self.addCleanup(agent.end, signal.SIGKILL)
        event = agent.wait_for("documents_fetched")
        self.assertEqual(event["problem"]["code"], "no_new_permissions")
        begin = time.monotonic()
        while len(asked.read_text()) < 3:
            self.assertLess(time.monotonic() - begin, 30)
            time.sleep(0.05)
        self.assertGreater(time.monotonic() - begin, 3)
        self.assertEqual(agent.end(), 0)
        self.assertEqual(len(agent.events("documents_fetched")), 1)

    def test_permissions_that_are_replaced_while_the_hook_runs_stay(self):
        """They may give less."""
        self.short_permissions(100)
        narrow = self.at / "narrow.p7s"
        shutil.copy(self.talker / "permissions.p7s", narrow)
        self.short_permissions(200)
        script = SIGN.format(at=self.at, ca=self.permissions_ca, seconds=9000, begin="$(date -u +%FT%TZ)")
        event = self.look(*self.documents_hook(text=f"cp {narrow} {self.talker}/permissions.p7s\n{script}"), exit=1)
        self.assertEqual((event["files"], event["problem"]["code"]), ([], "files_changed"))
        self.assertEqual((self.talker / "permissions.p7s").read_bytes(), narrow.read_bytes())
        self.assertEqual(self.names(self.look(*self.documents_hook())), ["permissions.p7s", "permissions.xml"])

    def test_hook_that_others_can_change_is_not_run(self):
        words = self.documents_hook()
        (self.at / "documents").chmod(0o777)
        event = self.look(*words, exit=4)
        self.assertEqual(event["problem"]["code"], "hook_unsafe")

    def test_it_gets_the_certificate_and_what_is_wanted(self):
        self.short_permissions()
        script = f"cat >{self.at}/input-$DDSSEC_WANTED; env >{self.at}/env-$DDSSEC_WANTED"
        self.look(*self.documents_hook(text=script), exit=None)
        for wanted in ("permissions", "crl", "renewals"):
            self.assertEqual((self.at / f"input-{wanted}").read_text(), (self.talker / "cert.pem").read_text())
            lines = (self.at / f"env-{wanted}").read_text().splitlines()
            self.assertLessEqual({"DDSSEC_SUBJECT=CN=talker", f"DDSSEC_WANTED={wanted}"}, set(lines))
            self.assertLessEqual({line.split("=")[0] for line in lines}, {"PATH", "LC_ALL", "DDSSEC_FOLDER", "DDSSEC_SUBJECT",
                                                                         "DDSSEC_WANTED", "PWD", "_", "SHLVL", "OLDPWD"})

    def test_revocation_list_is_taken_once_and_never_an_older_one(self):
        old = (self.ca / "crl.pem").read_bytes()
        self.run_program("identity", "revoke", "demo/listener", "--ca", "demo")
        shutil.copy(self.ca / "crl.pem", self.at / "lists.pem")
        self.assertEqual(self.names(self.look(*self.documents_hook())), ["crl.pem"])
        self.assertEqual((self.talker / "crl.pem").read_bytes(), (self.ca / "crl.pem").read_bytes())
        self.assertIsNone(self.look(*self.documents_hook()))
        (self.at / "lists.pem").write_bytes(old)
        self.refuses("crl_older", *self.documents_hook())
        (self.at / "lists.pem").write_text("nothing")
        self.refuses("crl_malformed", *self.documents_hook(), exit=(1, 3))
        self.run_program("ca", "create", "other", "--role", "identity", "--no-passphrase")
        shutil.copy(self.at / "other/crl.pem", self.at / "lists.pem")
        self.refuses("crl_signature_invalid", *self.documents_hook(), exit=(1, 3))

    def test_revoked_participant_asks_for_no_certificate_once_its_list_is_there(self):
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo")
        self.run_program("crl", "new", "--ca", "demo", "--next-update", "400")
        shutil.copy(self.ca / "crl.pem", self.at / "lists.pem")
        events = self.once(*self.documents_hook(), *self.LATER, exit=None)
        self.assertEqual([event.get("code") for event in events if event["event"] == "failed"], ["certificate_revoked"])

    def test_renewal_list_is_put_beside_the_certificate(self):
        self.run_program("identity", "renew", "demo/listener", "--ca", "demo", "--permissions")
        shutil.copy(self.ca / "renewed.pem", self.at / "renewed.pem")
        self.assertEqual(self.names(self.look(*self.documents_hook())), ["renewed.pem"])
        self.assertIn("BEGIN CERTIFICATE", (self.talker / "renewed.pem").read_text())
        self.assertIsNone(self.look(*self.documents_hook()))
        (self.at / "renewed.pem").write_text("nothing")
        self.refuses("renewal_list_malformed", *self.documents_hook(), exit=(1, 3))

    def test_only_with_a_hook(self):
        self.run_program("agent", "demo/talker", "--ca", "demo", "--documents-hook", "/bin/true", exit=2)

    @unittest.skipUnless(os.geteuid() == 0, "only root has folders of other users")
    def test_folder_of_another_user_needs_a_trust_file_for_documents_too(self):
        self.short_permissions()
        self.at.chmod(0o755)
        for path in (self.talker, *self.talker.rglob("*")):
            shutil.chown(path, 65534, 65534)
        words = self.documents_hook()
        self.assertEqual(self.look(*words, exit=4)["problem"]["code"], "folder_untrusted")
        shutil.copy(self.ca / "ca.pem", self.at / "trust.pem")
        event = self.look(*words, "--trust", "trust.pem")
        self.assertEqual(self.names(event), ["permissions.p7s", "permissions.xml"])
        self.assertEqual((self.talker / "permissions.p7s").stat().st_uid, 65534)
        (self.talker / "cert.pem").write_bytes((self.at / "demo/listener/cert.pem").read_bytes())  # a copy, without its key
        self.rights("listener", "listener")
        event = self.look(*words, "--trust", "trust.pem", exit=None)
        self.assertEqual(event["problem"]["code"], "key_mismatch")

    def test_daemon_renewal_that_fails_does_not_delay_documents(self):
        ShortLived(self.at, self.ca).put_into(self.talker, 65 * 86400, age=300 * 86400)  # due; tried again after a minute
        self.short_permissions(6)
        words = self.documents_hook(seconds=12)
        self.hook("exit 1")
        agent = Running(self.at, "demo/talker", *words)
        self.addCleanup(agent.end, signal.SIGKILL)
        agent.wait_for("documents_fetched", 3, seconds=40)
        self.assertEqual([event["failures"] for event in agent.events("failed")], [1])
        self.assertEqual([event for event in agent.events("documents_fetched") if "problem" in event], [])
        self.assertEqual(agent.end(), 0)

    def test_daemon_renews_permissions_of_seconds_again_and_again(self):
        self.short_permissions(6)
        agent = Running(self.at, "demo/talker", *self.documents_hook(seconds=12))
        self.addCleanup(agent.end, signal.SIGKILL)
        agent.wait_for("documents_fetched", 3)
        self.assertEqual([event for event in agent.events("documents_fetched") if "problem" in event], [])
        self.assertEqual(agent.end(), 0)


if __name__ == "__main__":
    main()

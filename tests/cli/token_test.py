#!/usr/bin/env python3
"""Keys in a PKCS#11 token (SoftHSM's): of participants and of CAs, from the request to a signed document."""

import datetime
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import time
import unittest

from agent_folders import Running
from transcript import AT_THAT_TIME, NOW, PROGRAM, Transcript, main

PIN = "1234"


def module(name):
    return next(iter(pathlib.Path("/usr/lib").rglob(name)), pathlib.Path("/nowhere"))


SPY, SOFTHSM = module("pkcs11-spy.so"), module("libsofthsm2.so")
TALKER = "pkcs11:token=robot;object=talker"


class Token(Transcript):
    def setUp(self):
        super().setUp()
        (self.at / "tokens").mkdir()
        (self.at / "softhsm2.conf").write_text(f"directories.tokendir = {self.at}/tokens\nlog.level = ERROR\n")
        os.environ["SOFTHSM2_CONF"] = str(self.at / "softhsm2.conf")
        self.addCleanup(os.environ.pop, "SOFTHSM2_CONF")
        self.softhsm("--init-token", "--free", "--label", "robot", "--so-pin", "87654321")
        self.pin = f"?pin-source={self.at}/pin"
        (self.at / "pin").write_text(PIN + "\n")

    def softhsm(self, *words):
        subprocess.run(["softhsm2-util", *words, "--pin", PIN], check=True, capture_output=True, timeout=60)

    def put(self, name, *kind):
        """A key, made outside and moved in."""
        self.openssl("genpkey", "-algorithm", *(kind or ("EC", "-pkeyopt", "ec_paramgen_curve:P-256")), "-out",
                     "outside.pem")
        self.softhsm("--import", str(self.at / "outside.pem"), "--token", "robot", "--label", name, "--id",
                     f"{len(name):02x}{ord(name[0]):02x}")
        (self.at / "outside.pem").unlink()

    def make_cas(self):
        self.put("identity")
        self.put("permissions", "RSA")
        (self.at / "ca").mkdir()
        for role in ("identity", "permissions"):
            out = self.json("ca", "create", f"ca/{role}", "--role", role, "--key",
                            f"pkcs11:token=robot;object={role}{self.pin}", *NOW)
            self.assertFalse(out["result"]["encrypted"])
            made = {file["path"]: file["mode"] for file in out["files_written"]}
            wanted = {f"ca/{role}/ca.pem": "0644", f"ca/{role}/ca.key.p11": "0600"}
            if role == "identity":
                wanted["ca/identity/crl.pem"] = "0644"
            self.assertEqual(made, wanted)

    def make_talker(self):
        self.put("talker")
        self.json("identity", "csr", "talker", "-o", "talker", "--key", TALKER + self.pin)
        self.assertEqual((self.at / "talker/key.p11").read_text(), TALKER + self.pin + "\n")
        self.json("identity", "sign-csr", "talker", "--ca", "ca", "--yes", *NOW)

    def test_a_whole_system_without_a_key_in_a_file(self):
        self.make_cas()
        self.make_talker()
        self.json("governance", "new", "--sign", "--ca", "ca", "-o", "governance.xml", *NOW)
        self.json("permissions", "new", "--cert", "talker/cert.pem", "--publish", "chatter", "--sign", "--ca", "ca",
                  "-o", "talker/permissions.xml", *NOW)
        for name, source in (("identity_ca.pem", "ca/identity/ca.pem"), ("governance.p7s", "governance.p7s"),
                             ("permissions_ca.pem", "ca/permissions/ca.pem")):
            (self.at / "talker" / name).write_bytes((self.at / source).read_bytes())
        told = self.json("doctor", "talker", *NOW, exit=1)
        self.assertEqual([one["id"] for one in told["diagnostics"]], ["DOC005", "DOC023"])  # no list yet
        self.assertEqual(told["result"]["verdicts"], {"cyclonedds@0.10.2": "fail", "fastdds@2.9.1": "ok", "ddssec": "ok"})
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "ca/identity/ca.pem", "talker/cert.pem")
        self.openssl("smime", "-verify", "-text", *AT_THAT_TIME, "-in", "talker/governance.p7s", "-CAfile",
                     "ca/permissions/ca.pem", "-purpose", "any")
        self.json("identity", "revoke", "talker", "--ca", "ca", *NOW)
        self.openssl("crl", "-in", "ca/identity/crl.pem", "-CAfile", "ca/identity/ca.pem", "-verify", "-noout")
        key_files = [name for name in self.files() if name.endswith("key.pem")]
        self.assertEqual(key_files, [])

    def test_a_ca_is_shown_without_its_pin(self):
        self.make_cas()
        shown = self.json("ca", "show", "ca", *NOW)["result"]["key"]
        self.assertEqual(shown, {"encrypted": False, "mode": "0600", "token": "pkcs11:token=robot;object=identity"})
        text = self.run_program("ca", "show", "ca", *NOW).stdout
        self.assertIn("in a token, pkcs11:token=robot;object=identity\n", text)

    def test_a_ca_made_elsewhere_is_imported_with_its_token(self):
        self.make_cas()
        self.json("ca", "import", "other", "--cert", "ca/identity/ca.pem", "--key",
                  "pkcs11:token=robot;object=identity", "--passphrase-file", "pin")
        self.put("talker")
        self.json("identity", "csr", "talker", "-o", "talker", "--key", TALKER, "--passphrase-file", "pin")
        self.json("identity", "sign-csr", "talker", "--ca", "other", "--yes", "--passphrase-file", "pin", *NOW)
        self.refused("key_mismatch", 1, "ca", "import", "wrong", "--cert", "ca/identity/ca.pem", "--key",
                     TALKER + self.pin)

    def test_refusals_say_what_is_wrong_and_never_the_pin(self):
        self.put("talker")
        csr = ("identity", "csr", "talker", "-o", "talker", "--key")
        cases = (("pkcs11_pin_wrong", TALKER + "?pin-value=98765"),
                 ("pkcs11_not_found", f"pkcs11:token=robot;object=nobody?pin-value={PIN}"),
                 ("pkcs11_not_found", f"pkcs11:token=other;object=talker?pin-value={PIN}"),
                 ("file_not_found", TALKER + "?pin-source=file:nowhere"))
        for code, uri in cases:
            told = self.refused(code, 3 if code == "file_not_found" else 1, *csr, uri)
            self.assertNotIn("98765", str(told))
        self.refused("passphrase_needed", 4, *csr, TALKER)
        self.refused("pkcs11_unavailable", 1, *csr, TALKER + self.pin, environment={"OPENSSL_ENGINES": str(self.at)})
        self.refused("usage", 2, "ca", "create", "ca", "--key", TALKER + self.pin)

    def test_a_key_in_a_token_is_not_replaced_by_one_in_a_file(self):
        self.make_cas()
        self.make_talker()
        self.refused("key_in_token", 1, "identity", "renew", "talker", "--ca", "ca", "--rekey", *NOW)
        self.refused("key_in_token", 1, "ca", "rotate", "ca", "--role", "identity", "talker", *NOW)
        renewed = self.json("identity", "renew", "talker", "--ca", "ca", "--days", "700", *NOW)
        self.assertEqual([pathlib.Path(file["path"]).name for file in renewed["files_written"]], ["cert.pem"])

    def logins(self, name, *words):
        """How often the command logs in to a token, and what it prints."""
        log = self.at / f"{name}.log"
        done = subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, text=True, capture_output=True, timeout=60, check=False,
                              env={**os.environ, "PKCS11_MODULE_PATH": str(SPY), "PKCS11SPY": str(SOFTHSM),
                                   "PKCS11SPY_OUTPUT": str(log)})
        text = log.read_text() if log.exists() else ""
        return len(re.findall(r"(?m)^\d+: C_Login$", text)), done.stdout + done.stderr

    @unittest.skipUnless(SPY.exists(), "no pkcs11-spy (opensc-pkcs11)")
    def test_a_folder_costs_one_wrong_pin_at_most_and_none_if_others_can_change_it(self):
        self.put("k")
        self.run_program("init", "demo", *NOW)
        for number, name in enumerate(("cert", "key", "identity_ca", "permissions_ca")):
            (self.at / "demo/talker" / f"{name}.pem").unlink()
            (self.at / "demo/talker" / f"{name}.p11").write_text(f"pkcs11:token=robot;object=k?pin-value=000{number}\n")
        commands = (("doctor", "demo/talker"), ("check", "demo/talker", "demo/listener"),
                    ("can", "demo/talker", "publish", "x"))
        for words in commands:
            self.assertEqual(self.logins(words[0], *words)[0], 1, words)
        (self.at / "demo/talker").chmod(0o777)
        for words in commands:
            logins, text = self.logins(words[0] + "-open", *words)
            self.assertEqual(logins, 0, words)
            if words[0] != "can":  # it reports what it reads first
                self.assertIn("not looked at, because another user can change the folder", " ".join(text.split()), words)

    def test_the_agent_renews_with_keys_in_tokens_and_tries_a_wrong_pin_once(self):
        self.make_cas()
        self.make_talker()
        (self.at / "talker/identity_ca.pem").write_bytes((self.at / "ca/identity/ca.pem").read_bytes())
        later = ("--ca", "ca", "--once", "--now", "2027-09-01")
        before = (self.at / "talker/cert.pem").read_text()
        told = self.json("agent", "talker", *later, "--rekey", exit=1)
        self.assertEqual(told["result"]["events"][0]["code"], "key_in_token")
        told = self.json("agent", "talker", *later)
        self.assertEqual(told["result"]["events"][0]["event"], "renewed")
        self.assertNotEqual((self.at / "talker/cert.pem").read_text(), before)
        (self.at / "pin").write_text("9999\n")
        told = self.json("agent", "talker", "--ca", "ca", "--once", "--now", "2028-06-30", exit=1)
        event, = told["result"]["events"]
        self.assertEqual((event["code"], event["again_in"]), ("pkcs11_pin_wrong", None))
        self.assertNotIn("9999", json.dumps(told))

    @unittest.skipUnless(SPY.exists(), "no pkcs11-spy (opensc-pkcs11)")
    def test_the_agent_tries_one_wrong_pin_for_all_folders(self):
        """Of the CA, and of folders that belong to one user."""
        self.make_cas()
        folders = [f"p{number}" for number in range(3)]
        for folder in folders:
            self.json("identity", "issue", folder, "--ca", "ca", "-o", folder, *NOW)
        for name in ("ca", "folder"):
            log = self.at / f"{name}.log"
            (self.at / "pin").write_text("9999\n")
            if name == "folder":
                for folder in folders:
                    (self.at / folder / "key.pem").unlink()
                    (self.at / folder / "key.p11").write_text(f"pkcs11:token=robot;object=identity{self.pin}\n")
            done = subprocess.run([PROGRAM, "agent", *folders, "--ca", "ca", "--once", "--now", "2027-09-01"], cwd=self.at,
                                  text=True, capture_output=True, timeout=60, check=False, stdin=subprocess.DEVNULL,
                                  env={**os.environ, "PKCS11_MODULE_PATH": str(SPY), "PKCS11SPY": str(SOFTHSM),
                                       "PKCS11SPY_OUTPUT": str(log)})
            self.assertEqual(done.stdout.count('"code":"pkcs11_pin_wrong"'), 3, done.stdout)
            self.assertEqual(len(re.findall(r"(?m)^\d+: C_Login$", log.read_text())), 1, name)

    def spied(self, log):
        return {"PKCS11_MODULE_PATH": str(SPY), "PKCS11SPY": str(SOFTHSM), "PKCS11SPY_OUTPUT": str(log)}

    def make_permissions_ca(self):
        """Its key is in the token, that of the identity CA in a file."""
        self.make_cas()
        shutil.rmtree(self.at / "ca/identity")
        self.json("ca", "create", "ca/identity", "--role", "identity", "--no-passphrase", *NOW)

    def test_agent_wrong_pin_of_the_permissions_ca_leaves_the_tokens_of_participants_in_use(self):
        """Only the permissions of one are due; the other has a token with a PIN of its own."""
        self.make_permissions_ca()
        self.json("governance", "new", "--sign", "--ca", "ca", "-o", "governance.xml", *NOW)
        self.json("identity", "issue", "one", "--ca", "ca", "-o", "one", "--governance", "governance.p7s", "--publish", "x", *NOW)
        self.json("permissions", "new", "--cert", "one/cert.pem", "--publish", "x", "--days", "180", "--sign", "--ca", "ca", "-o",
                  "one/permissions.xml", "--replace", *NOW)
        self.json("identity", "issue", "two", "--ca", "ca", "-o", "two", "--days", "150", *NOW)
        self.softhsm("--import", str(self.at / "two/key.pem"), "--token", "robot", "--label", "two", "--id", "0002")
        (self.at / "two/key.pem").unlink()
        (self.at / "two/key.p11").write_text(f"pkcs11:token=robot;object=two?pin-value={PIN}\n")
        (self.at / "two/key.p11").chmod(0o600)
        (self.at / "pin").write_text("9999\n")
        done = self.run_program("agent", "one", "two", "--ca", "ca", "--permissions", "--once", "--now", "2027-03-25", exit=1)
        events = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([(event["event"], event.get("code")) for event in events],
                         [("failed", "pkcs11_pin_wrong"), ("renewed", None)])

    @unittest.skipUnless(SPY.exists(), "no pkcs11-spy (opensc-pkcs11)")
    def test_agent_wrong_pin_of_the_permissions_ca_is_tried_once_and_certificates_are_renewed(self):
        self.make_permissions_ca()
        folders = [f"p{number}" for number in range(3)]
        self.json("governance", "new", "--sign", "--ca", "ca", "-o", "governance.xml", *NOW)
        for folder in folders:
            self.json("identity", "issue", folder, "--ca", "ca", "-o", folder, "--governance", "governance.p7s", "--publish", "x",
                      *NOW)
        (self.at / "pin").write_text("9999\n")
        log = self.at / "spy.log"
        done = self.run_program("agent", *folders, "--ca", "ca", "--permissions", "--once", "--now", "2027-09-01", exit=1,
                                environment=self.spied(log))
        events = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([(event["event"], event["problem"]["code"]) for event in events], [("renewed", "pkcs11_pin_wrong")] * 3)
        self.assertEqual(len(re.findall(r"(?m)^\d+: C_Login$", log.read_text())), 1)

    @unittest.skipUnless(SPY.exists(), "no pkcs11-spy (opensc-pkcs11)")
    def test_agent_wrong_pin_for_permissions_of_the_hook_is_tried_once_and_lists_arrive(self):
        self.put("robot")
        self.run_program("init", "demo")
        folder = self.at / "demo/talker"
        (folder / "key.pem").unlink()
        (folder / "key.p11").write_text("pkcs11:token=robot;object=robot?pin-value=9999\n")
        (folder / "key.p11").chmod(0o600)
        now = datetime.datetime.now(datetime.timezone.utc)
        text = self.openssl("smime", "-verify", "-text", "-CAfile", "demo/ca/permissions/ca.pem", "-in",
                            folder / "permissions.p7s").replace("\r", "")
        for word, seconds in (("not_before", -90), ("not_after", 30)):  # due, and again after 2 s
            text = re.sub(f"<{word}>.*?<", f"<{word}>{now + datetime.timedelta(seconds=seconds):%FT%TZ}<", text)
        (self.at / "short.xml").write_text(text)
        self.openssl("smime", "-sign", "-text", "-noattr", "-signer", "demo/ca/permissions/ca.pem", "-inkey",
                     "demo/ca/permissions/ca.key.pem", "-in", "short.xml", "-out", folder / "permissions.p7s")
        hook, log, asked = self.at / "documents", self.at / "spy.log", self.at / "asked-crl"
        hook.write_text(f"#!/bin/sh\necho >>{self.at}/asked-$DDSSEC_WANTED\n[ $DDSSEC_WANTED != crl ]\n")
        hook.chmod(0o755)
        agent = Running(self.at, "demo/talker", "--hook", hook, "--documents-hook", hook, **self.spied(log))
        self.addCleanup(agent.end, signal.SIGKILL)
        event = agent.wait_for("documents_fetched")
        self.assertEqual(event["problem"]["code"], "pkcs11_pin_wrong")
        end = time.monotonic() + 30
        while len(asked.read_text()) < 4:
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)
        self.assertEqual(agent.end(), 0)
        self.assertEqual(len(agent.events("documents_fetched")), 1)
        self.assertEqual(len(re.findall(r"(?m)^\d+: C_Login$", log.read_text())), 1)
        self.assertFalse((self.at / "asked-permissions").exists())

    def test_doctor_says_why_a_token_cannot_be_used(self):
        self.run_program("init", "demo", "--participant", "talker", *NOW)
        folder = self.at / "demo/talker"
        (folder / "key.pem").unlink()
        (folder / "key.p11").write_text(f"{TALKER}?pin-value={PIN}\n")
        (folder / "key.p11").chmod(0o644)
        told = self.json("doctor", "demo/talker", *NOW, exit=1)["diagnostics"]
        self.assertEqual([one["id"] for one in told][:3], ["DOC005", "DOC005", "DOC003"])
        self.assertIn("DOC008", [one["id"] for one in told], "the configurations name key.pem")
        self.assertIn("no connected token", told[0]["message"])
        self.assertNotIn(PIN, str(told))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""ddssec agent --hook: what the program that signs gets, and what of its answer is taken."""

import pathlib
import re
import shutil
import time
import unittest

from agent_folders import SIGN, AgentTest
from est_server import EstServer
from transcript import DATA, main

PAGE = DATA.parent.parent / "docs/agent.md"
# A request as Go's encoder writes names: what fits into a PrintableString is one.
PRINTABLE = "[req]\nprompt=no\nstring_mask=pkix\ndistinguished_name=dn\n[dn]\nCN=talker\n"


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

    def test_messages_of_a_hook_cannot_look_like_events(self):
        """In a journal, standard error is beside the events."""
        script = r"""printf '{"event":"renewed"}\033[2J\ntorn' >&2; head -c 300000 /dev/zero | tr '\0' x >&2; exit 3"""
        done = self.run_program("agent", "demo/talker", "--once", "--hook", self.hook(script), *self.LATER, exit=1)
        lines = done.stderr.splitlines()
        messages = [line for line in lines if line.startswith("hook: ")]
        self.assertRegex(messages[0], r'^hook: {"event":"renewed"}[^\x1b]*$')
        self.assertTrue(messages[1].startswith("hook: tornxxx"), messages[1])
        self.assertEqual(sum(line.count("x") for line in messages[1:]), 300000)
        self.assertTrue(lines[len(messages)].startswith("error[hook_failed]"), lines[len(messages)])

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

    def printable_request(self):
        request = self.at / "other.csr"
        (self.at / "cnf").write_text(PRINTABLE)
        self.openssl("req", "-new", "-config", "cnf", "-key", self.talker / "key.pem", "-out", request)
        return str(request)

    def test_the_same_subject_in_another_encoding(self):
        hook = self.signing_hook("-days", "400", "-in", self.printable_request())
        event = self.refused("renewal_unfit", "--hook", hook, *self.LATER)
        self.assertIn("CN=UTF8STRING:talker, found CN=PRINTABLESTRING:talker", event["message"])
        self.assertIn("stop the participant", event["hint"])

    def test_a_ca_that_writes_names_in_another_way_renews_what_it_issued(self):
        """As step-ca and Vault do: the first certificate and the next have the same octets."""
        request = self.printable_request()
        first = self.openssl("x509", "-req", "-in", request, "-CA", self.ca / "ca.pem", "-CAkey", self.ca / "ca.key.pem",
                             "-set_serial", "0x55", "-days", "365")
        (self.talker / "cert.pem").write_text(first)
        event, = self.once("--hook", self.signing_hook("-days", "400", "-in", request), *self.LATER)
        self.assertEqual(event["event"], "renewed")
        told = self.openssl("x509", "-in", self.talker / "cert.pem", "-noout", "-subject", "-nameopt", "multiline,show_type")
        self.assertIn("PRINTABLESTRING:talker", told)
        self.run_program("doctor", "demo/talker", "--now", "+301d")

    def est_hook(self, server, options=""):
        """The line of docs/agent.md."""
        line, = re.findall(r"(?m)^\| EST \(RFC 7030\) \| `(.*)` \|$", PAGE.read_text())
        return self.hook(f"URL={server.url}\n" + line.replace(r"\|", "|").replace("curl -sf", "curl -sf" + options))

    @unittest.skipUnless(shutil.which("curl"), "there is no curl")
    def test_the_page_s_line_for_est_renews(self):
        server = EstServer(self.at, self.ca)
        self.addCleanup(server.close)
        key = self.public_key()
        server.refuses = True
        self.refused("hook_failed", "--hook", self.est_hook(server), *self.LATER)
        server.refuses = False
        event, = self.once("--hook", self.est_hook(server), *self.LATER)
        self.assertEqual((event["event"], self.public_key(), len(server.subjects)), ("renewed", key, 1))
        self.run_program("doctor", "demo/talker", "--now", "+301d")

    @unittest.skipUnless(shutil.which("curl"), "there is no curl")
    def test_an_est_server_that_asks_for_a_certificate(self):
        server = EstServer(self.at, self.ca, has_tls=True)
        self.addCleanup(server.close)
        trust = f" --cacert {server.certificate}"
        self.refused("hook_failed", "--hook", self.est_hook(server, trust), *self.LATER)
        options, = re.findall(r"add `(--cert .*? --key .*?)`", PAGE.read_text().replace("\n", " "))
        self.once("--hook", self.est_hook(server, f"{trust} {options}"), *self.LATER)
        self.assertEqual(server.subjects, [((("commonName", "talker"),),)])

    def test_another_key(self):
        request = self.at / "other.csr"
        self.openssl("req", "-new", "-key", self.at / "demo/listener/key.pem", "-subj", "/CN=talker", "-out", request)
        self.refused("key_mismatch", "--hook", self.signing_hook("-days", "400", "-in", str(request)), *self.LATER)

    def test_a_certificate_of_a_ca(self):
        (self.at / "ext").write_text("basicConstraints=critical,CA:TRUE\n")
        self.refused("renewal_unfit", "--hook", self.signing_hook("-days", "400", "-extfile", f"{self.at}/ext"), *self.LATER)

    def test_folder_that_changes_while_a_hook_runs_keeps_its_files(self):
        """A certificate for the former key would stand beside the next key, and the participant would not start."""
        again = f"cp {self.talker}/cert.pem {self.at}/c && mv {self.at}/c {self.talker}/cert.pem"
        self.refused("files_changed", "--hook", self.signing_hook(before=again), *self.LATER)
        shutil.copytree(self.talker, self.at / "former")
        self.run_program("identity", "issue", "talker", "--ca", "demo", "-o", "demo/talker", "--replace", "--publish", "x",
                         "--days", "900")
        self.talker.rename(self.at / "next")
        (self.at / "former").rename(self.talker)
        change = f"cp {self.at}/next/key.pem {self.at}/next/cert.pem {self.talker}/"
        event, = self.once("--hook", self.signing_hook(before=change), *self.LATER, exit=1)
        self.assertEqual(event["code"], "files_changed")
        for name in ("key.pem", "cert.pem"):
            self.assertEqual((self.talker / name).read_bytes(), (self.at / "next" / name).read_bytes())
        self.assertEqual(self.once("--hook", self.signing_hook(), *self.LATER)[0]["event"], "current")

    def test_another_issuer(self):
        self.run_program("ca", "create", "other", "--role", "identity", "--no-passphrase")
        self.ca = self.at / "other"
        event = self.refused("issuer_unknown", "--hook", self.signing_hook(), *self.LATER)
        self.assertIn("about the certificate that the CA or the hook answered", event["message"])

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


if __name__ == "__main__":
    main()

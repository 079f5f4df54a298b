#!/usr/bin/env python3
"""What all commands have in common in what they say: dry runs, colour, quiet, terminals."""

import json
import os
import pty
import subprocess

from transcript import NOW, PROGRAM, Transcript, main


class Output(Transcript):
    def test_a_dry_run_checks_everything_and_writes_nothing(self):
        made = (("init", "demo"), ("ca", "create", "ca", "--no-passphrase"),
                ("governance", "new", "-o", "governance.xml"),
                ("init", "keystore", "--layout", "sros2"))
        for words in made:
            before = self.files()
            done = self.run_program(*words, "--dry-run", *NOW)
            self.assertEqual(self.files(), before)
            told = dict(reversed(line.split()[2:4]) for line in done.stdout.splitlines()[1:])
            out = json.loads(self.run_program(*words, "--dry-run", "--format", "json", *NOW).stdout)
            self.assertTrue(out["dry_run"])
            self.run_program(*words, *NOW)
            modes = {f: f"{m:04o}" for f, m in self.files().items() if f not in before}
            links = {f for f in modes if (self.at / f).is_symlink()}
            self.assertEqual(told, {f: "link" if f in links else m for f, m in modes.items()})

    def test_a_dry_run_of_changes(self):
        self.run_program("init", "demo", *NOW)
        content = {f: (self.at / f).read_bytes() for f in self.files()}
        for words in (("identity", "renew", "demo/talker", "--ca", "demo", "--rekey", "--permissions",
                       "--days", "400"),
                      ("identity", "revoke", "demo/talker", "--ca", "demo"),
                      ("crl", "new", "--ca", "demo"), ("crl", "distribute", "--ca", "demo"),
                      ("ca", "renew", "demo")):
            done = self.run_program(*words, "--dry-run", *NOW)
            self.assertIn("would write ", done.stdout)
            self.assertEqual({f: (self.at / f).read_bytes() for f in self.files()}, content)
        self.refused("would_overwrite", 4, "init", "demo", "--dry-run")

    def test_colour_only_where_it_is_wanted(self):
        wrong = ("ca", "show", "nothing")
        self.assertNotIn("\033", self.run_program(*wrong, exit=3).stderr)
        always = self.run_program(*wrong, "--color", "always", exit=3).stderr
        self.assertTrue(always.startswith("\033[1;31merror[file_not_found]:\033[0m "), always)
        self.refused("usage", 2, *wrong, "--color", "blue")
        color = {"TERM": "xterm", "NO_COLOR": ""}
        self.assertIn("\033[1;31m", self.on_terminal(*wrong, environment=color))
        for environment in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
            self.assertNotIn("\033", self.on_terminal(*wrong, environment={**color, **environment}))
        self.assertNotIn("\033", self.on_terminal(*wrong, "--color", "never", environment=color))

    def on_terminal(self, *words, environment):
        """What a person sees whose terminal is standard output and standard error."""
        ours, theirs = pty.openpty()
        done = subprocess.Popen([PROGRAM, *words], cwd=self.at, stdin=subprocess.DEVNULL,
                                stdout=theirs, stderr=theirs, env={**os.environ, **environment})
        done.wait(timeout=60)
        os.close(theirs)
        seen = b""
        while True:
            try:
                octets = os.read(ours, 65536)
            except OSError:  # the other side is closed
                break
            if not octets:
                break
            seen += octets
        os.close(ours)
        return seen.decode("utf-8", "replace")

    def test_a_terminal_without_utf_8_gets_no_octets_that_it_cannot_show(self):
        words = ("ca", "create", "straße", "--no-passphrase", "--dry-run")
        plain = self.on_terminal(*words, environment={"LC_ALL": "C"})
        self.assertIn(r"stra\xc3\x9fe/identity/ca.pem", plain)
        self.assertTrue(plain.isascii())
        self.assertIn("straße", self.on_terminal(*words, environment={"LC_ALL": "C.UTF-8"}))
        self.assertIn("straße", self.run_program(*words, environment={"LC_ALL": "C"}).stdout)

    def test_no_control_sequence_of_a_name_reaches_a_terminal(self):
        seen = self.on_terminal("ca", "create", "a\033[31m", "--no-passphrase", "--dry-run",
                                environment={"LC_ALL": "C.UTF-8"})
        self.assertIn("a?[31m/identity/ca.pem", seen)
        self.assertNotIn("\033", seen)

    def test_names_of_documents_neither_command_nor_reorder_a_terminal(self):
        self.run_program("init", "demo", *NOW)
        evil = "rt/\u009b2J\u202eneve\u2066\u200fx"
        for kind, find, put in (("permissions", "<topic>*</topic>", f"<topic>{evil}</topic>"),
                                ("governance", "<topic_expression>*<", f"<topic_expression>{evil}<")):
            source = self.at / ("demo/governance.xml" if kind == "governance" else "p.xml")
            if kind == "permissions":
                self.run_program("permissions", "new", "-o", "p.xml", "--cert", "demo/talker/cert.pem",
                                 "--publish", "*", *NOW)
            text = source.read_text()
            self.assertIn(find, text)
            (self.at / "evil.xml").write_text(text.replace(find, put))
            for words in (("show",), ("lint",)):
                seen = self.on_terminal(kind, *words, "evil.xml", environment={"LC_ALL": "C.UTF-8"})
                logged = self.run_program(kind, *words, "evil.xml", *NOW)
                for shown in (seen, logged.stdout + logged.stderr):
                    self.assertIn(r"rt/\u009b2J\u202eneve\u2066\u200fx", shown)
                    self.assertEqual([c for c in shown if c in "\u009b\u202e\u2066\u200f"], [])
            told = self.json(kind, "lint", "evil.xml", *NOW)["diagnostics"]
            wanted = "PERM041" if kind == "permissions" else "DOC097"
            self.assertEqual([d["severity"] for d in told if d["id"] == wanted], ["warning"])
            self.assertIn("U+009B", next(d["message"] for d in told if d["id"] == wanted))

    def test_json_on_a_terminal_is_ascii_and_means_the_same(self):
        for locale in ("C", "C.UTF-8"):
            seen = self.on_terminal("ca", "create", "stra\u00dfe\u202e\u009b", "--no-passphrase", "--dry-run",
                                    "--format", "json", environment={"LC_ALL": locale})
            self.assertTrue(seen.isascii())
            self.assertEqual(json.loads(seen)["result"]["dir"], "stra\u00dfe\u202e\u009b")

    def test_octets_that_are_not_utf_8_are_escaped(self):
        wrong = ("ca", "show", b"a\x9b31m\xff")
        seen = self.on_terminal(*wrong, "--color", "never", environment={"LC_ALL": "C.UTF-8"})
        self.assertIn(r"a\x9b31m\xff", seen)
        self.assertNotIn("\ufffd", seen)
        out = subprocess.run([PROGRAM, *wrong, "--format", "json"], cwd=self.at, capture_output=True, timeout=60,
                             check=False)
        self.assertTrue(json.loads(out.stdout)["diagnostics"][0]["file"].startswith("a\ufffd31m\ufffd"))

    def test_what_is_wrong_with_a_command_line_is_said_plainly(self):
        self.assertIn("missing argument B", self.refused("usage", 2, "check", "a")["message"])
        told = self.refused("usage", 2, "check", "--foo", "a", "b")["message"]
        self.assertIn('"--foo" is unknown here', told)
        self.assertNotIn("did you mean", told)
        self.assertEqual(self.run_program("-V").stdout, self.run_program("--version").stdout)
        self.run_program("init", "demo", *NOW)
        for value in ("abc", "300", "08", "-1"):
            told = self.refused("usage", 2, "doctor", "demo/talker", "--ros", environment={"ROS_DOMAIN_ID": value})
            self.assertIn("the environment variable ROS_DOMAIN_ID: ", told["message"])
            self.assertIn(f'found "{value}"', told["message"])

    def test_words_of_a_choice_count_in_any_letter_case(self):
        self.run_program("init", "demo", "--profile", "Open", "--layout", "FLAT", *NOW)
        self.assertEqual(json.loads(self.run_program("init", "other", "--format", "JSON", *NOW).stdout)["exit"], 0)
        self.assertEqual(json.loads(self.run_program("doctor", "none", "--format=Json", exit=3).stdout)["exit"], 3)
        self.assertEqual(json.loads(self.run_program("ca", "frobnicate", "--format", "JSON", exit=2).stdout)["exit"], 2)
        for words in (("ca", "show", "demo", "--role", "Permissions"), ("identity", "csr", "x", "-o", "x", "--key", "RSA2048"),
                      ("check", "demo/talker", "demo/listener", "--vendor", "A=CycloneDDS", "--require", "writer=a"),
                      ("doctor", "demo/talker", "--vendor", "FastDDS@2.9.1", "--color", "NEVER"),
                      ("can", "demo/talker", "PUBLISH", "x"), ("completion", "Bash"), ("explain", "doc086"),
                      ("governance", "diff", "demo/governance.xml", "other/governance.xml", "--fail-on", "Breaking"),
                      ("identity", "revoke", "demo/talker", "--ca", "demo", "--reason", "KEYCOMPROMISE", "--dry-run")):
            self.run_program(*words, *NOW, exit=None)
        told = self.refused("usage", 2, "init", "third", "--profile", "stict")["message"]
        self.assertIn("expected open, balanced or strict", told)

    def test_quiet_and_verbose(self):
        done = self.run_program("ca", "create", "ca", "--no-passphrase", "-v")
        self.assertEqual(len(done.stderr.splitlines()), 5)
        self.assertRegex(done.stderr, r"(?m)^wrote 0600 ca/identity/ca.key.pem  [0-9a-f]{64}$")
        for words in (("ca", "create", "cb", "--no-passphrase"), ("init", "demo"),
                      ("identity", "issue", "x", "--ca", "demo", "-o", "x"), ("crl", "new", "--ca", "demo")):
            done = self.run_program(*words, "-q")
            self.assertEqual((done.stdout, done.stderr), ("", ""), words)
        self.assertIn("CN=talker", self.run_program("identity", "show", "demo/talker", "-q").stdout)
        self.assertIn("would write", self.run_program("init", "other", "-q", "--dry-run").stdout)
        self.assertIn("hint:", self.run_program("init", "demo", "-q", exit=4).stderr)
        self.refused("usage", 2, "ca", "show", "ca/identity", "-q", "-v")
        self.assertIn("error[", self.run_program("ca", "show", "nothing", "-q", exit=3).stderr)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""What every command has in common: help, usage errors, codes, times."""

import json
import shlex
import shutil
import subprocess

from transcript import DATA, PROGRAM, Transcript, main


class Contract(Transcript):
    def commands(self):
        rows = self.run_program("--help").stdout.splitlines()
        return [row[2:30].strip() for row in rows if row.startswith("  ")]

    def test_help_lists_every_command_and_each_explains_itself(self):
        self.assertIn("ca create", self.commands())
        for name in self.commands():
            text = self.run_program(*name.split(), "--help").stdout
            self.assertIn(f"usage: ddssec {name}", text)
            self.assertIn("--format FORM", text)
            self.assertIn(f"ddssec {name} ", text.split("\nexamples\n")[1])

    def test_help_shows_commands_in_sections(self):
        sections = self.run_program("--help").stdout.split("\n\n")[1:-1]
        titles = [section.splitlines()[0] for section in sections]
        self.assertEqual(len(titles), 10)
        self.assertFalse([title for title in titles if title.startswith(" ")])
        self.assertEqual([row.split()[0] for row in sections[0].splitlines()[1:]], ["init"])
        # Each command stands in exactly one: the manual page has them all.
        man = self.run_program("man").stdout.replace("\\-", "-")
        known = [line.removeprefix(".SS ddssec ") for line in man.splitlines() if line.startswith(".SS ")]
        self.assertEqual(len(self.commands()), len(known))
        for name in self.commands():
            self.assertTrue(any(line.startswith(name + " ") for line in known), name)

    def test_help_on_a_group_lists_its_commands(self):
        text = self.run_program("ca", "--help").stdout
        self.assertIn("ca show", text)
        self.assertNotIn("identity issue", text)

    def test_wrong_words_are_usage_errors_with_a_guess(self):
        self.assertIn("no command", self.refused("usage", 2)["message"])
        self.assertIn('did you mean "identity"?', self.refused("usage", 2, "identiti")["message"])
        self.assertIn('did you mean "show"?', self.refused("usage", 2, "ca", "shw")["message"])
        self.assertIn("needs a second word", self.refused("usage", 2, "ca")["message"])
        self.assertIn('did you mean "--days"?',
                      self.refused("usage", 2, "ca", "create", "x", "--dais", "3")["message"])

    def test_words_in_another_order_or_of_other_tools_lead_to_the_command(self):
        for words, meant in ((("create", "ca"), '"ca create"'), (("new", "governance"), '"governance new"'),
                             (("sign",), '"governance sign" or "permissions sign"'),
                             (("verify",), '"crl verify", "governance verify", "permissions verify" or "keystore verify"'),
                             (("issue", "identity"), '"identity issue"'), (("revoke", "x"), '"identity revoke"'),
                             (("lint", "g.xml"), '"governance lint" or "permissions lint"'),
                             (("ca", "new"), '"create"'), (("governance", "create"), '"new"'),
                             (("permissions", "validate"), '"verify"'),
                             (("keystore", "renew", "ks"), '"identity renew"')):
            self.assertIn(f"did you mean {meant}?", self.refused("usage", 2, *words)["message"])
        self.assertNotIn("did you mean", self.refused("usage", 2, "frobnicate")["message"])
        self.assertIn("needs a second word: create, import,", self.refused("usage", 2, "ca")["message"])

    def test_options_of_other_tools_lead_to_ours(self):
        for words, meant in ((("init", "x", "-d", "3"), '"--domain", "--days", "--dropin" or "--dry-run"'),
                             (("check", "a", "b", "--json"), '"--format json"'),
                             (("check", "a", "b", "--topic", "t"), '"--topics"'),
                             (("governance", "show", "a", "--topics", "t"), '"--topic"'),
                             (("permissions", "new", "--topic", "t"), '"--publish" or "--subscribe"'),
                             (("ca", "create", "x", "--password", "y"), '"--passphrase-file" or "--passphrase-env"')):
            self.assertIn(f"did you mean {meant}?", self.refused("usage", 2, *words)["message"])

    def test_all_that_is_missing_is_said_at_once_with_an_example(self):
        told = self.refused("usage", 2, "identity", "issue")["message"]
        self.assertIn("missing arguments --ca DIR, -o DIR and NAME (or --from FILE); for example: ddssec identity issue talker --ca ca", told)
        told = self.refused("usage", 2, "governance", "new", "out.xml")["message"]
        self.assertIn('missing argument -o FILE; "out.xml" is one argument too many; for example: ddssec', told)
        told = self.refused("usage", 2, "permissions", "sign", "foo.xml")["message"]
        self.assertIn("missing argument --ca", told)
        self.assertIn('"c" is one argument too many', self.refused("usage", 2, "check", "a", "b", "c")["message"])

    def test_an_option_is_not_taken_for_the_value_of_another(self):
        told = self.refused("usage", 2, "permissions", "new", "--cert", "c", "--publish", "-o", "p.xml")["message"]
        self.assertIn('no value follows "--publish": "-o" is an option; if it is meant as the value, write --publish=-o',
                      told)
        self.refused("file_not_found", 3, "permissions", "new", "--cert", "c", "--publish=-o", "-op.xml")

    def test_help_is_a_word_too(self):
        for words in ((), ("ca",), ("ca", "create"), ("check",)):
            self.assertEqual(self.run_program("help", *words).stdout, self.run_program(*words, "--help").stdout)
        self.assertIn('did you mean "check"?', self.refused("usage", 2, "help", "chek")["message"])

    def test_the_hint_names_the_command_whose_help_says_more(self):
        for words, named in ((("check", "a"), "check"), (("ca", "create", "x", "--dais", "3"), "ca create"),
                             (("expiry", "--within", "soon"), "expiry"), (("ca",), "ca"), (("ca", "shw"), "ca")):
            self.assertEqual(self.refused("usage", 2, *words)["hint"], f"ddssec {named} --help says more")
        self.assertIn("ddssec --help lists", self.refused("usage", 2, "chek")["hint"])

    def test_what_cannot_be_written_is_a_failure(self):
        for words in (("--help",), ("ca", "create", "--help"), ("version",)):
            with open("/dev/full", "w", encoding="utf-8") as full:
                done = subprocess.run([PROGRAM, *words], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
            self.assertEqual(done.returncode, 5, words)
            self.assertRegex(done.stderr, r"error\[file_unwritable\]: .*No space left[^$]*standard output")

    def test_missing_twofold_and_superfluous_arguments_are_usage_errors(self):
        self.refused("usage", 2, "ca", "show")
        self.refused("usage", 2, "explain", "usage", "more")
        self.refused("usage", 2, "ca", "create", "x", "--days", "3", "--days", "4")
        self.refused("usage", 2, "identity", "issue", "x", "-o", "y")

    def test_nothing_behind_the_equals_sign_takes_no_other_word(self):
        for words in (("ca", "create", "x", "--days=", "--no-passphrase"),
                      ("can", "x", "publish", "y", "--partition=", "z"), ("expiry", "--within=")):
            told = self.refused("usage", 2, *words)["message"]
            self.assertIn("an empty value is written --", told)
        self.refused("file_not_found", 3, "can", "x", "publish", "y", "--partition", "")

    def test_options_of_every_command_may_come_first(self):
        out = self.run_program("--format", "json", "-q", "--now=2026-11-21T00:00:00Z", "version").stdout
        self.assertEqual(json.loads(out)["result"]["schema"], "ddssec/2")
        self.assertEqual(self.run_program("--version").stdout, self.run_program("version").stdout)
        self.assertEqual(self.run_program("-h").stdout, self.run_program("--help").stdout)
        self.assertEqual(self.run_program("-q", "ca", "--help").stdout,
                         self.run_program("ca", "--help").stdout)
        self.refused("usage", 2, "--format")
        self.refused("usage", 2, "--quiet")
        self.refused("usage", 2, "--days", "3", "ca", "create", "x")

    def test_times_and_formats_must_be_exact(self):
        self.refused("usage", 2, "explain", "usage", "--now", "tomorrow")
        done = self.run_program("explain", "usage", "--format", "yaml", exit=2)
        self.assertIn("expected text or json, found yaml", done.stderr)

    def test_explain_knows_codes_by_name_and_number(self):
        by_name = self.json("explain", "no_grant_for_subject")["result"]
        self.assertEqual(by_name, self.json("explain", "1242")["result"])
        self.assertEqual(by_name["number"], 1242)
        self.assertIn("write the subject name exactly", self.run_program("explain", "1242").stdout)
        self.refused("usage", 2, "explain", "99999")
        for spelling in ("error[no_grant_for_subject]:", "[1242]", "NO_GRANT_FOR_SUBJECT"):
            self.assertEqual(self.json("explain", spelling)["result"], by_name)
        self.assertEqual(self.json("explain", "doc080")["result"], self.json("explain", "DOC080")["result"])

    def test_explain_names_every_severity_of_a_rule(self):
        """transcript.py holds every finding of every test against it."""
        self.assertTrue(self.run_program("explain", "DOC083").stdout.startswith(
            "DOC083 (error; note where --vendor does not name the products)\n"))
        told = self.json("explain", "DOC083")["result"]
        self.assertEqual((told["severity"], [one["severity"] for one in told["other_severities"]]), ("error", ["note"]))
        self.assertTrue(self.run_program("explain", "DOC089").stdout.startswith("DOC089 (warning)\n"))

    def test_explain_knows_the_verdicts_as_the_readme_has_them(self):
        readme = (DATA.parent.parent / "cli/README.md").read_text()
        for word in ("ok", "unsafe", "late", "fail"):
            told = self.json("explain", word)["result"]
            self.assertIn(f"| `{word}` | {told['meaning']} |", readme)
            self.assertEqual(self.json("explain", word.upper())["result"], told)
        self.assertIn("late (a verdict of doctor and keystore verify)", self.run_program("explain", "late").stdout)

    def test_explain_helps_with_a_part_of_a_name_or_number(self):
        told = self.json("explain", "124")["result"]["matches"]
        self.assertEqual({m["number"] // 10 for m in told}, {124})
        self.assertIn("no_grant_for_subject", [m["name"] for m in told])
        self.assertIn("no_grant_for_subject             1242 ", self.run_program("explain", "124").stdout)
        self.assertIn("DOC080", [m["name"] for m in self.json("explain", "doc08")["result"]["matches"]])
        self.assertEqual(self.json("explain", "grant_for")["result"]["name"], "no_grant_for_subject")
        for nothing in ("99999", "DOC999", "x"):
            self.assertIn("or a part of one", self.refused("usage", 2, "explain", nothing)["message"])

    def test_explain_has_examples_whose_commands_and_options_exist(self):
        names = [m["name"] for part in ("DOC", "GOV", "PERM", "CAP") for m in self.json("explain", part)["result"]["matches"]]
        names += [m["name"] for digit in range(10, 19) for m in self.json("explain", str(digit))["result"]["matches"]]
        lines = set()
        for name in names:
            told = self.json("explain", name)["result"]
            self.assertEqual(told["name"], name)
            lines.update(told["examples"])
        self.assertGreater(len(lines), 40)
        for line in lines:
            if not line.startswith("ddssec "):
                continue
            words = shlex.split(line)[1:]
            text = self.run_program(*words[:2 if " ".join(words[:2]) in self.commands() else 1], "--help").stdout
            self.assertTrue(text.startswith("usage: ddssec "), line)
            for option in (w for w in words if w.startswith("-") and w != "--help"):
                self.assertRegex(text, rf"(?m)^  (-\w, )?{option} ?", line)
        self.assertIn("for example:  ddssec identity show", self.run_program("explain", "DOC080").stdout)

    def test_what_explain_proposes_for_a_refused_topic_works_as_it_stands(self):
        for action, code in (("publish", "1421"), ("subscribe", "1422")):
            shutil.rmtree(self.at / "demo", ignore_errors=True)
            self.run_program("init", "demo", "--allow-topics", "Square")
            ask = ("can", "demo/talker", action, "rt/chatter", "--partition", "p")
            self.json(*ask, exit=1)
            line = next(e for e in self.json("explain", code)["result"]["examples"] if "permissions new" in e)
            self.run_program(*shlex.split(line, comments=True)[1:])
            self.json(*ask)

    def test_the_hint_of_a_refused_topic_keeps_the_other_topics(self):
        told = self.json("explain", "DOC086")["result"]
        self.assertIn("with all topics of the participant", told["hint"])
        for example in told["examples"]:
            if "permissions new" in example:
                self.assertIn("name all of its topics", example)
        self.assertTrue(any(e.startswith("ddssec permissions show") for e in told["examples"]))

    def test_no_control_sequence_reaches_the_terminal(self):
        self.assertIn('"??[31m"', self.refused("usage", 2, "explain", "\n\x1b[31m")["message"])


if __name__ == "__main__":
    main()

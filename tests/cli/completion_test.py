#!/usr/bin/env python3
"""completion and man: every command and option of the help is in all of them."""

import re
import subprocess

from transcript import Transcript, main


class Completion(Transcript):
    def commands(self):
        rows = self.run_program("--help").stdout.splitlines()
        return [re.split(r"  +", row.strip())[0] for row in rows if row.startswith("  ")]

    def options(self, command):
        text = self.run_program(*command.split(), "--help").stdout.split("\nexit:")[0]
        return re.findall(r"(?m)^  (?:-\w, )?(--?[a-z0-9-]+)", text)

    def test_every_command_and_option_is_in_all_of_them(self):
        pages = {shell: self.run_program("completion", shell).stdout for shell in ("bash", "zsh", "fish")}
        man = self.run_program("man").stdout.replace("\\-", "-")
        self.assertGreater(len(self.commands()), 20)
        for command in self.commands():
            bash, zsh = (re.search(rf"'{command}'\*?\) (.*) ;;", pages[shell]).group(1)
                         for shell in ("bash", "zsh"))
            last = command.split()[-1]
            fish = "\n".join(re.findall(rf"__fish_seen_subcommand_from {last}'.*", pages["fish"]))
            section = man.split(f".SS ddssec {command} ")[1].split(".SS")[0]
            shared = man.split(".SH COMMANDS")[0]
            for option in self.options(command):
                self.assertIn(option, re.split(r"[ ']", bash), command)
                self.assertIn(f"'{option}:", zsh, command)
                self.assertIn(f" -l {option[2:]} " if option.startswith("--") else f" -s {option[1:]} ",
                              fish, command)
                self.assertTrue(f"{option}\\fR" in section or f"{option}\\fR" in shared, (command, option))

    def completed(self, *words):
        script = self.run_program("completion", "bash").stdout
        script += f"COMP_WORDS=({' '.join(repr(w) for w in words)}); COMP_CWORD={len(words) - 1}; _ddssec\n"
        script += 'printf "%s\\n" "${COMPREPLY[@]}"\n'
        return subprocess.run(["bash", "-c", script], text=True, capture_output=True, check=True,
                              timeout=60).stdout.split()

    def test_bash_completes(self):
        self.assertEqual(self.completed("ddssec", "iden"), ["identity"])
        self.assertEqual(self.completed("ddssec", "identity", "re"), ["renew", "revoke"])
        self.assertEqual(self.completed("ddssec", "identity", "issue", "--pub"), ["--publish"])
        self.assertEqual(self.completed("ddssec", "init", "demo", "--lay"), ["--layout"])
        self.assertEqual(self.completed("ddssec", "ca", "show", "x"), [])

    def test_bash_completes_values(self):
        self.assertEqual(self.completed("ddssec", "init", "demo", "--layout", ""), ["flat", "sros2"])
        self.assertEqual(self.completed("ddssec", "identity", "issue", "x", "--key", "rsa"), ["rsa2048", "rsa3072"])
        self.assertEqual(self.completed("ddssec", "ca", "import", "--key", ""), [])  # a file
        self.assertEqual(self.completed("ddssec", "completion", ""), ["bash", "zsh", "fish"])
        self.assertEqual(self.completed("ddssec", "can", "demo/talker", "p"), ["publish"])
        self.assertEqual(self.completed("ddssec", "explain", "DOC08")[:2], ["DOC080", "DOC081"])
        self.assertEqual(self.completed("ddssec", "explain", "no_grant"), ["no_grant_for_subject"])

    def test_each_value_that_is_offered_is_taken(self):
        for option, values, words in (
                ("--key", "p256 rsa2048 rsa3072", ("identity", "csr", "x", "-o", "x", "--dry-run")),
                ("--profile", "open balanced strict", ("governance", "new", "-o", "x", "--dry-run")),
                ("--layout", "flat sros2", ("init", "x", "--dry-run")),
                ("--role", "identity permissions both", ("ca", "create", "x", "--no-passphrase", "--dry-run")),
                ("--pre-shared-key", "NONE SIGN ENCRYPT", ("governance", "new", "-o", "x", "--dry-run"))):
            self.assertIn(f"words='{values}'", self.run_program("completion", "bash").stdout)
            for value in values.split():
                self.run_program(*words, option, value)

    def test_each_shell_can_read_its_page(self):
        for shell in ("bash", "zsh", "fish"):
            (self.at / shell).write_text(self.run_program("completion", shell).stdout)
            subprocess.run([shell, "-n", shell], cwd=self.at, check=True, timeout=60)
        self.refused("usage", 2, "completion", "csh")


if __name__ == "__main__":
    main()

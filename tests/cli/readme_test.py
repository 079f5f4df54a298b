#!/usr/bin/env python3
"""cli/README.md begins with what a user looks up: each command is in its first table or named there with its group."""

import re

from transcript import DATA, Transcript, main

PAGE = DATA.parent.parent / "cli/README.md"


class Readme(Transcript):
    def commands(self):
        lines = self.run_program("--help").stdout.splitlines()
        return [line[2:30].strip() for line in lines if re.match(r"  [a-z]", line)]

    def test_every_command_is_in_the_users_part(self):
        users_part = PAGE.read_text().split("\n## ")[0]
        commands = self.commands()
        self.assertGreater(len(commands), 40)
        missing = [c for c in commands if c.split()[-1] not in re.findall(r"[a-z-]+", users_part)]
        self.assertEqual(missing, [])

    def test_its_commands_exist(self):
        groups = {c.split()[0] for c in self.commands()}
        for words in re.findall(r"`ddssec ([a-z]+)", PAGE.read_text()):
            self.assertIn(words, groups)


if __name__ == "__main__":
    main()

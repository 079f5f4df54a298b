#!/usr/bin/env python3
"""cli/README.md begins with what a user looks up: its first table has each command, with its group.

A row may name the group once: "`ddssec governance new`, `lint`" has both commands of that group.
"""

import re

from transcript import DATA, Transcript, main

PAGE = DATA.parent.parent / "cli/README.md"


def named(text, commands):
    """The commands that the code spans of a text name."""
    found = set()
    for line in text.splitlines():
        group = None
        for span in re.findall(r"`([^`]+)`", line):
            words = span.removeprefix("ddssec ").split()
            choices = [" ".join(words[:2]), words[0], f"{group} {words[0]}"]
            command = next((choice for choice in choices if choice in commands), None)
            if command:
                found.add(command)
                group = command.split()[0]
    return found


class Readme(Transcript):
    def commands(self):
        lines = self.run_program("--help").stdout.splitlines()
        return [line[2:30].strip() for line in lines if re.match(r"  [a-z]", line)]

    def test_every_command_is_in_the_users_part(self):
        users_part = PAGE.read_text().split("\n## ")[0]
        commands = self.commands()
        self.assertGreater(len(commands), 40)
        found = named(users_part, commands)
        self.assertEqual([c for c in commands if c not in found], [])

    def test_command_of_another_group_does_not_count(self):
        commands = ["identity show", "governance show", "governance new", "doctor"]
        self.assertEqual(named("| `ddssec identity show` |\n| `show` |", commands), {"identity show"})
        self.assertEqual(named("| `ddssec governance new`, `show` |", commands), {"governance new", "governance show"})
        self.assertEqual(named("| `ddssec doctor --ros`, `show` |", commands), {"doctor"})

    def test_its_commands_exist(self):
        groups = {c.split()[0] for c in self.commands()}
        for words in re.findall(r"`ddssec ([a-z]+)", PAGE.read_text()):
            self.assertIn(words, groups)


if __name__ == "__main__":
    main()

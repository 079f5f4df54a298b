#!/usr/bin/env python3
"""Holds scripts/commit-msg.sh to a table of messages and to a history of three commits, then asks it about the newest.

Exit 1 and a line for each fault.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

# Each gets the line TESTED, unless it has one or begins with "fixup!".
GOOD = [
    "pki: read delta lists\n\nA list without them is out of date.\n",
    "rtps, wire: read delta lists\n\nWhy.\n\n# A comment of git.\n",
    "rtps/security, access_control: read delta lists\n\nThe path and the name of a folder.\n",
    "all: read delta lists\n\nThe whole tree.\n",
    "tests/unit/pki, lint: read delta lists\n\nA deep path, and the name of a folder of the second level.\n",
    "fixup! pki: read delta lists\n",
    "pki: read delta lists\n\nWhy.\n\nTested: test_pki, and\ntest_governance.\n",
    "pki: read delta lists\n\nWhy.\nTested: test_pki.\n# ------------------------ >8 ------------------------\ndiff --git a/a b/a\n",
]
BAD = [
    "",
    "read delta lists\n\nThe area is missing.\n",
    "pkii: read delta lists\n\nThe area is no folder.\n",
    "pki, lists: read delta lists\n\nThe second area is no folder.\n",
    "security/tls: read delta lists\n\nThe area is no folder.\n",
    "pki: read delta lists.\n\nThe subject ends with a full stop.\n",
    "pki: " + "x" * 68 + "\n\nThe subject has 73 columns.\n",
    "pki: read delta lists\nThe second line is not empty.\n",
    "pki: read delta lists\n",
    "pki: read delta lists\n\n  \n# Only a comment of git.\n",
    "pki: read delta lists\n\n# ------------------------ >8 ------------------------\ndiff --git a/a b/a\n",
    "wycheproof: read delta lists\n\nThe folder is too deep for its name alone.\n",
    "data: read delta lists\n\nA part of paths, and no area.\n",
    "unit/pki: read delta lists\n\nThe path does not begin at the root.\n",
]
UNTESTED = [
    "pki: read delta lists\n\nWhy.\n",
    "pki: read delta lists\n\nWhy.\n\nTested: \n",
    "pki: read delta lists\n\nWhy, and it was Tested: by hand.\n",
    "pki: read delta lists\n\nWhy.\n\n# Tested: test_pki.\n",
    "pki: read delta lists\n\nWhy.\n\nTested: all programs,\nwith the whole series.\n",
    "pki: read delta lists\n\nWhy.\n\nTested: PENDING\n",
    "pki: read delta lists\n\nWhy.\n\nTested: the tools were not built.\n",
    "pki: read delta lists\n\nWhy.\n\nTested: test_pki, with the libraries of the commit before.\n",
    "pki: read delta lists\n\nWhy.\n\nTested: test_pki, on the joined branch.\n",
]
TESTED = "\nTested: test_pki.\n"


OPTIONS = ["user.name=Test", "user.email=test@example.org", "core.hooksPath=/dev/null", "commit.gpgSign=false"]


def tested(message):
    return message if message.startswith("fixup!") or "Tested:" in message else message + TESTED


def accepts(script, message, *commit):
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
        file.write(message)
        file.flush()
        run = subprocess.run([script, file.name, *commit], capture_output=True, text=True, check=False)
        return run.returncode == 0, run.stderr.strip()


def newest_commit(root):
    """The hash and the message of the newest commit that joins no others, or nothing outside a repository."""
    run = subprocess.run(["git", "-C", root, "log", "-1", "--no-merges", "--format=%H%n%B"], capture_output=True, text=True,
                         check=False)
    return run.stdout.split("\n", 1) if run.returncode == 0 else None


class History:
    """A repository with a copy of the script, in which each commit is made with a number of new files."""

    def __init__(self, folder, script):
        self.root = folder
        self.script = folder / "scripts/commit-msg.sh"
        self.script.parent.mkdir()
        shutil.copy(script, self.script)
        (folder / "scripts/hooks").mkdir()
        (folder / "scripts/hooks/commit-msg").symlink_to("../commit-msg.sh")
        self.git("init", "--quiet")

    def git(self, *words):
        options = [word for option in OPTIONS for word in ("-c", option)]
        subprocess.run(["git", "-C", self.root, *options, *words], check=True)

    def stage(self, prefix, files):
        (self.root / "pki").mkdir(exist_ok=True)
        for number in range(files):
            (self.root / f"pki/{prefix}{number}.txt").write_text("new\n", encoding="utf-8")
        self.git("add", "--all")

    def commit(self, message, files=1):
        self.stage(message.split()[1], files)
        self.git("commit", "--quiet", "--message", message)


def history_faults(script):
    """What the script says of bodies that come again, of short bodies, and as a hook."""
    with tempfile.TemporaryDirectory() as folder:
        history = History(pathlib.Path(folder), script)
        history.commit(tested("pki: one change\n\nSentences have a verb.\n"))
        history.commit(tested("pki: two changes\n\nLists are read in order.\n"))
        again = "pki: more changes\n\nSentences have\na verb.\n\nReviewed-by: A Person <a@example.org>\nTested: test_wire.\n"
        short = tested("pki: many changes\n\nA review named them.\n")
        amended = tested("pki: two good changes\n\nLists are read in order.\n")
        history.stage("few", 10)
        table = [(again, (), False, "a body that came before"), (amended, (), True, "the body of HEAD, as in an amendment"),
                 (short, (), True, "a short body for ten files")]
        yield from faults_of(history.script, table)
        if not accepts(history.root / "scripts/hooks/commit-msg", short)[0]:
            yield "as a hook, it does not know the folders"
        history.stage("many", 11)
        longer = short.replace("named them.", "named them. Each has its own name now, as the page of the style demands.")
        yield from faults_of(history.script, [(short, (), False, "a short body for more than ten files"),
                                              (longer, (), True, "a longer body for more than ten files")])
        history.commit(amended)
        yield from faults_of(history.script, [(amended, ("HEAD",), False, "a commit with the body of the one before")])
        said = accepts(history.script, tested("pki: read lists and keys\n\nWhy.\n"), "HEAD~1")
        if not said[0] or "warning" not in said[1]:
            yield 'there is no warning of "and" in a subject'


def faults_of(script, table):
    for message, commit, expected, what in table:
        if accepts(script, message, *commit)[0] != expected:
            yield f"{what} is {'refused' if expected else 'accepted'}: {accepts(script, message, *commit)[1]}"


def main():
    root = pathlib.Path(sys.argv[1])
    for name in [name for name in os.environ if name.startswith("GIT_")]:
        del os.environ[name]  # of a hook that runs this test: they name the repository of the hook
    script = root / "scripts/commit-msg.sh"
    found = list(history_faults(script))
    good, bad = [tested(message) for message in GOOD], [tested(message) for message in BAD]
    found += [f"{message!r} is refused: {accepts(script, message)[1]}" for message in good if not accepts(script, message)[0]]
    found += [f"{message!r} is accepted" for message in [*bad, *BAD, *UNTESTED] if accepts(script, message)[0]]
    newest = newest_commit(root)
    if newest and not accepts(script, newest[1], newest[0])[0]:
        found.append(f"the newest commit: {accepts(script, newest[1], newest[0])[1]}")
    print("\n".join(found) if found else f"{len(good)} accepted, {2 * len(bad) + len(UNTESTED)} refused")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

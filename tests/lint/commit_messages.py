#!/usr/bin/env python3
"""Holds scripts/commit-msg.sh to a table of messages, and then asks it about the newest commit.

Exit 1 and a line for each fault.
"""

import pathlib
import subprocess
import sys
import tempfile

GOOD = [
    "pki: read delta lists\n\nA list without them is out of date.\n",
    "rtps, wire: read delta lists\n\nWhy.\n\n# A comment of git.\n",
    "rtps/security, access_control: read delta lists\n\nThe path and the name of a folder.\n",
    "all: read delta lists\n\nThe whole tree.\n",
    "tests/unit/pki, lint: read delta lists\n\nA deep path, and the name of a folder of the second level.\n",
    "fixup! pki: read delta lists\n",
    "pki: read delta lists\n\nWhy.\n# ------------------------ >8 ------------------------\ndiff --git a/a b/a\n",
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


def accepts(script, message):
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
        file.write(message)
        file.flush()
        run = subprocess.run([script, file.name], capture_output=True, text=True, check=False)
        return run.returncode == 0, run.stderr.strip()


def newest_message(root):
    """That of HEAD, or None outside a repository."""
    run = subprocess.run(["git", "-C", root, "log", "-1", "--no-merges", "--format=%B"], capture_output=True, text=True, check=False)
    return run.stdout if run.returncode == 0 else None


def main():
    root = pathlib.Path(sys.argv[1])
    script = root / "scripts/commit-msg.sh"
    found = [f"{message!r} is refused: {accepts(script, message)[1]}" for message in GOOD if not accepts(script, message)[0]]
    found += [f"{message!r} is accepted" for message in BAD if accepts(script, message)[0]]
    newest = newest_message(root)
    if newest and not accepts(script, newest)[0]:
        found.append(f"the newest commit: {accepts(script, newest)[1]}")
    print("\n".join(found) if found else f"{len(GOOD)} accepted, {len(BAD)} refused")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

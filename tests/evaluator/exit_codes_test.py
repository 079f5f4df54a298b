#!/usr/bin/env python3
"""ddssec ... diff --fail-on has the evaluator's verdict, and ends with 1 exactly where that or another product's reading
asks for it.

Usage: exit_codes_test.py DDSSEC [PAIRS] [SEED]
"""

import collections
import json
import pathlib
import subprocess
import sys
import tempfile

import answers
import pairs

WORSE = {"governance": "weaker", "permissions": "wider"}


def told(program, kind, files):
    """(verdict, exit code, whether the new document allows more with a product) of the program."""
    words = [program, kind, "diff", *files, "--fail-on", WORSE[kind], "--format", "json"]
    done = subprocess.run(words, capture_output=True, timeout=60, check=False)
    result = json.loads(done.stdout)["result"]
    readings = result.get("readings", {}).get("all", [])
    return result.get("verdict"), done.returncode, any(r["widens"] and r["document"] == "new" for r in readings)


def check(program, kind, seed, number, folder):
    """(verdict, whether the program has it and ends as it must) of one pair."""
    documents = pairs.pair(kind, seed, number)
    files = [folder / f"{name}.xml" for name in ("old", "new")]
    for file, text in zip(files, documents):
        file.write_text(text, encoding="utf-8")
    verdict = answers.verdict_of(kind, *documents)
    *found, widens = told(program, kind, files)
    wanted = [verdict, 1 if widens or verdict in (WORSE[kind], "mixed") else 0]
    if found != wanted:
        print(f"{kind} pair {number} of seed {seed}: verdict and exit code {found} instead of {wanted}")
    return verdict, found == wanted


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    count, seed = (int(word) for word in (sys.argv[2:] + ["100", "1"][len(sys.argv) - 2:]))
    wrong = 0
    with tempfile.TemporaryDirectory(prefix="ddssec-evaluator-") as folder:
        for kind in sorted(WORSE):
            verdicts = collections.Counter()
            for number in range(count):
                verdict, is_right = check(program, kind, seed, number, pathlib.Path(folder))
                verdicts[verdict] += 1
                wrong += not is_right
            print(f"{kind}: {count} pairs: {dict(verdicts)}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

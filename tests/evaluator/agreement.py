#!/usr/bin/env python3
"""Makes pairs of documents, and holds the product's comparison against the evaluator's.

  agreement.py BATCH [--kind governance|permissions] [--pairs N] [--seed S] [--first I] [--jobs J]
  agreement.py BATCH --kind K --seed S --only I     shows one pair and both answers
  agreement.py BATCH --cases                        the pairs of tests/data/diff-cases
"""

import argparse
import collections
import json
import multiprocessing
import pathlib
import subprocess
import sys
import time

import answers
import pairs

CASES = pathlib.Path(__file__).resolve().parent.parent / "data/diff-cases"
CHUNK = 250
MOST_SHOWN = 3  # pairs
MOST_COMPLAINTS = 10


def asked(batch, kind, documents):
    """The product's answers, in order."""
    lines = "".join(json.dumps({"kind": kind, "old": old, "new": new}) + "\n" for old, new in documents)
    done = subprocess.run([batch], input=lines, capture_output=True, text=True, timeout=600, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def checked(work):
    """(verdicts, [(number, complaints)]) of one chunk."""
    batch, kind, seed, numbers = work
    documents = [pairs.pair(kind, seed, number) for number in numbers]
    verdicts, wrong = collections.Counter(), []
    for number, answer, (old, new) in zip(numbers, asked(batch, kind, documents), documents, strict=True):
        verdicts[answer.get("verdict", "error")] += 1
        found = answers.complaints(kind, answer, old, new)
        if found:
            wrong.append((number, found))
    return verdicts, wrong


def show(batch, kind, seed, number):
    """Everything about one pair."""
    documents = pairs.pair(kind, seed, number)
    answer, = asked(batch, kind, [documents])
    for name, text in zip(("old", "new"), documents):
        print(f"--- {name} document\n{text}")
    print(f"--- product: {answer.get('verdict', answer)}")
    for change in answer.get("changes", ()):
        print(f"  {change}")
    print(f"--- evaluator: {answers.verdict_of(kind, *documents)}")
    for complaint in answers.complaints(kind, answer, *documents)[:MOST_COMPLAINTS]:
        print(f"  {complaint}")


def chunks(options, kind):
    last = options.first + options.pairs
    for start in range(options.first, last, CHUNK):
        yield options.batch, kind, options.seed, range(start, min(start + CHUNK, last))


def run(options, kind):
    """Prints the verdicts and the first disagreements; returns how many disagree."""
    began, verdicts, wrong = time.monotonic(), collections.Counter(), []
    with multiprocessing.Pool(options.jobs) as pool:
        for counted, found in pool.imap(checked, chunks(options, kind)):
            verdicts += counted
            wrong += found
    share = ", ".join(f"{word} {count}" for word, count in verdicts.most_common())
    print(f"{kind}: {verdicts.total()} pairs from seed {options.seed}: {share}; "
          f"{len(wrong)} disagree; {time.monotonic() - began:.1f} s", flush=True)
    for number, _ in wrong[:MOST_SHOWN]:
        print(f"\n=== {kind} pair {number}; to repeat: agreement.py BATCH --kind {kind} "
              f"--seed {options.seed} --only {number}")
        show(options.batch, kind, options.seed, number)
    return len(wrong)


def run_cases(options):
    """The pairs of tests/data/diff-cases; returns how many disagree."""
    wrong = 0
    for old_file in sorted(CASES.glob("*.old.xml")):
        kind = "governance" if old_file.name.startswith("g") else "permissions"
        new_file = old_file.with_name(old_file.name.replace(".old.", ".new."))
        documents = [file.read_text(encoding="utf-8") for file in (old_file, new_file)]
        answer, = asked(options.batch, kind, [documents])
        for complaint in answers.complaints(kind, answer, *documents):
            print(f"{old_file.name}: {complaint}")
            wrong += 1
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("batch", help="the program compare_batch")
    parser.add_argument("--kind", choices=sorted(pairs.ROOTS))
    parser.add_argument("--pairs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", type=int)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--cases", action="store_true")
    options = parser.parse_args()
    if options.cases:
        return 1 if run_cases(options) else 0
    if options.only is not None:
        show(options.batch, options.kind, options.seed, options.only)
        return 0
    kinds = [options.kind] if options.kind else sorted(pairs.ROOTS)
    return 1 if sum(run(options, kind) for kind in kinds) else 0


if __name__ == "__main__":
    sys.exit(main())

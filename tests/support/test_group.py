#!/usr/bin/env python3
"""Runs many tests of a GoogleTest program as one test of ctest, prints what the failed ones said, and notes for
ctest_twice.sh how many there are, which failed and which were skipped.

With DDSSEC_FAILED_ONLY in the environment, the tests that an earlier run noted as failed run alone. If the program did
not come to its end then, they all run. Those that failed then and do not run count as failed once more.

Usage: test_group.py NOTES NAME SECONDS PROGRAM [OPTION ...]

NOTES: the file of the notes. A line is "tests NUMBER", "failed NAME.Suite.Test", "skipped NAME.Suite.Test", or
"unfinished" if the program crashed, also after its tests, did not end within SECONDS, or ran too few tests.
"""

import os
import pathlib
import re
import signal
import subprocess
import sys
import threading

PLANNED = re.compile(r"^\[==========\] Running (\d+) tests? from", re.M)
ENDED = re.compile(r"^\[==========\] \d+ tests? from .* ran\.", re.M)
# A test may print something before it on the same line.
STEP = re.compile(r"\[ +(RUN|OK|FAILED|SKIPPED) +\] ([\w/]+\.[\w/]+)")
LAST_OCTETS = 20_000  # of what a program printed that did not come to its end


def run(command, environment, seconds):
    """Its exit status and what it printed. It prints into a pipe: some tests limit the size of files. What it has
    started ends with it, since a process that keeps the pipe would delay the end."""
    program = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               start_new_session=True)
    overdue = threading.Timer(seconds, os.killpg, (program.pid, signal.SIGKILL))
    overdue.daemon = True
    overdue.start()
    try:
        text = program.stdout.read().decode(errors="replace")
        status = program.wait()
    except BaseException:  # such as the end of ctest
        os.killpg(program.pid, signal.SIGKILL)
        raise
    finally:
        overdue.cancel()
    return status, text


class Group:
    """What a run of a GoogleTest program shows of its tests."""

    def __init__(self, text):
        body = ENDED.split(text)[0]
        self.finished = ENDED.search(text) is not None
        self.planned = int((PLANNED.search(text) or [0, 0])[1])
        self.passed, self.failed, self.skipped, self.said = [], [], [], {}
        running, since = None, 0
        for step in STEP.finditer(body):
            what, test = step[1], step[2]
            if what == "RUN":
                running, since = test, step.start()
            elif test == running:
                running = None
                if what == "FAILED":
                    self.failed.append(test)
                    self.said[test] = body[since:step.end()]
                elif what == "SKIPPED":
                    self.skipped.append(test)
                else:
                    self.passed.append(test)
        if running:
            self.failed.append(running)

    def count_as_failed(self, due):
        """Of the tests that failed before, those that did not run."""
        self.failed += [test for test in due if test not in self.passed + self.failed + self.skipped]

    def notes(self, name):
        lines = [f"tests {self.planned}"] + [f"failed {name}.{test}" for test in self.failed]
        lines += [f"skipped {name}.{test}" for test in self.skipped] + ["unfinished"] * (not self.finished)
        return "\n".join(lines) + "\n"


def failed_before(notes, name):
    """The tests that failed in an earlier run, and whether its program came to its end."""
    if "DDSSEC_FAILED_ONLY" not in os.environ or not notes.is_file():
        return [], True
    lines = notes.read_text(encoding="utf-8").splitlines()
    failed = [line.removeprefix(f"failed {name}.") for line in lines if line.startswith("failed ")]
    return failed, "unfinished" not in lines


def not_run(group, again):
    """A sentence if tests that should have run did not: a filter fits none, or a test has another name now."""
    if not group.finished or (group.planned and group.planned == (len(again) or group.planned)):
        return ""
    return f"{group.planned} tests ran, and there should be {len(again) or 'some'}: does the filter still fit?"


def main():
    notes, name, seconds, *command = sys.argv[1:]
    notes, environment = pathlib.Path(notes), dict(os.environ, GTEST_COLOR="no", GTEST_BRIEF="0")
    due, had_finished = failed_before(notes, name)
    again = due if had_finished else []
    if again:
        command = [command[0], "--gtest_filter=" + ":".join(again)]
        for variable in ("GTEST_TOTAL_SHARDS", "GTEST_SHARD_INDEX"):
            environment.pop(variable, None)
    notes.unlink(missing_ok=True)
    status, text = run(command, environment, float(seconds))
    group = Group(text)
    wrong = not_run(group, again)
    group.count_as_failed(due)
    # One that a signal ended after its tests may have failed in any of them.
    in_doubt = group.finished and (wrong or status < 0)
    notes.parent.mkdir(parents=True, exist_ok=True)
    notes.write_text(group.notes(name) + ("unfinished\n" if in_doubt else ""), encoding="utf-8")
    print(f"{group.planned} tests, {len(group.failed)} failed, {len(group.skipped)} skipped")
    for kind, tests in (("FAILED", group.failed), ("SKIPPED", group.skipped)):
        for test in tests:
            print(f"{kind}: {name}.{test}")
    for test in group.said:
        print(group.said[test])
    if not group.finished:
        print(f"The program did not come to its end (exit status {status}, limit {seconds} s). Its last lines:")
        print(text[-LAST_OCTETS:])
    elif status != 0 and not group.failed:  # such as a sanitizer's report at the end
        print(f"Exit status {status}. Its last lines:\n{text[-LAST_OCTETS:]}")
    if wrong:
        print(wrong)
    return 0 if status == 0 and group.finished and not group.failed and not wrong else 1


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""ctest_twice.sh forgives a few tests that fail once and names them, as it names those that were skipped. It forgives
none that fails twice. It does the same for each test of a group that test_group.py runs."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parent / "ctest_twice.sh"
GOOD, BAD, ONCE = "true", "false", 'test -e "$0.ran" || { touch "$0.ran"; false; }'
SKIP = "exit 77"
FAIL_THEN_SKIP = 'test ! -e "$0.ran" || exit 77; touch "$0.ran"; false'
GROUP = SCRIPT.with_name("test_group.py")
# It prints what a program of GoogleTest prints whose tests have these names, and appends a line for each run to "runs".
PROGRAM = """#!/usr/bin/env python3
import os, pathlib, sys
here = pathlib.Path(sys.argv[0]).parent
tests = sys.argv[1:-1] if sys.argv[-1] == "--gtest_filter=*" else sys.argv[-1].partition("=")[2].split(":")
with open(here / "runs", "a") as runs:
    print(*tests, file=runs)
color = "" if os.environ.get("GTEST_COLOR") == "no" else "\\033[m"
print(f"{color}[==========] Running {len(tests)} tests from 1 test suite.")
failed, ends_well = [], True
for test in tests:
    print(f"[ RUN      ] {test}\\nwhat {test} says", flush=True)
    ran = here / test.replace("/", "-")
    first = not ran.exists()
    ran.touch()
    if "Crash" in test and (not first if "Later" in test else first or "Once" not in test):
        os.abort()
    ends_well = ends_well and not ("Exit" in test and first)
    fails = "Bad" in test or ("Once" in test and first)
    failed += [test] * fails
    print("[  FAILED  ]" if fails else "[  SKIPPED ]" if "Skip" in test else "[       OK ]", test, "(0 ms)")
print(f"{color}[==========] {len(tests)} tests from 1 test suite ran. (0 ms total)\\n[  PASSED  ] some tests.")
for test in failed:
    print(f"[  FAILED  ] {test}", flush=True)
if not ends_well:
    os.abort()
sys.exit(bool(failed))
"""


class CtestTwice(unittest.TestCase):
    def run_tests(self, **tests):
        """A build folder with nothing but these tests."""
        with tempfile.TemporaryDirectory(prefix="ddssec-ctest-") as folder:
            lines = [f'add_test([=[{name}]=] "sh" "-c" [=[{command}]=] "{folder}/{name}")'
                     for name, command in tests.items()]
            lines.append(f"set_tests_properties({' '.join(tests)} PROPERTIES SKIP_RETURN_CODE 77)" if tests else "")
            pathlib.Path(folder, "CTestTestfile.cmake").write_text("\n".join(lines) + "\n")
            done = subprocess.run([SCRIPT, folder, "--parallel", "2"], text=True, timeout=60, check=False,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            return done.returncode, done.stdout

    def test_all_pass(self):
        status, said = self.run_tests(a=GOOD, b=GOOD)
        self.assertEqual(status, 0, said)
        self.assertIn("100% tests passed, 0 tests failed out of 2", said)
        self.assertNotIn("AGAIN", said)
        self.assertNotIn("SKIPPED", said)

    def test_skipped_tests_are_named_at_the_end(self):
        status, said = self.run_tests(a=GOOD, b=SKIP, c=SKIP)
        self.assertEqual(status, 0, said)
        self.assertEqual(said.splitlines()[-2:],
                         ["SKIPPED: b, c", "100% tests passed, 0 tests failed out of 3"])

    def test_skipped_tests_are_named_beside_those_that_pass_only_when_run_again(self):
        status, said = self.run_tests(a=ONCE, b=SKIP)
        self.assertEqual(status, 0, said)
        self.assertEqual(said.splitlines()[-3:], [
            "SKIPPED: b", "PASSED ONLY WHEN RUN AGAIN: a",
            "100% tests passed, 0 tests failed out of 2; only when run again passed: a"])

    def test_a_failure_that_is_skipped_in_the_second_run_has_not_passed(self):
        _, said = self.run_tests(a=GOOD, b=FAIL_THEN_SKIP)
        self.assertIn("SKIPPED: b", said)
        self.assertNotIn("AGAIN", said)

    def test_some_pass_only_when_run_again(self):
        status, said = self.run_tests(a=GOOD, b=ONCE, c=ONCE, d=GOOD)
        self.assertEqual(status, 0, said)
        self.assertEqual(said.splitlines()[-2:], [
            "PASSED ONLY WHEN RUN AGAIN: b, c",
            "100% tests passed, 0 tests failed out of 4; only when run again passed: b, c"])

    def test_one_fails_twice(self):
        status, said = self.run_tests(a=GOOD, b=ONCE, c=BAD)
        self.assertNotEqual(status, 0, said)
        self.assertEqual(said.splitlines()[-3:], [
            "PASSED ONLY WHEN RUN AGAIN: b", "FAILED TWICE: c",
            "66% tests passed, 1 tests failed out of 3; only when run again passed: b"])

    def test_all_fail_twice(self):
        status, said = self.run_tests(a=BAD)
        self.assertNotEqual(status, 0, said)
        self.assertEqual(said.splitlines()[-2:], ["FAILED TWICE: a", "0% tests passed, 1 tests failed out of 1"])

    def test_many_failures_are_not_run_again(self):
        status, said = self.run_tests(**{f"t{i}": ONCE for i in range(6)})
        self.assertNotEqual(status, 0, said)
        self.assertNotIn("once more", said)
        self.assertIn("0% tests passed, 6 tests failed out of 6", said)

    def test_no_test_at_all_is_a_failure(self):
        status, said = self.run_tests()
        self.assertNotEqual(status, 0, said)

    def test_a_failure_of_an_earlier_run_is_not_run_again(self):
        with tempfile.TemporaryDirectory(prefix="ddssec-ctest-") as folder:
            stale = pathlib.Path(folder, "Testing/Temporary/LastTestsFailed.log")
            stale.parent.mkdir(parents=True)
            stale.write_text("1:old\n")
            pathlib.Path(folder, "CTestTestfile.cmake").write_text('add_test(a "true")\n')
            done = subprocess.run([SCRIPT, folder], text=True, capture_output=True, timeout=60, check=False)
            self.assertEqual((done.returncode, "once more" in done.stdout), (0, False), done.stdout)


class Groups(unittest.TestCase):
    def run_group(self, *tests, seconds=30):
        """An entry of ctest that passes, and a group with these tests. What its program ran, besides."""
        with tempfile.TemporaryDirectory(prefix="ddssec-ctest-") as folder:
            program = pathlib.Path(folder, "program")
            program.write_text(PROGRAM)
            program.chmod(0o755)
            pathlib.Path(folder, "CTestTestfile.cmake").write_text(
                'add_test(other "true")\n'
                f'add_test(some.tests "{GROUP}" "{folder}/Testing/Temporary/groups/some.tests" some {seconds} '
                f'"{program}" {" ".join(tests)} "--gtest_filter=*")\n')
            done = subprocess.run([SCRIPT, folder, "--parallel", "2"], text=True, timeout=60, check=False,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            return done.returncode, done.stdout, pathlib.Path(folder, "runs").read_text().splitlines()

    def test_each_test_of_a_group_counts(self):
        status, said, _ = self.run_group("A.Good", "A.Fine", "A.Well")
        self.assertEqual(status, 0, said)
        self.assertEqual(said.splitlines()[-1], "100% tests passed, 0 tests failed out of 4")

    def test_skipped_tests_of_a_group_are_named(self):
        status, said, _ = self.run_group("A.Good", "A.Skip", "B/A.Skip/0")
        self.assertEqual(status, 0, said)
        self.assertEqual(said.splitlines()[-2:], [
            "SKIPPED: some.A.Skip, some.B/A.Skip/0", "100% tests passed, 0 tests failed out of 4"])

    def test_only_the_failed_tests_of_a_group_run_again(self):
        status, said, runs = self.run_group("A.Good", "A.Once", "A.Skip", "B/A.Once/1")
        self.assertEqual(status, 0, said)
        self.assertEqual(runs, ["A.Good A.Once A.Skip B/A.Once/1", "A.Once B/A.Once/1"])
        again = "some.A.Once, some.B/A.Once/1"
        self.assertEqual(said.splitlines()[-3:], [
            "SKIPPED: some.A.Skip", f"PASSED ONLY WHEN RUN AGAIN: {again}",
            f"100% tests passed, 0 tests failed out of 5; only when run again passed: {again}"])

    def test_what_a_failed_test_printed_is_shown_and_no_more(self):
        _, said, _ = self.run_group("A.Good", "A.Once")
        self.assertIn("what A.Once says", said)
        self.assertNotIn("what A.Good says", said)

    def test_a_test_of_a_group_that_fails_twice_is_named(self):
        status, said, _ = self.run_group("A.Bad", "A.Good", "A.Once")
        self.assertNotEqual(status, 0, said)
        self.assertEqual(said.splitlines()[-3:], [
            "PASSED ONLY WHEN RUN AGAIN: some.A.Once", "FAILED TWICE: some.A.Bad",
            "75% tests passed, 1 tests failed out of 4; only when run again passed: some.A.Once"])

    def test_many_failures_of_a_group_are_named_and_not_run_again(self):
        status, said, runs = self.run_group(*(f"A.Bad{i}" for i in range(6)))
        self.assertNotEqual(status, 0, said)
        self.assertEqual(len(runs), 1)
        self.assertEqual(said.splitlines()[-2:], [
            "FAILED: " + ", ".join(f"some.A.Bad{i}" for i in range(6)), "14% tests passed, 6 tests failed out of 7"])

    def test_a_program_that_crashes_once_runs_all_its_tests_again(self):
        status, said, runs = self.run_group("A.Good", "A.CrashOnce", "A.Fine")
        self.assertEqual(status, 0, said)
        self.assertEqual(runs, ["A.Good A.CrashOnce A.Fine"] * 2)
        self.assertIn("PASSED ONLY WHEN RUN AGAIN: some.A.CrashOnce, some.tests", said)

    def test_a_test_that_crashes_twice_is_named(self):
        status, said, _ = self.run_group("A.Good", "A.Crash", "A.Fine")
        self.assertNotEqual(status, 0, said)
        self.assertIn("what A.Crash says", said)
        self.assertIn("FAILED TWICE: some.A.Crash, some.tests", said)

    def test_a_failed_test_that_a_crash_keeps_from_running_again_is_not_forgiven(self):
        status, said, runs = self.run_group("A.CrashLater", "A.Once", "A.CrashOnce")
        self.assertNotEqual(status, 0, said)
        self.assertEqual(len(runs), 2)
        self.assertIn("FAILED TWICE: some.A.CrashLater, some.A.CrashOnce, some.A.Once, some.tests", said)

    def test_a_program_that_crashes_after_a_failed_test_and_its_end_runs_all_again(self):
        status, said, runs = self.run_group("A.Good", "A.Once", "A.Exit")
        self.assertEqual(status, 0, said)
        self.assertEqual(runs, ["A.Good A.Once A.Exit"] * 2)
        self.assertIn("PASSED ONLY WHEN RUN AGAIN: some.A.Once, some.tests", said)

    def test_colors_of_googletest_do_not_hide_what_ran(self):
        os.environ["GTEST_COLOR"] = "yes"
        self.addCleanup(os.environ.pop, "GTEST_COLOR")
        status, said, _ = self.run_group("A.Good")
        self.assertEqual(status, 0, said)

    def test_a_group_whose_filter_fits_no_test_fails(self):
        status, said, _ = self.run_group()
        self.assertNotEqual(status, 0, said)
        self.assertIn("0 tests ran, and there should be some", said)
        self.assertIn("FAILED TWICE: some.tests", said)

    def test_a_program_that_is_not_there_fails(self):
        with tempfile.TemporaryDirectory(prefix="ddssec-ctest-") as folder:
            done = subprocess.run([GROUP, f"{folder}/notes", "some", "5", f"{folder}/nowhere"], text=True,
                                  capture_output=True, timeout=60, check=False)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn("nowhere", done.stdout + done.stderr)

    def test_a_program_that_does_not_end_is_ended_with_its_children_and_its_test_named(self):
        with tempfile.TemporaryDirectory(prefix="ddssec-ctest-") as folder:
            program = pathlib.Path(folder, "program")
            program.write_text("#!/bin/sh\necho '[==========] Running 2 tests from 1 test suite.'\n"
                               "echo '[ RUN      ] A.Endless'\nsleep 60\n")
            program.chmod(0o755)
            done = subprocess.run([GROUP, f"{folder}/notes", "some", "0.5", program], text=True, capture_output=True,
                                  timeout=30, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertIn("FAILED: some.A.Endless", done.stdout)
            self.assertEqual(pathlib.Path(folder, "notes").read_text(), "tests 2\nfailed some.A.Endless\nunfinished\n")


if __name__ == "__main__":
    sys.exit(unittest.main())

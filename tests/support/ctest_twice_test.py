#!/usr/bin/env python3
"""ctest_twice.sh forgives a few tests that fail once and names them, as it names those that were skipped. It forgives
none that fails twice."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parent / "ctest_twice.sh"
GOOD, BAD, ONCE = "true", "false", 'test -e "$0.ran" || { touch "$0.ran"; false; }'
SKIP = "exit 77"
FAIL_THEN_SKIP = 'test ! -e "$0.ran" || exit 77; touch "$0.ran"; false'


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


if __name__ == "__main__":
    sys.exit(unittest.main())

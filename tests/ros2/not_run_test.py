#!/usr/bin/env python3
"""ctest says without -V that no real ROS 2 node was tried, and why.

Usage: not_run_test.py TESTS      TESTS: what ctest reads in the build folder to say so (not_run.cmake)
"""

import pathlib
import re
import subprocess
import sys
import tempfile

TESTS = pathlib.Path(sys.argv[1]).read_text(encoding="utf-8")
OURS = ("ros2.nodes", "cli.tutorial.secure-a-ros2-robot_nodes")


def said(folder, nodes):
    """What `ctest -L ros2` prints where the nodes would be in that folder."""
    tests, count = re.subn(r'set\(nodes ".*"\)', lambda _: f'set(nodes "{nodes}")', TESTS)
    assert count == 1, TESTS
    (folder / "CTestTestfile.cmake").write_text(tests, encoding="utf-8")
    done = subprocess.run(["ctest", "-L", "ros2"], cwd=folder, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def expect(output, reason):
    for test in OURS:
        assert re.search(rf"^\s*\d+ - {re.escape(test)}_NOT_RUN_{reason} \(Skipped\)$", output, re.M), output


def nodes_that_lack_libraries(folder):
    """A library that needs another, which is gone."""
    (folder / "lib").mkdir(parents=True)
    (folder / "run.sh").write_text("", encoding="utf-8")
    for name, linked in (("gone", ()), ("class_loader", ("-L.", "-lgone"))):
        subprocess.run(["cc", "-shared", "-fPIC", "-x", "c", "/dev/null", "-o", f"lib{name}.so", "-Wl,--no-as-needed",
                        *linked], cwd=folder / "lib", check=True)
    (folder / "lib" / "libgone.so").unlink()
    return folder


with tempfile.TemporaryDirectory(prefix="ddssec-not-run-") as made:
    where = pathlib.Path(made)
    expect(said(where, where / "none"), "the_folder_shared_ros2_is_missing")
    expect(said(where, nodes_that_lack_libraries(where / "old")), "the_nodes_lack_libraries")

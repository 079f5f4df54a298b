#!/usr/bin/env python3
"""Changes one place of the code at a time and looks whether the unit tests notice ("mutants").

Usage: scripts/mutants.py [--folder FOLDER ...] [--count N] [--seed N] [--part I/N] [--build FOLDER] [--only FILE]

Works in a copy of the checkout (build/mutants), which it keeps for the next run. Prints one line for each mutant, and at
the end the share that was noticed, and those that were not. A mutant that does not compile does not count. Two runs with
--part 1/2 and --part 2/2, each with a build folder of its own, share one sample.
"""

import argparse
import os
import random
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# The programs that test a folder. Which file in them is not asked: all must pass.
TESTS = {
    "pki": ["test_pki", "test_vectors_pki"],
    "governance": ["test_governance", "test_governance_compare"],
    "governance/doctor": ["test_governance_doctor"],
    "plugins/authentication": ["test_authentication", "test_attack_authentication"],
    "plugins/access_control": ["test_access_control", "test_attack_access_control"],
    "plugins/cryptography": ["test_cryptography", "test_cryptography_attacks", "test_cryptography_vectors"],
    "plugins/cyclonedds": ["test_cyclonedds", "test_attack_cyclonedds"],
}
# Left out: what only scripts/test.sh --long runs, and all seeds but the first, since this build is slow.
LONG = ":".join(["MoreSeeds/*", *(f"Seeds/*Reference.*/{number}" for number in range(1, 5))])
TIMEOUT = 240  # seconds for one test program; a mutant may wait for ever

# Each is a change of one line: a pattern, and what stands in its place.
CHANGES = [
    ("equal", r" == ", " != "), ("unequal", r" != ", " == "),
    ("less", r" < (?!<)", " <= "), ("at most", r" <= ", " < "),
    ("greater", r" > (?!>)", " >= "), ("at least", r" >= ", " > "),
    ("and", r" && ", " || "), ("or", r" \|\| ", " && "),
    ("negated condition", r"\bif \(!", "if ("), ("negated result", r"\breturn !", "return "),
    ("true", r"\breturn true;", "return false;"), ("false", r"\breturn false;", "return true;"),
    ("plus", r"(?<=[\w)]) \+ (?=\d)", " - "), ("minus", r"(?<=[\w)]) - (?=\d)", " + "),
    ("check", r"^\s*DDSSEC_RETURN_IF_ERROR\(.*\);$", ";"),
    ("call", r"^\s+(?!return\b|throw\b|co_|static\b|const\b|auto\b|using\b|DDSSEC_|EXPECT|ASSERT|case\b)[\w:.>\-]+\([^;]*\);$", ";"),
    ("early success", r"\breturn \{\};$", "return std::unexpected(Error(Code::internal));"),
]


def masked(line):
    """The line with texts and comments blanked out, of the same length."""
    line = re.sub(r'"(?:[^"\\]|\\.)*"|\'(?:[^\'\\]|\\.)\'', lambda m: "\0" * len(m[0]), line)
    return re.sub(r"//.*", lambda m: "\0" * len(m[0]), line)


def mutants_of(file):
    """(line number, name, changed line) of each place in the file."""
    for number, line in enumerate(file.read_text().splitlines()):
        if line.startswith("#") or "template" in line or "static_assert" in line:
            continue
        seen = masked(line)
        for name, pattern, change in CHANGES:
            for match in re.finditer(pattern, seen):
                yield number, name, line[:match.start()] + change + line[match.end():]


def folder_of(file):
    """The folder of TESTS whose tests are for the file."""
    path = file.as_posix()
    return max((one for one in TESTS if path.startswith(one + "/")), key=len, default=None)


class Workshop:
    """The copy, in which mutants are built and tested."""

    def __init__(self, build, jobs):
        self.at, self.jobs = build, jobs
        self.source, self.binary = build / "source", build / "binary"
        self.filters = {}  # of each program: tests to leave out

    def run(self, *command, **more):
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", **more)

    def must(self, *command):
        done = self.run(*command)
        if done.returncode != 0:
            sys.exit(f"mutants.py: {' '.join(map(str, command))}\n{done.stdout[-3000:]}")

    def prepare(self, programs):
        """The tree as it is here, built."""
        self.source.mkdir(parents=True, exist_ok=True)
        files = subprocess.run(["git", "-C", ROOT, "ls-files", "-z"], stdout=subprocess.PIPE, check=True).stdout
        for name in filter(None, files.decode().split("\0")):
            to = self.source / name
            if (ROOT / name).is_file() and not (to.is_file() and to.read_bytes() == (ROOT / name).read_bytes()):
                to.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / name, to)
        self.must("cmake", "-S", self.source, "-B", self.binary, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                  "-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DNDEBUG", "-DDDSSEC_BUILD_TESTS=ON", "-DDDSSEC_BUILD_BENCH=OFF",
                  "-DDDSSEC_BATCH=1")  # a mutant compiles one file
        self.must("cmake", "--build", self.binary, "-j", str(self.jobs), "--target", *programs)
        for program in programs:
            self.leave_out_failing(program)

    def leave_out_failing(self, program):
        """Some tests limit how long something takes, and this build is slow."""
        told = self.run(self.binary / "bin" / program, "--gtest_brief=1", f"--gtest_filter=-{LONG}").stdout
        failing = sorted(set(re.findall(r"^\[  FAILED  \] ([\w/.]+)", told, re.M)))
        self.filters[program] = ":".join([LONG, *failing])
        if failing:
            print(f"left out of {program}, since they fail without a mutant: {', '.join(failing)}", flush=True)
        if not self.passes(program):
            sys.exit(f"mutants.py: {program} fails without a mutant")

    def own_tests(self, file):
        """A filter for the tests in the file that is named after this one; empty if there is none."""
        names = set()
        for test in (self.source / "tests").rglob(file.stem + "_test.cpp"):
            names |= set(re.findall(r"^(?:TYPED_)?TEST(?:_[FP])?\((\w+),", test.read_text(), re.M))
        return ":".join(f"{name}.*:*/{name}.*:{name}/*" for name in sorted(names))

    def passes(self, program, wanted="*"):
        try:
            done = self.run(self.binary / "bin" / program, "--gtest_fail_fast", "--gtest_brief=1",
                            f"--gtest_filter={wanted}-{self.filters[program]}", timeout=TIMEOUT)
        except subprocess.TimeoutExpired:
            return False
        return done.returncode == 0

    def judge(self, file, number, changed, programs):
        """"noticed", "not noticed" or "does not compile"."""
        path = self.source / file
        text = path.read_text()
        lines = text.splitlines(keepends=True)
        lines[number] = changed + "\n"
        try:
            path.write_text("".join(lines))
            built = self.run("cmake", "--build", self.binary, "-j", str(self.jobs), "--target", *programs)
            if built.returncode != 0:
                return "does not compile"
            own = self.own_tests(file)  # they notice most mutants, and do not take long
            if own and not all(self.passes(one, own) for one in programs):
                return "noticed"
            return "not noticed" if all(self.passes(one) for one in programs) else "noticed"
        finally:
            path.write_text(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", action="append", choices=sorted(TESTS), help="again for more; default: all")
    parser.add_argument("--only", action="append", default=[], help="a file; again for more")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--part", default="1/1", help="I/N: each N-th mutant, from the I-th on")
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "mutants")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    os.environ["CCACHE_DISABLE"] = "1"  # each mutant is compiled once

    folders = arguments.folder or sorted(TESTS)
    files = [file.relative_to(ROOT) for folder in folders for file in sorted((ROOT / folder).rglob("*.cpp"))]
    files = [file for file in dict.fromkeys(files) if folder_of(file) in folders]
    if arguments.only:
        files = [file for file in files if file.as_posix() in arguments.only]
    places = [(file, *place) for file in files for place in mutants_of(ROOT / file)]
    random.Random(arguments.seed).shuffle(places)
    part, parts = map(int, arguments.part.split("/"))
    places = places[part - 1::parts]
    workshop = Workshop(arguments.build, arguments.jobs)
    programs = {folder: TESTS[folder] for folder in {folder_of(file) for file in files}}
    print(f"{len(places)} places in {len(files)} files; building", flush=True)
    workshop.prepare(sorted({one for some in programs.values() for one in some}))

    noticed, missed = 0, []
    for file, number, name, changed in places:
        if noticed + len(missed) >= arguments.count:
            break
        begin = time.monotonic()
        verdict = workshop.judge(file, number, changed, programs[folder_of(file)])
        print(f"{verdict:16} {file}:{number + 1} {name}: {changed.strip()} ({time.monotonic() - begin:.0f} s)", flush=True)
        noticed += verdict == "noticed"
        if verdict == "not noticed":
            missed.append(f"{file}:{number + 1} {name}: {changed.strip()}")
    count = noticed + len(missed)
    print(f"\n{noticed} of {count} mutants noticed ({100 * noticed / max(count, 1):.0f} %); seed {arguments.seed}; not noticed:")
    print("\n".join(f"  {one}" for one in missed))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""What the generator cannot make is refused with file, line, what and what to do; nothing is written.
Usage: refusals_test.py IDLC PLUGIN"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

IDLC, PLUGIN = sys.argv.pop(1), str(pathlib.Path(sys.argv.pop(1)).resolve())
FINE = "@final struct Fine { long x; };\n"

# What stands in line 2, the words of the refusal.
REFUSED = [
    ("union U switch (long) { case 1: long a; };", "a union", "use a struct and an enum"),
    ("bitmask B { ONE, TWO };", "a bitmask", "use an unsigned integer"),
    ("@mutable struct S { long x; };", "@mutable", "make it @appendable"),
    ("struct S : Fine { long y; };", "inheritance", "make the base type a member"),
    ("struct S { @optional long x; };", "@optional", "use a sequence with the bound 1"),
    ("struct S { @external Fine x; };", "@external", "leave it out"),
    ("struct S { @id(7) long x; };", "@id", "leave it out"),
    ("struct S { @hashid long x; };", "@hashid", "leave it out"),
    ("@autoid(HASH) struct S { long x; };", "@autoid(HASH)", "leave it out"),
    ("struct S { long double x; };", "long double", "use a double"),
    ("struct S { sequence<sequence<sequence<long, 2>, 2>, 2> x; };", "bounds three deep",
     "leave the innermost bound out"),
]


class RefusalsTest(unittest.TestCase):
    def generate(self, text, folder):
        file = pathlib.Path(folder) / "given.idl"
        file.write_text(text, encoding="utf-8")
        return subprocess.run([IDLC, "-l", PLUGIN, "-W", "no-implicit-extensibility", "-o", folder, str(file)],
                              capture_output=True, text=True, check=False)

    def test_each_is_refused_with_its_place(self):
        for line, what, to_do in REFUSED:
            with self.subTest(line), tempfile.TemporaryDirectory() as folder:
                done = self.generate(FINE + line + "\n", folder)
                said = done.stdout + done.stderr
                self.assertNotEqual(done.returncode, 0, said)
                self.assertRegex(said, rf"given\.idl:2:\d+: ddssec cannot do .*{re.escape(what)}.*: {to_do}")
                self.assertFalse((pathlib.Path(folder) / "given.hpp").exists())

    def test_several_refusals_are_all_said(self):
        with tempfile.TemporaryDirectory() as folder:
            done = self.generate("struct S { @optional long x; };\nbitmask B { ONE };\n", folder)
            said = done.stdout + done.stderr
            self.assertIn("given.idl:1:", said)
            self.assertIn("given.idl:2:", said)

    def test_what_is_no_idl_is_idlcs_own_to_refuse(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertNotEqual(self.generate("struct S { nothing x; };\n", folder).returncode, 0)

    def test_a_folder_that_is_not_there(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "given.idl"
            file.write_text(FINE, encoding="utf-8")
            done = subprocess.run([IDLC, "-l", PLUGIN, "-o", f"{folder}/nowhere", str(file)],
                                  capture_output=True, text=True, check=False)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn("cannot be written", done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()

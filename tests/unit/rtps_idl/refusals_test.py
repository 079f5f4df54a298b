#!/usr/bin/env python3
"""What the generator cannot make is refused with file, line, what and what to do; nothing is written.
Usage: refusals_test.py IDLC PLUGIN EXPLAIN"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

IDLC, PLUGIN, EXPLAIN = sys.argv.pop(1), *(str(pathlib.Path(sys.argv.pop(1)).resolve()) for _ in range(2))
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
    ("struct S { wchar x; };", "wchar", "use a char or a string"),
    ("@data_representation(XCDR1) struct S { long x; };", "@data_representation", "leave it out"),
]

# What idlc calls a syntax error: the word at which it stands, and what to do.
UNREADABLE = [
    ("struct S { wstring x; };", "wstring", "use a string"),
    ("struct S { wstring<8> x; };", "wstring", "use a string"),
    ("struct S { any x; };", "any", "use a sequence<octet>"),
    ("struct S { fixed<4, 2> x; };", "fixed", "use an integer and a scale"),
    ("struct S { map<long, string> x; };", "map", "use a sequence of structs"),
    ("bitset B { bitfield<3> x; };", "bitset", "use an unsigned integer"),
    ("interface I { };", "interface", "types of topics are structs"),
]


class RefusalsTest(unittest.TestCase):
    def generate(self, text, folder, *options):
        file = pathlib.Path(folder) / "given.idl"
        file.write_text(text, encoding="utf-8")
        return subprocess.run([IDLC, "-l", PLUGIN, "-W", "no-implicit-extensibility", *options, "-o", folder, str(file)],
                              capture_output=True, text=True, check=False)

    def test_each_is_refused_with_its_place(self):
        for line, what, to_do in REFUSED:
            with self.subTest(line), tempfile.TemporaryDirectory() as folder:
                done = self.generate(FINE + line + "\n", folder)
                said = done.stdout + done.stderr
                self.assertNotEqual(done.returncode, 0, said)
                self.assertRegex(said, rf"given\.idl:2:\d+: ddssec cannot do .*{re.escape(what)}.*: {to_do}")
                self.assertFalse((pathlib.Path(folder) / "given.hpp").exists())

    def test_nothing_else_is_said_of_what_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            done = self.generate("struct S { wchar x; };\n", folder)
            self.assertEqual(done.returncode, 1, "idlc must not be ended by a signal")
            self.assertNotIn("without members", done.stdout + done.stderr)

    def explain(self, text, folder):
        file = pathlib.Path(folder) / "given.idl"
        file.write_text(text, encoding="utf-8")
        return subprocess.run([EXPLAIN, str(file)], capture_output=True, text=True, check=False)

    def test_what_idlc_cannot_read_is_explained(self):
        for line, word, to_do in UNREADABLE:
            with self.subTest(line), tempfile.TemporaryDirectory() as folder:
                self.assertNotEqual(self.generate(FINE + line + "\n", folder).returncode, 0)
                done = self.explain(FINE + line + "\n", folder)
                self.assertEqual(done.returncode, 1)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                self.assertIn(f"given.idl:2:{line.index(word) + 1}: ddssec cannot do {word}: {to_do}", done.stderr)

    def test_words_in_comments_literals_and_names_are_no_types(self):
        text = ("// any map\n/* fixed\n wstring */ struct S { long _map; long anyway; };\n"
                'const string T = "a \\" bitset"; const char C = \'"\';\nconst char D = \'\\\'\'; // native\n')
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(self.explain(text, folder).stderr, "")
            self.assertEqual(self.explain("", folder).stderr, "")
            self.assertIn(":1:9: ", self.explain("/* x */ any", folder).stderr)

    def test_included_files_are_explained_too(self):
        with tempfile.TemporaryDirectory() as folder:
            top = pathlib.Path(folder)
            (top / "elsewhere").mkdir()
            (top / "elsewhere/far.idl").write_text('#include "../given.idl"\nstruct F { any x; };\n', encoding="utf-8")
            (top / "near.idl").write_text(' #  include <far.idl>\nstruct N { map<long, long> x; };\n', encoding="utf-8")
            (top / "given.idl").write_text('#include "near.idl"\n#include "gone.idl"\nstruct S { wstring x; };\n',
                                           encoding="utf-8")
            done = subprocess.run([EXPLAIN, "-I", str(top / "elsewhere"), str(top / "given.idl")],
                                  capture_output=True, text=True, check=False)
        said = done.stderr.replace(folder + "/", "").splitlines()
        self.assertEqual([line.split(": ")[0] for line in said],
                         ["elsewhere/far.idl:2:12", "near.idl:2:12", "given.idl:2", "given.idl:3:12"], said)
        self.assertIn("gone.idl is not there: name the folder that holds gone.idl behind INCLUDES", said[2])

    def test_a_missing_include_in_angle_brackets_is_named_as_idlc_looks_for_it(self):
        """Beside the file only what is in quotes is found."""
        with tempfile.TemporaryDirectory() as folder:
            top = pathlib.Path(folder)
            for place in ("base", "far/base"):
                (top / place).mkdir(parents=True)
            (top / "base/types.idl").write_text("@final struct Part { long x; };\n", encoding="utf-8")
            (top / "far/base/far.idl").write_text("@final struct Far { long x; };\n", encoding="utf-8")
            text = "@final struct S { long x; };\n"
            for name, also, where in (("base/types.idl", "; or write it in quotes", folder),
                                      ("base/far.idl", "of idlc\n", f"{folder}/far")):
                angle = f"#include <{name}>\n{text}"
                self.assertNotEqual(self.generate(angle, folder).returncode, 0)
                done = self.explain(angle, folder)
                self.assertIn(f"given.idl:1: the included file {name} is not there: name the folder that holds {name} "
                              "behind INCLUDES of ddssec_idl_generate, or with -I of idlc", done.stderr)
                self.assertIn(also, done.stderr)
                self.assertEqual(self.generate(angle, folder, "-I", where).returncode, 0)
                done = subprocess.run([EXPLAIN, "-I", where, str(top / "given.idl")], capture_output=True, text=True,
                                      check=False)
                self.assertEqual(done.stderr, "")
            quoted = f'#include "base/types.idl"\n{text}'
            self.assertEqual(self.generate(quoted, folder).returncode, 0)
            self.assertEqual(self.explain(quoted, folder).stderr, "")

    def test_a_header_names_the_included_file_that_was_not_made(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "parts.idl").write_text("@final struct Part { long x; };\n", encoding="utf-8")
            done = self.generate('#include "parts.idl"\n@final struct S { Part p; };\n', folder)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            made = subprocess.run(["c++", "-fsyntax-only", "-x", "c++", f"{folder}/given.hpp"], capture_output=True,
                                  text=True, check=False)
        self.assertIn("given.idl includes parts.idl: name that in ddssec_idl_generate too", made.stderr)

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

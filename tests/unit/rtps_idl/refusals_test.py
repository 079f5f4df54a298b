#!/usr/bin/env python3
"""What the generator cannot make is refused with file, line, what and what to do; nothing is written.
Usage: refusals_test.py IDLC PLUGIN EXPLAIN CMAKE_FUNCTION"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest

IDLC, PLUGIN, EXPLAIN, FUNCTION = (sys.argv.pop(1),
                                   *(str(pathlib.Path(sys.argv.pop(1)).resolve()) for _ in range(3)))
PATIENCE = 30  # seconds; an idlc that hangs is killed then
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

# What idlc runs on forever over, or gives up halfway over and still reports success. The line of the refusal first.
RECURSIVE = [
    (2, "struct T { sequence<T> kids; };"),
    (2, "struct T { @key sequence<T, 4> kids[3]; };"),
    (2, "module m { struct T { sequence<sequence<m::T> > kids; }; };"),
    (3, "struct B;\nstruct A { sequence<B> b; };\nstruct B { sequence<A> a; };"),
    (3, "struct B;\nstruct A { B b; };\nstruct B { A a; };"),
    (4, "struct B;\ntypedef sequence<B> Bs;\nstruct B { Bs more; };"),
    (5, "struct C;\ntypedef sequence<C> Cs;\ntypedef Cs Css[2];\nstruct A { Css cs; };\nstruct C { A a; };"),
    (3, "module m { struct B; typedef sequence<B> Bs; };\nmodule m { struct B { Bs more; long x; }; };"),
]
UNDEFINED = [
    (3, "struct B;\nstruct A { sequence<B> b; };\nstruct B { long x; };"),
    (4, "struct B;\ntypedef sequence<B> Bs;\nstruct A { Bs b; };\nstruct B { long x; };"),
    (3, "union B;\nstruct A { sequence<B> b; };\nunion B switch (long) { case 1: A a; };"),
]
UNIONS = [
    "union U switch (long) { case 1: sequence<U> kids; };",
    "union U;\ntypedef sequence<U> Us;\nunion U switch (long) { case 1: Us kids; };",
    "struct B;\nunion U switch (long) { case 1: sequence<B> kids; };\nstruct B { U u; };",
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
                              capture_output=True, text=True, check=False, timeout=PATIENCE)

    def refused(self, text):
        """What is said of a file that is not made."""
        with self.subTest(text), tempfile.TemporaryDirectory() as folder:
            done = self.generate(text, folder)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            self.assertFalse((pathlib.Path(folder) / "given.hpp").exists())
            return done.stdout + done.stderr
        return ""

    def test_recursive_types_are_refused(self):
        for line, text in RECURSIVE:
            said = self.refused(FINE + text + "\n")
            self.assertRegex(said, rf"given\.idl:{line}:\d+: ddssec cannot do a recursive type: keep all nodes in one seq")
            self.assertEqual(said.count("ddssec cannot do"), 1, said)
        for text in UNIONS:
            self.assertIn("ddssec cannot do a union: use a struct and an enum", self.refused(FINE + text + "\n"))

    def test_types_before_their_definition_are_refused(self):
        for line, text in UNDEFINED:
            said = self.refused(FINE + text + "\n")
            self.assertRegex(said, rf"given\.idl:{line}:\d+: ddssec cannot do a member of a type before its definition: ")
            self.assertNotIn("Type id not found", said)

    def test_a_recursive_type_of_an_included_file_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "tree.idl").write_text("@final struct T { sequence<T> kids; };\n", encoding="utf-8")
            done = self.generate('#include "tree.idl"\n@final struct S { sequence<T> trees; };\n', folder)
            self.assertIn("given.idl:2:8: ddssec cannot do a recursive type: ", done.stdout + done.stderr)

    def test_forward_declarations_that_nothing_waits_for_are_fine(self):
        text = ("struct B;\n@final struct B { long x; };\n@final struct A { B one; sequence<B> more; };\n"
                "@final struct C { A a[2]; B b; };\n")
        with tempfile.TemporaryDirectory() as folder:
            done = self.generate(text, folder)
            self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))

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
        return self.run_explained([str(file)], "false")

    def run_explained(self, arguments, *idlc, seconds=PATIENCE):
        return subprocess.run([EXPLAIN, *arguments, str(seconds), *idlc], capture_output=True, text=True,
                              check=False, timeout=2 * PATIENCE)

    def test_what_idlc_does_well_needs_no_explanation(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "given.idl"
            file.write_text("struct S { any x; };\n", encoding="utf-8")
            done = self.run_explained([str(file)], "true")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            done = self.run_explained([str(file)], f"{folder}/no-idlc")
            self.assertEqual(done.returncode, 1)
            self.assertIn("no-idlc: No such file", done.stderr)

    def hanging_idlc(self, folder):
        """An executable that says which process it is, and hangs."""
        path = pathlib.Path(folder) / "idlc"
        path.write_text(f'#!/bin/sh\necho $$ > "{folder}/pid"\nexec sleep {10 * PATIENCE}\n', encoding="utf-8")
        path.chmod(0o755)
        return path

    def assert_ended(self, folder):
        pid = int((pathlib.Path(folder) / "pid").read_text(encoding="utf-8"))
        with self.assertRaises(ProcessLookupError, msg="idlc runs on"):
            os.kill(pid, 9)

    def test_an_idlc_that_hangs_is_stopped(self):
        with tempfile.TemporaryDirectory() as folder:
            done = self.run_explained(["given.idl"], str(self.hanging_idlc(folder)), seconds=1)
            self.assertEqual(done.returncode, 1)
            self.assertIn("given.idl: idlc was stopped after 1 s: ", done.stderr)
            self.assert_ended(folder)

    def test_a_build_with_an_idlc_that_hangs_ends(self):
        with tempfile.TemporaryDirectory() as folder:
            top = pathlib.Path(folder)
            (top / "given.idl").write_text(FINE, encoding="utf-8")
            (top / "CMakeLists.txt").write_text(
                "cmake_minimum_required(VERSION 3.25)\nproject(p LANGUAGES NONE)\n"
                f"set(DDSSEC_IDLC {self.hanging_idlc(folder)})\nset(DDSSEC_IDLC_PLUGIN {PLUGIN})\n"
                f"set(DDSSEC_IDL_EXPLAIN {EXPLAIN})\ninclude({FUNCTION})\nddssec_idl_generate(types given.idl)\n",
                encoding="utf-8")
            # Nothing else of ddssec needs make.
            for command in (["-G", "Ninja", "-B", "build", "-DDDSSEC_IDLC_SECONDS=1"],
                            ["--build", "build", "--target", "types_idl"]):
                begin = time.monotonic()
                done = subprocess.run(["cmake", *command], cwd=folder, capture_output=True, text=True, check=False,
                                      timeout=2 * PATIENCE)
            self.assertNotEqual(done.returncode, 0, done.stdout)
            self.assertIn("given.idl: idlc was stopped after 1 s: ", done.stdout + done.stderr)
            self.assertLess(time.monotonic() - begin, PATIENCE)
            self.assert_ended(folder)

    def test_a_file_that_is_not_there_is_an_error_at_configure_time(self):
        for made, code in (("", 1), ("set_source_files_properties(forklif.idl PROPERTIES GENERATED TRUE)\n", 0)):
            with self.subTest(made), tempfile.TemporaryDirectory() as folder:
                (pathlib.Path(folder) / "CMakeLists.txt").write_text(
                    "cmake_minimum_required(VERSION 3.25)\nproject(p LANGUAGES NONE)\n"
                    f"set(DDSSEC_IDLC_PLUGIN {PLUGIN})\nset(DDSSEC_IDL_EXPLAIN {EXPLAIN})\ninclude({FUNCTION})\n{made}"
                    "ddssec_idl_generate(types forklif.idl)\n", encoding="utf-8")
                done = subprocess.run(["cmake", "-G", "Ninja", "-B", "build"], cwd=folder, capture_output=True, text=True,
                                      check=False, timeout=PATIENCE)
                self.assertEqual("there is no file" in done.stderr, code == 1, done.stderr)
                self.assertEqual(done.returncode, code, done.stderr)

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
            done = self.run_explained(["-I", str(top / "elsewhere"), str(top / "given.idl")], "false")
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
                done = self.run_explained(["-I", where, str(top / "given.idl")], "false")
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

#!/usr/bin/env python3
"""Holds what is installed to what the compiler and the linker can do against attackers, by its ELF headers, and finds paths of
the machine that built it.
Usage: hardening_test.py SOURCE BUILD"""

import pathlib
import platform
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
del sys.argv[1:3]
# They take no input of strangers, and call nothing that has a checked form.
WITHOUT_CHECKED_CALLS = {"libddssec_idlc.so", "ddssec-idl-explain"}


def readelf(options, file):
    return subprocess.run(["readelf", "-W", options, file], check=True, text=True, capture_output=True).stdout


class Hardening(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="ddssec-hardening-")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.root = pathlib.Path(cls.folder.name)
        subprocess.run(["cmake", "--install", BUILD, "--prefix", cls.root], check=True, stdout=subprocess.DEVNULL)
        cls.files = sorted(path for path in cls.root.rglob("*") if path.is_file() and not path.is_symlink())
        cls.programs = [path for path in cls.files if path.read_bytes()[:4] == b"\x7fELF"]
        cls.archives = [path for path in cls.files if path.suffix == ".a"]

    def each(self, files):
        self.assertTrue(files)
        for file in files:
            with self.subTest(file.name):
                yield file

    def test_all_programs_are_looked_at(self):
        names = {path.name for path in self.programs}
        self.assertLessEqual({"ddssec", "ddssec-keeper", "libddssec_authentication.so", "libddssec_access_control.so",
                              "libddssec_cryptography.so"}, names)

    def test_addresses_are_random(self):
        for file in self.each(self.programs):
            self.assertRegex(readelf("-hW", file), r"Type:\s+DYN")
            if file.suffix != ".so":
                self.assertRegex(readelf("-dW", file), r"FLAGS_1.*\bPIE\b")

    def test_tables_of_addresses_are_read_only(self):
        for file in self.each(self.programs):
            self.assertIn("GNU_RELRO", readelf("-lW", file))
            self.assertRegex(readelf("-dW", file), r"BIND_NOW|FLAGS_1.*\bNOW\b")

    def test_nothing_is_writable_and_executable(self):
        for file in self.each(self.programs):
            segments = readelf("-lW", file)
            self.assertRegex(segments, r"GNU_STACK\s+(0x\w+\s+){5}RW\s")
            self.assertNotRegex(segments, r"\bLOAD\s+(0x\w+\s+){5}RWE")
            self.assertNotIn("TEXTREL", readelf("-dW", file))

    def test_the_loader_searches_no_folder_of_the_build(self):
        for file in self.each(self.programs):
            self.assertNotRegex(readelf("-dW", file), r"\((RPATH|RUNPATH)\)")

    def test_the_stack_is_guarded_and_calls_are_checked(self):
        for file in self.each(self.programs):
            imported = readelf("--dyn-syms", file)
            self.assertIn("__stack_chk_fail", imported)
            if file.name not in WITHOUT_CHECKED_CALLS:
                self.assertRegex(imported, r"__(mem\w+|str\w+|v?f?printf|v?snprintf|read|recv\w*)_chk")

    @unittest.skipUnless(platform.machine() == "x86_64", "only x86-64 has it")
    def test_jumps_have_marked_targets(self):
        for file in self.each(self.archives):
            with_code = re.split(r"^File: ", readelf("-SW", file), flags=re.MULTILINE)[1:]
            code = {part.split("\n")[0] for part in with_code if re.search(r"\.text\S*\s+PROGBITS\s+\w+\s+\w+\s+(?!0+\s)\w+", part)}
            notes = re.split(r"^File: ", readelf("-nW", file), flags=re.MULTILINE)[1:]
            marked = {part.split("\n")[0] for part in notes if "IBT, SHSTK" in part}
            self.assertEqual(code - marked, set())

    def test_no_file_names_the_folder_that_it_was_built_in(self):
        for file in self.each(self.files):
            octets = file.read_bytes()
            for folder in (SOURCE, BUILD):
                self.assertIsNone(re.search(rb"(?<![\w.}])" + re.escape(str(folder).encode()) + b"/", octets), folder)


if __name__ == "__main__":
    unittest.main()

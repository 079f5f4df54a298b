#!/usr/bin/env python3
"""Holds the bill of materials (scripts/sbom.sh) to what the installed files link, as ldd says.
Usage: sbom_test.py SOURCE BUILD"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE, BUILD = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
del sys.argv[1:3]
ALWAYS = {"openssl", "libsodium", "tinyxml2", "fmtlib", "sqlite3", "libpcap", "nlohmann-json3", "cli11", "tomlplusplus", "glibc"}


def output_of(*command):
    return subprocess.run(command, check=True, text=True, capture_output=True).stdout


class Bill(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="ddssec-sbom-")
        cls.addClassCleanup(cls.folder.cleanup)
        cls.at = pathlib.Path(cls.folder.name)
        cls.text = cls.write("first.json")
        cls.bill = json.loads(cls.text)
        cls.components = cls.bill["components"]
        subprocess.run(["cmake", "--install", BUILD, "--prefix", cls.at / "installed"], check=True, stdout=subprocess.DEVNULL)

    @classmethod
    def write(cls, name):
        output_of(SOURCE / "scripts/sbom.sh", "--build", BUILD, "--out", cls.at / name)
        return (cls.at / name).read_text(encoding="utf-8")

    def test_it_is_cyclonedx(self):
        self.assertEqual((self.bill["bomFormat"], self.bill["specVersion"]), ("CycloneDX", "1.5"))
        self.assertRegex(self.bill["serialNumber"], r"^urn:uuid:[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$")
        references = [part["bom-ref"] for part in [self.bill["metadata"]["component"], *self.components]]
        self.assertEqual(len(references), len(set(references)))
        for edge in self.bill["dependencies"]:
            self.assertLessEqual({edge["ref"], *edge["dependsOn"]}, set(references))
        self.assertEqual({edge["ref"] for edge in self.bill["dependencies"]}, set(references))

    def test_each_part_has_version_and_licence(self):
        for part in self.components:
            self.assertTrue(part["version"], part)
            [licence] = part["licenses"]
            self.assertTrue(licence.get("expression") or licence["license"]["name"], part)

    def test_versions_are_the_installed_ones(self):
        for part in self.components:
            if part.get("purl"):
                self.assertEqual(output_of("dpkg-query", "--show", "--showformat", "${Version}\n", part["name"]).split()[0], part["version"])

    def test_the_product_is_whole(self):
        files = {path.relative_to(self.at / "installed").as_posix() for path in (self.at / "installed").rglob("*")
                 if path.is_file() and not path.is_symlink() and path.read_bytes()[:4] == b"\x7fELF"}
        self.assertGreater(len(files), 4)
        self.assertEqual(files, {part["name"] for part in self.components if "purl" not in part})

    def test_it_names_what_ldd_names(self):
        libraries = set()
        for part in self.components:
            if "purl" not in part:
                libraries |= set(re.findall(r"(?:=> |\t)/\S*?([^/\s]+) \(", output_of("ldd", self.at / "installed" / part["name"])))
        self.assertIn("libcrypto.so.3", libraries)
        packages = set()
        for library in libraries:
            lines = output_of("dpkg-query", "--search", f"*/{library}").splitlines()
            packages.add(next(line.split(":")[0] for line in lines if re.search(r"/lib(64|/x86_64-linux-gnu|/aarch64-linux-gnu)?/[^/]+$", line)))
        linked = {part["name"] for part in self.components
                  if any(use["value"].startswith("linked") for use in part.get("properties", []))}
        self.assertEqual(linked, packages)

    def test_sources_that_are_always_there(self):
        sources = {use["value"] for part in self.components for use in part.get("properties", [])}
        self.assertLessEqual(ALWAYS, sources)

    def test_the_same_build_gives_the_same_bytes(self):
        self.assertEqual(self.text, self.write("second.json"))

    def test_a_folder_that_is_no_build_is_refused(self):
        refused = subprocess.run([SOURCE / "scripts/sbom.sh", "--build", self.at], text=True, capture_output=True, check=False)
        self.assertEqual((refused.returncode, refused.stderr),
                         (1, f"sbom.sh: {self.at} is no build folder; scripts/test.sh and scripts/packages.sh make one\n"))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Libraries that cyclonedds.xml names by whole paths: the stock Cyclone DDS runs ddssec's plugins or does not start.

LD_LIBRARY_PATH is not set, as for an executable with file capabilities: by their names alone, Cyclone DDS would find
its own plugins.
Usage: whole_paths_test.py BUILD_FOLDER
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
OURS = "authentication, access control and cryptography of ddssec"


class WholePaths(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="ddssec-whole-paths-")
        self.addCleanup(self.folder.cleanup)
        self.at = pathlib.Path(self.folder.name)
        shutil.copytree(BUILD / "dropin", self.at / "dropin")  # the files, not the links
        subprocess.run([BUILD / "bin/ddssec", "init", "demo", "--dropin", "dropin", "-q"], cwd=self.at, check=True)

    def start(self, program="ddsperf", name="talker", action=("pub", "10Hz"), **more):
        environment = {key: value for key, value in os.environ.items() if key != "LD_LIBRARY_PATH"}
        environment["CYCLONEDDS_URI"] = f"file://{self.at}/demo/{name}/cyclonedds.xml"
        return subprocess.Popen([program, "-D", "3", *action], env={**environment, **more}, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def run_one(self, *words, **more):
        process = self.start(*words, **more)
        return process.communicate(timeout=20)[0], process.returncode

    def refused(self, reason):
        said, status = self.run_one()
        self.assertNotEqual(status, 0, said)
        self.assertIn(reason, said)
        self.assertNotIn("plugins_in_use", said)

    def test_two_applications_run_ours_and_samples_arrive(self):
        reader = self.start(name="listener", action=("sub",))
        said, _ = self.run_one()
        received = reader.communicate(timeout=20)[0]
        for text in (said, received):
            self.assertIn(OURS, text)
        self.assertRegex(received, r"total [1-9]")

    def test_the_loader_is_not_asked(self):
        said, _ = self.run_one(LD_LIBRARY_PATH="/usr/lib")
        self.assertIn(OURS, said)

    def test_without_the_folder_it_does_not_start(self):
        (self.at / "dropin").rename(self.at / "elsewhere")
        self.refused(f"Could not load Authentication library: {self.at}/dropin/libdds_security_auth.so")

    def test_without_one_library_it_does_not_start(self):
        for name in ("ac", "crypto"):
            library = self.at / f"dropin/libdds_security_{name}.so"
            library.rename(self.at / "kept")
            self.refused(str(library))
            (self.at / "kept").rename(library)

    def test_without_a_library_that_ours_need_it_does_not_start(self):
        library = self.at / "dropin/libdds_security_ac.so"
        needed = b"libtinyxml2.so"
        octets = library.read_bytes()
        self.assertIn(needed, octets)
        library.write_bytes(octets.replace(needed, b"libnowhere0.so"))
        self.refused("libnowhere0.so")


if __name__ == "__main__":
    unittest.main()

"""Folders for the tests of `ddssec doctor`: those of golden_folders.py, and the products that judge them."""

import tempfile

import golden_folders
from transcript import WithoutLists

VENDORS = ["cyclonedds@0.10.2", "fastdds@2.9.1", "ddssec"]


class DoctorTest(WithoutLists):
    NAMES = None  # of the folders to make; None: all

    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.TemporaryDirectory(prefix="ddssec-golden-")
        cls.addClassCleanup(cls.made.cleanup)
        cls.paths = golden_folders.make_all(cls.made.name, cls.NAMES)

    def doctor(self, name, *words, exit):
        return self.json("doctor", self.paths[name], *words, exit=exit)

#!/usr/bin/env python3
"""What doctor says about files of Fast DDS profiles, against what Fast DDS takes from them: a file that doctor calls ok
makes Fast DDS start with all security properties. One file for each row of governance/doctor/fastdds_elements.def, and
those of tests/cli/fastdds_profiles.py. Doctor knows less of Fast DDS 3: it says ok to fewer files.

Usage: fastdds_profiles_test.py SOURCES BUILD_FOLDER
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
SOURCES, BUILD = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
del sys.argv[1:3]
sys.path.insert(0, str(SOURCES / "tests/cli"))
from fastdds_profiles import CLEAN, DOUBTFUL, PLAIN, TRANSPORT, changed  # noqa: E402

ROW = re.compile(r'^X\("([^"]+)", (\w+), "([^"]*)"\)$', re.M)
VALUES = {"text": ["a b"], "texts": ["a"], "boolean": ["true", "false"], "number": ["0", "2147483647"],
          "octet": ["0", "255"], "port": ["0", "65535"], "domain": ["0", "232"],
          "seconds": ["0", "2147483647", "DURATION_INFINITY"], "address": ["127.0.0.1", "239.255.0.1"]}
NOT_BESIDE = {"transport", "group", "list", "profile"}
PROPERTIES = "participant/rtps/propertiesPolicy"


def nested(path, value):
    for name in reversed(path.split("/")):
        value = f"<{name}>{value}</{name}>"
    return value


def files_for_rows(correct):
    """A file for each value of each row that holds text."""
    for path, form, keywords in ROW.findall((SOURCES / "governance/doctor/fastdds_elements.def").read_text()):
        if form in NOT_BESIDE or path.startswith(PROPERTIES):
            continue
        root, rest = path.split("/", 1)
        for value in keywords.split("|") if form == "keyword" else VALUES[form]:
            if path.startswith("participant/rtps/"):
                yield path, correct.replace("<propertiesPolicy>", nested(path.split("/", 2)[2], value) + "<propertiesPolicy>")
            elif root == "participant":
                yield path, correct.replace("<rtps>", nested(rest, value) + "<rtps>")
            elif root == "transport_descriptors":
                kind, inner = ("SHM", "") if rest.endswith(("/transport_id", "/type")) else ("UDPv4", nested(rest.split("/")[1], value))
                if rest.count("/") > 1:
                    inner = nested(rest.split("/", 1)[1], value)
                kind = value if rest.endswith("/type") else kind
                described = TRANSPORT.format(kind).replace("</transport_descriptor>", inner + "</transport_descriptor>")
                yield path, correct.replace("<participant ", described + "<participant ", 1)
            else:
                for kind in ("data_writer", "data_reader", "publisher", "subscriber") if root == "endpoint" else (root,):
                    profile = f'<{kind} profile_name="p">{nested(rest, value)}</{kind}>'
                    yield f"{kind}: {path}", correct.replace("</profiles>", profile + "</profiles>")


class FastDdsProfiles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ddssec-fastdds-profiles-")
        self.addCleanup(folder.cleanup)
        self.at = pathlib.Path(folder.name)
        subprocess.run([BUILD / "bin/ddssec", "init", "demo", "-q"], cwd=self.at, check=True)
        self.talker = self.at / "demo/talker"
        self.profile = self.talker / "fastdds.xml"
        self.correct = self.profile.read_text()
        (self.talker / "cyclonedds.xml").unlink()
        self.wanted = self.taken()
        self.assertIn("dds.sec.auth.plugin=builtin.PKI-DH", self.wanted)
        linked = subprocess.run(["ldd", BUILD / "bin/fastdds_profile"], text=True, stdout=subprocess.PIPE, check=True).stdout
        self.is_newer = "libfastrtps.so.2" not in linked

    def environment(self, **more):
        both = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")  # before Fast DDS 3, and since
        return {**os.environ, **dict.fromkeys(both, str(self.profile)), **more}

    def taken(self, **more):
        """The security properties that Fast DDS takes from the file."""
        done = subprocess.run([BUILD / "bin/fastdds_profile"], cwd=self.at, env=self.environment(**more), text=True,
                              stdout=subprocess.PIPE, check=True)
        return [line for line in done.stdout.splitlines() if line.startswith("dds.sec.")]

    def says_ok(self, **more):
        done = subprocess.run([BUILD / "bin/ddssec", "doctor", "demo/talker", "--vendor", "fastdds", "--format", "json"],
                              cwd=self.at, env=self.environment(**more), text=True, stdout=subprocess.PIPE)
        answer = json.loads(done.stdout)
        self.assertEqual(answer["exit"] == 0, set(answer["result"]["verdicts"].values()) == {"ok"})
        return answer["exit"] == 0

    def test_known_variants(self):
        for rows, is_ok in ((DOUBTFUL, False), (CLEAN, True)):
            for row in rows:
                with self.subTest(row[0]):
                    self.profile.write_text(changed(self.correct, row))
                    is_taken, says_ok = set(self.taken()) == set(self.wanted), self.says_ok()
                    if self.is_newer:
                        self.assertLessEqual(says_ok, is_ok and is_taken)
                    else:
                        self.assertEqual((is_taken, says_ok), (is_ok or row[2], is_ok))

    def test_every_row_of_the_table(self):
        count = 0
        for path, text in files_for_rows(self.correct):
            with self.subTest(path, text=text):
                self.assertNotEqual(text, self.correct)
                self.profile.write_text(text)
                if not self.is_newer or self.says_ok():
                    self.assertEqual(self.taken(), self.wanted)
                    count += 1
        self.assertGreater(count, 0 if self.is_newer else 200)

    def test_the_file_in_the_working_directory(self):
        other = self.at / f"DEFAULT_{'FASTDDS' if self.is_newer else 'FASTRTPS'}_PROFILES.xml"
        other.write_text(f"<profiles>{PLAIN.format('mine')}</profiles>")
        self.assertEqual((self.taken(), self.says_ok()), ([], False))
        skipped = {"SKIP_DEFAULT_XML_FILE": "1"}
        self.assertEqual((self.taken(**skipped), self.says_ok(**skipped)), (self.wanted, True))
        other.write_text('<profiles><data_writer profile_name="w"><qos/></data_writer></profiles>')
        self.assertEqual((self.taken(), self.says_ok()), (self.wanted, True))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""doctor reads the folder's fastdds.xml as Fast DDS does. Each row of UNSECURED was measured with Fast DDS 2.9.1: a
participant without any security reads what a process with this profile writes."""

import re

from fastdds_profiles import CLEAN, DOUBTFUL, PLAIN, changed
from transcript import NOW, Transcript, main

UNSECURED = [(r"<property><name>dds\.sec\.\w+\.plugin<.*\n", "", "no property dds.sec.auth.plugin"),
             (r"<property><name>dds\.sec\.auth\.plugin<.*\n", "", "no property dds.sec.auth.plugin"),
             (r"builtin\.PKI-DH</value>", "builtin.PKIDH</value>", 'which must be "builtin.PKI-DH"'),
             (r"dds\.sec\.auth\.plugin<", "dds.sec.auth.plugins<", "no property dds.sec.auth.plugin"),
             (r' is_default_profile="true"', "", "is_default_profile"),
             (r"<property>.*\n", "", "no property"), (r"</profiles>", "", "cannot be read"),
             (r"</profiles>", "</profiles><?x y?>", "cannot be read")]
# Measured as well: it starts and does not match such a participant; it does not start.
OTHER = [(r"<property><name>dds\.sec\.crypto\.plugin<.*\n", "", "DOC101", "no property dds.sec.crypto.plugin"),
         (r"<property><name>dds\.sec\.auth\.builtin\.PKI-DH\.private_key<.*\n", "", "DOC102", "names no dds.sec.auth")]


class FastDdsProfile(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "-q", *NOW)
        self.profile = self.at / "demo/talker/fastdds.xml"
        self.correct = self.profile.read_text()

    def told(self, *words, exit, **more):
        answer = self.json("doctor", "demo/talker", *words, *NOW, exit=exit, **more)
        return answer["result"]["verdicts"], [(one["id"], one["severity"], one["message"]) for one in answer["diagnostics"]
                                              if re.search("fastdds.xml|FASTRTPS|FASTDDS", one["message"])]

    def test_profiles_with_which_fast_dds_is_not_secured(self):
        rows = [(old, new, "DOC101", words) for old, new, words in UNSECURED] + OTHER
        for old, new, rule, words in rows:
            changed = re.sub(old, new, self.correct)
            self.assertNotEqual(changed, self.correct)
            self.profile.write_text(changed)
            with self.subTest(old=old, new=new):
                verdicts, told = self.told("--vendor", "fastdds", exit=1)
                self.assertEqual(verdicts, {"fastdds@2.9.1": "unsafe" if "crypto" in old else "fail"})
                self.assertIn((rule, "error", words), [(id, severity, words if words in message else message)
                                                       for id, severity, message in told])
                self.assertEqual(self.told("--vendor", "cyclonedds", exit=0)[1], [])

    def test_a_profile_with_other_settings(self):
        self.profile.write_text('<?xml version="1.0" encoding="UTF-8"?>\n<!-- ours -->\n<dds>' + self.correct.replace(
            "<rtps>", "<domainId>0</domainId><rtps>") + "</dds>")
        self.assertEqual(self.told(exit=0), ({"cyclonedds@0.10.2": "ok", "fastdds@2.9.1": "ok", "ddssec": "ok"}, []))

    def test_files_that_fast_dds_may_ignore(self):
        for row in DOUBTFUL:
            with self.subTest(row[0]):
                self.profile.write_text(changed(self.correct, row))
                verdicts, told = self.told("--vendor", "fastdds", exit=1)
                self.assertEqual(verdicts, {"fastdds@2.9.1": "fail"})
                self.assertTrue({"DOC101", "DOC108"} & {one[0] for one in told if one[1] == "error"}, told)
        for row in CLEAN:
            with self.subTest(row[0]):
                self.profile.write_text(changed(self.correct, row))
                told = self.told("--vendor", "fastdds", exit=0, environment=self.variable(self.profile))
                self.assertEqual(told, ({"fastdds@2.9.1": "ok"}, []))

    def test_a_finding_names_the_element_and_the_line(self):
        self.profile.write_text(self.correct.replace("<propertiesPolicy>",
                                                     "<useBuiltinTransports>yes</useBuiltinTransports><propertiesPolicy>"))
        answer = self.json("doctor", "demo/talker", "--vendor", "fastdds", *NOW, exit=1)
        found = [one for one in answer["diagnostics"] if one["id"] == "DOC108"]
        self.assertIn('fastdds.xml has <useBuiltinTransports> with the value "yes"', found[0]["message"])
        self.assertIn("runs WITHOUT security", found[0]["message"])
        self.assertEqual(found[0]["line"], 3)

    def test_elements_of_fast_dds_3_are_not_all_known(self):
        other = self.correct.replace("<propertiesPolicy>", "<useBuiltinTransports>true</useBuiltinTransports><propertiesPolicy>")
        self.profile.write_text(other)
        self.told("--vendor", "fastdds", exit=0)
        self.assertEqual({one[0] for one in self.told("--vendor", "fastdds@3.1.2", exit=1)[1] if one[1] == "error"}, {"DOC108"})

    # Measured with Fast DDS 2.9.1: it does not start with any of them.
    def test_paths_that_fast_dds_does_not_read(self):
        folder = self.at / "demo/talker"
        for name in ("identity_ca.pem", "cert.pem", "key.pem", "crl.pem", "permissions_ca.pem", "governance.p7s",
                     "permissions.p7s"):
            path = f"{folder}/{name}"
            for value in (f"file:{path}", path, f" file://{path}", f"file://{path} ", f"\nfile://{path}\n"):
                with self.subTest(value=value):
                    self.profile.write_text(self.correct.replace(f"file://{path}", value))
                    told = self.told("--vendor", "fastdds", exit=1)[1]
                    self.assertIn("DOC008", {one[0] for one in told})

    def test_the_file_in_the_working_directory(self):
        fastdds, own = ("--vendor", "fastdds"), self.variable(self.profile)
        other = self.at / "DEFAULT_FASTRTPS_PROFILES.xml"
        for text in (f"<profiles>{PLAIN.format('mine')}</profiles>", f"<dds>{PLAIN.format('mine')}</dds>", "<"):
            other.write_text(text)
            told = self.told(*fastdds, exit=1, environment=own)[1]
            self.assertEqual([one[:2] for one in told], [("DOC101", "error")])
            self.assertIn("DEFAULT_FASTRTPS_PROFILES.xml in the working directory", told[0][2])
        self.assertEqual(self.told(*fastdds, exit=0, environment={**own, "SKIP_DEFAULT_XML_FILE": "1"})[1], [])
        self.assertEqual(self.told("--vendor", "cyclonedds", exit=0, environment=own)[1], [])
        for text in ('<profiles><data_writer profile_name="w"><qos/></data_writer></profiles>', self.correct):
            other.write_text(text)
            self.assertEqual(self.told(*fastdds, exit=0, environment=own)[1], [])

    def test_fast_dds_3_has_other_names(self):
        new = {"FASTDDS_DEFAULT_PROFILES_FILE": str(self.profile)}
        fastdds = ("--vendor", "fastdds@3.1.2")
        self.assertEqual(self.told(*fastdds, exit=0, environment=new)[1], [])
        told = self.told(*fastdds, exit=0, environment=self.variable(self.profile))[1]
        self.assertEqual([one[:2] for one in told], [("DOC101", "warning")])
        self.assertIn("FASTDDS_DEFAULT_PROFILES_FILE is not set", told[0][2])
        (self.at / "DEFAULT_FASTRTPS_PROFILES.xml").write_text(f"<profiles>{PLAIN.format('mine')}</profiles>")
        self.assertEqual(self.told(*fastdds, exit=0, environment=new)[1], [])
        (self.at / "DEFAULT_FASTDDS_PROFILES.xml").write_text(f"<profiles>{PLAIN.format('mine')}</profiles>")
        self.assertIn("in the working directory", self.told(*fastdds, exit=1, environment=new)[1][0][2])

    @staticmethod
    def variable(value):
        return {"FASTRTPS_DEFAULT_PROFILES_FILE": str(value)}

    def test_the_variable(self):
        variable = self.variable
        fastdds = ("--vendor", "fastdds")
        for environment, words in ((None, "is not set in this shell"), (variable(""), "is empty in this shell")):
            told = self.told(*fastdds, exit=0, environment=environment)[1]
            self.assertEqual([one[:2] for one in told], [("DOC101", "warning")])
            self.assertIn(words, told[0][2])
        self.assertEqual(self.told(*fastdds, exit=0, environment=variable(self.profile))[1], [])
        for other in ("demo/listener/fastdds.xml", "demo/talker/cert.pem", "gone.xml"):
            told = self.told(*fastdds, exit=0, environment=variable(self.at / other))[1]
            self.assertEqual([one[:2] for one in told], [("DOC101", "warning")])
        own = self.at / "own.xml"
        own.write_text(self.correct.replace("builtin.PKI-DH</value>", "none</value>"))
        told = self.told(*fastdds, exit=1, environment=variable(own))[1]
        self.assertEqual([one[:2] for one in told], [("DOC101", "error")])


if __name__ == "__main__":
    main()

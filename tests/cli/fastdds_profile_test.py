#!/usr/bin/env python3
"""doctor reads the folder's fastdds.xml as Fast DDS does. Each row of UNSECURED was measured with Fast DDS 2.9.1: a
participant without any security reads what a process with this profile writes."""

import re

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
                                              if "fastdds.xml" in one["message"] or "FASTRTPS" in one["message"]]

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
        self.assertEqual(self.told(exit=0), ({"cyclonedds@0.10.2": "ok", "fastdds@2.9.1": "ok", "ours": "ok"}, []))

    def test_the_variable(self):
        def variable(value):
            return {"FASTRTPS_DEFAULT_PROFILES_FILE": str(value)}

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

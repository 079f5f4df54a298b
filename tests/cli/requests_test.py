#!/usr/bin/env python3
"""identity sign-csr: which subjects a request may ask for, and what is said of the answer to its question."""

import os
import pty
import subprocess

from transcript import NOW, PROGRAM, Transcript, main


class Requests(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)

    def request(self, subject):
        self.openssl("req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", "r.key",
                     "-subj", subject, "-out", "r.pem")
        return ("identity", "sign-csr", "r.pem", "--ca", "demo", "-o", "cert.pem", *NOW)

    def test_no_participant_gets_the_name_of_a_ca(self):
        for subject in ("/CN=demo Identity CA", "/CN=demo Permissions CA"):
            for more in ((), ("--another-key",)):
                told = self.refused("subject_taken", 4, *self.request(subject), "--yes", *more)
                self.assertIn("which is a CA's", told["message"])

    def test_nor_none(self):
        self.refused("subject_name_malformed", 2, *self.request("/"), "--yes")

    # Measured: Cyclone DDS's own plugins give O=acme the permissions of O=acme,CN=talker, and /a those of /a/b.
    def test_no_part_of_another_subject(self):
        for subject, other in (("/O=acme/CN=robot", "/O=acme"), ("/CN=one", "/CN=one/OU=x"), ("/CN=\\/a\\/b", "/CN=\\/a")):
            (self.at / "cert.pem").unlink(missing_ok=True)
            self.run_program(*self.request(subject), "--yes")
            (self.at / "cert.pem").unlink()
            told = self.refused("subject_taken", 4, *self.request(other), "--yes")
            self.assertIn("compare the certificate's attributes only", told["message"])
            self.run_program(*self.request(other), "--yes", "--another-key")
        (self.at / "cert.pem").unlink()
        self.run_program(*self.request("/O=plant/CN=robot7"), "--yes")  # one attribute in common is no matter

    def test_nor_for_a_participant_that_is_issued(self):
        issue = ("identity", "issue", "x", "--ca", "demo", *NOW)
        self.refused("subject_taken", 4, *issue, "-o", "x", "--subject", "CN=talker,O=acme")
        self.run_program(*issue, "-o", "x", "--subject", "CN=x,O=acme")
        self.run_program(*issue, "-o", "x", "--subject", "CN=x", "--replace")  # its own one does not count
        self.refused("subject_taken", 4, *issue, "-o", "y", "--subject", "CN=x,O=other")
        (self.at / "fleet.toml").write_text('[[participant]]\nname = "a"\n[[participant]]\nname = "b"\nsubject = "CN=a,O=b"\n')
        self.refused("subject_taken", 4, "identity", "issue", "--from", "fleet.toml", "--ca", "demo", "-o", "fleet", *NOW)

    def test_an_answer_that_is_not_yes_is_called_so(self):
        words = self.request("/CN=device")
        for answer, exit in ((b"n\n", 4), (b"\n", 4), (b"y\n", 0)):
            ours, theirs = pty.openpty()
            os.write(ours, answer)
            done = subprocess.Popen([PROGRAM, *words], cwd=self.at, stdin=theirs, stdout=theirs, stderr=theirs)
            os.close(theirs)
            self.assertEqual(done.wait(timeout=60), exit)
            text = os.read(ours, 65536).decode()
            os.close(ours)
            self.assertEqual("error[not_confirmed]" in text, exit != 0, text)


if __name__ == "__main__":
    main()

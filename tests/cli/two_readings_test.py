#!/usr/bin/env python3
"""A signed file that two readers read as two documents is an error for every command. The header is not signed, so
anyone who passes the file on can change it."""

import re
import subprocess

from transcript import NOW, PROGRAM, Transcript, main

HEADER = b'Content-Type: multipart/signed; protocol="application/x-pkcs7-signature"; micalg="sha-256"'


class TwoReadings(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "--participant", "a", "--participant", "b", "-q", *NOW)
        self.run_program("governance", "new", "--profile", "open", "-o", "old.xml", "--sign", "--ca", "demo", "-q", *NOW)
        self.run_program("governance", "sign", self.hide_old_document(), "--ca", "demo", "-o", "strict.p7s", "-q", *NOW)

    def hide_old_document(self):
        """Strict XML that the CA will sign, with a genuine open document inside."""
        old, strict = (self.at / "old.p7s").read_bytes(), (self.at / "demo/governance.xml").read_bytes()
        self.old = re.search(rb'boundary="([^"]+)"', old).group(1)
        parts = old[old.index(b"--" + self.old + b"\n"):].rstrip(b"\n") + b"\n"
        rule = re.search(rb"<topic_rule>.*?</topic_rule>", strict, re.S).group(0)
        hidden = re.sub(rb"<topic_expression>.*</topic_expression>",
                        lambda _: b"<topic_expression><![CDATA[never\n" + parts + b"]]></topic_expression>", rule)
        (self.at / "strict.xml").write_bytes(strict.replace(rule, hidden + rule, 1))
        return "strict.xml"

    def with_header(self, parameters):
        signed = (self.at / "strict.p7s").read_bytes()
        ours = re.search(rb'boundary="([^"]+)"', signed).group(1)
        parameters = parameters.replace(b"OURS", ours).replace(b"OLD", self.old)
        changed = re.sub(rb"Content-Type: multipart/signed.*\n", lambda _: HEADER + parameters + b"\n", signed, count=1)
        for file in ("two.p7s", "demo/a/governance.p7s", "demo/b/governance.p7s"):
            (self.at / file).write_bytes(changed)

    def answers(self):
        yield ("governance", "lint", "two.p7s")
        yield ("governance", "diff", "demo/governance.p7s", "two.p7s")
        yield ("governance", "show", "two.p7s")
        yield ("governance", "verify", "two.p7s", "--ca", "demo")
        for product in ("ddssec", "cyclonedds", "fastdds"):
            yield ("doctor", "demo/a", "--vendor", product)
            yield ("check", "demo/a", "demo/b", "--vendor", product)

    def test_headers_that_openssl_reads_differently(self):
        for parameters in (b'; x=a"; boundary=OURS; w="; boundary=OLD; v="', b'; boundary=OURS\nX: (\n ; boundary=OLD',
                           b"; boundary=OLD; boundary=OURS"):
            self.with_header(parameters)
            for words in self.answers():
                with self.subTest(words=words, parameters=parameters):
                    done = subprocess.run([PROGRAM, *words, *NOW], cwd=self.at, capture_output=True, timeout=60, check=False)
                    self.assertIn(done.returncode, (1, 3), done.stdout + done.stderr)

    def test_the_same_file_with_a_plain_header_is_taken(self):
        self.with_header(b"; boundary=OURS")
        for words in self.answers():
            with self.subTest(words=words):
                self.run_program(*words, *NOW, exit=0)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""What Cyclone DDS 0.10.2 and Fast DDS 2.9.1 start with although ddssec refuses it: doctor calls it unsafe, not a failure, and check says
that it cannot say. Each row was measured with real pairs on stock plugins."""

import json
import subprocess

from transcript import PROGRAM, WithoutLists, main
from workshop import GOVERNANCE, Folder, Workshop, grant, openssl, permissions

# Document, what is replaced, by what: the participants come up and talk.
TAKEN = [("g", "<id>0<", "<id>+0<"), ("p", "<id>0<", "<id>0x0<"), ("g", "<id>0<", "<id>0X0<"), ("g", "<id>0<", "<id>00<"),
         ("p", "<id>0<", "<id><"),
         ("p", ">DENY<", ">deny<"), ("p", ">DENY<", ">FOO<"), ("p", ">DENY<", "><"),
         ("p", "2020-01-01T00:00:00Z", "1969-12-31T23:59:59Z"), ("p", "2020-01-01T00:00:00Z", "yesterday"),
         ("p", ">Square</topic>", ">Square</topic><topic/>"), ("p", ' name="participant"', ' name="a" name="b"'),
         ("g", ">false<", "><"), ("g", ">SIGN<", "><"),
         ("g", "<id>0<", "<id>-0<"), ("g", "<id>0<", "<id>4294967296</id><id>0<"),
         ("g", "<topic_expression>", "<topic_expression>other</topic_expression><topic_expression>"),
         ("p", "<default>DENY<", "<default>DENY</default><default>ALLOW<"),
         ("p", "<not_after>", "<not_after>2021-01-01T00:00:00Z</not_after><not_after>"),
         ("p", "<permissions>", "<permissions></permissions><permissions>"), ("g", "<topic_rule>", "<!-- \x01 --><topic_rule>")]
# The participants come up; there are no rights in what is empty.
EMPTY = [("p", "<publish><topics><topic>Square</topic></topics>", "<publish><topics></topics>"),
         ("p", "<publish><topics><topic>Square</topic></topics>", "<publish>"),
         ("p", "</topics></publish>", "</topics><partitions></partitions></publish>")]
# The same for Fast DDS.
TAKEN_BY_FASTDDS = [("g", "<id>0<", "<id>-0<"), ("g", "<id>0<", "<id>+0<"), ("g", "<id>0<", "<id>0</id><id>231<"),
                    ("g", "<topic_rule>", "hello<topic_rule>"), ("g", "</dds>", "</dds><dds/>"), ("g", ">true<", ">01<"),
                    ("g", "<id>0<", "<id_range><min>5</min><max>3</max></id_range><id>0<"),
                    ("p", "2037-01-01T", "2037-02-30T"), ("p", "2037-01-01T00:00:00Z", "2036-06-30T23:59:60Z"),
                    ("p", "<default>DENY<", "<default>DENY</default><default>ALLOW<"), ("p", ">Square<", ">Squ<!-- -->are<"),
                    ("p", "</not_after>", "</not_after><not_after>2021-01-01T00:00:00Z</not_after>"),
                    ("g", "<topic_rule>", "<!-- \x01 --><topic_rule>"), ("p", "2020-01-01T00:00:00Z", "0001-01-01T00:00:00Z"), ("p", "2020-01-01T00:00:00Z", "2020-1-1T0:0:0Z"),
                    ("p", "<publish><topics><topic>Square</topic></topics>", "<publish>")]
REFUSED_BY_FASTDDS = [("g", "<topic_expression>", "<topic_expression>other</topic_expression><topic_expression>"),
                      ("g", "<topic_rule>", "<?x y?><topic_rule>"),
                      ("p", "2020-01-01T00:00:00Z", "2020-01-01 00:00:00Z"), ("p", "2020-01-01T00:00:00Z", "2020-13-01T00:00:00Z"),
                      ("p", "2020-01-01T00:00:00Z", "2020-01-01T00:00Z"), ("p", "2020-01-01T00:00:00Z", "garbage"),
                      ("p", "2037-01-01T00:00:00Z", "10000-01-01T00:00:00Z"),
                      ("g", ">true<", ">yes<"), ("p", ">DENY<", ">deny<"), ("p", "<publish>", "<foo/><publish>")]
# The participants do not come up; with an empty topic_expression the process crashes.
REFUSED = [("g", "<id>0<", "<id>abc<"), ("p", "<id>0<", "<id>-1<"), ("g", "<id>0<", "<id>231<"), ("p", "<id>0<", "<id>00x<"),
           ("p", "2020-01-01T00:00:00Z", ""), ("p", "2037-01-01T00:00:00Z", "tomorrow"),
           ("p", "2037-01-01T00:00:00Z", "1960-01-01T00:00:00Z"), ("g", ">false<", ">yes<"), ("g", ">SIGN<", ">FOO<"),
           ("g", "<topic_expression>*<", "<topic_expression><"), ("p", "<publish>", "<foo/><publish>"),
           ("p", "<publish>", "<Foo/><publish>"), ("g", "</topic_expression>", "</TOPIC_expression>")]
CAPITALS = [("p", "publish>"), ("p", "subscribe>"), ("p", "topics>"), ("p", "topic>"), ("p", "allow_rule>"),
            ("p", "validity>"), ("p", "not_before>"), ("p", "domains>"), ("g", "domain_rule>"), ("g", "topic_rule>"),
            ("g", "rtps_protection_kind>"), ("g", "topic_expression>"), ("g", "id>")]
PLAIN = ' protocol="application/x-pkcs7-signature";'


class StockSpelling(WithoutLists):
    def setUp(self):
        super().setUp()
        shop = Workshop(self.at / "shop")
        self.folders = [Folder(shop, self.at / name, f"/CN={name}", name) for name in ("talker", "partner")]

    def sign(self, what, old, new):
        for folder in self.folders:
            texts = {"g": GOVERNANCE, "p": permissions(grant(folder.subject))}
            for name, document in (("governance", "g"), ("permissions", "p")):
                text = texts[document].replace(old, new) if document == what else texts[document]
                self.assertTrue(document != what or text != texts[document])
                folder.sign(name, text)

    def judged(self, product="cyclonedds", version="0.10.2"):
        """The verdict for the product, and how check ends for two participants on it."""
        done = self.run_program("doctor", "talker", "--format", "json", exit=None)
        verdicts = json.loads(done.stdout)["result"]["verdicts"]
        self.assertEqual(verdicts["ddssec"], "fail")
        check = subprocess.run([PROGRAM, "check", "talker", "partner", "--topics", "Square", "--vendor", product], cwd=self.at, capture_output=True, timeout=60, check=False)
        return verdicts[f"{product}@{version}"], check.returncode

    def test_values_that_cyclone_dds_takes(self):
        for what, old, new in TAKEN + EMPTY:
            self.sign(what, old, new)
            with self.subTest(what=what, old=old, new=new):
                self.assertEqual(self.judged(), ("unsafe", 3))

    def test_values_that_cyclone_dds_refuses(self):
        for what, old, new in REFUSED:
            self.sign(what, old, new)
            with self.subTest(what=what, old=old, new=new):
                self.assertEqual(self.judged(), ("fail", 1))

    def test_values_that_fast_dds_takes(self):
        for rows, verdict in ((TAKEN_BY_FASTDDS, ("unsafe", 3)), (REFUSED_BY_FASTDDS, ("fail", 1))):
            for what, old, new in rows:
                self.sign(what, old, new)
                with self.subTest(what=what, old=old, new=new):
                    self.assertEqual(self.judged("fastdds", "2.9.1"), verdict)

    def test_names_in_capitals_are_read_as_cyclone_dds_does(self):
        for what, name in CAPITALS:
            self.sign(what, name, name.title())
            with self.subTest(what=what, name=name):
                self.assertEqual(self.judged(), ("ok", 0))

    def test_signed_files_that_openssl_reads(self):
        for old, new in ((PLAIN, ""), ("Content-Transfer-Encoding: base64\n", "")):
            self.sign("p", "<permissions>", "<permissions> ")
            for folder in self.folders:
                file = folder.path / "permissions.p7s"
                text = file.read_bytes()
                self.assertIn(old.encode(), text)
                file.write_bytes(text.replace(old.encode(), new.encode()))
            with self.subTest(old=old):
                self.assertEqual(self.judged(), ("unsafe", 3))
        self.sign("p", "<permissions>", "<permissions> ")
        for folder in self.folders:  # unsigned text after the last boundary
            file = folder.path / "permissions.p7s"
            file.write_bytes(file.read_bytes() + b"\ntrailing text\n")
        self.assertEqual(self.judged(), ("unsafe", 3))
        for folder in self.folders:
            folder.replace("permissions.p7s", "Square", "Circle")  # now no product accepts it
        self.assertEqual(self.judged()[0], "fail")

    def test_certificates_and_keys_in_other_forms(self):
        talker = self.folders[0]
        talker.replace("identity_ca.pem", "CERTIFICATE", "X509 CERTIFICATE")
        self.assertEqual(self.judged(), ("unsafe", 3))
        talker.put("identity_ca.pem", talker.identity_ca / "cert.pem")
        openssl("ec", "-in", talker.key, "-param_enc", "explicit", "-out", talker.path / "key.pem")
        (talker.path / "key.pem").chmod(0o600)
        self.assertEqual(self.judged(), ("unsafe", 3))


if __name__ == "__main__":
    main()

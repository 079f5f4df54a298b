#!/usr/bin/env python3
"""A comment or CDATA inside a value, and values that Fast DDS refuses. Measured: Fast DDS 2.9 reads what stands before
the comment, Cyclone DDS 0.10.2 joins the pieces."""

from transcript import NOW, Transcript, main

VENDORS = ["cyclonedds@0.10.2", "fastdds@2.9.1", "ddssec"]


class Pieces(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "-q", *NOW)
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "*Foo", "-o", "permissions.xml", *NOW)
        self.texts = {"governance": (self.at / "demo/governance.xml").read_text(),
                      "permissions": (self.at / "permissions.xml").read_text()}

    def change(self, kind, old, new):
        self.assertIn(old, self.texts[kind])
        (self.at / "old.xml").write_text(self.texts[kind])
        (self.at / "new.xml").write_text(self.texts[kind].replace(old, new, 1))

    def sign_as_others_do(self, kind):
        authority = self.at / "demo/ca/permissions"
        self.openssl("smime", "-sign", "-text", "-in", "new.xml", "-out", f"demo/talker/{kind}.p7s", "-signer",
                     authority / "ca.pem", "-inkey", authority / "ca.key.pem")

    def warnings(self, kind):
        told = self.json(kind, "lint", "new.xml", *NOW)["diagnostics"]
        return [one["message"] for one in told if one["severity"] != "note"]

    CHANGES = (("governance", "<topic_expression>*", "<topic_expression>*<!-- all -->Foo"),
               ("governance", "<rtps_protection_kind>SIGN", "<rtps_protection_kind>SI<!-- -->GN"),
               ("governance", ">false</allow_un", "><![CDATA[fal]]>se</allow_un"),
               ("permissions", "<topic>*Foo", "<topic>*<!-- was: all -->Foo"),
               ("permissions", "<subject_name>CN=", "<subject_name>C<!-- -->N="))

    def test_every_command_refuses_it(self):
        for kind, old, new in self.CHANGES:
            with self.subTest(new=new):
                self.change(kind, old, new)
                for words in ((kind, "lint", "new.xml"), (kind, "sign", "new.xml", "--ca", "demo", "-o", "x.p7s", *NOW),
                              (kind, "diff", "old.xml", "new.xml", "--fail-on", "any"),
                              (kind, "diff", "new.xml", "old.xml")):
                    told = self.json(*words, exit=3)["diagnostics"]
                    self.assertEqual([one["id"] for one in told], ["value_in_pieces"], words)

    def test_doctor_predicts_each_product(self):
        for kind, old, new in self.CHANGES:
            with self.subTest(new=new):
                self.change(kind, old, new)
                signed = self.at / f"demo/talker/{kind}.p7s"
                before = signed.read_bytes()
                self.sign_as_others_do(kind)
                out = self.json("doctor", "demo/talker", *NOW, exit=1)
                checks = {check["title"]: check["verdicts"] for check in out["result"]["checks"]}
                self.assertEqual(checks[f"{kind}: document readable"], dict(zip(VENDORS, ["ok", "unsafe", "fail"])))
                self.run_program("check", "demo/talker", "demo/listener", *NOW, exit=1)
                self.run_program("can", "demo/talker", "publish", "Foo", *NOW, exit=3)
                signed.write_bytes(before)

    def test_a_comment_between_elements_is_no_matter(self):
        self.change("governance", "<domain_rule>", "<domain_rule><!-- all robots -->")
        self.assertEqual(self.warnings("governance"), [])

    # With each of these Fast DDS 2.9.1 does not start, and Cyclone DDS 0.10.2 and ddssec do.
    REFUSED = (("governance", ">false</allow_un", "> false </allow_un", "blanks"),
               ("governance", ">false</allow_un", ">fAlse</allow_un", "fAlse"),
               ("governance", ">SIGN</rtps", "> SIGN</rtps", "blanks"),
               ("permissions", ">DENY<", "> DENY <", "blanks"),
               ("permissions", "T00:00:00Z</not_before>", "T24:00:00Z</not_before>", "24:00:00"))

    def test_values_that_fast_dds_refuses(self):
        self.texts["permissions"] = self.texts["permissions"].replace(
            self.texts["permissions"].split("<not_before>")[1].split("<")[0], "2026-11-01T00:00:00Z")
        for kind, old, new, word in self.REFUSED:
            with self.subTest(new=new):
                self.change(kind, old, new)
                told = self.warnings(kind)
                self.assertEqual([word in message for message in told], [True], told)
                self.run_program(kind, "diff", "old.xml", "new.xml", "--fail-on", "any", exit=1)
                signed = self.at / f"demo/talker/{kind}.p7s"
                before = signed.read_bytes()
                self.sign_as_others_do(kind)
                verdicts = self.json("doctor", "demo/talker", *NOW, exit=1)["result"]["verdicts"]
                self.assertEqual(verdicts, dict(zip(VENDORS, ["ok", "fail", "ok"])))
                signed.write_bytes(before)

    def test_a_second_place_with_blanks_does_not_hide_behind_the_first(self):
        deny = "<deny_rule>" + self.texts["permissions"].split("<allow_rule>")[1].split("</allow_rule>")[0] + "</deny_rule>"
        text = self.texts["permissions"].replace("<allow_rule>", deny.replace("*Foo", "Bar") + "<allow_rule>", 1)
        self.texts["permissions"] = text.replace("<topic>*Foo", "<topic> *Foo")
        self.change("permissions", "<topic>Bar", "<topic> Bar")
        self.run_program("permissions", "diff", "old.xml", "old.xml", "--fail-on", "any")
        self.run_program("permissions", "diff", "old.xml", "new.xml", "--fail-on", "any", exit=1)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""governance lint and permissions lint: findings with line, path, hint and vendors; hostile files."""

import re

from transcript import DATA, NOW, WithDocuments, main


class Lint(WithDocuments):
    def edit(self, file, *pairs):
        text = (self.at / file).read_text()
        for old, new in pairs:
            self.assertIn(old, text)
            text = text.replace(old, new)
        (self.at / file).write_text(text)

    def lint(self, *words, exit=0):
        return self.json(*words, *NOW, exit=exit)

    def test_good_permissions_have_nothing(self):
        check = ["permissions", "lint", "p.xml", "--cert", "talker/cert.pem", "--governance", "g.xml"]
        self.lint(*check)
        self.assertEqual(self.run_program(*check, *NOW).stdout, "p.xml: nothing found\n")

    def test_what_a_good_document_leaves_open_is_a_note(self):
        out = self.lint("governance", "lint", "g.xml", "--domain", "0")
        self.assertEqual(out["result"], {"file": "g.xml", "errors": 0, "warnings": 0, "notes": 2})
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["GOV042", "GOV044"])

    def test_a_finding_has_all_that_it_takes(self):
        self.edit("g.xml", ("<topic_expression>*<", "<topic_expression>rt/[^a]<"))
        out = self.lint("governance", "lint", "g.xml", "--domain", "7", exit=1)
        self.assertEqual(out["result"], {"file": "g.xml", "errors": 1, "warnings": 2, "notes": 2})
        told = {d["id"]: d for d in out["diagnostics"]}
        self.assertEqual(sorted(told), ["GOV003", "GOV011", "GOV012", "GOV042", "GOV044"])
        told = told["GOV012"]
        self.assertEqual(told, {
            "id": "GOV012", "severity": "warning",
            "message": '"rt/[^a]": a bracket expression holds "^"; Cyclone DDS matches "rt/a", '
                       'which ddssec does not',
            "file": "g.xml", "line": 14,
            "path": "/dds/domain_access_rules/domain_rule[1]/topic_access_rules/topic_rule[1]",
            "hint": told["hint"], "vendors": ["cyclonedds"]})
        text = self.run_program("governance", "lint", "g.xml")
        self.assertEqual(text.stdout, "g.xml: 2 warnings, 2 notes\n")
        self.assertRegex(text.stderr, r"(?m)^warning\[GOV012\]: .*\n  --> g.xml:14\n"
                                      r"  concerns: cyclonedds\n  hint: use only ")

    def test_signed_documents_are_linted_too(self):
        self.run_program("governance", "sign", "g.xml", "--ca", "ca", *NOW)
        self.assertEqual(self.lint("governance", "lint", "g.p7s")["result"]["file"], "g.p7s")
        self.lint("governance", "lint", "g.p7s", "--domain", "3", exit=1)

    def test_permissions_against_certificate_and_governance(self):
        self.edit("g.xml", ("<topic_expression>*<", "<topic_expression>b<"))
        out = self.lint("permissions", "lint", "p.xml", "--governance", "g.xml")
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["PERM025"])
        self.edit("p.xml", ("<subject_name>CN=talker<", "<subject_name>CN=other<"))
        out = self.lint("permissions", "lint", "p.xml", "--cert", "talker/cert.pem", exit=1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["PERM011"])

    def test_a_grant_that_cyclone_dds_takes_for_another_subject(self):
        grant = re.search("<grant .*</grant>", (self.at / "p.xml").read_text(), re.S)[0]
        other = grant.replace(">CN=talker<", ">CN=talker,OU=x<")
        self.edit("p.xml", (grant, grant + other))
        self.assertEqual(self.lint("permissions", "lint", "p.xml")["diagnostics"], [])
        self.edit("p.xml", (grant + other, other + grant))
        told = self.lint("permissions", "lint", "p.xml", exit=1)["diagnostics"]
        self.assertEqual([(d["id"], d["vendors"], d["line"]) for d in told], [("PERM010", ["cyclonedds"], 4)])
        self.assertIn('gives a certificate of "CN=talker" the rights of "CN=talker,OU=x"', told[0]["message"])

    def test_blanks_in_end_tags_and_domain_tags(self):
        for file, rule, old, new, words in (
                ("g.xml", "GOV001", "</domain_rule>", "</domain_rule >", "</domain_rule> has a blank"),
                ("p.xml", "PERM001", "</grant>", "</grant\n>", "</grant> has a blank or a line break"),
                ("p.xml", "PERM006", "</id>", "</id><tag>lab</tag>", "Cyclone DDS ignores it")):
            with self.subTest(new=new):
                whole = (self.at / file).read_text()
                self.edit(file, (old, new))
                lint = ("governance" if file == "g.xml" else "permissions", "lint", file)
                told = [d for d in self.lint(*lint, exit=None)["diagnostics"] if d["id"] == rule]
                self.assertEqual(len(told), 1)
                self.assertIn(words, told[0]["message"])
                line = (self.at / file).read_text().splitlines()[told[0]["line"] - 1]
                self.assertIn(new.split("\n")[0].split("</id>")[-1], line)
                (self.at / file).write_text(whole.replace(old, f"<!-- </a > -->{old}", 1) if rule != "PERM006" else whole)
                self.assertNotIn(rule, [d["id"] for d in self.lint(*lint, exit=None)["diagnostics"]])
                (self.at / file).write_text(whole)

    def test_ended_permissions_are_an_error_by_the_time_given(self):
        out = self.json("permissions", "lint", "p.xml", "--now", "2030-01-01T00:00:00Z", exit=1)
        self.assertEqual([(d["id"], d["severity"]) for d in out["diagnostics"]], [("PERM002", "error")])

    def test_permissions_that_a_product_refuses_are_named_by_each_command(self):
        """What doctor says of the same documents: real participants did not start with them."""
        denial = "<deny_rule><domains><id>0</id></domains></deny_rule><allow_rule>"
        whole = (self.at / "p.xml").read_text()
        end = re.search("<not_after>(.*)</not_after>", whole)[1]
        ca = ("--ca", "ca/permissions/ca.pem")
        for old, new, rule, vendors in ((end, "2263-01-01T00:00:00Z", "PERM002", ["cyclonedds"]),
                                        (end, "2037-01-01T24:00:00Z", "PERM002", ["cyclonedds"]),
                                        (">CN=talker<", ">cn=talker<", "PERM011", ["cyclonedds", "fastdds"]),
                                        (">CN=talker<", ">2.5.4.3=talker<", "PERM011", ["cyclonedds", "fastdds"]),
                                        (">CN=talker<", '>CN="talker"<', "PERM011", ["cyclonedds", "fastdds"]),
                                        (">CN=talker<", ">\n  CN=talker\n  <", "PERM011", ["fastdds"]),
                                        ("<allow_rule>", denial, "PERM027", ["cyclonedds", "fastdds"])):
            (self.at / "p.xml").write_text(whole.replace(old, new, 1))
            self.run_program("permissions", "sign", "p.xml", "--ca", "ca", "--replace", "-o", "p.p7s", *NOW)
            for words in (("lint", "p.xml"), ("lint", "p.xml", "--cert", "talker/cert.pem"),
                          ("sign", "p.xml", "--ca", "ca", "--replace", "-o", "p.p7s"), ("verify", "p.p7s", *ca),
                          ("verify", "p.p7s", *ca, "--cert", "talker/cert.pem")):
                with self.subTest(new=new, words=words):
                    told = self.json("permissions", *words, *NOW)["diagnostics"]
                    self.assertIn((rule, vendors), [(d["id"], d.get("vendors")) for d in told])
            with self.subTest(new=new, words="identity issue"):
                told = self.json("identity", "issue", "talker", "--ca", "ca", "-o", "talker", "--replace", "--permissions",
                                 "p.xml", *NOW)["diagnostics"]
                self.assertIn((rule, vendors, "p.xml"), [(d["id"], d.get("vendors"), d["file"]) for d in told])
        told = self.json("permissions", "new", "--cert", "talker/cert.pem", "-o", "late.xml", "--publish", "a", "--not-after",
                         "3000-01-01T00:00:00Z", *NOW)["diagnostics"]
        self.assertIn(("PERM002", ["cyclonedds"]), [(d["id"], d.get("vendors")) for d in told])

    def test_vendors_own_documents(self):
        folder = DATA / "cyclonedds/validate_local_permissions"
        out = self.lint("governance", "lint", folder / "Test_Governance_full.xml", exit=1)
        self.assertIn("GOV001", [d["id"] for d in out["diagnostics"]])

    def test_rules_are_explained(self):
        self.assertIn("hint", self.json("explain", "GOV012")["result"])
        self.refused("usage", 2, "explain", "GOV999")

    def bad(self, code, content, exit=3):
        (self.at / "bad.xml").write_bytes(content)
        told = self.refused(code, exit, "governance", "lint", "bad.xml")
        self.assertEqual(told["file"], "bad.xml")
        self.refused(code, exit, "permissions", "lint", "bad.xml")
        return told

    def test_hostile_files_are_refused(self):
        good = (self.at / "g.xml").read_bytes()
        head = b'<?xml version="1.0" encoding="UTF-8"?>\n'
        self.assertEqual(self.bad("xml_doctype", head + b"<!DOCTYPE dds>" + good[len(head):])["line"], 2)
        self.bad("xml_entity", head + b"<dds>&xxe;</dds>")
        self.bad("xml_too_deep", head + b"<a>" * 1000 + b"</a>" * 1000)
        self.bad("xml_too_deep", head + b"<a>" * 1_000_000)
        self.bad("xml_control_character", good.replace(b"<id>0", b"<id>0\0"))
        self.bad("xml_encoding", good.replace(b">*<", b">\xff\xfe<"))
        self.bad("xml_encoding", good.decode().encode("utf-16"))
        self.bad("xml_processing_instruction", head + b"<?php echo 1 ?><dds/>")
        self.bad("item_empty", b"")
        self.bad("xml_not_well_formed", good[:-20])
        self.bad("document_kind", head + b"<html/>")

    def test_huge_and_missing_files_are_refused(self):
        with open(self.at / "huge.xml", "wb") as huge:
            huge.truncate(100 * 1024 * 1024)
        self.refused("file_too_large", 3, "governance", "lint", "huge.xml")
        self.refused("file_not_found", 3, "governance", "lint", "none.xml")
        self.assertEqual(self.refused("file_not_found", 3, "governance", "lint", "ca")["file"], "ca/governance.p7s")
        self.refused("document_kind", 3, "governance", "lint", "p.xml")
        self.refused("usage", 2, "governance", "lint", "g.xml", "--domain", "231")

    def test_truncated_signed_documents_are_refused(self):
        self.run_program("governance", "sign", "g.xml", "--ca", "ca", *NOW)
        whole = (self.at / "g.p7s").read_bytes()
        for size in range(0, len(whole) - 1, 97):
            (self.at / "cut.p7s").write_bytes(whole[:size])
            done = self.run_program("governance", "lint", "cut.p7s", exit=3)
            self.assertRegex(done.stderr, r"^error\[((xml|smime)_\w+|item_empty)\]: ")


if __name__ == "__main__":
    main()

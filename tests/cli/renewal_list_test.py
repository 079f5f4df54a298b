#!/usr/bin/env python3
"""The lists of renewed certificates and permissions: what commands write into them, and where they go."""

import base64
import datetime
import re
import signal

from agent_folders import Running, checked_events
from transcript import Transcript, main

PEM = re.compile(r"-----BEGIN ([A-Z ]+)-----.*?-----END \1-----\n", re.DOTALL)
CERTIFICATE, PERMISSIONS = "CERTIFICATE", "SIGNED PERMISSIONS"


class RenewalList(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "--participant", "talker", "--participant", "listener")

    def labels(self, path):
        file = self.at / path
        return [found[1] for found in PEM.finditer(file.read_text())] if file.exists() else []

    def renew(self, name="talker", *words):
        self.run_program("identity", "renew", f"demo/{name}", "--ca", "demo", "--days", "700", *words)

    def distribute(self, *words):
        return self.json("crl", "distribute", "--ca", "demo", *words)

    def test_renewed_is_in_the_lists_of_its_cas_and_in_each_folder_after_distribute(self):
        self.assertEqual(self.labels("demo/ca/identity/renewed.pem"), [])
        self.renew("talker", "--permissions")
        self.assertEqual(self.labels("demo/ca/identity/renewed.pem"), [CERTIFICATE])
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS])
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [])
        out = self.distribute()
        self.assertEqual(out["result"]["renewals"], {"certificates": 1, "permissions": 1})
        for name in ("talker", "listener"):
            self.assertEqual(self.labels(f"demo/{name}/renewed.pem"), [CERTIFICATE, PERMISSIONS])
        certificate = (self.at / "demo/talker/cert.pem").read_text()
        self.assertIn(certificate.strip(), (self.at / "demo/listener/renewed.pem").read_text())

    def test_a_later_renewal_takes_the_place_of_the_former_of_its_subject_alone(self):
        for name in ("talker", "listener", "talker"):
            self.renew(name, "--permissions")
        self.assertEqual(self.labels("demo/ca/identity/renewed.pem"), [CERTIFICATE] * 2)
        self.assertIn((self.at / "demo/talker/cert.pem").read_text(),
                      (self.at / "demo/ca/identity/renewed.pem").read_text())

    def test_distribute_says_what_the_list_has_and_writes_it_once(self):
        self.renew()
        done = self.run_program("crl", "distribute", "--ca", "demo")
        self.assertIn("renewal list with 1 certificate and 0 permissions documents\n", done.stdout)
        written = [file["path"] for file in self.distribute()["files_written"]]
        self.assertNotIn("demo/listener/renewed.pem", " ".join(written), "it is there already")

    def test_revoked_is_not_distributed(self):
        self.renew()
        self.distribute()
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo")
        self.renew("listener")
        self.distribute()
        certificate = (self.at / "demo/talker/cert.pem").read_text()
        self.assertEqual(self.distribute()["result"]["renewals"]["certificates"], 1)
        self.assertNotIn(certificate, (self.at / "demo/listener/renewed.pem").read_text())
        self.assertIn(certificate, (self.at / "demo/ca/identity/renewed.pem").read_text())

    # Only a revoked certificate was on the participant's list, which it would have refused (1386).
    def test_replace_after_a_revocation_makes_the_list_of_the_folder_again_and_says_so(self):
        self.run_program("keystore", "create", "ks", "--no-passphrase")
        self.run_program("keystore", "enclave", "ks", "/talker", "--allow-all")
        for ca, folder, words in (("demo", "demo/talker", ("identity", "issue", "talker", "--ca", "demo", "-o", "demo/talker")),
                                  ("ks", "ks/enclaves/talker", ("keystore", "enclave", "ks", "/talker"))):
            self.run_program("identity", "renew", folder, "--ca", ca, "--days", "700")
            self.run_program("crl", "distribute", "--ca", ca)
            self.assertEqual(self.labels(f"{folder}/renewed.pem"), [CERTIFICATE])
            self.run_program("identity", "revoke", folder, "--ca", ca)
            done = self.run_program(*words, "--replace", "--days", "400")
            self.assertIn(f"{folder}/renewed.pem  renewal list, made again without revoked certificates\n", done.stdout)
            self.assertEqual(self.labels(f"{folder}/renewed.pem"), [])
            self.assertNotIn("DOC115", [d["id"] for d in self.json("doctor", folder, "--vendor", "ddssec")["diagnostics"]])
            before = (self.at / folder / "renewed.pem").read_bytes()
            done = self.run_program(*words, "--replace", "--days", "400")
            self.assertNotIn("renewal list", done.stdout)
            self.assertEqual((self.at / folder / "renewed.pem").read_bytes(), before)

    # ---- permissions sign

    def xml_of(self, path):
        signed = (self.at / path).read_bytes().decode("latin-1").replace("\r", "")
        return re.search(r"<\?xml.*?</dds>\n?", signed, re.DOTALL)[0]

    def sign(self, xml, to, *words, exit=0):
        (self.at / "next.xml").write_text(xml)
        return self.run_program("permissions", "sign", "next.xml", "--ca", "demo", "-o", to, *words, exit=exit)

    @staticmethod
    def until(xml, year):
        return re.sub(r"<not_after>.*?</not_after>", f"<not_after>{year}-01-01T00:00:00</not_after>", xml)

    @staticmethod
    def of_nine_days(xml):
        begin = datetime.datetime.fromisoformat(re.search("<not_before>(.*?)Z?</not_before>", xml)[1])
        end = (begin + datetime.timedelta(days=9)).isoformat()
        return re.sub(r"<not_after>.*?</not_after>", f"<not_after>{end}</not_after>", xml)

    def test_permissions_sign_lists_an_extension_and_nothing_else(self):
        ca, talker = "demo/ca/permissions/renewed.pem", "demo/talker/permissions.p7s"
        xml = self.xml_of(talker)
        narrow = xml.replace("<topic>*</topic>", "<topic>Square</topic>")
        self.assertNotEqual(narrow, xml)
        for number, other in enumerate((self.until(narrow, 2051), self.of_nine_days(xml), xml, re.sub(r"<subject_name>(.*?)</subject_name>",
                r"<subject_name_expression>\1</subject_name_expression>", self.until(xml, 2051)))):
            self.sign(other, f"other{number}.p7s", "--no-lint")
            self.assertEqual(self.labels(ca), [])
        # The last document for the place is extended.
        self.sign(self.until(xml, 2051), talker, "--replace", "--no-lint")
        self.assertEqual(self.labels(ca), [PERMISSIONS])
        # So is one that is listed, wherever the new one goes.
        self.sign(self.until(xml, 2052), "elsewhere.p7s", "--replace", "--no-lint")
        self.assertEqual(self.labels(ca), [PERMISSIONS])
        self.assertIn("2052-01-01", self.listed(ca)[0])
        # A narrow one takes the place of none, and an extension of it counts beside the wide one.
        self.sign(self.until(narrow, 2060), talker, "--replace", "--no-lint")
        self.assertEqual(self.labels(ca), [PERMISSIONS])
        self.sign(self.until(narrow, 2061), talker, "--replace", "--no-lint")
        self.assertEqual(self.labels(ca), [PERMISSIONS] * 2)
        self.run_program("governance", "sign", "demo/governance.xml", "--ca", "demo", "--replace")
        self.assertEqual(self.labels(ca), [PERMISSIONS] * 2)

    def test_permissions_sign_lists_wider_ones(self):
        ca, talker = "demo/ca/permissions/renewed.pem", "demo/talker/permissions.p7s"
        square = self.xml_of(talker).replace("<topic>*</topic>", "<topic>Square</topic>")
        self.sign(self.until(square, 2050), talker, "--replace", "--no-lint")
        self.assertEqual(self.labels(ca), [])
        both = square.replace("<topic>Square</topic>", "<topic>Circle</topic><topic>Square</topic>")
        self.sign(self.until(both, 2051), talker, "--replace", "--no-lint")
        self.assertEqual(self.labels(ca), [PERMISSIONS])
        # Rights in another domain are no more.
        other = re.sub(r"<id>\d+</id>", "<id>77</id>", both)
        self.assertNotEqual(other, both)
        self.sign(self.until(other, 2052), talker, "--replace", "--no-lint")
        self.assertEqual(self.labels(ca), [PERMISSIONS])

    def listed(self, path):
        """The signed texts of a list."""
        blocks = [found[0] for found in PEM.finditer((self.at / path).read_text()) if found[1] == PERMISSIONS]
        return [base64.b64decode("".join(one.split("\n")[1:-2])).decode("latin-1") for one in blocks]

    # Before, a document that was signed for later, or elsewhere, kept the agent from any extension.
    def test_permissions_that_are_signed_elsewhere_stop_no_extension(self):
        xml = self.xml_of("demo/talker/permissions.p7s").replace("<topic>*</topic>", "<topic>Square</topic>")
        self.sign(xml, "narrow.p7s")
        self.sign(re.sub(r"<not_before>.*?</not_before>", "<not_before>2040-01-01T00:00:00</not_before>",
                         self.until(xml, 2051)), "planned.p7s", "--no-lint")
        self.renew("talker", "--permissions")
        (event,) = checked_events(self.run_program("agent", "demo/talker", "--ca", "demo", "--permissions", "--once",
                                                   "--now", "+600d").stdout)
        self.assertTrue(event["permissions_extended"])
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS])

    def test_permissions_that_are_replaced_in_their_place_are_not_extended(self):
        talker = self.at / "demo/talker/permissions.p7s"
        wide = talker.read_bytes()
        self.sign(self.xml_of("demo/talker/permissions.p7s").replace("<topic>*</topic>", "<topic>Square</topic>"),
                  "demo/talker/permissions.p7s", "--replace")
        talker.write_bytes(wide)
        words = ("identity", "renew", "demo/talker", "--ca", "demo", "--days", "700", "--permissions")
        self.assertIn("document_superseded", self.run_program(*words, exit=(1, 3, 4)).stderr)
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [])

    def test_permissions_that_have_ended_leave_the_list(self):
        talker = "demo/talker/permissions.p7s"
        xml = self.xml_of(talker)
        for year in (2051, 2052):
            self.sign(self.until(xml, year), talker, "--replace", "--no-lint")
        listed = self.at / "demo/ca/permissions/renewed.pem"
        ended = self.until(re.sub(r"<not_before>.*?</not_before>", "<not_before>2019-01-01T00:00:00</not_before>", xml), 2020)
        self.sign(ended, "ended.p7s", "--no-lint")
        listed.write_text(listed.read_text() + self.block("ended.p7s"))
        self.renew("listener", "--permissions")
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS] * 2)
        self.assertNotIn("2020-01-01", "".join(self.listed("demo/ca/permissions/renewed.pem")))

    def block(self, path):
        text = base64.encodebytes((self.at / path).read_bytes()).decode().replace("\n", "")
        lines = [text[i:i + 64] for i in range(0, len(text), 64)]
        return "\n".join([f"-----BEGIN {PERMISSIONS}-----", *lines, f"-----END {PERMISSIONS}-----", ""])

    def test_a_move_leaves_out_permissions_for_an_expression_and_says_so(self):
        xml = re.sub(r"<subject_name>(.*?)</subject_name>", r"<subject_name_expression>\1</subject_name_expression>",
                     self.xml_of("demo/talker/permissions.p7s"))
        self.sign(xml, "demo/talker/permissions.p7s", "--replace", "--no-lint")
        self.run_program("ca", "rotate", "demo", "--role", "permissions", "--overlap", "1d")
        done = self.run_program("ca", "rotate", "demo", "--role", "permissions", "--move", exit=(0, 1))
        self.assertIn("warning[permissions_unlisted]", done.stderr)
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS])

    # ---- lists that are damaged, full, or in the way

    def revoke_and_distribute(self, exit):
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", exit=(0, 1, 3, 4))
        out = self.run_program("crl", "distribute", "--ca", "demo", exit=exit)
        self.assertEqual((self.at / "demo/listener/crl.pem").read_bytes(),
                         (self.at / "demo/ca/identity/crl.pem").read_bytes())
        return out

    def test_a_damaged_list_of_a_ca_keeps_nothing_back_and_the_next_renewal_begins_a_new_one(self):
        self.renew("listener", "--permissions")
        self.distribute()
        file, before = self.at / "demo/ca/permissions/renewed.pem", self.labels("demo/listener/renewed.pem")
        for days, octets in ((800, b"x" * (9 << 20)), (810, file.read_bytes()[:300]), (820, b"")):
            file.write_bytes(octets)
            self.revoke_and_distribute(exit=(1, 3, 4))
            self.assertEqual(self.labels("demo/listener/renewed.pem"), before)
            done = self.run_program("identity", "renew", "demo/listener", "--ca", "demo", "--days", days, "--permissions")
            self.assertIn("warning[renewal_list_malformed]", done.stderr)
            self.assertIn("a new list was begun", done.stderr)
            self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS])
            self.distribute()

    def test_a_damaged_list_of_a_ca_the_hint_of_distribute_helps(self):
        self.renew("listener")
        self.distribute()
        file = self.at / "demo/ca/identity/renewed.pem"
        file.write_bytes(b"damaged")
        done = self.run_program("crl", "distribute", "--ca", "demo", exit=1)
        self.assertIn("warning[renewal_list_malformed]", done.stderr)
        self.assertIn("hint: remove it", done.stderr)
        self.assertNotIn("crl distribute", done.stderr)
        file.unlink()
        self.distribute()
        self.assertEqual(self.labels("demo/talker/renewed.pem"), [CERTIFICATE])

    def test_a_list_that_cannot_be_written_is_no_success(self):
        for role in ("identity", "permissions"):
            (self.at / f"demo/ca/{role}/renewed.pem").mkdir()
        before = (self.at / "demo/talker/cert.pem").read_bytes()
        done = self.run_program("identity", "renew", "demo/talker", "--ca", "demo", "--days", "700", "--permissions", exit=5)
        self.assertEqual(done.stderr.count("error[would_overwrite]"), 2)
        self.assertNotEqual((self.at / "demo/talker/cert.pem").read_bytes(), before, "the list stops no renewal")
        done = self.sign(self.until(self.xml_of("demo/talker/permissions.p7s"), 2052), "demo/talker/permissions.p7s",
                         "--replace", exit=5)
        self.assertIn("error[would_overwrite]", done.stderr)

    def test_a_list_whose_entries_have_all_left_is_emptied(self):
        self.renew()
        self.distribute()
        self.revoke_and_distribute(exit=0)
        file = self.at / "demo/listener/renewed.pem"
        self.assertEqual(file.read_text(), "# no renewed certificate or permissions\n")
        self.assertEqual(self.about(), [])
        written = [one["path"] for one in self.distribute()["files_written"]]
        self.assertFalse([path for path in written if path.endswith("renewed.pem")])
        self.renew("listener")
        self.distribute()
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE])

    def test_a_folder_without_its_permissions_ca_keeps_its_permissions_and_is_named(self):
        self.renew("talker", "--permissions")
        self.distribute()
        before = self.listed("demo/listener/renewed.pem")
        (self.at / "demo/listener/permissions_ca.pem").rename(self.at / "elsewhere.pem")
        self.run_program("identity", "renew", "demo/talker", "--ca", "demo", "--days", "800", "--permissions")
        (named,) = self.distribute()["result"]["without_permissions"]
        self.assertTrue(named.endswith("demo/listener"))
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE, PERMISSIONS])
        self.assertEqual(self.listed("demo/listener/renewed.pem"), before)
        self.assertNotEqual(self.listed("demo/talker/renewed.pem"), before)
        self.assertIn("no permissions CA is in the folder",
                      self.run_program("crl", "distribute", "--ca", "demo").stdout)
        (self.at / "elsewhere.pem").rename(self.at / "demo/listener/permissions_ca.pem")
        self.assertEqual(self.distribute()["result"]["without_permissions"], [])
        self.assertEqual(self.listed("demo/listener/renewed.pem"), self.listed("demo/talker/renewed.pem"))

    def test_a_damaged_list_of_a_ca_stops_no_agent(self):
        (self.at / "demo/ca/permissions/renewed.pem").write_bytes(b"")
        words = ("agent", "demo/talker", "demo/listener", "--ca", "demo", "--permissions", "--once", "--now")
        events = checked_events(self.run_program(*words, "+300d", exit=(0, 1)).stdout)
        self.assertEqual([event["permissions_extended"] for event in events], [True] * 2)
        self.assertEqual(["problem" in event for event in events], [True, False], "it is said once")
        self.assertEqual(self.labels("demo/ca/permissions/renewed.pem"), [PERMISSIONS] * 2)

    def test_a_list_of_a_folder_that_cannot_be_written_keeps_no_revocation_from_it(self):
        self.renew("listener")
        list_ = self.at / "demo/listener/renewed.pem"
        list_.mkdir()
        self.assertIn("would_overwrite", self.revoke_and_distribute(exit=(1, 3, 4)).stderr)
        list_.rmdir()
        list_.write_bytes(b"")
        self.distribute()
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE])

    def fill_list(self, fifth):
        """Eight documents, with no room for another one: of x0 to x7, of which x3 ends first, but for the fifth one."""
        xml = self.xml_of("demo/listener/permissions.p7s")
        subject = re.search(r"<subject_name>(.*?)</subject_name>", xml)[1]

        def document(i, size):
            text = (self.of_nine_days(xml) if i == 3 else self.until(xml, 2052)).replace(subject, f"CN=x{fifth if i == 5 else i}")
            if i == 5:
                text = text.replace("<topic>*</topic>", "<topic>Square</topic>")
            self.sign(text.replace("<publish>", "<!--" + "x" * size + "--><publish>", 1), f"p{i}.p7s", "--no-lint", "--replace")
            return self.block(f"p{i}.p7s")

        blocks = [document(i, 760_000) for i in range(8)]
        rest = (8 << 20) - sum(map(len, blocks))
        blocks[7] = document(7, 760_000 + (rest - 1000) * 3 // 4 * 64 // 65)
        (self.at / "demo/ca/permissions/renewed.pem").write_text("".join(blocks))

    def subjects(self):
        return [re.search(r"<subject_name>(.*?)</subject_name>", one)[1]
                for one in self.listed("demo/ca/permissions/renewed.pem")]

    def test_a_full_list_of_a_ca_leaves_out_former_ones_then_those_that_end_first_and_names_them(self):
        words = ("identity", "renew", "demo/listener", "--ca", "demo", "--permissions", "--days")
        for days, fifth, left in (("700", 0, [1, 2, 3, 4, 0, 6, 7]), ("701", 5, [0, 1, 2, 4, 5, 6, 7])):
            self.fill_list(fifth)
            gone = 3 if fifth else 0
            self.assertRegex(self.run_program(*words, days, exit=5).stderr,
                             rf"file_too_large(.|\n)*entries of CN=x{gone} were left out")
            self.assertEqual(self.subjects(), [*(f"CN=x{i}" for i in left), "CN=listener"])
        self.assertLessEqual((self.at / "demo/ca/permissions/renewed.pem").stat().st_size, 8 << 20)
        self.distribute()

    # ---- what doctor says

    def about(self, *words):
        out = self.json("doctor", "demo/listener", *words, exit=(0, 1))
        return [(one["severity"], one["message"]) for one in out["diagnostics"] if one["id"] == "DOC115"]

    def test_doctor_says_what_is_wrong_with_a_list(self):
        self.renew("talker", "--permissions")
        self.distribute()
        self.assertEqual(self.about(), [])
        file = self.at / "demo/listener/renewed.pem"
        good = file.read_text()
        for text in ("garbage", ""):
            file.write_text(text)
            ((severity, message),) = self.about()
            self.assertEqual(severity, "warning")
            self.assertRegex(message, "^renewed.pem: ")
        self.run_program("init", "other", "--participant", "foreign")
        self.run_program("identity", "renew", "other/foreign", "--ca", "other", "--days", "700", "--permissions")
        foreign = "".join((self.at / f"other/ca/{role}/renewed.pem").read_text() for role in ("identity", "permissions"))
        file.write_text(good + foreign)
        ((severity, message),) = self.about()
        self.assertEqual(severity, "note")
        self.assertRegex(message, "^renewed.pem: 2 of 4 entries have no effect: CN=foreign: ")
        file.write_text(foreign)
        ((severity, message),) = self.about()
        self.assertEqual(severity, "warning")
        check = self.json("check", "demo/talker", "demo/listener", exit=(0, 1))
        self.assertIn("DOC115", [one["id"] for one in check["diagnostics"]])
        file.write_text(good)
        ((severity, message),) = self.about("--now", "+800d")
        self.assertRegex(message, "2 of 2 entries have no effect: CN=talker: .*expired")

    def test_keystore_verify_says_what_is_wrong_with_a_list(self):
        self.run_program("keystore", "create", "ks", "--no-passphrase")
        self.run_program("keystore", "enclave", "ks", "/talker", "--allow-all")
        (self.at / "ks/enclaves/talker/renewed.pem").write_text("garbage")
        said = [one for one in self.json("keystore", "verify", "ks", exit=(0, 1))["diagnostics"] if one["id"] == "DOC115"]
        self.assertEqual([one["severity"] for one in said], ["warning"])

    def test_of_another_ca_stays_where_the_folder_trusts_it_and_goes_where_it_does_not(self):
        self.run_program("init", "other", "--participant", "foreign")
        self.run_program("identity", "renew", "other/foreign", "--ca", "other", "--days", "700")
        foreign = (self.at / "other/ca/identity/renewed.pem").read_text()
        trusted = self.at / "demo/listener/identity_ca.pem"
        trusted.write_text(trusted.read_text() + (self.at / "other/ca/identity/ca.pem").read_text())
        for name in ("talker", "listener"):
            (self.at / f"demo/{name}/renewed.pem").write_text(foreign)
        self.renew()
        self.distribute()
        self.assertEqual(self.labels("demo/talker/renewed.pem"), [CERTIFICATE])
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE] * 2)

    def test_a_damaged_list_of_a_folder_is_made_anew(self):
        (self.at / "demo/listener/renewed.pem").write_text("garbage")
        self.renew()
        self.distribute()
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE])

    def test_a_move_lists_what_the_successor_issues_and_signs_and_a_theft_nothing(self):
        for role, label in (("identity", CERTIFICATE), ("permissions", PERMISSIONS)):
            self.run_program("ca", "rotate", "demo", "--role", role, "--overlap", "1d")
            self.assertEqual(self.labels(f"demo/ca/{role}/renewed.pem"), [])
            self.run_program("ca", "rotate", "demo", "--role", role, "--move")
            self.assertEqual(self.labels(f"demo/ca/{role}/renewed.pem"), [label] * 2)
        self.distribute()
        self.assertEqual(self.labels("demo/talker/renewed.pem"), [CERTIFICATE] * 2 + [PERMISSIONS] * 2)
        before = (self.at / "demo/ca/identity/renewed.pem").read_bytes()
        self.run_program("ca", "rotate", "demo", "--role", "identity", "--end")
        self.run_program("ca", "rotate", "demo", "--role", "identity")
        self.assertEqual((self.at / "demo/ca/identity/renewed.pem").read_bytes(), before)
        self.distribute()

    def test_a_rotation_at_once_removes_the_entries_of_the_former_ca_from_each_folder(self):
        self.renew("talker", "--permissions")
        self.distribute()
        for role, left in (("identity", [PERMISSIONS]), ("permissions", [])):
            self.run_program("ca", "rotate", "demo", "--role", role)
            for name in ("talker", "listener"):
                self.assertEqual(self.labels(f"demo/{name}/renewed.pem"), left)
        self.assertEqual(self.about(), [])

    def test_the_end_of_an_overlap_removes_the_entries_of_the_former_ca_from_each_folder(self):
        self.renew()
        self.distribute()
        self.run_program("ca", "rotate", "demo", "--role", "identity", "--overlap", "1d")
        self.run_program("ca", "rotate", "demo", "--role", "identity", "--move")
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE], "both CAs count")
        self.run_program("ca", "rotate", "demo", "--role", "identity", "--end")
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [])

    def test_a_rotation_at_once_leaves_a_list_that_cannot_be_read(self):
        (self.at / "demo/listener/renewed.pem").write_text("garbage")
        self.run_program("ca", "rotate", "demo", "--role", "identity")
        self.assertEqual((self.at / "demo/listener/renewed.pem").read_text(), "garbage")

    def test_expiry_passes_over_the_list(self):
        self.renew()
        self.distribute()
        entries = self.json("expiry", "demo")["result"]["entries"]
        self.assertFalse([one for one in entries if one["file"].endswith("renewed.pem")])

    def test_the_agent_puts_the_list_into_its_folders(self):
        out = self.run_program("agent", "demo/talker", "demo/listener", "--ca", "demo", "--permissions", "--once",
                               "--now", "+300d").stdout
        self.assertEqual([event["event"] for event in checked_events(out)], ["renewed"] * 2)
        for name in ("talker", "listener"):
            self.assertEqual(self.labels(f"demo/{name}/renewed.pem"), [CERTIFICATE] * 2 + [PERMISSIONS] * 2)

    def test_the_agent_with_a_list_that_it_cannot_write_later_says_so_once(self):
        words = ("agent", "demo/talker", "demo/listener", "--ca", "demo", "--once", "--now", "+300d")
        (self.at / "demo/talker/renewed.pem").mkdir()
        events = checked_events(self.run_program(*words, exit=4).stdout)
        self.assertEqual([(event["event"], "problem" in event) for event in events],
                         [("renewed", True), ("renewed", False)])
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE] * 2)

    # Before, this folder had the entry up to ten minutes later.
    def test_the_agent_puts_its_own_entry_into_the_folder_that_it_renewed(self):
        begin = datetime.datetime.now(datetime.timezone.utc) - datetime.timedelta(hours=20)
        self.run_program("identity", "renew", "demo/talker", "--ca", "demo", "--days", "1", "--now", f"{begin:%FT%TZ}")
        self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "Square", "--sign", "--ca", "demo",
                         "--replace", "-o", "demo/talker/permissions.xml")
        agent = Running(self.at, "demo/talker", "--ca", "demo", "--permissions")
        self.addCleanup(agent.end, signal.SIGKILL)
        self.assertTrue(agent.wait_for("renewed")["permissions_extended"])
        self.assertEqual(agent.end(), 0)
        certificate = (self.at / "demo/talker/cert.pem").read_text()
        self.assertIn(certificate, (self.at / "demo/talker/renewed.pem").read_text())
        self.assertEqual(self.labels("demo/talker/renewed.pem"), [CERTIFICATE, PERMISSIONS])

    def test_the_agent_puts_the_list_into_a_folder_whose_renewal_fails(self):
        self.renew("talker", "--permissions")
        (self.at / "demo/listener/key.pem").write_bytes((self.at / "demo/talker/key.pem").read_bytes())
        out = self.run_program("agent", "demo/listener", "--ca", "demo", "--once", "--now", "+300d", exit=1).stdout
        self.assertEqual([event["event"] for event in checked_events(out)], ["failed"])
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE, PERMISSIONS])

    def test_the_agent_reports_once_a_list_that_is_too_long_for_folders(self):
        self.renew("talker", "--permissions")
        file = self.at / "demo/ca/permissions/renewed.pem"
        entry = PEM.search(file.read_text())[0]
        file.write_text(entry * (2 * 1024 * 1024 // len(entry) + 1))
        out = self.run_program("agent", "demo/talker", "demo/listener", "--ca", "demo", "--once", exit=3).stdout
        events = checked_events(out)
        self.assertEqual([event["event"] for event in events], ["current", "failed", "current"])
        self.assertEqual((events[1]["code"], events[1]["folder"]), ("file_too_large", "demo"))
        self.assertIn("ddssec crl distribute --ca demo", events[1]["hint"])
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [])

    def test_the_agent_puts_the_list_into_a_folder_whose_renewal_the_ca_refuses(self):
        self.renew("talker", "--permissions")
        out = self.run_program("agent", "demo/listener", "--ca", "demo", "--once", "--days", "5", "--now", "+300d", exit=1).stdout
        self.assertEqual([(event["event"], event["code"]) for event in checked_events(out)], [("failed", "renewal_goes_back")])
        self.assertEqual(self.labels("demo/listener/renewed.pem"), [CERTIFICATE, PERMISSIONS])


if __name__ == "__main__":
    main()

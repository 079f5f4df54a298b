#!/usr/bin/env python3
"""doctor: all that is wrong with a participant's folder, in one sentence each, for each product."""

import pathlib
import re
import shutil
import subprocess

import golden_folders
from doctor_folders import VENDORS, DoctorTest
from forecast import Table
from transcript import PROGRAM, main
from workshop import GOVERNANCE, Folder, Workshop, allow, openssl

HERE = pathlib.Path(__file__).resolve().parent
MEASURED = Table(HERE.parent.parent)


def table():
    """A folder's verdicts and rules by its name: of stock products as measured, of ours in doctor_golden.txt."""
    rows = {}
    for line in (HERE / "doctor_golden.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            name, ours, *rules = line.split()
            rows[name] = ([*(MEASURED.outcome(name, product) for product in VENDORS[:2]), ours], rules)
    return rows


# For each folder: the rule, the document, and both values that its sentence must name.
SENTENCES = {
    "permissions-missing": ("DOC001", "permissions.p7s", "missing"),
    "governance-link-broken": ("DOC001", "governance.p7s", "../nowhere/governance.p7s"),
    "certificate-garbage": ("DOC002", "cert.pem", "X.509"),
    "key-readable-by-all": ("DOC003", "key.pem", "0644", "0600"),
    "ca-key-beside": ("DOC004", "ca.key.pem", "CN=identity CA"),
    "subject-misspelt": ("DOC010", "permissions.p7s", '"CN=talker"', "CN=talkre"),
    "subject-root-first": ("DOC011", "permissions.p7s", '"C=DE,O=Acme,CN=talker"',
                           '"CN=talker,O=Acme,C=DE"'),
    "key-of-another": ("DOC012", "key.pem", "cert.pem", "CN=talker"),
    "key-encrypted": ("DOC013", "key.pem", "encrypted"),
    "p384": ("DOC014", "cert.pem", "EC-secp384r1", "EC-prime256v1"),
    "identity-sha512": ("DOC015", "cert.pem", "signed with SHA512", "Fast DDS 2.9.1"),
    "identity-ca-sha512": ("DOC015", "identity_ca.pem", "CN=sha512-ca CA", "SHA-256 only"),
    "identity-ca-no-constraints": ("DOC020", "cert.pem", "CN=no-constraints CA", "basicConstraints CA:TRUE"),
    "permissions-ca-no-constraints": ("DOC035", "governance.p7s", "CN=no-constraints-permissions CA", "basicConstraints CA:TRUE"),
    "governance-bom": ("DOC037", "governance.p7s", "a byte order mark", "Cyclone DDS"),
    "governance-default-namespace": ("DOC037", "governance.p7s", "attribute xmlns"),
    "governance-escaped-quotes": ("DOC036", "governance.p7s", "encoding"),
    "governance-doctype": ("DOC036", "governance.p7s", "DOCTYPE"),
    "identity-unknown-ca": ("DOC020", "cert.pem", "CN=foreign CA", "CN=identity CA"),
    "identity-other-ca-same-name": ("DOC020", "cert.pem", "CN=identity CA", "two CAs of one name"),
    "identity-below-intermediate": ("DOC020", "cert.pem", "CN=middle CA", "CN=identity CA"),
    "identity-expired": ("DOC021", "cert.pem", "CN=talker", "notAfter is 2021-01-01T00:00:00Z", "now"),
    "identity-not-yet-valid": ("DOC021", "cert.pem", "notBefore is 2036-01-01T00:00:00Z", "now"),
    "identity-ca-expired": ("DOC022", "identity_ca.pem", "2021-01-01T00:00:00Z", "now"),
    "crl-der": ("DOC023", "crl.pem", "is DER", "PEM"),
    "crl-expired": ("DOC023", "crl.pem", "out of date"),
    "crl-of-other-ca": ("DOC023", "crl.pem", "CN=identity CA", "CN=foreign CA"),
    "crl-names-own": ("DOC024", "crl.pem", "1000", "CN=talker"),
    "permissions-unsigned": ("DOC030", "permissions.p7s", "unsigned XML", "multipart/signed"),
    "form-no-text": ("DOC030", "permissions.p7s", "text/plain", "-text"),
    "form-opaque-text": ("DOC030", "permissions.p7s", "opaque", "multipart/signed"),
    "permissions-changed": ("DOC031", "permissions.p7s", "signature"),
    "permissions-by-foreign-ca": ("DOC032", "permissions.p7s", "CN=foreign CA",
                                  "CN=permissions CA"),
    "permissions-by-ca-of-same-name": ("DOC032", "permissions.p7s", "CN=permissions CA", "serial"),
    "permissions-by-itself": ("DOC033", "permissions.p7s", "CN=talker", "CN=identity CA"),
    "form-sha1": ("DOC034", "permissions.p7s", "SHA1", "SHA-256"),
    "permissions-ca-may-not-sign": ("DOC035", "governance.p7s", "keyUsage"),
    "governance-unknown-kind": ("DOC036", "governance.p7s", "SIGNED", "ENCRYPT"),
    "governance-order": ("DOC037", "governance.p7s", "order"),
    "governance-end-tag-blank": ("DOC037", "governance.p7s", "</domain_rule>", "Cyclone DDS refuses"),
    "permissions-end-tag-blank": ("DOC037", "permissions.p7s", "</grant>", "Cyclone DDS refuses"),
    "permissions-domain-tag": ("DOC037", "permissions.p7s", "<tag>", "Cyclone DDS ignores it"),
    "governance-key-revision": ("DOC037", "governance.p7s", "enable_key_revision", "DDS-Security 1.2"),
    "governance-pre-shared-key": ("DOC091", "security.properties", "<rtps_psk_protection_kind> is ENCRYPT",
                                  "dds.sec.crypto.rtps_psk_secret_passphrase"),
    "grant-expired": ("DOC040", "permissions.p7s", "not_after", "2021-01-01T00:00:00Z", "now"),
    "grant-twice": ("DOC043", "permissions.p7s", "CN=talker", "lines 12 and 22"),
    "governance-other-domain": ("DOC051", "permissions.p7s", "only domain 0", "covers only 1"),
    "grant-other-domain": ("DOC051", "permissions.p7s", "domain 0", "for 7"),
    "grant-default-allow": ("DOC052", "permissions.p7s", "ALLOW", "DENY"),
    "grant-deny-one-way": ("DOC053", "permissions.p7s", '"Square"', "publish"),
    "governance-other-topics": ("DOC054", "governance.p7s", "topic_rule"),
    "governance-unauthenticated": ("DOC055", "governance.p7s", "allow_unauthenticated_participants"),
}


# Documents that products accept, and that lint nevertheless treats as a mistake.
CONTRADICTIONS = {"governance-unauthenticated"}


def exit_of(name):
    return 0 if table()[name][0] == ["ok"] * 3 and name not in CONTRADICTIONS else 1


class Golden(DoctorTest):
    def test_explain_knows_every_rule(self):
        for rule, *_ in {values[:1]: None for values in SENTENCES.values()}:
            self.assertEqual(self.json("explain", rule)["result"]["name"], rule)

    def test_every_folder_is_in_the_table(self):
        self.assertEqual(sorted(table()), sorted(golden_folders.FOLDERS))
        self.assertEqual(list(MEASURED.rows), list(golden_folders.FOLDERS))

    def test_every_version_gets_what_was_measured_of_it(self):
        others = [product for product in MEASURED.columns if product not in VENDORS]
        pairs = [[one for one in others if one.startswith(vendor)] for vendor in ("cyclonedds", "fastdds")]
        for name in golden_folders.FOLDERS:
            for cyclone in pairs[0]:
                asked = (cyclone, pairs[1][-1])
                with self.subTest(folder=name, products=asked):
                    expected = {product: MEASURED.outcome(name, product) for product in asked}
                    words = [word for product in asked for word in ("--vendor", product)]
                    out = self.json("doctor", self.paths[name], *words, exit=None)
                    self.assertEqual(out["result"]["verdicts"], expected)

    def test_a_ca_of_version_1_is_named_for_products_that_refuse_it(self):
        for name, file in (("x509-v1-ca", "identity_ca.pem"), ("x509-v1-permissions-ca", "permissions_ca.pem")):
            out = self.doctor(name, "--vendor", "fastdds@3.1.2", exit=1)
            told = [d for d in out["diagnostics"] if d["id"] == "DOC016"]
            self.assertEqual([pathlib.Path(d["file"]).name for d in told], [file])
            self.assertIn("X.509 version 1, which Fast DDS 3.1.2 does not take as a CA", told[0]["message"])
            self.assertEqual(told[0]["vendors"], ["fastdds@3.1.2"])
            self.doctor(name, "--vendor", "all", exit=0)

    def test_folders_named_after_version_1_hold_a_certificate_of_it(self):
        """The openssl program of 3.2 and later adds extensions, and version 3 with them, unless told not to."""
        for name, file in (("x509-v1", "cert.pem"), ("x509-v1-ca", "identity_ca.pem"),
                           ("x509-v1-permissions-ca", "permissions_ca.pem")):
            text = openssl("x509", "-in", self.paths[name] / file, "-noout", "-text")
            self.assertIn("Version: 1 (0x0)", text)
            self.assertNotIn("X509v3", text)

    def notes(self, *words, **more):
        """What is said about versions."""
        out = self.json("doctor", self.paths["correct"], *words, exit=0, **more)
        return list(out["result"]["verdicts"]), [d["message"] for d in out["diagnostics"] if d["id"] == "DOC098"]

    def test_versions_are_the_installed_ones_or_said_to_be_assumed(self):
        self.assertEqual(self.notes(), (VENDORS, []))
        self.assertEqual(self.notes("--vendor", "cyclonedds@0.10.5"), (["cyclonedds@0.10.5"], []))
        self.assertEqual(self.notes("--vendor", "cyclonedds@0.10.7"), (
            ["cyclonedds@0.10.7"],
            ["Cyclone DDS 0.10.7 is predicted as 0.10.5, the nearest older version that is known"]))
        self.assertEqual(self.notes("--vendor", "cyclonedds@0.9"), (
            ["cyclonedds@0.9.0"], ["Cyclone DDS 0.9.0 is predicted as 0.10.2, the oldest version that is known"]))
        self.assertEqual(self.notes("--vendor", "cyclonedds@11.0"), (
            ["cyclonedds@11.0.0"], ["what Cyclone DDS 11.0.0 does was taken from a review of it and from what older "
                                    "versions were measured to do"]))
        libraries = self.at / "libraries"
        libraries.mkdir()
        (libraries / "libddsc.so.0.10.4").touch()
        (libraries / "libfastdds.so.3.1.2").touch()
        (libraries / "libfastdds.so").symlink_to("libfastdds.so.3.1.2")
        found = self.notes(environment={"LD_LIBRARY_PATH": f"/nowhere:{libraries}"})
        self.assertEqual(found, (["cyclonedds@0.10.4", "fastdds@3.1.2", "ddssec"], [
            "Cyclone DDS 0.10.4 is predicted as 0.10.2, the nearest older version that is known"]))
        for word in ("cyclonedds@", "cyclonedds@x", "cyclonedds@1.2.3.4", "ours@1.0", "cyclonedds@0.10.5,fastdds"):
            self.refused("usage", 2, "doctor", self.paths["correct"], "--vendor", word)
        self.refused("usage", 2, "doctor", self.paths["correct"], "--vendor", "fastdds@2.9.1", "--vendor", "fastdds@3.1.2")

    def test_every_folder_gets_its_verdicts_and_rules(self):
        for name, (verdicts, rules) in table().items():
            with self.subTest(folder=name):
                out = self.doctor(name, exit=exit_of(name))
                self.assertEqual(list(out["result"]["verdicts"].items()),
                                 list(zip(VENDORS, verdicts)))
                self.assertEqual(sorted({d["id"] for d in out["diagnostics"]}), rules)
                for check in out["result"]["checks"]:
                    self.assertEqual(list(check["verdicts"]), VENDORS)
                    bad = set(check["verdicts"].values()) != {"ok"}
                    self.assertTrue("fix" in check or not bad, check)

    def test_every_sentence_names_the_document_both_values_and_the_fix(self):
        for name, (rule, document, *values) in SENTENCES.items():
            with self.subTest(folder=name):
                out = self.doctor(name, exit=exit_of(name))
                told = [d for d in out["diagnostics"] if d["id"] == rule]
                self.assertTrue(told, out["diagnostics"])
                self.assertEqual(pathlib.Path(told[0]["file"]).name, document)
                for value in values:
                    self.assertIn(value, told[0]["message"])
                self.assertTrue(told[0]["hint"])

    def test_the_product_that_is_asked_for_decides(self):
        slashes = ("subject-slashes", "--vendor")
        self.assertEqual(self.doctor(*slashes, "cyclonedds", exit=0)["diagnostics"], [])
        out = self.doctor(*slashes, "fastdds@2.9.1", "--vendor", "ddssec", exit=1)
        self.assertEqual(out["result"]["verdicts"], {"fastdds@2.9.1": "fail", "ddssec": "ok"})
        self.assertEqual(out["diagnostics"][0]["vendors"], ["fastdds@2.9.1"])
        self.assertEqual(self.doctor("p384", "--vendor", "all", exit=1)["result"]["vendors"], VENDORS)

    def test_the_domain_and_the_time_count(self):
        self.doctor("grant-other-domain", "--domain", "7", exit=1)  # governance has domain 0 only
        out = self.doctor("correct", "--now", "2036-12-20T00:00:00Z", exit=1)
        self.assertIn("DOC022", [d["id"] for d in out["diagnostics"]])  # CAs live ten years
        out = self.doctor("identity-not-yet-valid", "--now", "2036-11-10T00:00:00Z", exit=0)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC041"])
        self.assertIn("identity_ca.pem of CN=identity CA ends first", out["diagnostics"][0]["message"])
        out = self.doctor("grant-expired", "--now", "2020-12-31T23:00:00Z", exit=1)
        self.assertIn("DOC042", [d["id"] for d in out["diagnostics"]])

    def test_what_begins_later_asks_for_the_clock(self):
        told = self.doctor("crl-empty", "--now", "2010-01-01T00:00:00Z", exit=1)["diagnostics"]
        early = [d for d in told if d["id"] in ("DOC021", "DOC022", "DOC023", "DOC040")]
        self.assertEqual({d["id"] for d in early}, {"DOC021", "DOC022", "DOC023", "DOC040"})
        for one in early:
            self.assertIn("this machine's clock says 2010-01-01T00:00:00Z: is it behind?", one["hint"], one)
        told = self.doctor("correct", "--now", "2037-01-01T00:00:00Z", exit=1)["diagnostics"]
        self.assertTrue(told)
        self.assertFalse([d for d in told if "is it behind" in d["hint"]])

    def test_standard_output_comes_before_standard_error(self):
        done = subprocess.run([PROGRAM, "doctor", self.paths["subject-slashes"]], text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=60, check=False)
        self.assertLess(done.stdout.index("1 error, 1 warning"), done.stdout.index("error[DOC011]"))

    def test_one_run_finds_all_faults(self):
        folder = self.at / "broken"
        shutil.copytree(self.paths["identity-expired"], folder)
        shutil.copy(self.paths["form-no-text"] / "permissions.p7s", folder)
        shutil.copy(self.paths["governance-other-domain"] / "governance.p7s", folder)
        shutil.copy(self.paths["crl-of-other-ca"] / "crl.pem", folder)
        (folder / "key.pem").unlink()
        found = [d["id"] for d in self.json("doctor", "broken", exit=1)["diagnostics"]]
        self.assertEqual(found, ["DOC001", "DOC021", "DOC023", "DOC030", "DOC051"])

    def test_a_spelling_is_told_once_with_the_number_of_its_other_places(self):
        folder = Folder(Workshop(self.at / "shop"), self.at / "talker", "/CN=talker", "talker")
        begin, end = GOVERNANCE.index("<topic_rule>"), GOVERNANCE.index("</topic_access_rules>")
        rule = GOVERNANCE[begin:end].replace("<enable_read_access_control>true<", "<enable_read_access_control>1<")
        spelt = "<enable_read_access_control> is 1: every product reads true and false"
        for count, more in ((1, ""), (2, " (and at 1 other place)"), (3, " (and at 2 other places)")):
            rules = "".join(rule.replace(">*<", f">{name}<") for name in "ab*"[-count:])
            folder.sign("governance", GOVERNANCE[:begin] + rules + GOVERNANCE[end:])
            told = [d for d in self.json("doctor", "talker", exit=None)["diagnostics"] if d["id"] == "DOC037"]
            self.assertEqual([d["message"] for d in told], [spelt + more])
            lines = (self.at / "talker/governance.p7s").read_text().splitlines()
            self.assertIn("<enable_read_access_control>1<", lines[told[0]["line"] - 1])

    def test_places_above_the_limit_of_notes_are_counted(self):
        folder = Folder(Workshop(self.at / "shop"), self.at / "talker", "/CN=talker", "talker")
        begin, end = GOVERNANCE.index("<topic_rule>"), GOVERNANCE.index("</topic_access_rules>")
        rule = (GOVERNANCE[begin:end].replace("<enable_read_access_control>true<", "<enable_read_access_control>1<")
                .replace("<enable_write_access_control>true<", "<enable_write_access_control>1<"))
        rules = "".join(rule.replace(">*<", f">t{number}<") for number in range(400))
        folder.sign("governance", GOVERNANCE[:begin] + rules + rule + GOVERNANCE[end:])
        told = [d["message"] for d in self.json("doctor", "talker", exit=None)["diagnostics"] if d["id"] == "DOC037"]
        self.assertEqual(len(told), 2)
        for message in told:
            self.assertIn("(and at 400 other places)", message)
        told = self.json("governance", "lint", "talker", exit=None)["diagnostics"]
        self.assertIn(f"(and {2 * 401 - 20} more like this)", "".join(d["message"] for d in told if d["id"] == "GOV023"))

    # Not among the folders for the products: their verdict depends on the patch level of OpenSSL.
    def test_a_delta_revocation_list_is_refused(self):
        folder = self.at / "delta"
        shutil.copytree(self.paths["correct"], folder)
        shutil.copy(HERE.parent / "data/nist-pkits/crls/deltaCRLCA1deltaCRL.crl", folder / "crl.pem")
        out = self.json("doctor", "delta", "--vendor", "ddssec", exit=1)
        told = {d["id"]: d for d in out["diagnostics"]}
        self.assertEqual((list(told), told["DOC002"]["file"]), (["DOC002"], "delta/crl.pem"))
        self.assertIn("a delta revocation list", told["DOC002"]["message"])
        self.assertIn("a complete list of CN=deltaCRL CA1", told["DOC002"]["message"])

    def test_another_ca_of_the_same_name_stands_first(self):
        """Measured: stock Cyclone DDS reads the first certificate only, and refuses the participant."""
        shop = golden_folders.Workshop(self.at / "shop")
        folder = self.at / "two-of-one-name"
        made = golden_folders.Folder(shop, folder)
        other = shop.ca("same-name", subject="/CN=identity CA")
        own = made.identity_ca.joinpath("cert.pem").read_text()
        (folder / "identity_ca.pem").write_text((other / "cert.pem").read_text() + own)
        out = self.json("doctor", "two-of-one-name", exit=1)
        self.assertEqual(out["result"]["verdicts"], {**dict.fromkeys(VENDORS, "ok"), VENDORS[0]: "fail"})
        (folder / "identity_ca.pem").write_text(own + (other / "cert.pem").read_text())
        self.assertEqual(self.json("doctor", "two-of-one-name", exit=0)["result"]["verdicts"], dict.fromkeys(VENDORS, "ok"))

    def test_lint_of_both_documents_is_part_of_it(self):
        folder = self.at / "dead"
        shutil.copytree(self.paths["correct"], folder)
        made = golden_folders.Workshop(self.at / "shop").ca("permissions") / "cert.pem"
        shutil.copy(made, folder / "permissions_ca.pem")
        rule = golden_folders.GOVERNANCE.split("<topic_rule>")[1].split("</topic_rule>")[0]
        weaker = f"<topic_rule>{rule}</topic_rule>".replace("*", "Circle").replace(
            "<data_protection_kind>ENCRYPT", "<data_protection_kind>SIGN")
        two = golden_folders.GOVERNANCE.replace("</topic_rule>", "</topic_rule>" + weaker)
        for name, text in (("governance", two), ("permissions", golden_folders.permissions(
                golden_folders.grant("CN=talker", allow("/chatter"))))):
            golden_folders.openssl("smime", "-sign", "-text", "-signer", made, "-inkey",
                                   made.parent / "key.pem", "-out", folder / f"{name}.p7s", text=text)
        out = self.json("doctor", "dead", exit=1)
        told = {d["id"]: d for d in out["diagnostics"]}
        self.assertEqual(sorted(told), ["GOV010", "PERM034"])
        self.assertEqual((told["GOV010"]["file"], told["PERM034"]["file"]),
                         ("dead/governance.p7s", "dead/permissions.p7s"))
        self.assertGreater(told["GOV010"]["line"], 1)
        self.assertEqual(out["result"]["verdicts"], dict.fromkeys(VENDORS, "ok"))
        self.assertIn("governance: a topic rule that can never apply",
                      [check["title"] for check in out["result"]["checks"]])

    def test_what_concerns_another_product_is_left_out(self):
        for vendor, exit, found in (("cyclonedds", 1, ["DOC107", "PERM013"]), ("ddssec", 0, [])):
            out = self.doctor("grant-bracket-caret", "--vendor", vendor, exit=exit)
            self.assertEqual(sorted({d["id"] for d in out["diagnostics"]}), found)

    def test_text_is_a_table_and_sentences(self):
        done = self.run_program("doctor", self.paths["subject-slashes"], exit=1)
        lines = done.stdout.splitlines()
        self.assertRegex(lines[0], r"domain 0 +cyclonedds@0\.10\.2 +fastdds@2\.9\.1 +ddssec$")
        self.assertIn(["ok", "fail", "ok"], [line.split()[-3:] for line in lines
                                             if line.startswith("subject name form")])
        self.assertEqual(lines[-1], "1 error, 1 warning")  # no list
        self.assertRegex(done.stderr, r"(?m)^error\[DOC011\]: .*\n  --> .*/permissions\.p7s:12\n"
                                      r"  concerns: fastdds@2\.9\.1\n  hint: .*\n$")

    def test_nothing_is_written_and_nothing_is_secret(self):
        before = sorted(p.name for p in self.paths["correct"].iterdir())
        done = self.run_program("doctor", self.paths["correct"])
        self.assertEqual(sorted(p.name for p in self.paths["correct"].iterdir()), before)
        self.assertIsNone(re.search("PRIVATE KEY|MHc|MIG", done.stdout + done.stderr))

    def test_wrong_command_lines(self):
        self.refused("file_not_found", 3, "doctor", "nowhere")
        (self.at / "cert.pem").write_text("a file")
        told = self.refused("file_unreadable", 3, "doctor", "cert.pem")
        self.assertIn("(expected a participant's folder, found a file)", told["message"])
        self.refused("usage", 2, "doctor", self.paths["correct"], "--vendor", "connext")
        self.refused("usage", 2, "doctor", self.paths["correct"], "--domain", "231")


if __name__ == "__main__":
    main()

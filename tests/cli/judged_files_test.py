#!/usr/bin/env python3
"""doctor, check and keystore verify judge the files that a process reads: those that its configuration names, and of
two layouts in one folder both."""

import re
import shutil
import subprocess

from transcript import NOW, Transcript, main


class JudgedFiles(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "-q", *NOW)
        self.run_program("governance", "new", "--profile", "open", "-o", "old.xml", "--sign", "--ca", "demo", "-q", *NOW)
        self.run_program("ca", "create", "other", "--no-passphrase", "-q", *NOW)
        self.talker = self.at / "demo/talker"
        self.configuration = self.talker / "cyclonedds.xml"
        self.correct = self.configuration.read_text()

    def told(self, *words, exit, **more):
        told = self.json(*words, *NOW, exit=exit, **more)["diagnostics"]
        return [one["message"] for one in told if one["id"] == "DOC008" or "DOC008" in one["message"]]

    def configure(self, old, new):
        self.assertIn(old, self.correct)
        self.configuration.write_text(self.correct.replace(old, new))

    def test_what_init_writes_names_what_is_judged(self):
        self.assertEqual(self.told("doctor", "demo/talker", exit=0), [])
        self.assertEqual(self.told("doctor", "demo/listener", exit=0,
                                   environment={"CYCLONEDDS_URI": f"file://{self.configuration}"}), [])

    def test_another_governance_document_is_told_with_both_paths(self):
        shutil.copy(self.at / "old.p7s", self.talker / "governance_old.p7s")
        self.configure("/governance.p7s", "/governance_old.p7s")
        for product in ("ddssec", "cyclonedds"):
            message = self.told("doctor", "demo/talker", "--vendor", product, exit=1)[0]
            self.assertIn(f"{self.talker}/governance_old.p7s as governance", message)
            self.assertIn("reads that, and not demo/talker/governance.p7s, which was judged", message)
        self.assertTrue(self.told("check", "demo/talker", "demo/listener", exit=1))
        self.assertEqual(self.told("doctor", "demo/talker", "--vendor", "fastdds", exit=0), [])

    def test_every_file_counts(self):
        for name, other in (("identity_ca.pem", "other/identity/ca.pem"), ("permissions_ca.pem", "other/permissions/ca.pem"),
                            ("permissions.p7s", "demo/listener/permissions.p7s"), ("cert.pem", "demo/listener/cert.pem"),
                            ("key.pem", "demo/listener/key.pem"), ("crl.pem", "old.p7s")):
            with self.subTest(name=name):
                self.configure(f"{self.talker}/{name}", f"{self.at}/{other}")
                self.assertEqual(len(self.told("doctor", "demo/talker", exit=1)), 1)

    def test_a_folder_of_trusted_cas_is_not_what_was_judged(self):
        (self.at / "cas").mkdir()
        (self.talker / "crl.pem").unlink()
        (self.talker / "fastdds.xml").unlink()
        crl = re.search("<CRL>.*</CRL>", self.correct)[0]
        self.configure(crl, f"<TrustedCADirectory>{self.at}/cas</TrustedCADirectory>")
        for words in (("doctor", "demo/talker"), ("check", "demo/talker", "demo/listener")):
            message = self.told(*words, exit=1)[0]
            self.assertIn(f"names the folder {self.at}/cas as <TrustedCADirectory>", message)
            self.assertIn("believe peers by every CA in it, without a revocation list", message)
        self.configure(crl, "<TrustedCADirectory></TrustedCADirectory>")
        self.assertEqual(self.told("doctor", "demo/talker", exit=0), [])
        self.configure(crl, crl + "<TrustedCADirectory>/x</TrustedCADirectory>")
        told = self.json("doctor", "demo/talker", *NOW, exit=1)["diagnostics"]
        self.assertTrue([one for one in told if one["id"] == "DOC102" and "do not go together" in one["message"]])

    def test_ways_to_write_it(self):
        shutil.copy(self.at / "old.p7s", self.talker / "old.p7s")
        named = f"<Governance>file:{self.talker}/governance.p7s</Governance>"
        for text, count in (("<governance >file://{}/old.p7s</governance>", 1), ("<Governance>{}/old.p7s</Governance>", 1),
                            ("<Governance>file:old.p7s</Governance>", 1), ("<Governance>file:nowhere.p7s</Governance>", 1),
                            ("<Governance>file:$X/governance.p7s</Governance>", 1), ("<Governance>data:,x</Governance>", 1),
                            ("<Governance>file:{}/nowhere.p7s</Governance>", 1),
                            ("<Governance><![CDATA[file:{}/governance.p7s]]></Governance>", 0),
                            (named + "</Security></Domain><Domain><Security><Governance>file:{}/old.p7s</Governance>", 1),
                            ("<!-- <Governance>file:{}/old.p7s</Governance> -->" + named, 0),
                            ("<Governance>file:governance.p7s</Governance>", 0), ("<Governance>{}/governance.p7s</Governance>", 1)):
            with self.subTest(text=text):
                self.configure(named, text.replace("{}", str(self.talker)))
                self.assertEqual(len(self.told("doctor", "demo/talker", exit=min(count, 1))), count)

    def refused_by_all(self, rule, *words, environment=None):
        """doctor, check and can end with 1, and say why; with Cyclone DDS's own plugins, too."""
        for command in (("doctor", "demo/talker"), ("doctor", "demo/talker", "--vendor", "cyclonedds"),
                        ("check", "demo/talker", "demo/listener"),
                        ("check", "demo/talker", "demo/listener", "--vendor", "cyclonedds")):
            told = self.json(*command, *NOW, exit=1, environment=environment)["diagnostics"]
            told = [one for one in told if one["severity"] == "error" and rule in one["id"] + one["message"]]
            self.assertTrue(told, command)
            for word in words:
                self.assertIn(word, told[0]["message"], command)
        can = self.json("can", "demo/talker", "publish", "x", *NOW, exit=1, environment=environment)["result"]
        self.assertIn(f"the participant does not start: {rule}", can["because"])

    # What Cyclone DDS 0.10.2 makes of these configurations was measured: it runs without security.
    def test_a_configuration_that_leaves_the_process_unsecured(self):
        security = re.search("<Security>.*</Security>", self.correct, re.S)[0]
        for text, words in ((self.correct.replace(security, ""), ("cyclonedds.xml has no <Security> for domain 0",)),
                            (self.correct.replace(security, f"<!--{security}-->"), ("runs without security",)),
                            (self.correct.replace('Id="any"', 'Id="1"'), ("for domain 1 only: in domain 0",))):
            self.configuration.write_text(text)
            self.refused_by_all("DOC101", *words)
        self.configuration.write_text(self.correct.replace('Id="any"', 'Id="0"'))
        self.assertEqual(self.told("doctor", "demo/talker", exit=0), [])

    def test_an_empty_configuration_leaves_the_process_unsecured(self):
        for text in ("", "\n", "<?xml version=\"1.0\"?>\n", "<!-- later -->"):
            with self.subTest(text=text):
                self.configuration.write_text(text)
                self.refused_by_all("DOC101", "cyclonedds.xml has no <Security> for domain 0", "runs without security")
        self.configuration.write_text(self.correct)
        (self.at / "empty.xml").write_text("")
        told = self.json("doctor", "demo/talker", *NOW, environment={"CYCLONEDDS_URI": f"file://{self.at}/empty.xml"})
        self.assertEqual([(one["id"], one["severity"]) for one in told["diagnostics"]], [("DOC101", "warning")])

    # Measured as well: <Id> still counts, but not after other values of its <Domain>.
    def test_the_former_id_of_a_domain(self):
        self.configure('<Domain Id="any">', "<Domain><Id>0</Id>")
        self.assertEqual(self.told("doctor", "demo/talker", exit=0), [])
        self.configure('<Domain Id="any">', "<Domain><Id>5</Id>")
        self.refused_by_all("DOC101", "for domain 5 only: in domain 0")
        self.configure("</Domain>", "<Id>5</Id></Domain>")
        self.refused_by_all("DOC102", "<Id>5</Id> after other values of the same <Domain>")

    # It does not start, but for <AccessControl>: there stock plugins start without the documents.
    def test_a_configuration_that_cyclone_dds_does_not_start_with(self):
        access = re.search("<AccessControl>.*</AccessControl>", self.correct, re.S)[0]
        for old, new, words in (
                (access, "", ("no <AccessControl>", "governance.p7s")),
                ("initFunction=\"init_crypto\"", "initFunction=\"init_krypto\"", ("init_krypto", "\"init_crypto\"")),
                ("path=\"dds_security_ac\"", "path=\"dds_security_acc\"", ("dds_security_acc", "dds_security_ac")),
                ("<Permissions>", "<Permision>", ("permision",)),
                ("<Security>", "<Security verbose=\"1\">", ("attribute verbose",)),
                (f"<PrivateKey>file:{self.talker}/key.pem</PrivateKey>", "", ("names no <PrivateKey>",)),
                ('Id="any"', 'Id="all"', ("all",)),
                ("</Domain>", "<Genral/></Domain>", ("<genral> inside <Domain>", "does not know")),
                ('"dds_security_crypto" initFunction="init_crypto" finalizeFunction="finalize_crypto"',
                 '"dds_security_ac" initFunction="init_access_control" finalizeFunction="finalize_access_control"',
                 ("the library of <AccessControl> in <Cryptographic>",)),
                ("<Domain", "<Id>0</Id><Domain", ("<id> inside <CycloneDDS>",)),
                ("<Domain", "<Security/><Domain", ("<security> inside <CycloneDDS>",)),
                ("</CycloneDDS>", "</CycloneDDS>\n<CycloneDDS/>", ("goes on after </CycloneDDS>",)),
                ("</CycloneDDS>", "</CycloneDDS>\nend", ("text outside of <CycloneDDS>",))):
            with self.subTest(new=new):
                self.configure(old, new)
                self.refused_by_all("DOC102", *words)

    def test_a_file_that_is_not_there_or_has_no_scheme(self):
        self.configure("/governance.p7s", "/governance.p7z")
        self.refused_by_all("DOC008", f"{self.talker}/governance.p7z as governance", "governance.p7s is what was judged")
        self.configure(f"file:{self.talker}/key.pem", f"{self.talker}/key.pem")
        self.refused_by_all("DOC008", 'without "file:"', f"write file:{self.talker}/key.pem")

    def test_the_environment_counts_for_check_and_can_too(self):
        other = self.at / "other.xml"
        other.write_text(self.correct.replace('Id="any"', 'Id="3"'))
        named = {"CYCLONEDDS_URI": f"file://{other}"}
        self.refused_by_all("DOC101", "CYCLONEDDS_URI", "for domain 3 only", environment=named)
        self.assertEqual(self.json("doctor", "demo/listener", *NOW, environment=named)["diagnostics"][0]["severity"],
                         "warning")
        for uri in (f"file://{self.at}/nowhere.xml", f"file:{other}"):
            self.refused_by_all("DOC102", "cannot be read", environment={"CYCLONEDDS_URI": uri})
        # Measured: the second <Security> counts, and the participant does not start.
        second = {"CYCLONEDDS_URI": f"file://{self.configuration},<Security><Authentication><IdentityCA>file:x</IdentityCA>"
                                    "</Authentication></Security>"}
        self.refused_by_all("DOC102", "has no <AccessControl>", environment=second)
        general = {"CYCLONEDDS_URI": "<General/>"}
        told = self.json("doctor", "demo/talker", *NOW, environment=general)["diagnostics"]
        self.assertEqual([(one["id"], one["severity"]) for one in told], [("DOC101", "warning")])

    def unsecured(self, *words, **more):
        told = self.json("doctor", *words, *NOW, **more)["diagnostics"]
        return [one for one in told if one["id"] == "DOC101"]

    # Measured: Cyclone DDS 0.10.2 starts without security in all of these environments.
    def test_an_environment_that_names_no_configuration(self):
        for environment, words in ((None, "is not set"), ({"CYCLONEDDS_URI": ""}, "is empty")):
            told = self.unsecured("demo/talker", environment=environment)
            self.assertEqual([one["severity"] for one in told], ["warning"])
            self.assertIn(f"CYCLONEDDS_URI {words} in this shell", told[0]["message"])
            self.assertIn("WITHOUT security", told[0]["message"])
            self.assertIn(f"export CYCLONEDDS_URI=file://{self.configuration}", told[0]["hint"])
            text = self.run_program("doctor", "demo/talker", *NOW, environment=environment).stdout
            self.assertNotIn("nothing found", text)
            self.assertIn("and CYCLONEDDS_URI set to the folder's cyclonedds.xml, Cyclone DDS would load", text)
        told = self.unsecured("demo/talker", "--vendor", "fastdds")
        self.assertEqual([one["message"].split()[0] for one in told], ["FASTRTPS_DEFAULT_PROFILES_FILE"])
        named = {"CYCLONEDDS_URI": f"file://{self.configuration}"}
        self.assertEqual(self.unsecured("demo/talker", environment=named), [])
        self.configuration.unlink()
        self.assertEqual(self.unsecured("demo/talker"), [])

    def test_an_environment_that_names_a_folder(self):
        for uri, line in ((f"file://{self.talker}", self.configuration), ("demo/talker/", self.configuration),
                          (str(self.at), self.configuration), (f"demo,{self.at}", self.configuration)):
            with self.subTest(uri=uri):
                named = {"CYCLONEDDS_URI": uri}
                self.refused_by_all("DOC101", "names the folder", "runs without security", environment=named)
                told = self.unsecured("demo/talker", exit=1, environment=named)
                self.assertEqual(told[0]["hint"], f"export CYCLONEDDS_URI=file://{line}")
        both = {"CYCLONEDDS_URI": f"file://{self.at},file://{self.configuration}"}
        self.assertEqual(self.unsecured("demo/talker", environment=both), [])
        both = {"CYCLONEDDS_URI": f"file://{self.at},nowhere.xml"}
        self.refused_by_all("DOC102", "cannot be read", environment=both)

    def test_lines_for_the_shell_are_quoted(self):
        (self.at / "demo/talker").rename(self.at / "demo/it's")
        line = self.unsecured("demo/it's", exit=1)[0]["hint"].split(" where ")[0]
        said = subprocess.run(["sh", "-c", line + '; printf %s "$CYCLONEDDS_URI"'], text=True, capture_output=True, check=True)
        self.assertEqual(said.stdout, f"file://{self.at}/demo/it's/cyclonedds.xml")

    def test_a_revocation_list_that_is_not_named_is_not_read(self):
        self.configure(f"<CRL>file:{self.talker}/crl.pem</CRL>", "")
        self.assertIn("names no revocation list", self.told("doctor", "demo/talker", exit=1)[0])

    def test_the_configuration_in_force_counts_for_its_participant(self):
        self.configure("/governance.p7s", "/../../old.p7s")
        (self.at / "elsewhere.xml").write_text(self.configuration.read_text())
        self.configuration.write_text(self.correct)
        environment = {"CYCLONEDDS_URI": f"file://{self.at}/elsewhere.xml"}
        self.assertIn("CYCLONEDDS_URI", self.told("doctor", "demo/talker", exit=1, environment=environment)[0])
        self.assertEqual(self.told("doctor", "demo/listener", exit=0, environment=environment), [])

    def test_fastdds_configuration(self):
        file = self.talker / "fastdds.xml"
        file.write_text(file.read_text().replace("/governance.p7s", "/../../old.p7s"))
        self.assertIn("fastdds.xml names", self.told("doctor", "demo/talker", "--vendor", "fastdds", exit=1)[0])
        self.assertEqual(self.told("doctor", "demo/talker", "--vendor", "cyclonedds", exit=0), [])

    def test_a_key_that_only_cyclonedds_takes_is_no_no(self):
        """Measured: two participants of stock Cyclone DDS 0.10.2 talk, one of them with such a key."""
        def openssl(*words):
            subprocess.run(["openssl", *words], cwd=self.talker, check=True, capture_output=True)
        authority = self.at / "demo/ca/identity"
        openssl("ecparam", "-name", "secp256k1", "-genkey", "-noout", "-out", "key.pem")
        openssl("req", "-new", "-key", "key.pem", "-subj", "/CN=talker", "-out", "request")
        openssl("x509", "-req", "-in", "request", "-CA", authority / "ca.pem", "-CAkey", authority / "ca.key.pem",
                "-set_serial", "119", "-days", "30", "-out", "cert.pem")
        (self.talker / "request").unlink()
        pair = ("check", "demo/talker", "demo/listener")
        told = self.json(*pair, "--vendor", "cyclonedds", exit=3)["diagnostics"][0]
        self.assertIn("whether they would talk is not known", told["message"])
        self.json(*pair, exit=1)
        self.assertEqual(self.json("doctor", "demo/talker", "--vendor", "cyclonedds", exit=1)["result"]["verdicts"],
                         {"cyclonedds@0.10.2": "unsafe"})

    def test_two_layouts_in_an_enclave(self):
        for keystore in ("ks", "foreign"):
            self.run_program("keystore", "create", keystore, "--no-passphrase", "-q", *NOW)
            self.run_program("keystore", "enclave", keystore, "/a", "--allow-all", "-q", *NOW)
        enclave = self.at / "ks/enclaves/a"
        self.run_program("keystore", "verify", "ks", *NOW)
        for role in ("identity", "permissions"):  # the same under both names changes nothing
            shutil.copy(enclave / f"{role}_ca.cert.pem", enclave / f"{role}_ca.pem")
        self.run_program("keystore", "verify", "ks", *NOW)
        self.run_program("doctor", enclave, *NOW)
        for role in ("identity", "permissions"):
            own, foreign = ((self.at / f"{ks}/public/{role}_ca.cert.pem").read_text() for ks in ("ks", "foreign"))
            (enclave / f"{role}_ca.cert.pem").unlink()
            (enclave / f"{role}_ca.cert.pem").write_text(own + foreign)
        for words in (("keystore", "verify", "ks"), ("doctor", enclave), ("check", enclave, enclave)):
            told = self.json(*words, *NOW, exit=1)["diagnostics"]
            self.assertTrue([one for one in told if "DOC009" in one["id"] + one["message"]], words)
        ids = [one["id"] for one in self.json("keystore", "verify", "ks", *NOW, exit=1)["diagnostics"]]
        self.assertEqual(ids.count("DOC006"), 2, "what ROS 2 reads is what is judged")


if __name__ == "__main__":
    main()

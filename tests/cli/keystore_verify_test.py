#!/usr/bin/env python3
"""keystore verify, and what doctor and check say of an enclave."""

import pathlib
import shutil
import subprocess

from keystore_folders import KeystoreTest
from transcript import NOW, PROGRAM, main


class Verify(KeystoreTest):
    def test_verify_refuses_what_gives_the_keystore_away(self):
        self.create()
        self.json("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.json("keystore", "verify", "ks", *NOW)
        def told(rule):
            out = self.json("keystore", "verify", "ks", *NOW, exit=1)["diagnostics"]
            return [one["message"] for one in out if one["id"] == rule and one["severity"] == "error"]
        key = self.at / "ks/private/identity_ca.key.pem"
        for place in ("enclaves/a", "public"):
            copy = self.at / "ks" / place / "copied.key.pem"
            shutil.copy(key, copy)
            self.assertIn("copied.key.pem holds the private key" if place != "public" else "holds a private key", told("DOC004")[0])
            copy.unlink()
        for place in ("enclaves/a", "private", "public", "enclaves", ""):
            folder = self.at / "ks" / place
            mode = folder.stat().st_mode
            folder.chmod(0o777)
            self.assertIn("every user of this machine (mode 777)", told("DOC104")[0])
            folder.chmod(mode)
        self.json("keystore", "verify", "ks", *NOW)

    def test_verify_names_an_empty_enclave(self):
        self.create()
        (self.at / "ks/enclaves/b/c").mkdir(parents=True)
        out = self.json("keystore", "verify", "ks", *NOW)["diagnostics"]
        self.assertEqual([(one["id"], one["message"]) for one in out], [("DOC105", "ks/enclaves/b/c is empty")])

    def test_verify_takes_the_domain_of_the_documents(self):
        self.create("--domain", "3")
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        out = self.json("keystore", "verify", "ks", *NOW)
        self.assertEqual([(e["name"], e["domain"]) for e in out["result"]["enclaves"]], [("/a", 3), ("/b", 3)])
        self.json("can", "ks/enclaves/a", "publish", "x", "--domain", "4", *NOW, exit=1)
        self.assertEqual(out["diagnostics"], [])
        self.json("keystore", "verify", "ks", "--domain", "0", *NOW, exit=1)

    def test_verify_says_once_which_of_several_domains_it_took(self):
        self.create("--domain", "2-4")
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", "--domain", "0-9", *NOW)
        told = [d["message"] for d in self.json("keystore", "verify", "ks", *NOW)["diagnostics"]
                if d["id"] == "DOC095"]
        self.assertEqual(told, ["the documents are for domains 2-4; domain 2 was checked"])

    def test_verify_warns_of_an_enclave_in_which_no_node_starts(self):
        self.create()
        for name, topic in (("/plain", "chatter"), ("/all", "*")):
            self.run_program("keystore", "enclave", "ks", name, "--publish", topic, "--subscribe", topic, *NOW)
        out = self.json("keystore", "verify", "ks", *NOW)
        told = [(d["id"], d["severity"], d["file"]) for d in out["diagnostics"] if "no topic of ROS 2" in d["message"]]
        self.assertEqual(told, [("PERM034", "warning", "ks/enclaves/plain/permissions.p7s")], out["diagnostics"])

    def test_verify_of_a_keystore_without_enclaves_says_so(self):
        self.create()
        self.assertIn("there is no enclave in it yet", self.run_program("keystore", "verify", "ks", *NOW).stdout)

    def test_verify_names_an_enclave_of_another_keystore(self):
        self.create()
        self.run_program("keystore", "create", "other", "--no-passphrase", *NOW)
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.run_program("keystore", "enclave", "other", "/b", "--allow-all", *NOW)
        shutil.copytree(self.at / "ks/enclaves/a", self.at / "ks/enclaves/copy")  # follows links, as cp -rL
        told = self.json("keystore", "verify", "ks", *NOW, exit=1)["diagnostics"]
        self.assertEqual([(d["id"], d["file"]) for d in told], [("DOC006", "ks/enclaves/copy/cert.pem")])
        self.assertIn("enclave /copy has the key of enclave /a", told[0]["message"])
        shutil.rmtree(self.at / "ks/enclaves/copy")
        shutil.copytree(self.at / "other/enclaves/b", self.at / "ks/enclaves/b")
        told = self.json("keystore", "verify", "ks", *NOW, exit=1)["diagnostics"]
        self.assertEqual([(d["id"], d["file"]) for d in told],
                         [("DOC006", f"ks/enclaves/b/{name}")
                          for name in ("identity_ca.cert.pem", "permissions_ca.cert.pem", "governance.p7s")])

    def test_the_name_of_a_folder_forges_no_line_and_no_command(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        shutil.copytree(self.at / "ks/enclaves/a", self.at / "ks/enclaves/b\n$(id) ok")
        self.assertEqual(self.run_program("keystore", "list", "ks", *NOW).stdout, "/a\n/b?$(id) ok\n")
        told = self.run_program("keystore", "verify", "ks", *NOW, exit=1)
        self.assertEqual([line.split("  ")[0] for line in told.stdout.splitlines()], ["/a", "/b?$(id) ok"])
        self.assertIn("hint: ddssec keystore enclave ks '/b?$(id) ok' --replace,", told.stderr)
        folder = "ks/enclaves/b\n$(id) ok"
        for command in (("doctor", folder), ("expiry", folder), ("can", folder, "publish", "x"),
                        ("check", folder, "ks/enclaves/a")):
            with self.subTest(command[0]):
                lines = subprocess.run([PROGRAM, *command, *NOW], cwd=self.at, text=True, capture_output=True,
                                       timeout=60, check=False).stdout.splitlines()
                self.assertTrue(any("b?$(id) ok" in line for line in lines), lines)
                self.assertFalse([line for line in lines if line.startswith("$(id)")])

    def test_plain_text_that_was_edited_is_told(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.assertNotIn("DOC038", [d["id"] for d in self.json("keystore", "verify", "ks", *NOW)["diagnostics"]])
        for file in ("ks/enclaves/a/permissions.xml", "ks/enclaves/governance.xml"):
            text = (self.at / file).read_text()
            (self.at / file).write_text(text.replace("<id>0</id>", "<id>1</id>"))
        for command in (("keystore", "verify", "ks"), ("doctor", "ks/enclaves/a")):
            told = [d for d in self.json(*command, *NOW)["diagnostics"] if d["id"] == "DOC038"]
            self.assertEqual({(d["severity"], pathlib.Path(d["file"]).name) for d in told},
                             {("warning", "permissions.xml"), ("warning", "governance.xml")})

    def test_hints_in_an_enclave_name_the_policy(self):
        self.create()
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--publish", "rt/x", *NOW)
        a, b = "ks/enclaves/a", "ks/enclaves/b"
        remedy = "ddssec keystore permission KEYSTORE ENCLAVE --policy FILE --node-defaults"
        out = self.json("check", a, b, "--topics", "rt/far_away", *NOW, exit=1)
        told = [d for d in out["diagnostics"] if d["id"] == "DOC086"]
        self.assertTrue(told and all(remedy in d["hint"] for d in told), out["diagnostics"])
        shutil.copy(self.at / b / "permissions.p7s", self.at / a / "permissions.p7s")
        self.hint("DOC010", remedy, a)
        signed = (self.at / b / "permissions.p7s").read_bytes()
        (self.at / b / "permissions.p7s").write_bytes(signed.replace(b"rt/x", b"rt/y"))
        self.hint("DOC031", remedy, b)
        self.hint("DOC050", "ddssec keystore create KEYSTORE --domain 5", a, "--domain", "5")
        told = self.json("check", a, b, "--domain", "5", *NOW, exit=1)["diagnostics"]
        for one in [d for d in told if "DOC050" in d["message"]]:
            self.assertIn("ddssec keystore create KEYSTORE --domain 5", one["hint"])
        self.assertIn("DOC090", [d["id"] for d in told])
        self.assertIn("keystore permission", self.run_program("explain", "topic_not_allowed").stdout)

    def hint(self, rule, words, *doctor):
        told = self.json("doctor", *doctor, *NOW, exit=1)["diagnostics"]
        self.assertEqual([d["id"] for d in told if d["id"] == rule and words in d["hint"]], [rule], told)

    def test_doctor_of_a_keystore_names_its_command_and_its_enclaves(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--publish", "rt/x", *NOW)
        told = self.refused("file_not_found", 3, "doctor", "ks")
        self.assertIn("ks is a keystore", told["message"])
        self.assertIn("ddssec keystore verify ks looks at all its enclaves: ks/enclaves/a", told["hint"])

    def test_an_enclave_without_a_list_is_told(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        (self.at / "ks/enclaves/a/crl.pem").unlink()
        told = self.json("doctor", "ks/enclaves/a", *NOW)["diagnostics"]
        self.assertEqual([(d["id"], d["severity"]) for d in told], [("DOC023", "warning")])
        self.assertIn("there is no crl.pem", told[0]["message"])
        self.assertIn("ddssec crl distribute", told[0]["hint"])

    def test_verify_of_a_copy_names_the_copy_and_not_the_original(self):
        self.create()
        for name in ("/zed", "/zed/deep"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        shutil.copytree(self.at / "ks/enclaves/zed", self.at / "ks/enclaves/alpha", symlinks=True)
        shutil.rmtree(self.at / "ks/enclaves/alpha/deep")
        copies = lambda: [d for d in self.json("keystore", "verify", "ks", *NOW, exit=1)["diagnostics"]
                          if d["id"] == "DOC006"]
        (told,) = copies()
        self.assertIn('enclave /alpha has the key of enclave /zed, "CN=/zed": it is a copy', told["message"])
        self.assertEqual(told["file"], "ks/enclaves/alpha/cert.pem")
        command = told["hint"].split(", with its rights")[0].split()
        self.assertEqual(command, ["ddssec", "keystore", "enclave", "ks", "/alpha", "--replace"])
        self.run_program(*command[1:], "--allow-all", *NOW)
        self.healthy("/alpha", "/zed", "/zed/deep")
        for name in ("cert.pem", "key.pem"):
            shutil.copy(self.at / "ks/enclaves/zed" / name, self.at / "ks/enclaves" / name)
        (told,) = copies()
        self.assertIn("enclave / has the key of enclave /zed", told["message"])
        self.assertEqual(told["hint"], "move cert.pem, key.pem and permissions.p7s out of ks/enclaves, the folder of "
                                       "all enclaves")

    def test_what_lies_outside_of_the_keystore_is_named(self):
        self.create()
        self.run_program("identity", "issue", "x", "--ca", "ks", "-o", "x", *NOW)
        told = self.run_program("crl", "distribute", "--ca", "ks", *NOW).stdout
        self.assertIn(f"  outside of the keystore:\n    {self.at}/x\n", told)


if __name__ == "__main__":
    main()

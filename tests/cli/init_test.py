#!/usr/bin/env python3
"""init: one command from nothing to participants that the doctor finds healthy."""

import os
import re
import subprocess
import xml.etree.ElementTree as xml

from transcript import AT_THAT_TIME, NOW, Transcript, main

FLAT = {"identity_ca.pem": 0o644, "cert.pem": 0o644, "key.pem": 0o600, "permissions_ca.pem": 0o644,
        "governance.p7s": 0o644, "permissions.p7s": 0o644, "crl.pem": 0o644,
        "cyclonedds.xml": 0o644, "fastdds.xml": 0o644}


class Init(Transcript):
    def init(self, *more):
        return self.json("init", "demo", *NOW, *more)

    def test_one_command_makes_everything(self):
        out = self.init("--participant", "a", "--participant", "b")
        expected = {f"demo/{name}/{file}": mode for name in "ab" for file, mode in FLAT.items()}
        for role in ("identity", "permissions"):
            expected |= {f"demo/ca/{role}/ca.pem": 0o644, f"demo/ca/{role}/ca.key.pem": 0o600}
        expected |= {"demo/ca/identity/crl.pem": 0o644, "demo/ca/identity/issued.jsonl": 0o644,
                     "demo/ca/permissions/signed.jsonl": 0o644,
                     "demo/governance.xml": 0o644, "demo/governance.p7s": 0o644}
        self.assertEqual(self.files(), expected)
        self.assertEqual({f["path"]: int(f["mode"], 8) for f in out["files_written"]}, expected)
        self.assertEqual([c["subject"] for c in out["result"]["cas"]],
                         ["CN=demo Identity CA", "CN=demo Permissions CA"])
        self.assertEqual([p["not_after"] for p in out["result"]["participants"]],
                         ["2027-11-21T00:00:00Z"] * 2)
        for name in ("a", "b"):
            self.assertEqual(self.faults(self.json("doctor", f"demo/{name}", *NOW)), [])
            self.json("can", f"demo/{name}", "publish", "anything", *NOW)
            self.json("can", f"demo/{name}", "subscribe", "a", "--partition", "p", *NOW)
            self.openssl("verify", *AT_THAT_TIME, "-CAfile", "demo/ca/identity/ca.pem",
                         f"demo/{name}/cert.pem")

    def test_what_it_made_serves_the_commands_that_follow(self):
        self.init()
        self.assertEqual(self.json("ca", "show", "demo", *NOW)["result"]["issued"], 2)
        self.json("crl", "verify", "demo", "--ca", "demo", *NOW)
        self.run_program("governance", "new", "-o", "again.xml", "--sign", "--ca", "demo", *NOW)
        self.run_program("governance", "verify", "again.p7s", "--ca", "demo/ca/permissions/ca.pem",
                         *NOW)
        self.run_program("identity", "issue", "third", "--ca", "demo", "-o", "demo/third", "--publish",
                         "x", "--governance", "demo/governance.p7s", *NOW)
        self.json("doctor", "demo/third", *NOW)
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)
        out = self.json("crl", "distribute", "--ca", "demo", *NOW)["result"]
        self.assertEqual(sorted(out["folders"]),
                         [str(self.at / "demo/listener"), str(self.at / "demo/third")])

    def test_path_that_no_shell_line_can_name_is_refused(self):
        """The line for CYCLONEDDS_URI would name another place, because the terminal gets no control characters."""
        for name in ("a\nb", "a\tb", "a\x1b[2Jb", "a\u202eb"):
            (self.at / name).mkdir()
            for words in (("init", f"{name}/demo"), ("init", f"{name}/ks", "--layout", "sros2"),
                          ("keystore", "create", f"{name}/ks", "--no-passphrase")):
                with self.subTest(words=words):
                    told = self.refused("usage", 2, *words, *NOW)
                    self.assertIn("only visible characters", told["hint"])
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        (self.at / "fleet.toml").write_text('[[participant]]\nname = "one"\n')
        for words in (("talker", "-o", "a\nb/talker"), ("--from", "fleet.toml", "-o", "a\nb/fleet")):
            self.refused("usage", 2, "identity", "issue", *words, "--ca", "ca", *NOW)
        self.at /= "a\nb"  # the whole path counts
        self.refused("usage", 2, "init", "demo", *NOW)

    def faults(self, out):
        """Of the folder: that LD_LIBRARY_PATH and CYCLONEDDS_URI name nothing of it is a matter of the shell."""
        return [d["id"] for d in out["diagnostics"] if d["id"] not in ("DOC068", "DOC101")]

    def test_the_next_line_works_as_it_is_printed(self):
        for more in ((), ("--domain", "7"), ("--domain", "7", "--layout", "sros2")):
            with self.subTest(options=more):
                folder = "demo" + str(len(more))
                done = self.run_program("init", folder, *more, *NOW)
                command = next(line for line in done.stdout.splitlines() if line.startswith("next: ddssec "))
                out = self.json(*command.split()[2:], *NOW)
                self.assertEqual(out["result"]["domain"], 7 if more else 0)
                self.assertEqual(self.faults(out), [])

    def test_everybody_has_the_list_from_the_beginning(self):
        for layout, talker in (("flat", "flat/talker"), ("sros2", "sros2/enclaves/talker")):
            self.run_program("init", layout, "--layout", layout, *NOW)
            self.json("crl", "verify", talker, "--ca", layout, *NOW)
            shown = self.json("crl", "show", talker, *NOW)["result"]
            self.assertEqual((shown["number"], shown["revoked"]), (1, []))
            ca = self.json("ca", "show", layout, *NOW)["result"]
            self.assertEqual(shown["next_update"], ca["not_after"])  # nothing to renew before

    def test_snippets_name_files_that_are_there(self):
        for layout in ("flat", "sros2"):
            out = self.json("init", layout, "--layout", layout, *NOW)["result"]["snippets"]
            cyclone = xml.fromstring(out["cyclonedds"])
            files = [e.text for e in cyclone.iter() if (e.text or "").startswith("file:")]
            fast = xml.fromstring(out["fastdds"])
            files += [e.text for e in fast.iter() if (e.text or "").startswith("file:")]
            self.assertEqual(len(files), 14)
            for file in files:
                self.assertTrue(os.path.isfile(file.removeprefix("file:").removeprefix("//")), file)
        self.assertIn(f"ROS_SECURITY_KEYSTORE={self.at}/sros2\n", out["ros2"])

    def test_names_with_special_characters(self):
        for name in ("a,b", "c++", "a&b", "b;c", 'q"q', "it's", "#x", "x=y", "back\\slash", "my demo"):
            with self.subTest(name=name):
                out = self.run_program("init", name, *NOW).stdout
                subject = self.json("ca", "show", name, *NOW)["result"]["subject"]
                self.assertEqual(re.sub(r"\\(.)", r"\1", subject), f"CN={name} Identity CA")
                lines = dict(re.findall(r"(next: ddssec doctor|export CYCLONEDDS_URI=)(.*)", out))
                for line, beginning in ((lines["next: ddssec doctor"], ""), (lines["export CYCLONEDDS_URI="], "file://")):
                    said = subprocess.run(["sh", "-c", f"printf %s {line}"],
                                          text=True, capture_output=True, check=True).stdout
                    self.assertIn(f"{name}/talker", said)
                    self.assertTrue(said.startswith(beginning))
                odd = set(name) & set('"\\')  # Cyclone DDS reads the permissions from another path
                self.run_program("doctor", f"{name}/talker", *NOW, exit=1 if odd else 0)
                self.run_program("doctor", f"{name}/talker", "--vendor", "ddssec", *NOW)
        self.run_program("ca", "create", "d,e", "--no-passphrase", *NOW)
        self.run_program("keystore", "create", "f,g", "--no-passphrase", *NOW)

    def test_each_participant_has_its_snippets_in_files_that_the_last_lines_name(self):
        done = self.run_program("init", "demo", *NOW)
        snippets = self.json("init", "other", *NOW)["result"]["snippets"]
        self.assertEqual((self.at / "other/talker/cyclonedds.xml").read_text(), snippets["cyclonedds"])
        self.assertEqual((self.at / "other/talker/fastdds.xml").read_text(), snippets["fastdds"])
        for name in ("talker", "listener"):
            for file in ("cyclonedds.xml", "fastdds.xml"):
                text = (self.at / "demo" / name / file).read_text()
                xml.fromstring(text)
                self.assertIn(f"{self.at}/demo/{name}/permissions.p7s", text)
        self.assertNotIn("<", done.stdout)
        self.assertIn(f"export CYCLONEDDS_URI=file://{self.at}/demo/talker/cyclonedds.xml\n", done.stdout)
        for variable in ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE"):
            self.assertIn(f"export {variable}={self.at}/demo/talker/fastdds.xml\n", done.stdout)

    def dropin(self, folder, octets="ddssec_"):
        (self.at / folder).mkdir()
        for name in ("auth", "ac", "crypto"):
            (self.at / folder / f"libdds_security_{name}.so").write_text(octets)
        return self.at / folder

    def libraries(self, folder):
        text = (self.at / folder / "cyclonedds.xml").read_text()
        return [element.get("path") for element in xml.fromstring(text).iter("Library")]

    def test_a_drop_in_folder_is_named_by_its_whole_path(self):
        ours = self.dropin("drop in")
        done = self.run_program("init", "demo", "--dropin", "drop in", *NOW)
        for name in ("talker", "listener"):
            self.assertEqual(self.libraries(f"demo/{name}"),
                             [f"{ours}/libdds_security_{kind}.so" for kind in ("auth", "crypto", "ac")])
        self.assertIn(f"names ddssec's libraries in {ours}: ", done.stdout)
        done = self.run_program("init", "robot", "--dropin", "/opt/robot/dropin", *NOW)
        self.assertEqual(self.libraries("robot/talker")[0], "/opt/robot/dropin/libdds_security_auth.so")
        self.assertIn("/opt/robot/dropin, which is not on this machine", done.stdout)

    def test_a_drop_in_folder_without_our_libraries_is_refused(self):
        self.dropin("stock", "init_crypto")
        ours = self.dropin("ours")
        (ours / "libdds_security_ac.so").unlink()
        self.dropin("a&b")
        for folder, reason in (("stock", "is not ddssec's"), ("ours", "has no libdds_security_ac.so"),
                               ("nowhere", "there is no such folder here"), ("", "cannot name it"),
                               ("a&b", "cannot name it"), ("/opt/$ORIGIN", "cannot name it")):
            self.assertIn(reason, self.refused("usage", 2, "init", "demo", "--dropin", folder)["message"])
        told = self.refused("usage", 2, "init", "demo", "--layout", "sros2", "--dropin", "/opt/dropin")
        self.assertIn("ROS 2 names the libraries itself", told["message"])
        self.assertFalse((self.at / "demo").exists())

    def test_a_keystore_of_ros_2_with_two_real_cas(self):
        self.init("--layout", "sros2", "--participant", "/robot/camera", "--participant", "base")
        for file in ("public/permissions_ca.cert.pem", "public/identity_ca.cert.pem",
                     "private/permissions_ca.key.pem", "private/identity_ca.key.pem",
                     "enclaves/governance.p7s"):
            self.assertTrue((self.at / "demo" / file).is_file(), file)
        self.assertEqual((self.at / "demo/private").stat().st_mode & 0o777, 0o700)
        camera = self.at / "demo/enclaves/robot/camera"
        links = {p.name: os.readlink(p) for p in camera.iterdir() if p.is_symlink()}
        self.assertEqual(links, {"identity_ca.cert.pem": "../../../public/identity_ca.cert.pem",
                                 "permissions_ca.cert.pem": "../../../public/permissions_ca.cert.pem",
                                 "governance.p7s": "../../governance.p7s"})
        for enclave, subject in (("robot/camera", "CN=/robot/camera"), ("base", "CN=/base")):
            path = f"demo/enclaves/{enclave}"
            self.assertEqual(self.json("identity", "show", path, *NOW)["result"]["subject"], subject)
            self.json("doctor", path, *NOW)
        renewed = self.json("identity", "renew", "demo/enclaves/base", "--ca", "demo", "--days", "400",
                            "--permissions", *NOW)
        self.assertEqual([f["path"] for f in renewed["files_written"]],
                         [f"demo/enclaves/base/{f}" for f in ("cert.pem", "permissions.xml", "permissions.p7s")])

    def test_domain_profile_and_topics_are_said_in_the_documents(self):
        self.init("--domain", "3-5", "--profile", "balanced", "--allow-topics", "rt/*")
        self.json("can", "demo/talker", "publish", "rt/x", "--domain", "4", *NOW)
        self.json("can", "demo/talker", "publish", "x", "--domain", "4", *NOW, exit=1)
        self.refused("usage", 2, "can", "demo/talker", "publish", "rt/x", *NOW)
        self.assertIn("<rtps_protection_kind>SIGN<", (self.at / "demo/governance.xml").read_text())

    def test_nothing_is_overwritten_and_names_stay_inside(self):
        self.init()
        self.refused("would_overwrite", 4, "init", "demo")
        for name in ("../x", "a/b", "", "ca"):
            told = self.refused("name_unusable", 2, "init", "x", "--participant", name)
            self.assertNotRegex(told["hint"], r"; --subject", "init has no such option")
            self.assertIn("choose another name" if name == "ca" else "identity issue --subject", told["hint"])
        for name in ("/", "/a/../b", "/9a", "//a", "/a/"):
            if name != "/":
                self.refused("enclave_name_unusable", 2, "init", "x", "--layout", "sros2",
                             "--participant", name)
        for option, value in (("--profile", "none"), ("--layout", "round"), ("--domain", "231")):
            self.refused("usage", 2, "init", "x", option, value)
        self.refused("usage", 2, "init", "x", "--participant", "a", "--participant", "a")


if __name__ == "__main__":
    main()

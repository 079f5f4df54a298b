#!/usr/bin/env python3
"""keystore: ROS 2's keystores, made here, or made by sros2 and taken over."""

import os
import pathlib
import shutil

from sros2_keystore import DATA, links_of, make_keystore
from transcript import Transcript, main

POLICY = DATA.parent.parent / "upstream/policies/talker_listener.policy.xml"
NOW = ("--now", "2026-11-21T00:00:00Z")
NEEDED = ("public/permissions_ca.cert.pem", "public/identity_ca.cert.pem",
          "private/permissions_ca.key.pem", "private/identity_ca.key.pem", "enclaves/governance.p7s")
TALKER = "ks/enclaves/talker_listener/talker"
SHORT = """<policy version="0.2.0"><enclaves>
<enclave path="/demo/talker"><profiles><profile ns="/" node="talker">
<topics publish="ALLOW"><topic>chatter</topic></topics></profile></profiles></enclave>
<enclave path="/demo/listener"><profiles><profile ns="/" node="listener">
<topics subscribe="ALLOW"><topic>chatter</topic></topics></profile></profiles></enclave>
</enclaves></policy>
"""


class Keystore(Transcript):
    def create(self, *more):
        return self.json("keystore", "create", "ks", "--no-passphrase", *more, *NOW)

    def golden(self):
        make_keystore(self.at / "ks")

    def links(self, folder):
        return {p.name: os.readlink(p) for p in (self.at / folder).iterdir() if p.is_symlink()}

    def healthy(self, *enclaves):
        out = self.json("keystore", "verify", "ks", *NOW)["result"]
        self.assertEqual([e["name"] for e in out["enclaves"]], sorted(enclaves))

    # Measured with Cyclone DDS 0.10.2: its own plugins give /a the permissions of /a/b, and /b/a those of /a/b.
    def test_an_enclave_whose_name_stock_cyclone_dds_takes_for_another_is_warned_of(self):
        self.create()
        enclave = lambda name: self.json("keystore", "enclave", "ks", name, "--allow-all", *NOW)["diagnostics"]
        for name in ("/a", "/c/d", "/ab"):
            self.assertEqual(enclave(name), [])
        for name, gains in (("/a/b", "/a the permissions of CN=/a/b"), ("/d/c", "/d/c the permissions of CN=/c/d")):
            (told,) = enclave(name)
            self.assertEqual((told["id"], told["severity"], told["vendors"]), ("PERM011", "warning", ["cyclonedds"]))
            self.assertIn(f"would give CN={gains}", told["message"])

    def test_create_makes_what_upstream_takes_for_a_keystore(self):
        out = self.create()
        for file in NEEDED:
            self.assertTrue((self.at / "ks" / file).is_file(), file)
        self.assertEqual([c["subject"] for c in out["result"]["cas"]],
                         ["CN=ks Identity CA", "CN=ks Permissions CA"])
        self.assertEqual((self.at / "ks/private").stat().st_mode & 0o777, 0o700)
        self.assertEqual({m for f, m in self.files().items() if "private" in f}, {0o600})
        self.refused("would_overwrite", 4, "keystore", "create", "ks", "--no-passphrase")
        self.refused("passphrase_needed", 4, "keystore", "create", "other")

    def test_one_ca_has_upstreams_names_and_links(self):
        self.create("--single-ca")
        self.assertEqual(self.links("ks/public"), {"identity_ca.cert.pem": "ca.cert.pem",
                                                   "permissions_ca.cert.pem": "ca.cert.pem"})
        self.assertEqual(self.links("ks/private"), {"identity_ca.key.pem": "ca.key.pem",
                                                    "permissions_ca.key.pem": "ca.key.pem"})

    def test_an_enclave_has_the_layout_of_upstreams(self):
        self.create()
        out = self.json("keystore", "enclave", "ks", "/talker_listener/talker", "--publish", "rt/chatter", *NOW)
        self.assertEqual((out["result"]["dir"], out["result"]["subject"]), (TALKER, "CN=/talker_listener/talker"))
        self.assertEqual(self.links(TALKER), links_of("talker_listener/talker"))
        self.assertEqual({p.name for p in (self.at / TALKER).iterdir() if not p.is_symlink()},
                         {"cert.pem", "key.pem", "permissions.xml", "permissions.p7s", "crl.pem"})
        done = self.run_program("keystore", "enclave", "ks", "/other", "--allow-all", *NOW)
        self.assertIn(f"export ROS_SECURITY_KEYSTORE={self.at}/ks\n", done.stdout)
        self.assertIn("--enclave /other\n", done.stdout)
        shutil.rmtree(self.at / "ks/enclaves/other")
        self.json("can", TALKER, "publish", "rt/chatter", *NOW)
        self.json("can", TALKER, "subscribe", "rt/chatter", *NOW, exit=1)
        self.json("keystore", "permission", "ks", "/talker_listener/talker", "--allow-all", *NOW)
        self.healthy("/talker_listener/talker")
        self.json("keystore", "enclave", "ks", "/talker_listener/listener", "--allow-all", *NOW)
        self.assertEqual(self.json("keystore", "list", "ks")["result"]["enclaves"],
                         ["/talker_listener/listener", "/talker_listener/talker"])
        self.refused("would_overwrite", 4, "keystore", "enclave", "ks", "/talker_listener/talker", "--allow-all")

    def test_names_and_links_do_not_lead_out(self):
        self.create()
        for name in ("talker", "/../x", "/a/../../x", "/9", "/a-b", "/a//b", "/", "/a/", "", "/" + "a" * 255):
            self.refused("enclave_name_unusable", 2, "keystore", "enclave", "ks", name, "--allow-all")
        (self.at / "outside").mkdir()
        (self.at / "ks/enclaves/away").symlink_to("../../outside")
        self.refused("enclave_name_unusable", 2, "keystore", "enclave", "ks", "/away/x", "--allow-all")
        self.refused("usage", 2, "keystore", "enclave", "ks", "/a")
        self.refused("keystore_incomplete", 3, "keystore", "list", "outside")

    def test_permission_replaces_what_an_enclave_may_do(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--publish", "rt/x", *NOW)
        self.json("keystore", "permission", "ks", "/a", "--subscribe", "rt/y", *NOW)
        self.json("can", "ks/enclaves/a", "publish", "rt/x", *NOW, exit=1)
        self.json("can", "ks/enclaves/a", "subscribe", "rt/y", *NOW)
        self.json("keystore", "permission", "ks", "/a", "--allow-all", *NOW)
        self.healthy("/a")
        (self.at / "own.xml").write_text((self.at / "ks/enclaves/a/permissions.xml").read_text()
                                         .replace("CN=/a", "CN=/b"))
        self.refused("no_grant_for_subject", 1, "keystore", "permission", "ks", "/a", "--permissions",
                     "own.xml", *NOW)

    def test_rights_come_straight_from_a_policy_of_sros2(self):
        self.golden()
        self.run_program("keystore", "import", "ks", *NOW)
        self.json("keystore", "permission", "ks", "/talker_listener/talker", "--policy", POLICY, *NOW)
        self.run_program("permissions", "from-ros-policy", POLICY, "--enclave", "/talker_listener/talker",
                         "--validity-from", f"{TALKER}/cert.pem", "-o", "same.xml", *NOW)
        self.assertEqual((self.at / TALKER / "permissions.xml").read_bytes(),
                         (self.at / "same.xml").read_bytes())
        self.healthy("/talker_listener/listener", "/talker_listener/talker", "/wildcard")
        self.refused("usage", 2, "keystore", "permission", "ks", "/wildcard", "--policy", POLICY, *NOW)

    def test_a_new_enclave_from_a_policy(self):
        self.create("--domain", "3")
        for name in ("talker", "listener"):
            self.run_program("keystore", "enclave", "ks", f"/talker_listener/{name}", "--domain", "3",
                             "--policy", POLICY, *NOW)
        self.json("can", TALKER, "publish", "rt/chatter", "--domain", "3", *NOW)
        self.json("can", TALKER, "subscribe", "rt/chatter", "--domain", "3", *NOW, exit=1)

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

    def test_names_of_dds_in_a_policy_are_told(self):
        (self.at / "short.xml").write_text(SHORT.replace("chatter", "rt/chatter", 1))
        self.create()
        enclave = ("ks", "/demo/talker", "--policy", "short.xml", "--node-defaults", *NOW)
        for command in ("enclave", "permission"):
            told = self.json("keystore", command, *enclave)["diagnostics"]
            self.assertEqual([(d["id"], d["file"]) for d in told], [("PERM035", "short.xml")])
            self.assertIn('"rt/chatter"', told[0]["message"])

    def test_doctor_of_a_keystore_names_its_command_and_its_enclaves(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--publish", "rt/x", *NOW)
        told = self.refused("file_not_found", 3, "doctor", "ks")
        self.assertIn("ks is a keystore", told["message"])
        self.assertIn("ddssec keystore verify ks looks at all its enclaves: ks/enclaves/a", told["hint"])

    def test_a_policy_with_what_every_node_needs(self):
        (self.at / "short.xml").write_text(SHORT)
        self.create()
        out = self.json("keystore", "enclave", "ks", "/demo/talker", "--policy", "short.xml", *NOW)
        told = out["diagnostics"][0]
        self.assertEqual((told["id"], told["file"]), ("PERM040", "ks/enclaves/demo/talker/permissions.p7s"))
        self.assertIn("rosout", told["message"])
        self.assertIn("--node-defaults", told["hint"])
        # Measured with a node of ROS 2 Humble: it aborts with "failed to create topic [rt/rosout]".
        variables = {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce",
                     "ROS_SECURITY_KEYSTORE": str(self.at / "ks")}
        doctor = ("doctor", "ks/enclaves/demo/talker", "--ros", *NOW)
        for words, more in ((("keystore", "verify", "ks", *NOW), {}), (doctor, {"environment": variables})):
            judged = self.json(*words, exit=1, **more)
            (told,) = [d for d in judged["diagnostics"] if d["id"] == "PERM040"]
            self.assertEqual(told["severity"], "error")
            self.assertIn("does not start in domain 0", told["message"])
            self.assertIn("--node-defaults", told["hint"])
            verdicts = judged["result"].get("enclaves", [judged["result"]])[0]["verdicts"]
            self.assertNotIn("ok", verdicts.values())
        out = self.json("keystore", "permission", "ks", "/demo/talker", "--policy", "short.xml", "--node-defaults",
                        *NOW)
        self.assertEqual(out["diagnostics"], [])
        self.assertEqual(self.json("keystore", "verify", "ks", *NOW)["diagnostics"], [])
        self.json("can", "ks/enclaves/demo/talker", "publish", "rr/talker/get_parametersReply", *NOW)
        self.json("can", "ks/enclaves/demo/talker", "publish", "rr/other/get_parametersReply", *NOW, exit=1)
        out = self.json("keystore", "enclave", "ks", "/demo/listener", "--policy", "short.xml", "--node-defaults",
                        *NOW)
        self.assertEqual(out["diagnostics"], [])
        told = self.refused("usage", 2, "keystore", "permission", "ks", "/demo/talker", "--publish", "rt/x",
                            "--node-defaults")
        self.assertIn("--policy", told["message"])

    def test_rights_have_one_source(self):
        self.create()
        new = ("keystore", "enclave", "ks", "/talker_listener/talker")
        self.refused("usage", 2, *new, "--policy", POLICY, "--publish", "rt/x")
        self.refused("usage", 2, *new, "--allow-all", "--publish", "rt/x")
        self.refused("file_not_found", 3, *new, "--policy", "none.xml")

    def test_profiles_of_a_policy_that_are_merged_are_told(self):
        self.create()
        (self.at / "two.xml").write_text(
            '<policy version="0.2.0"><enclaves><enclave path="/e">'
            + 2 * '<profiles><profile ns="/" node="a"><topics publish="ALLOW"><topic>x</topic></topics>'
                  '</profile></profiles>' + "</enclave></enclaves></policy>")
        out = self.json("keystore", "enclave", "ks", "/e", "--policy", "two.xml", *NOW)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["PERM031", "PERM040"])

    def test_a_keystore_of_sros2_is_taken_over(self):
        self.golden()
        told = self.json("keystore", "verify", "ks", *NOW, exit=1)
        self.assertEqual(len(told["result"]["keys_for_others"]), 4)
        self.assertEqual([d["file"] for d in told["diagnostics"] if d["id"] == "key_readable_by_others"],
                         ["ks/private/ca.key.pem"])
        self.assertEqual([d["id"] for d in told["diagnostics"]].count("DOC003"), 3)
        self.refused("key_readable_by_others", 4, "keystore", "split-ca", "ks", *NOW)
        out = self.json("keystore", "import", "ks", *NOW)["result"]
        self.assertEqual(out["logged"], ["/talker_listener/listener", "/talker_listener/talker", "/wildcard"])
        self.assertEqual(len(out["keys_closed"]), 4)
        self.assertEqual(out["folders_closed"], ["ks/private"])
        self.assertEqual((self.at / "ks/private").stat().st_mode & 0o777, 0o700)
        self.assertEqual(self.json("keystore", "import", "ks", *NOW)["result"],
                         {"folders_closed": [], "keys_closed": [], "logged": []})
        self.healthy("/talker_listener/listener", "/talker_listener/talker", "/wildcard")

    def test_a_folder_behind_a_link_keeps_its_mode(self):
        """A keystore that came from another user must not close any folder of this one."""
        for name in ("private", "enclaves"):
            with self.subTest(name=name):
                shutil.rmtree(self.at / "ks", ignore_errors=True)
                shutil.rmtree(self.at / "shared", ignore_errors=True)
                self.golden()
                (self.at / "ks" / name).rename(self.at / "shared")
                (self.at / "ks" / name).symlink_to(self.at / "shared")
                (self.at / "shared").chmod(0o777)
                keys = {key: key.stat().st_mode for key in (self.at / "shared").rglob("*key.pem")}
                self.assertTrue(keys)
                refusal = self.refused("file_unwritable", 5, "keystore", "import", "ks", *NOW)
                self.assertIn("symbolic link", refusal["message"])
                self.assertEqual((self.at / "shared").stat().st_mode & 0o777, 0o777)
                self.assertEqual({key: key.stat().st_mode for key in keys}, keys)

    def test_a_copy_of_another_enclaves_certificate_is_not_logged(self):
        self.golden()
        other = self.at / "ks/enclaves/talker_listener/listener/cert.pem"
        (self.at / TALKER / "cert.pem").write_bytes(other.read_bytes())
        told = self.refused("certificate_of_another_folder", 1, "keystore", "import", "ks", *NOW)
        self.assertIn("which is also in ks/enclaves/talker_listener/listener", told["message"])
        self.assertEqual(told["hint"], "ddssec keystore verify ks names the enclave that is the copy")
        self.assertIn("enclave /talker_listener/talker has the key of enclave /talker_listener/listener",
                      self.run_program("keystore", "verify", "ks", *NOW, exit=1).stderr)
        self.run_program("keystore", "create", "own", "--no-passphrase", *NOW)
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "own", name, "--allow-all", *NOW)
        shutil.copy(self.at / "own/enclaves/b/cert.pem", self.at / "own/enclaves/a/cert.pem")
        self.refused("certificate_of_another_folder", 1, "keystore", "import", "own", *NOW)

    def test_its_certificates_are_renewed_and_revoked_in_place(self):
        self.golden()
        self.run_program("keystore", "import", "ks", *NOW)
        before = self.json("identity", "show", TALKER, *NOW)["result"]
        out = self.json("identity", "renew", TALKER, "--ca", "ks", "--days", "2000", "--permissions", *NOW)
        self.assertEqual(out["result"]["subject"], before["subject"])
        self.healthy("/talker_listener/listener", "/talker_listener/talker", "/wildcard")
        self.run_program("identity", "revoke", "ks/enclaves/talker_listener/listener", "--ca", "ks", *NOW)
        out = self.json("crl", "distribute", "--ca", "ks", *NOW)["result"]
        self.assertEqual(out["folders"], [str(self.at / TALKER), str(self.at / "ks/enclaves/wildcard")])

    def test_a_copied_or_moved_keystore_keeps_to_its_own_enclaves(self):
        self.create()
        for name in ("/a", "/b", "/c"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        shutil.copytree(self.at / "ks", self.at / "copy", symlinks=True)
        before = {p: p.read_bytes() for p in (self.at / "ks").rglob("*") if p.is_file()}
        shutil.rmtree(self.at / "copy/enclaves/c")
        own = [str(self.at / "copy/enclaves/b")]
        out = self.json("identity", "revoke", "copy/enclaves/a", "--ca", "copy", *NOW)["result"]
        left_out = [str(self.at / "ks/enclaves/c")]
        self.assertEqual((out["folders"], out["elsewhere"]), (own + left_out, left_out))
        out = self.json("crl", "distribute", "--ca", "copy", *NOW)
        self.assertEqual((out["result"]["folders"], out["result"]["elsewhere"]), (own, left_out))
        self.assertEqual([f["path"] for f in out["files_written"]], [own[0] + "/crl.pem"])
        self.assertEqual({p: p.read_bytes() for p in before}, before)  # the original knows nothing of it
        told = self.run_program("crl", "distribute", "--ca", "copy", *NOW).stdout
        self.assertIn("another copy of this CA lies beside it", told)
        (self.at / "copy").rename(self.at / "moved")
        shutil.rmtree(self.at / "ks")
        out = self.json("crl", "distribute", "--ca", "moved", *NOW)["result"]
        self.assertEqual(out["folders"], [str(self.at / "moved/enclaves/b")])

    def test_the_keystores_newer_list_counts_before_it_is_distributed(self):
        self.create()
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        self.run_program("identity", "revoke", "ks/enclaves/a", "--ca", "ks", *NOW)
        for distributed in (False, True):
            for words in (("keystore", "verify", "ks"), ("doctor", "ks/enclaves/a")):
                told = [d for d in self.json(*words, *NOW, exit=1)["diagnostics"] if d["id"] == "DOC024"]
                self.assertEqual(len(told), 1, words)
                self.assertRegex(told[0]["message"], "serial [0-9A-F]+\\) is revoked by list 2 of the CA, .*"
                                 "/ks/public/identity_ca.crl.pem; crl.pem here is list 1; "
                                 "participants that do not have that list yet accept it$")
            self.json("check", "ks/enclaves/a", "ks/enclaves/b", *NOW, exit=1 if distributed else 0)
            told = self.json("can", "ks/enclaves/a", "publish", "x", *NOW, exit=1)["result"]
            self.assertIn("is revoked by list 2", told["because"])
            self.json("can", "ks/enclaves/b", "publish", "x", *NOW)
            states = {e["subject"]: e["state"] for e in self.json("expiry", "ks", *NOW)["result"]["entries"]
                      if e["kind"] == "certificate"}
            self.assertEqual(states, {"CN=/a": "revoked", "CN=/b": "ok"})
            told = [(d["id"], d["severity"]) for d in self.json("doctor", "ks/enclaves/b", *NOW)["diagnostics"]]
            self.assertEqual(told, [] if distributed else [("DOC023", "warning")])
            self.run_program("crl", "distribute", "--ca", "ks", *NOW)

    def test_a_list_that_the_ca_did_not_sign_counts_for_nothing(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        (self.at / "other").mkdir()
        self.run_program("keystore", "create", "other/ks", "--no-passphrase", *NOW)
        serial = self.json("identity", "show", "ks/enclaves/a", *NOW)["result"]["serial"]
        with open(self.at / "other/ks/private/identity_ca.issued.jsonl", "w", encoding="ascii") as log:
            log.write(f'{{"event":"issued","serial":"{serial}","subject":"CN=/a",'
                      '"not_after":"2027-11-21T00:00:00Z"}\n')
        self.run_program("identity", "revoke", serial, "--ca", "other/ks", *NOW)
        shutil.copy(self.at / "other/ks/public/identity_ca.crl.pem", self.at / "ks/public/identity_ca.crl.pem")
        self.assertEqual(self.json("doctor", "ks/enclaves/a", *NOW)["diagnostics"], [])

    def test_an_enclave_without_a_list_is_told(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        (self.at / "ks/enclaves/a/crl.pem").unlink()
        told = self.json("doctor", "ks/enclaves/a", *NOW)["diagnostics"]
        self.assertEqual([(d["id"], d["severity"]) for d in told], [("DOC023", "warning")])
        self.assertIn("there is no crl.pem", told[0]["message"])
        self.assertIn("ddssec crl distribute", told[0]["hint"])

    def test_a_revoked_enclave_comes_back_with_a_new_key(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.run_program("identity", "revoke", "ks/enclaves/a", "--ca", "ks", *NOW)
        told = self.refused("certificate_revoked", 1, "identity", "renew", "ks/enclaves/a", "--ca", "ks", *NOW)
        self.assertIn("ddssec keystore enclave", told["hint"])
        told = self.refused("would_overwrite", 4, "keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.assertIn("the enclave exists", told["message"])
        self.assertTrue(told["hint"].startswith("ddssec keystore permission gives it other rights"), told)
        self.assertIn("--replace issues it again, with a new key", told["hint"])
        self.run_program("keystore", "enclave", "ks", "/a", "--replace", *NOW)
        self.healthy("/a")

    def test_Replace_OfAnEnclave_KeepsItsPermissionsAndTheEnclavesBelowIt(self):
        self.create()
        for name in ("/a", "/a/b", "/z"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        files = lambda folder: {name: (self.at / "ks/enclaves" / folder / name).read_bytes()
                                for name in ("cert.pem", "key.pem", "permissions.p7s")}
        before, below = files("a"), files("a/b")
        done = self.run_program("keystore", "enclave", "ks", "/a", "--replace", *NOW)
        self.assertIn("permissions.p7s stays, until 2027-11-21\n", done.stdout)
        self.assertIn("the certificate before it is valid until 2027-11-21", done.stdout)
        after = files("a")
        self.assertEqual([name for name in before if before[name] != after[name]], ["cert.pem", "key.pem"])
        self.assertEqual(files("a/b"), below)
        self.healthy("/a", "/a/b", "/z")
        serial = done.stdout.split("ddssec identity revoke ")[1].split()[0]
        self.json("identity", "revoke", serial, "--ca", "ks", *NOW)
        self.run_program("crl", "distribute", "--ca", "ks", *NOW)
        self.healthy("/a", "/a/b", "/z")
        self.run_program("keystore", "enclave", "ks", "/a", "--replace", "--allow-all", *NOW)
        self.assertNotEqual(files("a")["permissions.p7s"], after["permissions.p7s"])
        self.healthy("/a", "/a/b", "/z")

    def test_Replace_WithoutPermissionsOfTheEnclave_AsksForThem(self):
        self.create()
        enclave = ("keystore", "enclave", "ks")
        self.refused("usage", 2, *enclave, "/a", "--replace", *NOW)  # there is nothing to keep
        for name in ("/a", "/b"):
            self.run_program(*enclave, name, "--allow-all", *NOW)
        shutil.copy(self.at / "ks/enclaves/b/permissions.p7s", self.at / "ks/enclaves/a/permissions.p7s")
        told = self.refused("no_grant_for_subject", 1, *enclave, "/a", "--replace", *NOW)
        self.assertTrue(told["hint"].startswith("give its rights, too"), told)
        later = ("--now", "2028-11-21T00:00:00Z")
        self.refused("grant_expired", 1, *enclave, "/b", "--replace", *later)
        for name in ("/a", "/b"):
            self.run_program(*enclave, name, "--replace", "--allow-all", *NOW)
        self.healthy("/a", "/b")

    def test_Replace_OfAnEnclaveOfAnotherKeystore_MakesItOneOfThisOne(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.run_program("keystore", "create", "other", "--no-passphrase", *NOW)
        self.run_program("keystore", "enclave", "other", "/a", "--allow-all", *NOW)
        shutil.rmtree(self.at / "ks/enclaves/a")
        shutil.copytree(self.at / "other/enclaves/a", self.at / "ks/enclaves/a")  # follows links, as cp -rL
        told = self.json("keystore", "verify", "ks", *NOW, exit=1)["diagnostics"]
        self.assertIn("ddssec keystore enclave KEYSTORE ENCLAVE --replace",
                      [d["hint"] for d in told if d["id"] == "DOC006"][0])
        self.run_program("keystore", "enclave", "ks", "/a", "--replace", "--allow-all", *NOW)
        self.healthy("/a")

    def test_Verify_OfACopy_NamesTheCopyAndNotTheOriginal(self):
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

    def test_another_domain_than_the_governance_documents_is_told(self):
        self.create("--domain", "5")
        self.assertEqual(self.json("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)["diagnostics"], [])
        told = self.json("keystore", "permission", "ks", "/a", "--allow-all", "--domain", "0", *NOW)["diagnostics"]
        self.assertEqual([(d["id"], d["severity"]) for d in told], [("DOC050", "warning")])
        self.assertIn("are for domain 0, and the governance document is for 5", told[0]["message"])

    def test_an_enclave_that_the_policy_does_not_have(self):
        self.create()
        (self.at / "short.xml").write_text(SHORT)
        told = self.refused("usage", 2, "keystore", "enclave", "ks", "/demo/talkr", "--policy", "short.xml", *NOW)
        self.assertIn("expected an enclave of the policy: /demo/talker, /demo/listener", told["message"])

    def test_what_lies_outside_of_the_keystore_is_named(self):
        self.create()
        self.run_program("identity", "issue", "x", "--ca", "ks", "-o", "x", *NOW)
        told = self.run_program("crl", "distribute", "--ca", "ks", *NOW).stdout
        self.assertIn(f"  outside of the keystore:\n    {self.at}/x\n", told)

    def test_a_keystore_that_was_not_taken_over_gets_the_list_too(self):
        self.golden()
        for key in (self.at / "ks").rglob("*key.pem"):
            key.chmod(0o600)
        told = self.run_program("identity", "revoke", TALKER, "--ca", "ks", *NOW).stdout
        self.assertIn("(puts the list into 2 folders)", told)
        self.assertIn("ddssec keystore import", told)
        self.json("crl", "distribute", "--ca", "ks", *NOW)
        self.json("check", TALKER, "ks/enclaves/talker_listener/listener", *NOW, exit=1)

    def test_split_ca_parts_what_sros2_joined(self):
        self.golden()
        self.run_program("keystore", "import", "ks", *NOW)
        identity = (self.at / "ks/public/identity_ca.cert.pem").read_bytes()
        rights = self.json("can", TALKER, "publish", "rt/chatter", *NOW)["result"]["because"]
        before = self.files()
        told = self.refused("document_unlogged", 1, "keystore", "split-ca", "ks", *NOW)
        self.assertIn("--unlogged", told["hint"])
        self.assertEqual(self.files(), before)
        out = self.json("keystore", "split-ca", "ks", "--unlogged", *NOW)
        self.assertEqual(out["result"]["unlogged"],
                         ["ks/enclaves/governance.p7s"] + [f"ks/enclaves/{name}/permissions.p7s" for name in
                                                           ("talker_listener/listener", "talker_listener/talker", "wildcard")])
        self.assertEqual(out["result"]["subject"], "CN=ks Permissions CA")
        self.assertEqual((self.at / "ks/public/identity_ca.cert.pem").read_bytes(), identity)
        self.assertNotEqual((self.at / "ks/public/permissions_ca.cert.pem").read_bytes(), identity)
        self.assertEqual(self.files()["ks/private/permissions_ca.key.pem"], 0o600)
        for file in NEEDED:
            self.assertTrue((self.at / "ks" / file).is_file(), file)
        self.healthy("/talker_listener/listener", "/talker_listener/talker", "/wildcard")
        self.assertEqual(self.json("can", TALKER, "publish", "rt/chatter", *NOW)["result"]["because"], rights)
        self.assertIn("two CAs already", self.run_program("keystore", "split-ca", "ks", *NOW).stdout)

    def test_permission_signs_for_the_enclaves_own_certificate_only(self):
        self.create()
        for name in ("/cam", "/controller"):
            self.run_program("keystore", "enclave", "ks", name, "--publish", "x", *NOW)
        permission = ("keystore", "permission", "ks", "/cam", "--publish", "y", *NOW)
        own = (self.at / "ks/enclaves/cam/cert.pem").read_bytes()
        self.openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj",
                     "/CN=\\/controller", "-days", "36500", "-keyout", "own.key.pem", "-out", "ks/enclaves/cam/cert.pem")
        self.refused("issuer_unknown", 1, *permission)
        shutil.copy(self.at / "ks/enclaves/controller/cert.pem", self.at / "ks/enclaves/cam/cert.pem")
        told = self.refused("certificate_of_another_folder", 1, *permission)
        self.assertIn("ddssec keystore enclave ks /cam --replace", told["hint"])
        self.assertNotIn("--subject", told["hint"])
        (self.at / "ks/enclaves/cam/cert.pem").write_bytes(own)
        self.json(*permission)
        self.run_program("identity", "revoke", "ks/enclaves/cam", "--ca", "ks", *NOW)
        self.refused("certificate_revoked", 1, *permission)

    def test_rotate_replaces_a_ca_and_everything_follows(self):
        self.create()
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        for role in ("identity", "permissions"):
            before = (self.at / f"ks/private/{role}_ca.key.pem").read_bytes()
            subject = self.json("identity", "show", "ks/enclaves/a", *NOW)["result"]["subject"]
            out = self.json("keystore", "rotate", "ks", "--role", role, *NOW)["result"]
            self.assertEqual(out["enclaves"], ["/a", "/b"])
            self.assertNotEqual((self.at / f"ks/private/{role}_ca.key.pem").read_bytes(), before)
            self.assertEqual(self.json("identity", "show", "ks/enclaves/a", *NOW)["result"]["subject"], subject)
            self.healthy("/a", "/b")
        self.refused("usage", 2, "keystore", "rotate", "ks", "--role", "both")

    def test_rotate_lets_nobody_back_in(self):
        self.create()
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        self.run_program("identity", "revoke", "ks/enclaves/b", "--ca", "ks", *NOW)
        self.run_program("keystore", "rotate", "ks", "--role", "identity", *NOW)
        self.json("keystore", "verify", "ks", *NOW, exit=1)  # /b stays with a CA that nobody has
        self.json("doctor", "ks/enclaves/a", *NOW)

    def test_rotate_takes_the_revocation_list_along(self):
        self.create()
        for name in ("/a", "/b", "/c"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
        self.run_program("identity", "revoke", "ks/enclaves/b", "--ca", "ks", *NOW)
        self.run_program("crl", "distribute", "--ca", "ks", *NOW)
        done = self.run_program("keystore", "rotate", "ks", "--role", "identity", *NOW)
        self.assertIn("2 enclaves signed anew", done.stdout)
        self.assertIn("/b is revoked and was left out", done.stdout)
        for name in ("a", "c"):
            self.json("crl", "verify", f"ks/enclaves/{name}", "--ca", "ks", *NOW)
        self.json("check", "ks/enclaves/a", "ks/enclaves/c", *NOW)
        self.json("check", "ks/enclaves/a", "ks/enclaves/b", *NOW, exit=1)

    def test_a_new_enclave_knows_who_was_revoked(self):
        self.create()
        for name in ("/a", "/b"):
            self.run_program("keystore", "enclave", "ks", name, "--allow-all", *NOW)
            self.assertEqual(self.json("crl", "show", f"ks/enclaves{name}", *NOW)["result"]["revoked"], [])
        self.run_program("identity", "revoke", "ks/enclaves/b", "--ca", "ks", *NOW)
        self.run_program("keystore", "enclave", "ks", "/c", "--allow-all", *NOW)
        self.json("crl", "verify", "ks/enclaves/c", "--ca", "ks", *NOW)
        self.json("check", "ks/enclaves/b", "ks/enclaves/c", *NOW, exit=1)

    def test_a_document_that_the_old_ca_did_not_sign_is_not_signed(self):
        self.create()
        self.run_program("keystore", "enclave", "ks", "/a", "--publish", "x", *NOW)
        document = self.at / "ks/enclaves/a/permissions.p7s"
        document.write_text(document.read_text().replace("<topic>x<", "<topic>*<"))
        self.refused("smime_signature_invalid", 1, "keystore", "rotate", "ks", "--role", "permissions", *NOW)


if __name__ == "__main__":
    main()

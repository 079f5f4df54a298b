#!/usr/bin/env python3
"""keystore create, enclave and permission: ROS 2's keystores, made here."""

import shutil

from keystore_folders import NEEDED, POLICY, SHORT, TALKER, KeystoreTest
from sros2_keystore import links_of
from transcript import NOW, main


class Keystore(KeystoreTest):
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
        (told,) = self.json("can", TALKER, "subscribe", "rt/chatter", *NOW, exit=1)["diagnostics"]
        self.assertIn("ddssec keystore permission", told["hint"])
        self.assertNotIn("permissions new", told["hint"])
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

    def test_names_of_dds_in_a_policy_are_told(self):
        (self.at / "short.xml").write_text(SHORT.replace("chatter", "rt/chatter", 1))
        self.create()
        enclave = ("ks", "/demo/talker", "--policy", "short.xml", "--node-defaults", *NOW)
        for command in ("enclave", "permission"):
            told = self.json("keystore", command, *enclave)["diagnostics"]
            self.assertEqual([(d["id"], d["file"]) for d in told], [("PERM035", "short.xml")])
            self.assertIn('"rt/chatter"', told[0]["message"])

    def test_a_policy_with_what_every_node_needs(self):
        (self.at / "short.xml").write_text(SHORT)
        self.create()
        out = self.json("keystore", "enclave", "ks", "/demo/talker", "--policy", "short.xml", *NOW)
        told = out["diagnostics"][0]
        self.assertEqual((told["id"], told["file"]), ("PERM040", "ks/enclaves/demo/talker/permissions.xml"))
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

    def test_permission_shows_what_lint_warns_of_whatever_the_rights_come_from(self):
        (self.at / "short.xml").write_text(SHORT.replace("chatter", "rt/chatter", 1))
        self.create()
        self.json("keystore", "enclave", "ks", "/demo/talker", "--allow-all", *NOW)
        (self.at / "half.xml").write_text((self.at / "ks/enclaves/demo/talker/permissions.xml").read_text().replace(
            "<topic>*</topic>", "<topic>rq/addRequest</topic>"))
        written = "ks/enclaves/demo/talker/permissions.xml"
        for words, file, expected in ((("--policy", "short.xml"), written, {"PERM035", "PERM040"}),
                                      (("--publish", "rq/addRequest"), written, {"PERM030", "PERM032", "PERM040"}),
                                      (("--permissions", "half.xml"), "half.xml", {"PERM030", "PERM032", "PERM040"})):
            for command in (("permission", "ks", "/demo/talker"), ("enclave", "ks", "/demo/talker", "--replace")):
                told = self.json("keystore", *command, *words, *NOW)["diagnostics"]
                self.assertLessEqual(expected, {d["id"] for d in told}, (command, words))
                self.assertEqual({d["severity"] for d in told}, {"warning"})
                self.assertEqual({d["file"] for d in told if d["id"] != "PERM035"}, {file})
                linted = self.json("permissions", "lint", written, *NOW, exit=None)["diagnostics"]
                self.assertLessEqual({d["message"] for d in linted if d["severity"] != "note"}, {d["message"] for d in told})

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


if __name__ == "__main__":
    main()

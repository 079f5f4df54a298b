#!/usr/bin/env python3
"""permissions from-ros-policy: the same octets as sros2, or one merged grant; bad policies."""

from transcript import DATA, NOW, Transcript, main

SROS2 = DATA / "sros2"
POLICIES = SROS2 / "upstream/policies"
TWO = """<policy version="0.2.0"><enclaves><enclave path="/e">
<profiles><profile ns="/" node="a"><topics publish="ALLOW"><topic>x</topic></topics></profile></profiles>
<profiles><profile ns="/" node="b"><topics subscribe="ALLOW"><topic>x</topic></topics></profile></profiles>
</enclave></enclaves></policy>
"""


class RosPolicy(Transcript):
    def convert(self, policy, *words, **more):
        return self.json("permissions", "from-ros-policy", policy, "-o", "p.xml", *NOW, *words, **more)

    def test_keystores_of_sros2_are_reproduced_octet_for_octet(self):
        enclave = SROS2 / "generated/keystore/enclaves/talker_listener/talker"
        self.convert(POLICIES / "talker_listener.policy.xml", "--enclave", "/talker_listener/talker",
                     "--validity-from", enclave / "cert.pem", "--sros2-order")
        self.assertEqual((self.at / "p.xml").read_bytes(), (enclave / "permissions.xml").read_bytes())

    def test_without_the_discovery_topic(self):
        out = self.convert(POLICIES / "add_two_ints.policy.xml", "--no-discovery-topic", "--domain", "3")
        self.assertIn("PERM032", [d["id"] for d in out["diagnostics"]])
        self.assertMeetsSchema("p.xml", "permissions.xsd")
        text = (self.at / "p.xml").read_text()
        self.assertNotIn("ros_discovery_info", text)
        self.assertIn("<id>3</id>", text)
        self.assertEqual([g["name"] for g in out["result"]["grants"]],
                         ["/add_two_ints/add_two_ints_server", "/add_two_ints/add_two_ints_client"])

    def test_profiles_of_one_enclave_are_merged_and_it_says_so(self):
        (self.at / "two.xml").write_text(TWO)
        out = self.convert("two.xml", "--days", "30")
        told = [d for d in out["diagnostics"] if d["id"] == "PERM031"]
        self.assertEqual([(d["file"], d["line"]) for d in told], [("two.xml", 1)])
        self.assertEqual(len(out["result"]["grants"]), 1)
        (self.at / "p.xml").unlink()
        out = self.convert("two.xml", "--sros2-order")
        self.assertEqual(len(out["result"]["grants"]), 2)
        self.assertIn("PERM010", [d["id"] for d in out["diagnostics"]])

    def test_names_of_dds_in_a_policy_are_told(self):
        for name in ("rt/x", "/rq/x", " rr/x"):
            (self.at / "two.xml").write_text(TWO.replace(">x<", f">{name}<", 1))
            told = [d for d in self.convert("two.xml")["diagnostics"] if d["id"] == "PERM035"]
            self.assertEqual([d["file"] for d in told], ["two.xml"], name)
            (self.at / "p.xml").unlink()
        (self.at / "two.xml").write_text(TWO.replace(">x<", ">route<"))
        self.assertNotIn("PERM035", [d["id"] for d in self.convert("two.xml")["diagnostics"]])

    def test_what_every_node_needs_is_added_on_demand(self):
        bare = TWO.replace("publish=", "publish=").replace("</topics></profile></profiles>\n</enclave>",
                           "</topics><services reply=\"DENY\"><service>~/set_parameters</service></services>"
                           "</profile></profiles>\n</enclave>")
        (self.at / "two.xml").write_text(bare)
        out = self.convert("two.xml")
        told = [d for d in out["diagnostics"] if d["id"] == "PERM040"]
        self.assertEqual(len(told), 1)
        for name in ("rosout", "subscribe to parameter_events", "~/list_parameters"):
            self.assertIn(name, told[0]["message"])
        (self.at / "p.xml").unlink()
        out = self.convert("two.xml", "--node-defaults")
        text = (self.at / "p.xml").read_text()
        for topic in ("rt/rosout", "rt/parameter_events", "rr/a/set_parametersReply", "rq/b/get_parametersRequest"):
            self.assertIn(f"<topic>{topic}</topic>", text)
        denied = text[text.index("<deny_rule>"):text.index("</deny_rule>")]
        self.assertIn("rr/b/set_parametersReply", denied)
        self.assertIn("reply to /b/set_parameters",
                      next(d["message"] for d in out["diagnostics"] if d["id"] == "PERM040"))
        (self.at / "p.xml").unlink()
        whole = POLICIES / "talker_listener.policy.xml"
        self.assertNotIn("PERM040", [d["id"] for d in self.convert(whole)["diagnostics"]])
        plain = (self.at / "p.xml").read_bytes()
        (self.at / "p.xml").unlink()
        self.convert(whole, "--node-defaults")
        self.assertEqual((self.at / "p.xml").read_bytes(), plain)  # it has them already

    def test_signed_at_once(self):
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        out = self.convert(POLICIES / "talker_listener.policy.xml", "--sign", "--ca", "ca")
        self.assertEqual([f["path"] for f in out["files_written"]], ["p.xml", "p.p7s"])

    def test_bad_policies_are_refused(self):
        def bad(code, text, exit=3):
            (self.at / "bad.xml").write_text(text)
            told = self.refused(code, exit, "permissions", "from-ros-policy", "bad.xml", "-o", "p.xml")
            self.assertEqual(told["file"], "bad.xml")
        bad("policy_value", TWO.replace("ALLOW", "MAYBE"))
        bad("document_kind", "<dds/>")
        bad("xml_doctype", "<!DOCTYPE policy [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>" + TWO)
        include = '<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="%s" xpointer="xpointer(/a/*)"/>'
        bad("policy_include", TWO.replace("<topics", include % "/etc/passwd" + "<topics"))
        bad("policy_include", TWO.replace("<topics", include % "../bad.xml" + "<topics"))
        (self.at / "policies").mkdir()
        (self.at / "outside.xml").write_text(TWO)
        (self.at / "policies/link.xml").symlink_to(self.at / "outside.xml")
        (self.at / "policies/up").symlink_to(self.at)
        for name in ("link.xml", "up/outside.xml"):
            (self.at / "policies/p.xml").write_text(TWO.replace("<topics", include % name + "<topics"))
            told = self.refused("policy_include", 3, "permissions", "from-ros-policy", "policies/p.xml", "-o", "p.xml")
            self.assertIn("a link to", told["message"])
        (self.at / "two.xml").write_text(TWO)
        self.refused("usage", 2, "permissions", "from-ros-policy", "two.xml", "-o", "p.xml",
                     "--enclave", "/other")
        self.refused("file_not_found", 3, "permissions", "from-ros-policy", "none.xml", "-o", "p.xml")


if __name__ == "__main__":
    main()

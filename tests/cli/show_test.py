#!/usr/bin/env python3
"""governance show and permissions show: effective values, and the rule and line that decide."""

from transcript import DATA, NOW, Transcript, main


class Show(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("governance", "new", "-o", "g.xml", "--domain", "0", "--domain", "3-5",
                         "--topic", "rt/cam*:data=NONE,metadata=NONE",
                         "--topic", "rt/log:read=false,write=false")

    def show(self, topic, *words, **more):
        return self.json("governance", "show", "g.xml", "--topic", topic, *words, **more)["result"]

    def test_a_topic_has_its_rule_its_line_and_what_they_achieve(self):
        out = self.show("rt/camera", "--domain", "4")
        rule = out["topic_rule"]
        self.assertEqual((rule["expression"], rule["number"], rule["data"]), ("rt/cam*", 1, "NONE"))
        line = (self.at / "g.xml").read_text().splitlines()[rule["line"] - 1]
        self.assertEqual(line.strip(), "<topic_rule>")
        self.assertEqual(out["domain_rule"]["rtps"], "SIGN")
        self.assertNotIn("outsider.payload_secrecy", out["properties"])
        self.assertIn("outsider.payload_integrity", out["properties"])
        self.assertIn("insider.payload_secrecy", self.show("rt/x")["properties"])

    def test_the_sentence_for_people(self):
        text = self.run_program("governance", "show", "g.xml", "--topic", "rt/x").stdout
        self.assertIn('topic rt/x, domain 0           rule 3 "*" (g.xml:', text)
        self.assertIn("against outsiders: confidential, authentic   "
                      "against insiders without the right: confidential, authentic", text)
        text = self.run_program("governance", "show", "g.xml", "--topic", "rt/camera1").stdout
        self.assertIn("against outsiders: authentic   against insiders without the right: nothing", text)
        text = self.run_program("governance", "show", "g.xml", "--topic", "rt/log").stdout
        self.assertIn("access     read free: every participant of the domain, write free: every participant", text)

    def test_the_whole_document(self):
        out = self.json("governance", "show", "g.xml")["result"]
        self.assertEqual(out["domain_rules"][0]["domains"], [[0, 0], [3, 5]])
        self.assertEqual([r["expression"] for r in out["domain_rules"][0]["topic_rules"]],
                         ["rt/cam*", "rt/log", "*"])
        self.json("governance", "show", "g.xml", "--domain", "3")

    def test_what_is_not_covered(self):
        self.refused("domain_not_covered", 1, "governance", "show", "g.xml", "--domain", "9")
        self.refused("domain_not_covered", 1, "governance", "show", "g.xml", "--topic", "a", "--domain", "9")
        text = (self.at / "g.xml").read_text().replace("<topic_expression>*<", "<topic_expression>a<")
        (self.at / "g.xml").write_text(text)
        self.refused("topic_not_covered", 1, "governance", "show", "g.xml", "--topic", "b")

    def test_permissions_of_a_signed_document(self):
        file = DATA / "sros2/generated/keystore/enclaves/talker_listener/talker/permissions.p7s"
        out = self.json("permissions", "show", file, *NOW)["result"]
        grant = out["grants"][0]
        self.assertEqual((grant["subject"], grant["valid_now"], grant["default"]),
                         ("CN=/talker_listener/talker", True, "DENY"))
        self.assertIn("rt/chatter", grant["rules"][0]["publish"][0]["topics"])
        text = self.run_program("permissions", "show", file, *NOW).stdout
        self.assertIn("rt/chatter", text)
        self.assertIn("all else: denied", text)
        late = self.run_program("permissions", "show", file, "--now", "2040-01-01T00:00:00Z").stdout
        self.assertIn("NOT VALID NOW", late)
        self.json("permissions", "show", file, "--subject", "CN = /talker_listener/talker", *NOW)
        self.refused("no_grant_for_subject", 1, "permissions", "show", file, "--subject", "CN=x")

    def test_names_of_topics_are_shown_whole(self):
        name = "rt/" + "a" * 200 + "/end"
        (self.at / "p.xml").write_text(f"""<dds><permissions><grant name="g"><subject_name>CN=a</subject_name>
            <validity><not_before>2020-01-01T00:00:00Z</not_before><not_after>2040-01-01T00:00:00Z</not_after></validity>
            <allow_rule><domains><id>0</id></domains><publish><topics><topic>{name}</topic></topics></publish></allow_rule>
            <default>DENY</default></grant></permissions></dds>""")
        self.assertIn(name, self.run_program("permissions", "show", "p.xml", *NOW).stdout)

    def test_relays_data_tags_and_domain_tags_are_shown(self):
        (self.at / "p.xml").write_text("""<dds><permissions><grant name="g"><subject_name>CN=a</subject_name>
<validity><not_before>2020-01-01T00:00:00Z</not_before><not_after>2037-01-01T00:00:00Z</not_after></validity>
<allow_rule><domains><id>0</id></domains>
<publish><topics><topic>a</topic></topics><partitions><partition>p</partition></partitions>
<data_tags><tag><name>colour</name><value>red</value></tag></data_tags></publish>
<relay><topics><topic>b</topic></topics></relay></allow_rule><default>DENY</default></grant></permissions></dds>""")
        rule = self.json("permissions", "show", "p.xml", *NOW)["result"]["grants"][0]["rules"][0]
        self.assertEqual(rule["publish"][0]["data_tags"], [{"name": "colour", "value": "red"}])
        self.assertEqual([r["topics"] for r in rule["relay"]], [["b"]])
        self.assertNotIn("data_tags", rule["relay"][0])
        text = self.run_program("permissions", "show", "p.xml", *NOW).stdout
        self.assertIn("publish    a  in partitions p  with data tags colour=red", text)
        self.assertIn("relay      b", text)

    def test_bad_documents_are_refused(self):
        self.refused("document_kind", 3, "permissions", "show", "g.xml")
        self.refused("file_not_found", 3, "governance", "show", "none.xml")
        (self.at / "bad.xml").write_text("<dds>")
        self.refused("xml_not_well_formed", 3, "governance", "show", "bad.xml")


class Folders(Transcript):
    """A participant's folder is taken wherever a document of it is asked for."""

    def test_commands_find_the_document_of_a_folder(self):
        self.run_program("init", "demo", *NOW)
        for kind in ("governance", "permissions"):
            file = f"demo/talker/{kind}.p7s"
            for command in (("show",), ("lint",), ("verify", "--ca", "demo")):
                out = self.json(kind, command[0], "demo/talker", *command[1:], *NOW)["result"]
                self.assertEqual(out["file"], file)
            out = self.json(kind, "diff", "demo/talker", file, "--ca", "demo", *NOW)["result"]
            self.assertEqual(out["signer"]["verified"], {"old": True, "new": True})
        self.json("permissions", "lint", "demo/talker", "--cert", "demo/talker", "--governance", "demo/talker",
                  *NOW)
        told = self.refused("file_not_found", 3, "permissions", "show", "demo")
        self.assertEqual(told["file"], "demo/permissions.p7s")


if __name__ == "__main__":
    main()

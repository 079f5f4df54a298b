#!/usr/bin/env python3
"""check and doctor --peer: would two participants talk, on which topics, and which line decides?"""

from check_participants import ONE_WAY, CheckTest
from transcript import main
from workshop import allow, grant, permissions


class Check(CheckTest):
    def test_they_talk_and_the_deciding_lines_are_named(self):
        result = self.check("--topics", "Square", exit=0)["result"]
        self.assertEqual([(a["from"], a["to"], a["ok"]) for a in result["authentication"]],
                         [("A", "B", True), ("B", "A", True)])
        self.assertEqual(result["join"]["masks"], ["0x80000007/0x80000006"] * 2)
        forth, back = result["topics"][0]["directions"]
        self.assertEqual((forth["writer"], forth["reader"], forth["ok"], back["ok"]),
                         ("A", "B", True, False))
        self.assertEqual(forth["protection"],
                         {"payload": "ENCRYPT", "metadata": "ENCRYPT", "rtps": "SIGN"})
        steps = [(s["judge"], s["about"], s["op"], s["rule"]["expression"]) for s in forth["steps"]]
        self.assertEqual(steps, [("A", "A", "publish", "Square"), ("B", "A", "publish", "Square"),
                                 ("B", "B", "subscribe", "Square"),
                                 ("A", "B", "subscribe", "Square")])
        rule = forth["steps"][0]["rule"]
        lines = (self.at / rule["file"]).read_text().splitlines()
        self.assertIn("<publish>", lines[rule["line"] - 1])
        self.assertEqual((rule["grant"], rule["index"], rule["kind"]), ("participant", 1, "allow"))

    def judged(self, topic):
        """Whether talker publishes it to listener: by vendor."""
        return {vendor: self.json("check", "talker", "listener", "--vendor", vendor, "--topics", topic, "--require", "writer=A",
                                  exit=None)["exit"] for vendor in ("cyclonedds", "fastdds", "ddssec")}

    def test_each_product_matches_by_its_own_reading(self):
        self.listener.sign("permissions", permissions(grant("CN=listener", ONE_WAY.format("subscribe").replace("Square", "*"))))
        every = ONE_WAY.format("publish").replace("Square", "rt/*")
        for expression, topic, expected in (("rt/[^b]", "rt/a", (0, 1, 1)), ("rt/[^b]", "rt/b", (1, 0, 0)),
                                            ("rt/[[:alpha:]]", "rt/a", (0, 1, 1)), ("rt/[!b]", "rt/a", (1, 1, 1))):
            denied = ONE_WAY.format("publish").replace("Square", expression).replace("allow_rule", "deny_rule")
            self.talker.sign("permissions", permissions(grant("CN=talker", denied + every)))
            self.assertEqual(tuple(self.judged(topic).values()), expected, (expression, topic))

    def test_cyclone_dds_takes_some_ends_for_past(self):
        for end, expected in (("9999-12-31T23:59:59Z", (1, 0, 0)), ("2036-12-31T24:00:00Z", (1, 1, 0)),
                              ("2036-12-31T00:00:00+14:00", (1, 0, 0)), ("2262-01-01T00:00:00Z", (0, 0, 0))):
            self.talker.sign("permissions", permissions(grant("CN=talker", ONE_WAY.format("publish"), end=end)))
            self.assertEqual(tuple(self.judged("Square").values()), expected, end)
            out = self.json("doctor", "talker", "--vendor", "cyclonedds", exit=expected[0])
            found = [d["message"] for d in out["diagnostics"] if d["id"] == "DOC040"]
            self.assertEqual(["as a time that has passed" in m for m in found], [True] * expected[0], end)

    def test_text(self):
        done = self.run_program("check", "talker", "listener", "--topics", "Square")
        self.assertIn("authentication   listener accepts talker: ok    talker accepts listener: ok", done.stdout)
        self.assertIn("  talker publishes -> listener subscribes   YES   ENCRYPT payload", done.stdout)
        self.assertIn("listener, locally: REFUSED: no publish rule", done.stdout)
        self.assertTrue(done.stdout.endswith("result: they match\n  talker publishes to listener: Square\n"
                                             "  listener publishes to talker: nothing\n"))
        done = self.run_program("check", "talker", "listener", "--explain")
        self.assertIn("talker, locally: allowed: grant \"participant\" rule 1 (allow) publish "
                      "\"Square\" (permissions.p7s:", done.stdout)

    def test_topics_of_an_expression_are_shown_by_it(self):
        """A name that only stands for an expression is in neither document."""
        self.talker.sign("permissions", permissions(grant("CN=talker", allow("*"))))
        self.listener.sign("permissions", permissions(grant("CN=listener", allow("rt/*") + allow("Square"))))
        told = self.run_program("check", "talker", "listener", "--explain").stdout
        self.assertEqual([line for line in told.splitlines() if line.startswith("topic")],
                         ["topics * (e.g. a)", "topics rt/* (e.g. rt/)", "topic Square"])
        self.assertIn("  talker publishes to listener: rt/* (e.g. rt/), Square\n", told)
        self.assertIn("  not on * (e.g. a): listener may not subscribe to it: ", told)
        topics = self.check(exit=0)["result"]["topics"]
        self.assertEqual([(topic["name"], topic["expression"]) for topic in topics],
                         [("a", "*"), ("rt/", "rt/*"), ("Square", None)])
        named = self.check("--topics", "a", exit=1)["result"]["topics"]
        self.assertEqual([(topic["name"], topic["expression"]) for topic in named], [("a", None)])

    def test_what_is_required_of_topics(self):
        self.check(exit=0)
        self.check("--topics", "Square,Circle", exit=1)
        self.check("--topics", "Square", "--require", "writer=A", exit=0)
        self.check("--topics", "Square", "--require", "writer=B", exit=1)
        self.check("--topics", "Square", "--require", "both", exit=1)
        (self.at / "topics").write_text("Square\n")
        self.check("--topics", "topics", exit=0)
        self.apart("DOC086", 'talker may not publish "Circle"', "default DENY",
                   words=("--topics", "Circle"), document="permissions.p7s")
        self.listener.sign("permissions", permissions(grant("CN=listener", allow("Circle"))))
        self.apart("DOC086", "no topic that talker may publish and listener subscribe")

    def test_a_no_has_its_reason_also_where_no_topic_was_named(self):
        text = self.run_program("check", "talker", "listener").stdout
        self.assertRegex(text, r"  listener publishes -> talker subscribes   NO: listener may not publish it: no publish "
                               r'rule of grant "participant" matches, default DENY \(permissions\.p7s:[0-9]+\)\n')
        self.assertNotIn("NO:", self.run_program("check", "talker", "listener", "--topics", "Square").stdout)

    def test_check_and_can_of_a_refusal_by_the_default_name_its_line(self):
        lines = (self.at / "listener/permissions.p7s").read_text().splitlines()
        (line,) = [number for number, text in enumerate(lines, 1) if "<default>" in text]
        text = self.run_program("check", "talker", "listener").stdout
        self.assertIn(f"default DENY (permissions.p7s:{line})\n", text)
        text = self.run_program("can", "listener", "publish", "Square", exit=1).stdout
        self.assertIn(f"permissions.p7s:{line})\n", text)

    def test_a_file_of_topics_that_is_not_there_is_no_topic(self):
        for name in ("topics.txt", "./topics", "../topics", "lists/topics.lst"):
            told = self.refused("file_not_found", 3, "check", "talker", "listener", "--topics", name)
            self.assertEqual(told["file"], name)
            self.assertIn(f"--topics {name},", told["hint"])
            named = self.check("--topics", name + ",", exit=1)["result"]["topics"]
            self.assertEqual([topic["name"] for topic in named], [name])

    def test_partitions_of_writers_and_readers(self):
        yard = allow("Square").replace("</topics></", "</topics><partitions>"
                                       "<partition>yard*</partition></partitions></")
        for made in (self.talker, self.listener):
            made.sign("permissions", permissions(grant(made.subject, yard)))
        ask = ("--topics", "Square")
        self.check(*ask, "--partition", "yard1", exit=0)
        self.check(*ask, "--partition", "yard1", "--partition", "yard2", "--vendor", "fastdds", exit=0)
        self.apart("DOC086", "talker may not publish", 'matches in partition "street", default DENY',
                   words=(*ask, "--partition", "street"))
        self.apart("DOC086", "default DENY", words=ask)
        result = self.apart("DOC086", 'does not hold in partitions "yard1", "", and Fast DDS looks no further',
                            words=(*ask, "--partition", "yard1", "--partition", "", "--vendor", "fastdds"))
        rule = result["topics"][0]["directions"][0]["steps"][0]["rule"]
        self.assertEqual((rule["kind"], rule["index"]), ("allow", 1))
        for partition in ("street", None):
            words = ask if partition is None else (*ask, "--partition", partition)
            for told in self.check(*words, exit=1)["diagnostics"]:
                self.assertIn('allows the topic, but only in "yard*"', told["message"])
                self.assertIn("the topic is allowed, but not " +
                              ("without a partition" if partition is None else 'in partition "street"'), told["hint"])

    def test_two_partition_expressions_never_match(self):
        """Measured: neither product exchanges a sample then, although the permissions allow it."""
        for name, may in (("talker", "publish"), ("listener", "subscribe")):
            rule = ONE_WAY.format(may).replace("</topics>", "</topics><partitions><partition>*</partition></partitions>")
            folder = getattr(self, name)
            folder.sign("permissions", permissions(grant(folder.subject, rule)))
        for product in ("ddssec", "cyclonedds"):
            for names, exit in ((["*"], 1), (["ab*"], 1), (["a?c"], 1), (["a*", "?"], 1), (["abc"], 0), (["ab*", "abc"], 0)):
                with self.subTest(product=product, names=names):
                    asked = [word for one in names for word in ("--partition", one)]
                    told = self.check("--topics", "Square", "--vendor", product, *asked, exit=exit)["diagnostics"]
                    told = [one for one in told if one["id"] == "DOC085"]
                    self.assertEqual(len(told), exit)
                    if exit:
                        self.assertIn("two partition expressions never match each other", told[0]["message"])
                        self.assertIn("without *", told[0]["hint"])

    def test_brackets_in_a_partition_are_an_expression_to_fast_dds_alone(self):
        """Measured with Fast DDS 2.9.1: [AB] does not match [AB], which is a name to the others."""
        for made, may in ((self.talker, "publish"), (self.listener, "subscribe")):
            rule = ONE_WAY.format(may).replace("</topics>", "</topics><partitions><partition>*</partition></partitions>")
            made.sign("permissions", permissions(grant(made.subject, rule)))
        ask = ("--topics", "Square", "--require", "writer=A", "--partition", "[AB]")
        for vendor, exit in (("fastdds", 1), ("cyclonedds", 0), ("ddssec", 0), ("B=fastdds", 1)):
            out = self.check(*ask, "--vendor", vendor, exit=exit)
            told = [d["message"] for d in out["diagnostics"] if "does not match its own text" in d["message"]]
            self.assertEqual(len(told), exit, vendor)
        self.check(*ask, "--partition", "A", "--vendor", "fastdds", exit=0)

    def test_names_that_are_nearly_shared_are_named(self):
        self.talker.sign("permissions", permissions(grant("CN=talker", ONE_WAY.format("publish").replace("Square", "DDSPref*"))))
        for topic, near in (("DDSPerfRDataKS", True), ("Circle", False)):
            self.listener.sign("permissions", permissions(grant("CN=listener", ONE_WAY.format("subscribe").replace("Square", topic))))
            told = [d["message"] for d in self.check(exit=1)["diagnostics"] if d["id"] == "DOC086"]
            said = f'; listener may subscribe to "{topic}", and of talker to publish "DDSPref*" is allowed: is one of them misspelt?'
            self.assertEqual([said in one for one in told], [near])

    def test_partitions_that_only_one_side_has(self):
        """Both may use the topic without a partition, so that it would count as working."""
        everywhere = allow("*").replace("</topics></", "</topics><partitions><partition>*</partition></partitions></")
        self.listener.sign("permissions", permissions(grant(self.listener.subject, everywhere)))
        out = self.check(exit=0)
        told = [d for d in out["diagnostics"] if d["id"] == "DOC099"]
        self.assertEqual([d["message"] for d in told],
                         ['topics "Square": talker may use them only without a partition, listener in "*" too: '
                          "in a partition they do not work"])
        self.assertIn("--partition", told[0]["hint"])
        text = self.run_program("check", "talker", "listener").stdout
        self.assertIn("result: they match, but on some topics without partitions only\n", text)
        self.talker.sign("permissions", permissions(grant(self.talker.subject, everywhere)))
        self.assertNotIn("DOC099", [d["id"] for d in self.check(exit=0)["diagnostics"]])

    def test_nothing_in_common_is_no_match(self):
        text = self.run_program("check", "talker", "listener", "--topics", "Circle", exit=1).stdout
        self.assertIn("result: they authenticate, but share none of these topics\n", text)
        self.listener.sign("permissions", permissions(grant(self.listener.subject, allow("Circle"))))
        text = self.run_program("check", "talker", "listener", exit=1).stdout
        self.assertIn("result: they authenticate, but share no topic\n", text)

    def test_what_was_not_looked_at_is_not_said_to_be_nothing(self):
        many = f"*a{'?' * 24}z"  # as many states as there are names of 24 letters
        self.listener.sign("permissions", permissions(grant(self.listener.subject, allow("*"))))
        self.talker.sign("permissions", permissions(grant(self.talker.subject, allow(many))))
        out = self.check(exit=1)
        told = [(d["id"], d["severity"]) for d in out["diagnostics"] if d["id"] == "DOC086"]
        self.assertEqual((told, out["result"]["topics_complete"]), ([("DOC086", "warning")], False))
        self.assertIn("is not known\n", self.run_program("check", "talker", "listener", exit=1).stdout)
        both = f"b</topic><topic>{many}"
        self.talker.sign("permissions", permissions(grant(self.talker.subject, allow(both))))
        self.assertIn("b", [topic["name"] for topic in self.check(exit=0)["result"]["topics"]])

    def test_a_name_that_is_close_to_an_allowed_one_is_proposed(self):
        told = self.check("--topics", "Sqare", exit=1)["diagnostics"]
        self.assertEqual({d["id"] for d in told}, {"DOC086"})
        meant = [one["message"] for one in told if 'is "Square" meant?' in one["hint"]]
        self.assertTrue(any("talker may not publish" in message for message in meant), told)
        self.assertTrue(any("listener may not subscribe" in message for message in meant), told)
        for one in self.check("--topics", "Circle", exit=1)["diagnostics"]:
            self.assertIn("add the topic to an allow_rule", one["hint"])

    def test_the_result_names_topics_and_leaves_out_what_every_ros_node_has(self):
        rules = allow("rt/chatter") + allow("rt/rosout") + allow("ros_discovery_info")
        for one in (self.talker, self.listener):
            one.sign("permissions", permissions(grant(one.subject, rules)))
        told = self.run_program("check", "talker", "listener").stdout
        self.assertIn("  talker publishes to listener: rt/chatter (and 2 topics of every ROS 2 node)\n", told)

    def test_what_later_versions_of_fast_dds_do_is_told_where_it_matters(self):
        for products, told in (("cyclonedds fastdds", True), ("fastdds ddssec", True), ("fastdds fastdds", False),
                               ("ddssec cyclonedds", False)):
            a, b = products.split()
            words = ("check", "talker", "listener", "--vendor", f"A={a}", "--vendor", f"B={b}")
            done = self.run_program(*words, exit=None)
            self.assertEqual("note[DOC094]: this is predicted for Fast DDS 2.9.1" in done.stderr, told, products)
        self.apart("DOC094", "Fast DDS 3.1.2 (talker) discovers nothing of Cyclone DDS 0.10.5 (listener)",
                   words=("--vendor", "A=fastdds@3.1.2", "--vendor", "B=cyclonedds@0.10.5"))
        self.check("--vendor", "fastdds@3.1.2", exit=0)
        out = self.check("--vendor", "A=fastdds@3.1.2", exit=0)  # ours may be embedded
        self.assertIn("only of ddssec's embedded participant", "".join(d["message"] for d in out["diagnostics"]))
        self.refused("usage", 2, "check", "talker", "listener", "--vendor", "fastdds@x")

    def test_each_topic_is_judged_for_itself(self):
        """Cyclone DDS 0.10.2 refuses to create Circle, and uses Square: measured, tests/interop/measure.py."""
        join = ONE_WAY.format("publish").replace("<publish><topics><topic>Square</topic></topics></publish>", "")
        deny = ONE_WAY.format("subscribe").replace("allow_rule", "deny_rule").replace("Square", "Circle")
        self.talker.sign("permissions", permissions(grant("CN=talker", join + deny + allow("*"))))
        self.listener.sign("permissions", permissions(grant("CN=listener", allow("Square") + allow("Circle"))))
        cyclone = ("--vendor", "cyclonedds@0.10.2")
        result = self.apart("DOC053", 'topic "Circle": Cyclone DDS 0.10.2 at talker refuses to create the topic',
                            words=cyclone, document="permissions.p7s")
        directions = {topic["name"]: [(one["ok"], one.get("reason", "")) for one in topic["directions"]]
                      for topic in result["topics"]}
        self.assertEqual((directions["Square"], result["talk"]), ([(True, "")] * 2, True))
        self.assertIn("refuses to create the topic", directions["Circle"][0][1])
        self.assertIn("talker may not subscribe to it", directions["Circle"][1][1])
        told = self.run_program("check", "talker", "listener", *cyclone, exit=1).stdout
        self.assertIn("result: they match, but a product keeps them apart on a topic\n"
                      "  talker publishes to listener: Square\n  listener publishes to talker: Square\n"
                      "  not on Circle: Cyclone DDS 0.10.2 at talker refuses to create the topic", told)
        self.check(*cyclone, "--topics", "Square", "--require", "both", exit=0)
        self.check(*cyclone, "--topics", "Circle", exit=1)
        for other in (("--vendor", "cyclonedds@11.0"), ()):
            self.check(*other, "--topics", "Circle", "--require", "writer=A", exit=0)

    def test_what_keeps_them_apart_is_said_of_each_topic(self):
        self.talker.sign("permissions", permissions(grant("CN=talker", allow("Square") + allow("Circle"))))
        told = self.run_program("check", "talker", "listener").stdout
        self.assertIn('  not on Circle: listener may not subscribe to it: no subscribe rule of grant "participant" '
                      "matches, default DENY (permissions.p7s:", told)

    def test_doctor_with_a_peer_is_both_and_the_check(self):
        out = self.json("doctor", "talker", "--peer", "listener", exit=0)
        self.assertEqual(out["result"]["peer"]["verdicts"]["ddssec"], "ok")
        meetings = {(m["self"], m["peer"]): m["talk"] for m in out["result"]["peer"]["meetings"]}
        self.assertEqual(len(meetings), 9)
        mixed = [meetings["cyclonedds@0.10.2", "fastdds@2.9.1"],
                 meetings["fastdds@2.9.1", "cyclonedds@0.10.2"]]
        self.assertEqual(sorted(mixed), [False, True])
        self.assertEqual(sorted(d["id"] for d in out["diagnostics"]), ["DOC083", "DOC094"])
        self.json("doctor", "talker", "--peer", "listener", "--vendor", "fastdds", "--vendor",
                  "cyclonedds", exit=1)
        (self.at / "listener/key.pem").unlink()
        out = self.json("doctor", "talker", "--peer", "listener", exit=1)
        self.assertIn("DOC001", [d["id"] for d in out["diagnostics"]])
        self.refused("file_not_found", 3, "doctor", "talker", "--peer", "nobody")

    def test_wrong_command_lines(self):
        self.refused("file_not_found", 3, "check", "talker", "nobody")
        self.refused("usage", 2, "check", "talker", "listener", "--vendor", "C=ddssec")
        self.refused("usage", 2, "check", "talker", "listener", "--require", "all")
        self.refused("usage", 2, "check", "talker", "listener", "--topics", ",")
        self.refused("usage", 2, "check", "talker", "listener", "--domain", "x")


if __name__ == "__main__":
    main()

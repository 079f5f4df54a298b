#!/usr/bin/env python3
"""check and doctor --peer: would two participants talk, and which line decides?"""

import hashlib
import pathlib
import shutil
import ssl
import tempfile

from transcript import WithoutLists, main
from workshop import GOVERNANCE, Folder, Workshop, allow, grant, permissions

ONE_WAY = """<allow_rule>
        <domains><id>0</id></domains>
        <{0}><topics><topic>Square</topic></topics></{0}>
      </allow_rule>"""


class Check(WithoutLists):
    """talker publishes Square and listener subscribes to it, until something is changed."""

    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.TemporaryDirectory(prefix="ddssec-check-")
        cls.addClassCleanup(cls.made.cleanup)
        cls.shop = Workshop(pathlib.Path(cls.made.name) / "workshop")

    def setUp(self):
        super().setUp()
        self.talker = self.participant("talker", "publish")
        self.listener = self.participant("listener", "subscribe")

    def participant(self, name, may, **leaf):
        made = Folder(self.shop, self.at / name, f"/CN={name}", leaf.pop("label", name), **leaf)
        made.sign("permissions", permissions(grant(made.subject, ONE_WAY.format(may))))
        return made

    def check(self, *words, exit):
        return self.json("check", "talker", "listener", *words, exit=exit)

    def apart(self, rule, *values, words=(), document=None):
        """They do not talk, and one sentence says so with these values."""
        out = self.check(*words, exit=1)
        told = [d for d in out["diagnostics"] if d["id"] == rule]
        told = [d for d in told if all(value in d["message"] for value in values)]
        self.assertTrue(told, out["diagnostics"])
        if document:
            self.assertEqual(pathlib.Path(told[0]["file"]).name, document)
        self.assertTrue(told[0]["hint"])
        self.hint = told[0]["hint"]
        return out["result"]

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

    def test_the_protection_of_a_topic_is_the_products(self):
        rules = GOVERNANCE.replace("<topic_expression>*<", "<topic_expression>Squar[^b]<")
        body = rules[rules.index("<topic_rule>"):rules.index("</topic_rule>") + len("</topic_rule>")]
        open_rule = body.replace("Squar[^b]", "*").replace("ENCRYPT", "NONE")
        rules = rules.replace("</topic_access_rules>", open_rule + "</topic_access_rules>")
        for folder in (self.talker, self.listener):
            folder.sign("governance", rules)
        for vendor, payload in (("cyclonedds", "NONE"), ("fastdds", "ENCRYPT"), ("ddssec", "ENCRYPT")):
            out = self.check("--vendor", vendor, "--topics", "Square", exit=0)["result"]
            self.assertEqual(out["topics"][0]["directions"][0]["protection"]["payload"], payload, vendor)

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

    def test_one_subject_on_both_sides_starts_the_handshake_by_chance(self):
        shutil.copytree(self.at / "talker", self.at / "again")
        told = [d["message"] for d in self.json("check", "talker", "again", "--vendor", "A=fastdds", "--vendor", "B=cyclonedds",
                                                exit=1)["diagnostics"] if d["id"] == "DOC083"]
        self.assertEqual(len(told), 1)
        self.assertIn('because both have the subject "CN=talker"', told[0])
        self.assertNotIn("by the hashes", told[0])

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

    def test_another_identity_ca(self):
        shutil.rmtree(self.at / "listener")
        made = self.participant("listener", "subscribe", label="stranger", ca=self.shop.ca("foreign"))
        made.put("identity_ca.pem", self.shop.ca("foreign") / "cert.pem")
        self.apart("DOC080", "CN=listener", 'issued by "CN=foreign CA"', '"CN=identity CA"',
                   document="identity_ca.pem")

    def test_another_ca_of_the_same_name(self):
        shutil.rmtree(self.at / "listener")
        ca = self.shop.ca("impostor", "/CN=identity CA")
        self.participant("listener", "subscribe", label="impostor", ca=ca).put(
            "identity_ca.pem", ca / "cert.pem")
        self.apart("DOC080", "talker does not accept", "CN=listener", "CN=identity CA",
                   "the CA of that name that is configured has another key")

    def test_a_revoked_peer(self):
        self.talker.put("crl.pem", self.shop.crl("listener", self.talker.identity_ca,
                                                 self.listener.certificate))
        self.apart("DOC080", "CN=listener serial", "revoked", document="crl.pem")
        self.assertIn("issue the participant again", self.hint)

    def test_a_list_that_is_none_is_not_taken_for_nobody_was_revoked(self):
        for text in ("no list", "", "-----BEGIN X509 CRL-----\n"):
            (self.at / "talker/crl.pem").write_text(text)
            out = self.check(exit=1)
            self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"] if d["severity"] == "error"],
                             [("DOC090", "talker/crl.pem")])
            out = self.json("doctor", "talker", exit=1)
            self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"] if d["severity"] == "error"],
                             [("DOC002", "talker/crl.pem")])
            self.assertEqual(out["result"]["verdicts"]["ours"], "fail")

    def test_a_list_of_another_ca(self):
        self.talker.put("crl.pem", self.shop.crl("foreign", self.shop.ca("foreign")))
        self.apart("DOC080", "CN=listener serial", "no revocation list", document="crl.pem")

    def test_the_hint_is_for_the_cause(self):
        self.apart("DOC080", "CN=listener serial", "expired", words=("--now", "2050-01-01T00:00:00Z"))
        self.assertIn("ddssec identity renew FOLDER --ca CA", self.hint)
        self.listener.sign("permissions", permissions(grant("CN=somebody", ONE_WAY.format("subscribe"))))
        self.apart("DOC081", "no grant for the subject", "CN=somebody")
        self.assertIn("write the subject name exactly", self.hint)

    def test_a_file_that_is_missing_is_said_once_of_whose_it_is(self):
        (self.at / "listener/cert.pem").unlink()
        out = self.check(exit=1)
        self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"] if d["severity"] == "error"],
                         [("DOC090", "listener/cert.pem")])
        self.assertEqual([a["ok"] for a in out["result"]["authentication"]], [True, False])

    def test_permissions_signed_by_another_ca(self):
        ca = self.shop.ca("foreign")
        signer = (ca / "cert.pem", ca / "key.pem")
        self.listener.put("permissions_ca.pem", ca / "cert.pem")
        self.listener.own_permissions(signer=signer)
        self.listener.sign("governance", GOVERNANCE, signer=signer)
        self.apart("DOC081", "listener's permissions", "CN=foreign CA", '"CN=permissions CA"',
                   document="permissions.p7s")

    def test_governance_that_differs_in_one_value(self):
        self.listener.sign("governance", GOVERNANCE.replace("<rtps_protection_kind>SIGN",
                                                            "<rtps_protection_kind>NONE"))
        result = self.apart("DOC082", "<rtps_protection_kind> is SIGN at talker (governance.p7s:",
                            "NONE at listener", document="governance.p7s")
        self.assertEqual(result["join"]["masks"], ["0x80000007/0x80000006", "0x80000006/0x80000006"])
        self.assertEqual(result["join"]["differences"][0]["element"], "rtps_protection_kind")

    def test_governance_of_which_one_asks_for_more(self):
        for element, where, values in (("rtps_psk_protection_kind", "</rtps_protection_kind>", ("NONE", "SIGN")),
                                       ("enable_key_revision", "</enable_join_access_control>", ("false", "true"))):
            self.listener.sign("governance", GOVERNANCE.replace(
                where, f"{where}<{element}>{values[1]}</{element}>"))
            self.apart("DOC082", f"<{element}> is {values[0]} at talker", f"{values[1]} at listener")

    def test_pre_shared_keys(self):
        words = GOVERNANCE.replace("</rtps_protection_kind>", "</rtps_protection_kind>"
                                   "<rtps_psk_protection_kind>ENCRYPT</rtps_psk_protection_kind>")
        properties = "dds.sec.crypto.rtps_psk_secret_passphrase"

        def have(passphrase, extra="", cipher=""):
            for made, line in ((self.talker, "1:xyzzy"), (self.listener, passphrase)):
                made.sign("governance", words)
                text = f"{properties} = data:,{line}\n"
                if made is self.listener:
                    text += f"{properties}_extra = data:,{extra}\n" if extra else ""
                    text += f"dds.sec.crypto.rtps_psk_symmetric_cipher_algorithm = {cipher}\n" if cipher else ""
                (made.path / "security.properties").write_text(text)

        have("1:xyzzy", cipher="AES256+GCM")
        self.check(exit=0)
        told = self.json("doctor", "listener", "--vendor", "ours", exit=0)["diagnostics"]
        self.assertEqual([one["id"] for one in told], ["DOC103"])  # the drop-in has no such keys
        for what, sentence in (
                (("2:plugh",), "talker sends under passphrase 1, and listener understands 2 only"),
                (("2:plugh", "1:xyzzy"), "listener sends under passphrase 2, and talker understands 1 only"),
                (("1:plugh",), "talker and listener have different passphrases under id 1"),
                (("1:xyzzy", "", "AES128+GCM"),
                 "pre-shared keys are for AES256+GCM at talker and for AES128+GCM at listener")):
            have(*what)
            self.apart("DOC092", sentence, document="security.properties")
            out = self.json("doctor", "talker", "--peer", "listener", "--vendor", "ours", exit=1)
            self.assertIn(sentence, [d["message"] for d in out["diagnostics"]])
            self.assertFalse("xyzzy" in str(out) or "plugh" in str(out))
        (self.listener.path / "security.properties").unlink()
        self.apart("DOC091", "<rtps_psk_protection_kind> is ENCRYPT", properties)
        open_file = self.at / "open.psk"
        open_file.write_text("1:xyzzy\n")
        open_file.chmod(0o644)
        (self.listener.path / "security.properties").write_text(f"{properties} = file:{open_file}\n")
        self.check(exit=0)
        out = self.json("doctor", "listener", "--vendor", "ours", exit=0)
        self.assertEqual([(d["id"], d["severity"]) for d in out["diagnostics"]], [("DOC091", "warning"), ("DOC103", "warning")])
        # Who cannot is told so, whatever is in the properties.
        self.apart("DOC090", "listener cannot start on its own with Cyclone DDS 0.10.2",
                   words=("--vendor", "B=cyclonedds"))

    def test_properties_with_which_the_plugins_do_not_start(self):
        revising = GOVERNANCE.replace("</enable_join_access_control>", "</enable_join_access_control>"
                                      "<enable_key_revision>true</enable_key_revision>")
        properties = self.listener.path / "security.properties"
        for governance, text, sentence in (
                (GOVERNANCE, "org.ddssec.crypto.key_lifetime = 3600\n", "<enable_key_revision>"),
                (GOVERNANCE, "org.ddssec.crypto.max_blocks_per_key = 1\n", "<enable_key_revision>"),
                (GOVERNANCE, "org.ddssec.crypto.key_lifetime = 0\n", None),
                (revising, "org.ddssec.crypto.key_lifetime = 3600\n", None),
                (revising, "org.ddssec.crypto.key_lifetime = 1h\n", "from 20 to 31536000"),
                (GOVERNANCE, "org.ddssec.files_poll_interval = five\n", "org.ddssec.files_poll_interval"),
                (GOVERNANCE, "org.ddssec.clock_step_grace = five\n", "org.ddssec.clock_step_grace"),
                (GOVERNANCE, "org.ddssec.crypto.trust_type_information = 1\n", "true or false"),
                (GOVERNANCE, "dds.sec.access.permissions = file:p.p7s\n", "[property_without_effect 1017]"),
                (revising, "org.ddssec.crypto.max_blocks_per_key = -1\n", "org.ddssec.crypto.max_blocks_per_key"),
                (revising, "no equals sign\n", "security.properties")):
            for made in (self.talker, self.listener):
                made.sign("governance", governance)
            properties.write_text(text)
            with self.subTest(text=text, sentence=sentence):
                out = self.json("doctor", "listener", "--vendor", "ours", exit=1 if sentence else 0)
                found = [d for d in out["diagnostics"] if d["id"] == "DOC093"]
                self.assertEqual(len(found), 1 if sentence else 0)
                if not sentence:
                    self.check(exit=0)
                    continue
                self.assertIn(sentence, found[0]["message"])
                self.apart("DOC093", sentence)
        # Cyclone DDS and Fast DDS do not read the file.
        self.listener.sign("governance", GOVERNANCE)
        self.talker.sign("governance", GOVERNANCE)
        self.check("--vendor", "A=cyclonedds", "--vendor", "B=cyclonedds", exit=0)

    def test_governance_that_differs_for_a_topic(self):
        self.listener.sign("governance", GOVERNANCE.replace("<data_protection_kind>ENCRYPT",
                                                            "<data_protection_kind>SIGN"))
        self.apart("DOC084", '"Square"', "<data_protection_kind> is ENCRYPT at talker",
                   "SIGN at listener", document="governance.p7s")
        # The permissions allow it: nothing else is to be done than what DOC084 says.
        self.assertEqual({d["id"] for d in self.check(exit=1)["diagnostics"]}, {"DOC084"})

    def test_one_topic_whose_protection_differs_is_not_hidden_by_one_that_works(self):
        rules = allow("Square") + allow("Circle*")
        for one in (self.talker, self.listener):
            one.sign("permissions", permissions(grant(one.subject, rules)))
        at = GOVERNANCE.index("<topic_rule>")
        circle = GOVERNANCE[at:GOVERNANCE.index("</topic_access_rules>")].replace(
            "<topic_expression>*", "<topic_expression>Circle*")
        for one, kind in ((self.talker, "ENCRYPT"), (self.listener, "SIGN")):
            one.sign("governance", GOVERNANCE[:at] + circle.replace(
                "<data_protection_kind>ENCRYPT", f"<data_protection_kind>{kind}") + GOVERNANCE[at:])
        self.apart("DOC084", 'topics under the <topic_rule> "Circle*", such as "', "is ENCRYPT at talker")
        told = self.run_program("check", "talker", "listener", exit=1).stdout
        self.assertIn("result: they match, but the protection of a topic differs\n", told)
        self.assertIn("  talker publishes to listener: Square\n", told)
        self.assertNotIn("only one of them may use", told)
        self.check("--topics", "Square", exit=0)

    def test_the_result_names_topics_and_leaves_out_what_every_ros_node_has(self):
        rules = allow("rt/chatter") + allow("rt/rosout") + allow("ros_discovery_info")
        for one in (self.talker, self.listener):
            one.sign("permissions", permissions(grant(one.subject, rules)))
        told = self.run_program("check", "talker", "listener").stdout
        self.assertIn("  talker publishes to listener: rt/chatter (and 2 topics of every ROS 2 node)\n", told)

    def test_a_folder_of_participants_is_no_participant(self):
        for words in (("check", "talker", "."), ("doctor", ".")):
            told = self.refused("file_not_found", 3, *words)
            self.assertIn(". is no participant's folder", told["message"])
            self.assertEqual(told["hint"], "it holds participants: ./listener, ./talker")

    def test_a_folder_of_a_ca_is_no_participant(self):
        for half in ("identity", "permissions"):
            (self.at / "ca" / half).mkdir(parents=True)
            shutil.copy(self.at / "talker" / "identity_ca.pem", self.at / "ca" / half / "ca.pem")
        for folder in ("ca", "ca/", "ca/identity", "./ca/permissions"):
            told = self.refused("file_not_found", 3, "doctor", folder)
            self.assertIn(f"{folder} is the folder of a CA", told["message"])
            self.assertEqual(told["hint"], "participants of it may be listener, talker")

    def test_a_peer_without_security(self):
        shutil.rmtree(self.at / "listener")
        (self.at / "listener").mkdir()
        self.apart("DOC087", "listener runs without security and talker with it")

    def test_the_domain_is_that_of_the_documents(self):
        rule = allow(domain=7)
        for party, name in ((self.talker, "talker"), (self.listener, "listener")):
            party.sign("governance", GOVERNANCE.replace("<id>0</id>", "<id>7</id>"))
            party.sign("permissions", permissions(grant(f"CN={name}", rule)))
        out = self.json("check", "talker", "listener")
        self.assertEqual((out["result"]["join"]["domain"], out["result"]["talk"]), (7, True))
        self.json("check", "talker", "listener", "--domain", "0", exit=1)
        self.assertEqual(self.json("doctor", "talker", "--peer", "listener", "--vendor", "ours")["result"]["domain"], 7)
        for party in (self.talker, self.listener):
            party.sign("governance", GOVERNANCE.replace("<id>0</id>", "<id>3</id><id>7</id>"))
        self.assertEqual(self.notes("check", "talker", "listener"), [])
        for party, name in ((self.talker, "talker"), (self.listener, "listener")):
            party.sign("permissions", permissions(grant(f"CN={name}", rule + allow(domain=3))))
        out = self.json("check", "talker", "listener")
        self.assertEqual(out["result"]["join"]["domain"], 3)
        told = self.notes("check", "talker", "listener")
        self.assertEqual([d["message"] for d in told], ["the documents are for domains 3, 7; domain 3 was checked"])
        self.assertIn("--domain N", told[0]["hint"])
        self.assertEqual(self.notes("check", "talker", "listener", "--domain", "7"), [])

    def notes(self, *words):
        """What is said about the domain that was taken."""
        return [d for d in self.json(*words)["diagnostics"] if d["id"] == "DOC095"]

    def test_a_domain_that_only_one_may_join(self):
        self.listener.sign("permissions", permissions(grant("CN=listener", allow(domain=7))))
        self.apart("DOC088", "talker does not let listener join domain 0", document="permissions.p7s")
        self.apart("DOC090", "DOC051", "domain 0")

    def test_a_participant_that_does_not_come_up(self):
        (self.at / "talker/key.pem").unlink()
        self.apart("DOC090", "talker cannot start on its own", "key.pem is missing")

    def test_one_subject_for_both(self):
        shutil.rmtree(self.at / "listener")
        shutil.copytree(self.at / "talker", self.at / "listener")
        self.listener.path = self.at / "listener"
        self.listener.sign("permissions", permissions(grant("CN=talker")))
        self.talker.sign("permissions", permissions(grant("CN=talker")))
        out = self.check(exit=0)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC089"])
        self.assertEqual(out["result"]["handshake"], {"starts": None, "ok": True})

    def test_who_starts_the_handshake_decides_between_the_products(self):
        """DDS-Security 1.2, clause 10.3.3 in openssl's words: the lower hash of the DER subject starts."""
        starts = "A" if self.subject_hash("talker") < self.subject_hash("listener") else "B"
        waits = "B" if starts == "A" else "A"
        out = self.check(exit=0)
        self.assertEqual(out["result"]["handshake"], {"starts": starts, "ok": True})
        self.assertEqual(out["diagnostics"], [])  # of Fast DDS 2.9.1 only if it is asked for
        out = self.check("--explain", exit=0)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC083"])
        for product in ("ddssec", "cyclonedds"):
            out = self.check("--explain", "--vendor", product, exit=0)
            self.assertNotIn("DOC083", [d["id"] for d in out["diagnostics"]])
        self.apart("DOC083", "CN=talker", "CN=listener",
                   words=("--vendor", f"{starts}=fastdds", "--vendor", f"{waits}=cyclonedds"))
        self.check("--vendor", f"{starts}=cyclonedds", "--vendor", f"{waits}=fastdds", exit=0)
        self.check("--vendor", f"{starts}=fastdds", "--vendor", f"{waits}=ours", exit=0)

    def test_what_later_versions_of_fast_dds_do_is_told_where_it_matters(self):
        for products, told in (("cyclonedds fastdds", True), ("fastdds ours", True), ("fastdds fastdds", False),
                               ("ours cyclonedds", False)):
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

    def subject_hash(self, name):
        def block(tag, content):
            return bytes([tag, len(content)]) + content
        common_name = block(0x06, b"\x55\x04\x03") + block(0x0C, name.encode())
        subject = block(0x30, block(0x31, block(0x30, common_name)))
        certificate = (self.at / name / "cert.pem").read_text()
        self.assertIn(subject, ssl.PEM_cert_to_DER_cert(certificate))
        return hashlib.sha256(subject).digest()

    def test_payload_protection_alone_between_the_products(self):
        xml = GOVERNANCE.replace("<metadata_protection_kind>ENCRYPT", "<metadata_protection_kind>NONE")
        for one in (self.talker, self.listener):
            one.sign("governance", xml)
        starter = "A" if self.subject_hash("talker") < self.subject_hash("listener") else "B"
        products = ("--vendor", "A=fastdds", "--vendor", "B=cyclonedds")
        out = self.check(*products, exit=1)
        self.assertIn("DOC085", [d["id"] for d in out["diagnostics"]])
        obstacle = out["result"]["topics"][0]["directions"][0]["obstacle"]
        self.assertIn("data_protection_kind ENCRYPT with metadata_protection_kind NONE", obstacle)
        self.check("--vendor", "A=fastdds", "--vendor", "B=ours", exit=0)
        self.check("--vendor", "fastdds", exit=0)
        if starter == "A":  # Cyclone DDS starts: the other direction works
            self.check("--vendor", "A=cyclonedds", "--vendor", "B=fastdds", exit=0)

    def test_access_control_that_nothing_protects(self):
        xml = GOVERNANCE
        for kind in ("metadata", "data"):
            xml = xml.replace(f"<{kind}_protection_kind>ENCRYPT", f"<{kind}_protection_kind>NONE")
        for one in (self.talker, self.listener):
            one.sign("governance", xml)
        told = [d for d in self.check(exit=0)["diagnostics"] if d["id"] == "GOV043"]
        self.assertEqual(len(told), 2)  # one for each governance document
        self.assertIn("refuse to make such an endpoint (1612)", told[0]["message"])
        self.assertTrue(told[0]["message"].startswith('topic "Square": '), told)
        for one in (self.talker, self.listener):
            one.sign("permissions", permissions(grant(one.subject, allow("*"))))
        told = [d["message"] for d in self.check(exit=0)["diagnostics"] if d["id"] == "GOV043"]
        self.assertTrue(told[0].startswith('topics "*" (e.g. "a"): access is controlled'), told)
        stock = self.check("--vendor", "cyclonedds", exit=0)["diagnostics"]
        self.assertNotIn("GOV043", [d["id"] for d in stock])

    def test_doctor_with_a_peer_is_both_and_the_check(self):
        out = self.json("doctor", "talker", "--peer", "listener", exit=0)
        self.assertEqual(out["result"]["peer"]["verdicts"]["ours"], "ok")
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
        self.refused("usage", 2, "check", "talker", "listener", "--vendor", "C=ours")
        self.refused("usage", 2, "check", "talker", "listener", "--require", "all")
        self.refused("usage", 2, "check", "talker", "listener", "--topics", ",")
        self.refused("usage", 2, "check", "talker", "listener", "--domain", "x")


if __name__ == "__main__":
    main()

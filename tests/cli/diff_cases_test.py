#!/usr/bin/env python3
"""tests/data/diff-cases: verdict, exit code, lines and text of pairs that were once judged wrongly."""

import subprocess

from transcript import DATA, PROGRAM, Transcript, main

CASES = DATA / "diff-cases"
PAYLOAD = ("data_protection_kind", "ENCRYPT", "NONE", "weaker")

# Verdict, exit code for --fail-on weaker or wider, and every line: element, old, new, class.
EXPECTED = {
    "g1a_weaker_alone": ("weaker", 1, [PAYLOAD]),
    "g1b_hidden_by_domain_element": ("mixed", 1, [
        PAYLOAD, ("discovery_protection_kind", "ENCRYPT", "ENCRYPT_WITH_ORIGIN_AUTHENTICATION", "stronger")]),
    "g1c_hidden_by_key_revision": ("mixed", 1, [PAYLOAD, ("enable_key_revision", "false", "true", "stronger")]),
    "g1d_hidden_by_other_topic": ("mixed", 1, [
        PAYLOAD, ("enable_write_access_control", "false", "true", "stronger")]),
    "g1e_both": ("mixed", 1, [
        ("metadata_protection_kind", "ENCRYPT", "NONE", "weaker"), PAYLOAD,
        ("discovery_protection_kind", "ENCRYPT", "ENCRYPT_WITH_ORIGIN_AUTHENTICATION", "stronger")]),
    "g2_relay": ("mixed", 1, [PAYLOAD, ("metadata_protection_kind", "NONE", "ENCRYPT", "stronger")]),
    # The open range of the first rule covers domain 5: the new rule for it never applies, except to stock products.
    "g3_openrange_first": ("neutral", 1, []),
    "g3b_openrange_cut": ("stronger", 0, [("domain_rule", "covered", "uncovered", "narrower")]),
    "g4_backslash": ("weaker", 1, [PAYLOAD]),
    "g5_tags_all": ("weaker", 1, [("domain_rule", "uncovered", "covered", "wider")]),
    "g5_tags_cross": ("weaker", 1, [("domain_rule", "uncovered", "covered", "wider")] * 2),
    "g6_trustchain": ("neutral", 0, []),
    "g7_octet": ("mixed", 1, [PAYLOAD, ("data_protection_kind", "NONE", "ENCRYPT", "stronger")]),
    "g8_text": ("mixed", 1, [
        ("metadata_protection_kind", "ENCRYPT", "NONE", "weaker"),
        ("metadata_protection_kind", "ENCRYPT", "NONE", "weaker"),
        ("data_protection_kind", "ENCRYPT", "SIGN", "weaker"),
        ("enable_key_revision", "false", "true", "stronger"),
        ("rtps_psk_protection_kind", "NONE", "SIGN", "stronger"),
        ("data_protection_kind", "NONE", "SIGN", "stronger")]),
    "p1_tags": ("wider", 1, [("join", "denied", "allowed", "wider"), ("rule", "denied", "allowed", "wider")]),
    # A denial of topics says nothing about joining (docs/decisions).
    "p2_join": ("neutral", 0, [("rewritten", None, None, "neutral")]),
    "p3_schema_mixed": ("mixed", 1, [("validity", "2026-01-01T00:00:00Z .. 2028-01-01T00:00:00Z",
                                      "2028-01-01T00:00:00Z .. 2030-01-01T00:00:00Z", "mixed")]),
    "p4_expr_same": ("neutral", 0, [("subject_name", "CN=a, O=x, C=US", "expression CN=a, O=x, C=US", "interop")]),
    "p5_minonly": ("wider", 1, [("join", "denied", "allowed", "wider"), ("rule", "denied", "allowed", "wider")]),
    "p6_partition_eg": ("wider", 1, [("rule", "denied", "allowed", "wider")]),
}


def words_of(name):
    kind, worse = ("permissions", "wider") if name.startswith("p") else ("governance", "weaker")
    return [kind, "diff", CASES / f"{name}.old.xml", CASES / f"{name}.new.xml", "--fail-on", worse]


class DiffCases(Transcript):
    def result(self, name):
        return self.json(*words_of(name), exit=EXPECTED[name][1])["result"]

    def changes(self, name):
        return self.result(name)["changes"]

    def octets(self, name):
        done = subprocess.run([PROGRAM, *map(str, words_of(name))], capture_output=True, timeout=60, check=False)
        self.assertEqual(done.returncode, EXPECTED[name][1], name)
        return done.stdout

    def text(self, name):
        return self.octets(name).decode()

    def test_every_case_is_there(self):
        self.assertEqual({path.name.split(".")[0] for path in CASES.glob("*.xml")}, set(EXPECTED))

    def test_verdict_lines_and_exit_code(self):
        for name, (verdict, _, lines) in EXPECTED.items():
            with self.subTest(name):
                result = self.result(name)
                self.assertEqual(result["verdict"], verdict)
                told = [(c["element"], c["old"], c["new"], c["class"]) for c in result["changes"]]
                self.assertEqual(told, lines)
                self.assertRegex(self.text(name), f"verdict: {verdict.upper()}( for ddssec's plugins)?;")

    def test_a_weaker_line_always_fails_the_gate(self):
        for name, (verdict, exit, lines) in EXPECTED.items():
            worse = any(line[3] in ("weaker", "wider", "mixed", "unknown") for line in lines)
            self.assertEqual(exit == 1, worse or name == "g3_openrange_first", name)
            self.assertEqual(verdict in ("weaker", "wider", "mixed", "unknown"), worse, name)

    def test_relays_are_named(self):
        for name in ("g1a_weaker_alone", "g2_relay"):
            self.assertEqual(self.changes(name)[0]["properties_lost"],
                             ["relay.payload_secrecy", "relay.payload_integrity"])
            self.assertIn("now relays can read the payload\n", self.text(name))

    def test_a_line_tells_what_its_own_element_does(self):
        last = self.changes("g8_text")[-1]
        self.assertEqual((last["properties_lost"], last["properties_gained"]), ([], ["relay.payload_integrity"]))
        text = self.text("g8_text")
        self.assertNotIn("now ", text[text.index("STRONGER"):])

    def test_open_ranges_are_open_and_warned_of(self):
        change, = self.changes("g3b_openrange_cut")
        self.assertEqual(change["domains"], [[1, 230]])
        self.assertEqual({tuple(map(tuple, c["domains"])) for c in self.changes("p5_minonly")}, {((1, 230),)})
        for name, rule in (("g3_openrange_first", "GOV004"), ("p5_minonly", "PERM004")):
            told = self.json(*words_of(name), exit=EXPECTED[name][1])["diagnostics"]
            self.assertEqual({d["id"] for d in told}, {rule})
            self.assertIn("Cyclone DDS and Fast DDS read domain 0 alone", told[0]["message"])

    def test_a_backslash_escapes(self):
        self.assertEqual(self.changes("g4_backslash")[0]["topics"]["witness"], "cmd*")

    def test_domains_and_tags_are_what_changed(self):
        every_but = {"form": "every_but", "expressions": [""], "examples": ["a"]}
        self.assertEqual([(c["domains"], c["tag_set"]) for c in self.changes("g5_tags_all")],
                         [([[0, 0]], every_but)])
        two, three = self.changes("g5_tags_cross")
        self.assertEqual((two["domains"], two["tag_set"]), ([[2, 2]], every_but))
        self.assertEqual((three["domains"], three["tag_set"]["form"]), ([[3, 3]], "every"))
        text = self.text("g5_tags_cross")
        self.assertIn("domain 2, every tag but the empty one (e.g. a)\n", text)
        self.assertIn("domain 3, every tag\n", text)
        for change in self.changes("p1_tags"):
            self.assertEqual((change["domains"], change["tag_set"]["expressions"]), ([[0, 230]], ["?*"]))

    def test_only_utf8_reaches_a_terminal(self):
        octets = self.octets("g7_octet")
        self.assertIn(r"(e.g. \xa9)".encode(), octets)
        self.assertIn("topic é ".encode(), octets)
        octets.decode("utf-8")
        witness = self.changes("g7_octet")[1]["topics"]["witness"]
        self.assertEqual(len(witness), 1, "JSON replaces what is not UTF-8")

    def test_partitions_are_told_as_what_they_are(self):
        change, = self.changes("p6_partition_eg")
        self.assertEqual(change["endpoints"]["partitions"],
                         {"form": "every_but", "expressions": [""], "examples": ["a"]})
        self.assertIn("publish topic a  in every partition but the default one (e.g. a)",
                      self.text("p6_partition_eg"))
        self.assertIn("publish topics * (e.g. a)  in every partition ", self.text("p1_tags"))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""explain finds Cyclone DDS's own sentences, all that docs/sentences-of-cyclone-dds.md has, and ddssec's by their words."""

import re

from transcript import DATA, Transcript, main

PAGE = DATA.parent.parent / "docs/sentences-of-cyclone-dds.md"
ROS_PAGE = DATA.parent.parent / "docs/secure-a-ros2-robot.md"


def sentences_of_page():
    rows = [line.split("|")[1] for line in PAGE.read_text().splitlines() if line.startswith("| ")]
    quoted = [part for row in rows for part in re.findall(r"`([^`]+)`", row)]
    return [re.sub(r"mismatch: A - B$", "mismatch: ...", s) for s in quoted
            if not s.startswith(("0x", "ddssec", "<", "metadata"))]


class Sentences(Transcript):
    def found(self, text):
        return [one["sentence"] for one in self.json("explain", text)["result"]["sentences"]]

    def test_each_sentence_of_the_page_is_found(self):
        sentences = sentences_of_page()
        self.assertGreater(len(sentences), 10)
        for sentence in sentences:
            self.assertTrue(self.found(sentence), sentence)

    def test_a_line_of_a_log_is_found(self):
        line = "1764000000.123 [5] recv: Remote secure participant 110c3:1:2:1c1 not allowed"
        self.assertEqual(self.found(line), ["Remote secure participant ... not allowed"])
        for own in ("Error occurred while validating local permissions: x", "Begin handshake reply failed: x (code: 117)"):
            self.assertEqual(len(self.found(own)), 1, own)  # 117 is a number of the stock plugins

    def test_sentences_of_ros_are_found_by_a_line(self):
        for line, sentence in (("[ERROR] [rcl]: could not find all security files at /k/enclaves", "could not find all security files"),
                               ("failed to create topic [rt/chatter] for unknown reasons", "failed to create topic [...]"),
                               ("rmw_create_node: invalid allocator", "invalid allocator"),
                               ("  what():  failed to initialize rcl: error not set", "failed to initialize rcl: error not set"),
                               ("error not set", "failed to initialize rcl: error not set"),
                               ("failed to initialize rcl: SECURITY ERROR: directory '/k/enclaves/tlaker' does not exist., at src/x.c:202",
                                "SECURITY ERROR: directory ... does not exist"),
                               ("[rmw_cyclonedds_cpp]: rmw_create_node: failed to create DDS participant", "failed to create DDS participant"),
                               ("failed to initialize rcl node: rcl node's rmw handle is invalid, at src/x.c:415", "rmw handle is invalid")):
            told, = self.json("explain", line)["result"]["sentences"]
            self.assertEqual((told["product"], told["sentence"]), ("ROS 2", sentence))
        self.assertIn("ROS 2: failed to create topic", self.run_program("explain", "failed to create topic").stdout)

    def test_each_sentence_of_the_page_of_ros_is_found(self):
        rows = [line.split("|")[1] for line in ROS_PAGE.read_text().splitlines() if line.startswith("| `")]
        sentences = [part for row in rows for part in re.findall(r"`([^`]+)`", row)]
        self.assertGreater(len(sentences), 7)
        for sentence in sentences:
            self.assertIn(sentence, self.found(sentence))

    def test_a_line_of_a_log_with_a_code_is_explained_by_the_code(self):
        for line in ('ddssec error: peer "CN=x" is on the list; found [crl_expired 1153] [certificate_revoked 1144]',
                     "1764000000.123 [5] recv: ddssec error: revoked [certificate_revoked 1144]\n",
                     "Begin handshake reply failed: ddssec's own line says more (code: 1144)",
                     "1764000000.123 [5] recv: Begin handshake reply failed: x (code: 1144), in a participant [7]"):
            self.assertEqual(self.json("explain", line)["result"].get("number"), 1144, line)
        for line in ("revoked [certificate_revoked 1145]", "revoked [revoked 99999]", "xyz (code: 99999)", "xyz (code: "):
            self.refused("usage", 2, "explain", line)

    def test_a_part_finds_all_that_have_it(self):
        found = self.found("not allowed")
        self.assertIn("Remote secure participant ... not allowed", found)
        self.assertIn("Not Allowed By Security", found)
        done = self.run_program("explain", "not allowed")
        self.assertIn("Cyclone DDS: Remote secure participant ... not allowed\n  the two do not match now", done.stdout)
        self.assertIn("  look with: ", done.stdout)

    def test_a_part_of_a_sentence_of_ddssec_finds_its_code(self):
        self.assertEqual(self.json("explain", "no configured CA issued")["result"]["name"], "issuer_unknown")
        self.assertIn("matches", self.json("explain", "signed document")["result"])

    def test_nonsense_is_found_nowhere(self):
        for text in ("...", "xyz", "not allowed at all by anybody", "  "):
            self.refused("usage", 2, "explain", text)
        for text, meant in (("nogrant", "no_grant_for_subject"), ("crl-expird", "crl_expired"), ("GOV04x", "GOV04")):
            self.assertIn(f'did you mean "{meant}', self.refused("usage", 2, "explain", text)["message"])


if __name__ == "__main__":
    main()

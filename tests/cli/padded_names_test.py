#!/usr/bin/env python3
"""Blanks around the expression of a topic: Fast DDS 2.9.1 takes them for a part of it, so that no topic matches;
Cyclone DDS and ddssec do not. Each row was measured with real pairs (Fast DDS: two runs of two, and four of four)."""

import json
import subprocess

from transcript import PROGRAM, WithoutLists, main
from workshop import GOVERNANCE, Folder, Workshop, allow, grant, permissions

PADDED_RULE = "<topic_expression> * </topic_expression>"
DENY = """<deny_rule>
        <domains><id>0</id></domains>
        <publish><topics><topic>{topic}</topic></topics></publish>
      </deny_rule>
      """


class PaddedNames(WithoutLists):
    def setUp(self):
        super().setUp()
        shop = Workshop(self.at / "shop")
        self.folders = [Folder(shop, self.at / name, f"/CN={name}", name) for name in ("talker", "partner")]

    def sign(self, rules=None, governance=GOVERNANCE):
        for folder in self.folders:
            folder.sign("governance", governance)
            folder.sign("permissions", permissions(grant(folder.subject, rules)))

    def meets(self, vendor):
        """How check ends for two participants of `vendor`."""
        return subprocess.run([PROGRAM, "check", "talker", "partner", "--topics", "Square", "--vendor", f"A={vendor}",
                               "--vendor", f"B={vendor}"], cwd=self.at, capture_output=True, timeout=60,
                              check=False).returncode

    def test_a_padded_topic_allows_nothing_on_fastdds(self):
        self.sign(allow(" Square "))
        self.assertEqual({vendor: self.meets(vendor) for vendor in ("ddssec", "cyclonedds", "fastdds")},
                         {"ddssec": 0, "cyclonedds": 0, "fastdds": 1})

    def test_a_padded_topic_denies_nothing_on_fastdds(self):
        self.sign(DENY.format(topic=" Square ") + allow())
        self.assertEqual({vendor: self.meets(vendor) for vendor in ("ddssec", "cyclonedds", "fastdds")},
                         {"ddssec": 1, "cyclonedds": 1, "fastdds": 0})

    def test_a_padded_rule_covers_no_topic_on_fastdds(self):
        self.sign(governance=GOVERNANCE.replace("<topic_expression>*</topic_expression>", PADDED_RULE))
        self.assertEqual({vendor: self.meets(vendor) for vendor in ("ddssec", "cyclonedds", "fastdds")},
                         {"ddssec": 0, "cyclonedds": 0, "fastdds": 1})

    def test_lint_says_what_becomes_of_them(self):
        for folder in self.folders:
            (folder.path / "permissions.xml").write_text(permissions(grant(folder.subject, allow(" Square "))))
        done = self.run_program("permissions", "lint", "talker/permissions.xml", "--format", "json", exit=None)
        said = [each for each in json.loads(done.stdout)["diagnostics"] if each["id"] == "PERM005"]
        self.assertTrue(said)
        self.assertIn("Fast DDS keeps them", said[0]["message"])


if __name__ == "__main__":
    main()

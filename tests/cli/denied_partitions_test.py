#!/usr/bin/env python3
"""A deny_rule for one partition of a topic. Measured with pairs on stock plugins, in the partitions "", "p" and "q":
Cyclone DDS 0.10.2 refuses to create the topic, and Fast DDS 2.9.1 the endpoint, in each of them."""

from transcript import WithoutLists, main
from workshop import Folder, Workshop, grant, permissions

LISTED = "<partitions><partition>{}</partition></partitions>"
TOPIC = "<topics><topic>Square</topic></topics>"
DENY = ("<deny_rule><domains><id>0</id></domains><publish>" + TOPIC + LISTED.format("p") +
        "</publish></deny_rule>")
ALLOW = ("<allow_rule><domains><id>0</id></domains>" +
         "".join(f"<{way}>{TOPIC}{LISTED.format('*')}</{way}>" for way in ("publish", "subscribe")) + "</allow_rule>")


class DeniedPartitions(WithoutLists):
    def setUp(self):
        super().setUp()
        shop = Workshop(self.at / "shop")
        self.folders = [Folder(shop, self.at / name, f"/CN={name}", name) for name in ("talker", "partner")]
        for folder in self.folders:
            folder.sign("permissions", permissions(grant(folder.subject, DENY + ALLOW)))

    def told(self, out):
        return [one for one in out["diagnostics"] if one["id"] == "DOC053"]

    def test_doctor_says_which_products_refuse_the_topic(self):
        out = self.json("doctor", "talker", exit=1)
        self.assertEqual(out["result"]["verdicts"], {"cyclonedds@0.10.2": "late", "fastdds@2.9.1": "late", "ddssec": "ok"})
        told = {vendor: one["message"] for one in self.told(out) for vendor in one["vendors"]}
        self.assertIn("Cyclone DDS 0.10.2 refuses the whole topic", told["cyclonedds@0.10.2"])
        self.assertIn("Fast DDS 2.9.1 denies it in all of them", told["fastdds@2.9.1"])

    def test_can_says_that_cyclonedds_refuses_the_topic(self):
        for partition, exit in (((), 0), (("--partition", "q"), 0), (("--partition", "p"), 1)):
            told = self.told(self.json("can", "talker", "publish", "Square", *partition, exit=exit))
            self.assertEqual([one["vendors"] for one in told], [["cyclonedds"]] if exit == 0 else [])

    def test_lint_says_so_for_each_product(self):
        out = self.json("permissions", "lint", "talker/permissions.p7s")
        told = {one["vendors"][0]: one["message"] for one in out["diagnostics"] if one["id"] == "PERM021"}
        self.assertIn('refuses the topic "Square" altogether', told["cyclonedds"])
        self.assertIn("denies its topics in all of them", told["fastdds"])

    def test_check_says_no_for_cyclonedds_and_yes_for_ddssec(self):
        pair = ("check", "talker", "partner", "--topics", "Square", "--partition", "q")
        self.json(*pair, "--vendor", "A=cyclonedds", "--vendor", "B=cyclonedds", exit=1)
        self.json(*pair, "--vendor", "A=fastdds", "--vendor", "B=fastdds", exit=1)
        self.json(*pair, "--vendor", "A=ddssec", "--vendor", "B=ddssec")


if __name__ == "__main__":
    main()

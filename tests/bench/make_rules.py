#!/usr/bin/env python3
"""Governance and permissions of many rules, for cyclone_host_bench.

Usage: make_rules.py FOLDER COUNT     FOLDER is what tests/unit/cyclonedds/make_pki.sh made; its
permissions of a and b get COUNT topics, and governance_rules.p7s COUNT rules, half of them literal
names and half of them patterns.
"""

import pathlib
import subprocess
import sys

VALIDITY = "<validity><not_before>2020-01-01T00:00:00</not_before><not_after>2035-01-01T00:00:00</not_after></validity>"
DOMAINS = "<domains><id_range><min>0</min><max>230</max></id_range></domains>"


def names(count):
    return [f"Literal{i}" if i % 2 == 0 else f"Area{i}/*/Speed?" for i in range(count)]


def permissions(subject, count):
    all_names = names(count)
    rules = ""
    for start in range(0, count, 100):
        topics = "".join(f"<topic>{name}</topic>" for name in all_names[start:start + 100])
        rules += "<allow_rule>" + DOMAINS + "".join(
            f"<{action}><topics>{topics}</topics></{action}>" for action in ("publish", "subscribe")) + "</allow_rule>\n"
    return (f'<dds><permissions><grant name="{subject}"><subject_name>CN={subject},O=driver</subject_name>'
            f"{VALIDITY}\n{rules}<default>DENY</default></grant></permissions></dds>\n")


def governance(count):
    rule = ("<topic_rule><topic_expression>{}</topic_expression>"
            "<enable_discovery_protection>true</enable_discovery_protection>"
            "<enable_liveliness_protection>false</enable_liveliness_protection>"
            "<enable_read_access_control>true</enable_read_access_control>"
            "<enable_write_access_control>true</enable_write_access_control>"
            "<metadata_protection_kind>ENCRYPT</metadata_protection_kind>"
            "<data_protection_kind>ENCRYPT</data_protection_kind></topic_rule>\n")
    return ("<dds><domain_access_rules><domain_rule>" + DOMAINS +
            "<allow_unauthenticated_participants>false</allow_unauthenticated_participants>"
            "<enable_join_access_control>true</enable_join_access_control>"
            "<discovery_protection_kind>ENCRYPT</discovery_protection_kind>"
            "<liveliness_protection_kind>NONE</liveliness_protection_kind>"
            "<rtps_protection_kind>NONE</rtps_protection_kind>\n<topic_access_rules>" +
            "".join(rule.format(name) for name in names(count)) +
            "</topic_access_rules></domain_rule></domain_access_rules></dds>\n")


def main():
    folder, count = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    documents = {"permissions_a": permissions("a", count), "permissions_b": permissions("b", count),
                 "governance_rules": governance(count)}
    for name, text in documents.items():
        (folder / f"{name}.xml").write_text('<?xml version="1.0" encoding="UTF-8"?>\n' + text, encoding="utf-8")
        subprocess.run(["openssl", "smime", "-sign", "-text", "-in", f"{name}.xml", "-out", f"{name}.p7s",
                        "-signer", "permca.pem", "-inkey", "permca.key"], cwd=folder, check=True)


if __name__ == "__main__":
    main()

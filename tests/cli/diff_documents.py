"""Documents for the tests of `governance diff` and `permissions diff`, and the calls that compare two of them."""

from transcript import Transcript


def topic(expression, data="ENCRYPT", metadata="NONE", discovery="true", liveliness="true", read="true", write="true"):
    return (f"<topic_rule><topic_expression>{expression}</topic_expression>\n"
            f"<enable_discovery_protection>{discovery}</enable_discovery_protection>\n"
            f"<enable_liveliness_protection>{liveliness}</enable_liveliness_protection>\n"
            f"<enable_read_access_control>{read}</enable_read_access_control>\n"
            f"<enable_write_access_control>{write}</enable_write_access_control>\n"
            f"<metadata_protection_kind>{metadata}</metadata_protection_kind>\n"
            f"<data_protection_kind>{data}</data_protection_kind></topic_rule>\n")


def governance(*topics, domain="<id>0</id>", rtps="SIGN", unauthenticated="false", discovery="ENCRYPT",
               liveliness="ENCRYPT"):
    return ('<?xml version="1.0" encoding="UTF-8"?>\n<dds><domain_access_rules><domain_rule>\n'
            f"<domains>{domain}</domains>\n"
            f"<allow_unauthenticated_participants>{unauthenticated}"
            "</allow_unauthenticated_participants>\n"
            "<enable_join_access_control>true</enable_join_access_control>\n"
            f"<discovery_protection_kind>{discovery}</discovery_protection_kind>\n"
            f"<liveliness_protection_kind>{liveliness}</liveliness_protection_kind>\n"
            f"<rtps_protection_kind>{rtps}</rtps_protection_kind>\n"
            f"<topic_access_rules>\n{''.join(topics)}</topic_access_rules>\n"
            "</domain_rule></domain_access_rules></dds>\n")


def rule(kind, *topics, domains="<id>0</id>", operation="publish", partitions=""):
    names = "\n".join(f"<topic>{name}</topic>" for name in topics)
    return (f"<{kind}_rule>\n<domains>{domains}</domains>\n<{operation}>\n<topics>\n{names}\n"
            f"</topics>\n{partitions}</{operation}>\n</{kind}_rule>\n")


JOIN = "<allow_rule>\n<domains><id>0</id></domains>\n</allow_rule>\n"


def grant(*rules, subject="CN=talker", name="talker", until="2027-01-01", default="DENY"):
    return (f'<grant name="{name}">\n<subject_name>{subject}</subject_name>\n'
            f"<validity><not_before>2026-01-01T00:00:00Z</not_before>\n"
            f"<not_after>{until}T00:00:00Z</not_after></validity>\n{''.join(rules)}"
            f"<default>{default}</default>\n</grant>\n")


def permissions(*grants):
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<dds><permissions>\n{"".join(grants)}' \
           "</permissions></dds>\n"


class Differences(Transcript):
    def write(self, old, new, kind="governance"):
        self.kind = kind
        (self.at / "old.xml").write_text(old)
        (self.at / "new.xml").write_text(new)

    def diff(self, *words, exit=0):
        return self.json(self.kind, "diff", "old.xml", "new.xml", *words, exit=exit)["result"]

    def text(self, *words, exit=0):
        text = self.run_program(self.kind, "diff", "old.xml", "new.xml", *words, exit=exit).stdout
        self.assertLessEqual(max(map(len, text.splitlines())), 100)
        return text

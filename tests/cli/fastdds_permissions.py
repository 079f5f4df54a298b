"""Permissions that Fast DDS does not use as they say: rows of a name, the rules, whether Fast DDS talks about FOO."""

DOCUMENT = """<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions><grant name="g"><subject_name>CN={}</subject_name>
<validity><not_before>2026-01-01T00:00:00Z</not_before><not_after>2056-11-01T00:00:00Z</not_after></validity>
{}<default>DENY</default></grant></permissions></dds>
"""
TOPIC = "Foo"


def rule(kind, domain, *topics):
    listed = "<topics>" + "".join(f"<topic>{topic}</topic>" for topic in topics) + "</topics>"
    return (f"<{kind}_rule><domains><id>{domain}</id></domains><publish>{listed}</publish><subscribe>{listed}</subscribe>"
            f"</{kind}_rule>\n")


def long_names(count):
    return [f"{'t' * 200}{number}" for number in range(count)]


DENIED_ELSEWHERE = rule("deny", 1, TOPIC) + rule("allow", 0, "*")
DENIED_ELSEWHERE_LATER = rule("allow", 0, "*") + rule("deny", 1, TOPIC)
SHORT = rule("allow", 0, TOPIC, *long_names(100))
LONG = rule("allow", 0, TOPIC, *long_names(300))
ROWS = [("denied in another domain first", DENIED_ELSEWHERE, False),
        ("denied in another domain later", DENIED_ELSEWHERE_LATER, True),
        ("short enough", SHORT, True), ("too long", LONG, False)]

"""Permissions that Fast DDS does not use as they say."""

import datetime

DOCUMENT = """<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions><grant name="g"><subject_name>CN={name}</subject_name>
<validity><not_before>2026-01-01T00:00:00Z</not_before><not_after>{end}</not_after></validity>
{rules}<default>DENY</default></grant></permissions></dds>
"""
END = "2056-11-01T00:00:00Z"
TOPIC = "Foo"


def rule(kind, domain, *topics):
    listed = "<topics>" + "".join(f"<topic>{topic}</topic>" for topic in topics) + "</topics>"
    return (f"<{kind}_rule><domains><id>{domain}</id></domains><publish>{listed}</publish><subscribe>{listed}</subscribe>"
            f"</{kind}_rule>\n")


def long_names(count):
    return [f"{'t' * 200}{number}" for number in range(count)]


def in_zone(now, hours, zone):
    """The time that many hours from now, as a clock in the zone shows it."""
    moment = now + datetime.timedelta(hours=hours)
    return moment.astimezone(datetime.timezone(datetime.timedelta(hours=zone))).isoformat(timespec="seconds")


DENIED_ELSEWHERE = rule("deny", 1, TOPIC) + rule("allow", 0, "*")
DENIED_ELSEWHERE_LATER = rule("allow", 0, "*") + rule("deny", 1, TOPIC)
SHORT = rule("allow", 0, TOPIC, *long_names(139))
LONG = rule("allow", 0, TOPIC, *long_names(144))


def rows(now):
    """Rows of a name, the end of the validity, the rules, and whether Fast DDS and whether others talk about TOPIC."""
    everything = rule("allow", 0, "*")
    return [("denied in another domain first", END, DENIED_ELSEWHERE, False, True),
            ("denied in another domain later", END, DENIED_ELSEWHERE_LATER, True, True),
            ("short enough", END, SHORT, True, True),
            ("too long", END, LONG, False, True),
            ("ended, by a clock far in the east not yet", in_zone(now, -1, 12), everything, True, False),
            ("not ended, by a clock far in the west long ago", in_zone(now, 1, -12), everything, False, True)]

"""What documents protect against outsiders, insiders and relays (the table in docs/comparison.md),
and which element has a part in a difference."""

from documents import TOPIC_FLAGS, TOPIC_KINDS

ORIGIN = "_WITH_ORIGIN_AUTHENTICATION"

def _secrecy(*kinds):
    return any(kind.startswith("ENCRYPT") for kind in kinds)


def _integrity(*kinds):
    return any(kind != "NONE" for kind in kinds)


def _both(asset, *kinds):
    return {f"{asset}_secrecy": _secrecy(*kinds), f"{asset}_integrity": _integrity(*kinds)}


def _of_domain(values):
    held = _both("outsider.bootstrap", values["rtps_psk_protection_kind"])
    return held | {"outsider.rejection": not values["allow_unauthenticated_participants"],
                   "insider.join_control": values["enable_join_access_control"],
                   "insider.key_revision": values["enable_key_revision"]}


def _against_outsiders(domain, topic):
    rtps, metadata = domain["rtps_protection_kind"], topic["metadata_protection_kind"]
    held = _both("outsider.payload", topic["data_protection_kind"], metadata, rtps)
    held |= _both("outsider.metadata", metadata, rtps)
    for asset in ("discovery", "liveliness"):
        kind = domain[f"{asset}_protection_kind"]
        held |= _both(f"outsider.{asset}", kind if topic[f"enable_{asset}_protection"] else "NONE", rtps)
    del held["outsider.liveliness_secrecy"]  # it holds nothing to read
    return held


def _against_insiders(domain, topic):
    data, metadata = topic["data_protection_kind"], topic["metadata_protection_kind"]
    read, write = topic["enable_read_access_control"], topic["enable_write_access_control"]
    return {"insider.payload_secrecy": read and _secrecy(data, metadata),
            "insider.payload_integrity": write and _integrity(data, metadata),
            "insider.metadata_secrecy": read and _secrecy(metadata),
            "insider.metadata_integrity": write and _integrity(metadata),
            "insider.sender_known": metadata.endswith(ORIGIN) or domain["rtps_protection_kind"].endswith(ORIGIN)}


def properties_of(domain, topic):
    """What a domain rule and one of its topic rules protect."""
    held = _of_domain(domain.values) | _against_outsiders(domain.values, topic.values)
    held |= _against_insiders(domain.values, topic.values) | _both("relay.payload", topic.values["data_protection_kind"])
    return {name for name, is_held in held.items() if is_held}


def _with_element(element, sides, others):
    """`sides` (domain rule, topic rule), but this element as in `others`."""
    (domain, topic), (other_domain, other_topic) = sides, others
    if element in TOPIC_FLAGS + TOPIC_KINDS:
        return domain, topic._replace(values=topic.values | {element: other_topic.values[element]})
    return domain._replace(values=domain.values | {element: other_domain.values[element]}), topic


def shares(element, properties, before, after):
    """Those of `properties`, which `before` has and `after` has not, in whose loss the element has a
    part: its change alone takes them, or without it they would still be there."""
    alone = properties_of(*_with_element(element, before, after))
    without = properties_of(*_with_element(element, after, before))
    return {name for name in properties if name not in alone or name in without}

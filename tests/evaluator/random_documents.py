"""Random documents as trees of elements."""

import xml.etree.ElementTree as ET

import words

KINDS = ["NONE", "SIGN", "ENCRYPT", "SIGN_WITH_ORIGIN_AUTHENTICATION", "ENCRYPT_WITH_ORIGIN_AUTHENTICATION"]
BASIC_KINDS = KINDS[:3]
IDS = [0, 0, 0, 1, 2, 5, 7, 100, 229, 230]


def leaf(name, text):
    element = ET.Element(name)
    element.text = text
    return element


def group(name, children):
    element = ET.Element(name)
    element.extend(children)
    return element


def boolean(rng):
    return rng.choice(["true", "false"])


def several(rng, most, make):
    return [make(rng) for _ in range(rng.randint(1, most))]


def id_range(rng):
    first, last = sorted((rng.choice(IDS), rng.choice(IDS)))
    ends = [leaf("min", str(first)), leaf("max", str(last))]
    draw = rng.random()
    return group("id_range", ends if draw < 0.5 else ends[:1] if draw < 0.75 else ends[1:])


def domain_id(rng):
    return leaf("id", str(rng.choice(IDS))) if rng.random() < 0.65 else id_range(rng)


def domain_tag(rng):
    if rng.random() < 0.5:
        return leaf("tag", words.random_name(rng))
    return leaf("tag_expression", words.random_expression(rng))


def domains(rng):
    children = several(rng, 2, domain_id)
    if rng.random() < 0.3:
        children += several(rng, 2, domain_tag)
    return group("domains", children)


def topic_rule(rng):
    metadata = rng.choice(BASIC_KINDS if rng.random() < 0.8 else KINDS)
    return group("topic_rule", [
        leaf("topic_expression", words.random_expression(rng)),
        leaf("enable_discovery_protection", boolean(rng)),
        leaf("enable_liveliness_protection", boolean(rng)),
        leaf("enable_read_access_control", boolean(rng)),
        leaf("enable_write_access_control", boolean(rng)),
        leaf("metadata_protection_kind", metadata),
        leaf("data_protection_kind", rng.choice(BASIC_KINDS))])


def algorithm_list(rng, name):
    known = words.ALGORITHMS[name]
    chosen = rng.sample(known, rng.randint(1, len(known)))
    return group(name, [leaf("algorithm", each) for each in chosen])


def algorithms(rng):
    names = ["digital_signature", "digital_signature_identity_trust_chain", "key_establishment",
             "symmetric_cipher"]
    if rng.random() < 0.6:
        names.remove("digital_signature_identity_trust_chain")
    if rng.random() < 0.3:
        names.remove(rng.choice(names))
    return group("allowed_crypto_algorithms", [algorithm_list(rng, name) for name in names])


def domain_rule(rng):
    children = [domains(rng), leaf("allow_unauthenticated_participants", boolean(rng)),
                leaf("enable_join_access_control", boolean(rng))]
    if rng.random() < 0.4:
        children.append(leaf("enable_key_revision", boolean(rng)))
    for name in ("discovery_protection_kind", "liveliness_protection_kind", "rtps_protection_kind"):
        children.append(leaf(name, rng.choice(BASIC_KINDS if rng.random() < 0.7 else KINDS)))
    if rng.random() < 0.4:
        children.append(leaf("rtps_psk_protection_kind", rng.choice(BASIC_KINDS)))
    children.append(group("topic_access_rules", several(rng, 4, topic_rule)))
    if rng.random() < 0.3:
        children.append(algorithms(rng))
    return group("domain_rule", children)


def governance(rng):
    return group("dds", [group("domain_access_rules", several(rng, 3, domain_rule))])


def data_tag(rng):
    return group("tag", [leaf("name", rng.choice("ab")), leaf("value", rng.choice("12"))])


def criteria(rng, action):
    children = [group("topics", several(rng, 2, lambda r: leaf("topic", words.random_expression(r))))]
    if rng.random() < 0.45:
        children.append(group("partitions", several(rng, 2, partition)))
    if rng.random() < 0.25:
        children.append(group("data_tags", several(rng, 2, data_tag)))
    return group(action, children)


def partition(rng):
    return leaf("partition", "" if rng.random() < 0.15 else words.random_expression(rng))


def rule(rng):
    children = [domains(rng)]
    for action, most in (("publish", 2), ("subscribe", 2), ("relay", 1)):
        if rng.random() < (0.7 if action != "relay" else 0.25):
            children += [criteria(rng, action) for _ in range(rng.randint(1, most))]
    return group(rng.choice(["allow_rule", "allow_rule", "deny_rule"]), children)


def subject(rng):
    if rng.random() < 0.65:
        return leaf("subject_name", words.random_subject(rng, is_expression=False))
    while True:
        text = words.random_subject(rng, is_expression=True)
        if words.subject_is_defined(text):
            return leaf("subject_name_expression", text)


def validity(rng):
    while True:
        first, end = sorted((words.random_date(rng), words.random_date(rng)))
        if first[:19] < end[:10]:  # at least a day, whatever the zones
            return group("validity", [leaf("not_before", first), leaf("not_after", end)])


def grant(rng):
    children = [subject(rng), validity(rng), *several(rng, 3, rule)]
    if rng.random() < 0.85:
        children.append(leaf("default", rng.choice(["DENY", "DENY", "ALLOW"])))
    element = group("grant", children)
    element.set("name", rng.choice(["g", "h", "k"]))
    return element


def permissions(rng):
    return group("dds", [group("permissions", several(rng, 3, grant))])

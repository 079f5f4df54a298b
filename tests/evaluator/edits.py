"""Random edits of a document: one to three make the second document of a pair."""

import copy

import random_documents as documents
import words

REPEATED = {"domain_rule": documents.domain_rule, "topic_rule": documents.topic_rule,
            "grant": documents.grant, "allow_rule": documents.rule, "deny_rule": documents.rule,
            "id": documents.domain_id, "id_range": documents.domain_id,
            "publish": lambda rng: documents.criteria(rng, "publish"),
            "subscribe": lambda rng: documents.criteria(rng, "subscribe"),
            "relay": lambda rng: documents.criteria(rng, "relay"),
            "tag_expression": documents.domain_tag, "partition": documents.partition,
            "topic": lambda rng: documents.leaf("topic", words.random_expression(rng))}
EXPRESSIONS = {"topic_expression", "topic", "partition", "tag_expression"}
# Of which children an element needs at least one.
NEEDED = {"domain_access_rules": {"domain_rule"}, "topic_access_rules": {"topic_rule"}, "permissions": {"grant"},
          "grant": {"allow_rule", "deny_rule"}, "domains": {"id", "id_range"}, "topics": {"topic"},
          "partitions": {"partition"}, "data_tags": {"tag"}}
NEEDED |= {name: {"algorithm"} for name in words.ALGORITHMS}
OPTIONAL = {
    "domain_rule": [("enable_key_revision", lambda rng: documents.leaf("enable_key_revision", "true")),
                    ("rtps_psk_protection_kind",
                     lambda rng: documents.leaf("rtps_psk_protection_kind", rng.choice(documents.BASIC_KINDS))),
                    ("allowed_crypto_algorithms", documents.algorithms)],
    "grant": [("default", lambda rng: documents.leaf("default", "ALLOW"))]}
CRITERIA = [("partitions", lambda rng: documents.group("partitions", [documents.partition(rng)])),
            ("data_tags", lambda rng: documents.group("data_tags", [documents.data_tag(rng)])),
            ("data_tags", lambda rng: documents.group("data_tags", [documents.data_tag(rng), documents.data_tag(rng)]))]
OPTIONAL |= {"publish": CRITERIA, "subscribe": CRITERIA, "relay": CRITERIA}


def _pairs(tree):
    """Every element with its parent."""
    return [(parent, child) for parent in tree.iter() for child in parent]


def _new_text(rng, element):
    name, text = element.tag, element.text or ""
    if name in EXPRESSIONS:
        return words.changed_expression(rng, text) if text else words.random_expression(rng)
    if name.startswith(("enable_", "allow_unauthenticated")):
        return "false" if text == "true" else "true"
    if name.endswith("_kind"):
        basic = name in ("data_protection_kind", "rtps_psk_protection_kind")
        return rng.choice([kind for kind in (documents.BASIC_KINDS if basic else documents.KINDS) if kind != text])
    if name in ("id", "min", "max"):
        return str(rng.choice(documents.IDS))
    if name == "tag":
        return words.random_name(rng)
    if name == "default":
        return "DENY" if text == "ALLOW" else "ALLOW"
    if name in ("name", "value"):
        return rng.choice("ab" if name == "name" else "12")
    if name in ("not_before", "not_after"):
        return words.random_date(rng)
    if name in ("subject_name", "subject_name_expression"):
        return words.changed_subject(rng, text, name == "subject_name_expression")
    return text


def change_text(rng, tree):
    leaves = [child for _, child in _pairs(tree) if len(child) == 0 and child.tag not in ("algorithm", "relay")
              and not child.tag.endswith("_rule")]
    element = rng.choice(leaves)
    element.text = _new_text(rng, element)


def remove(rng, tree):
    parent, child = rng.choice(_pairs(tree))
    optional = {name for name, _ in OPTIONAL.get(parent.tag, ())}
    if child.tag not in REPEATED and child.tag not in optional and child.tag not in (
            "algorithm", "tag", *words.ALGORITHMS):
        return False
    parent.remove(child)
    return True


def insert(rng, tree):
    pairs = [(parent, child) for parent, child in _pairs(tree) if child.tag in REPEATED]
    parent, child = rng.choice(pairs)
    new = copy.deepcopy(child) if rng.random() < 0.5 else REPEATED[child.tag](rng)
    if child.tag == "grant":  # mostly for a subject that is known
        new[0] = copy.deepcopy(child[0]) if rng.random() < 0.7 else new[0]
    parent.insert(list(parent).index(child) + rng.randint(0, 1), new)


def swap(rng, tree):
    pairs = [(parent, i) for parent in tree.iter() for i in range(len(parent) - 1)
             if parent[i].tag in REPEATED and parent[i + 1].tag in REPEATED]
    if not pairs:
        return False
    parent, i = rng.choice(pairs)
    parent[i], parent[i + 1] = parent[i + 1], parent[i]
    return True


def set_optional(rng, tree):
    parents = [each for each in tree.iter() if each.tag in OPTIONAL]
    parent = rng.choice(parents)
    name, make = rng.choice(OPTIONAL[parent.tag])
    found = parent.find(name)
    if found is None:
        parent.append(make(rng))
    else:
        parent.remove(found)
    return True


def set_tags(rng, tree):
    domains = rng.choice(list(tree.iter("domains")))
    domains.append(documents.domain_tag(rng))


def rename(rng, tree):
    """Allow to deny, publish to subscribe, a subject to an expression."""
    others = {"allow_rule": ["deny_rule"], "deny_rule": ["allow_rule"], "publish": ["subscribe", "relay"],
              "subscribe": ["publish"], "relay": ["subscribe"], "subject_name": ["subject_name_expression"],
              "subject_name_expression": ["subject_name"], "tag_expression": ["tag"]}
    found = [each for each in tree.iter() if each.tag in others and (len(each) or each.tag[0] in "st")]
    if not found:
        return False
    element = rng.choice(found)
    element.tag = rng.choice(others[element.tag])
    return True


def split_list(rng, tree):
    """One element with two topics, partitions or data tags becomes two with one each: an endpoint in
    both partitions, or with both tags, fits neither."""
    found = [(rule, criteria, each) for rule in tree.iter() if rule.tag in ("allow_rule", "deny_rule")
             for criteria in rule if criteria.tag != "domains" for each in criteria if len(each) > 1]
    if not found:
        return False
    rule, criteria, each = rng.choice(found)
    other = copy.deepcopy(criteria)
    other.find(each.tag)[:] = [each[-1]]
    each.remove(each[-1])
    rule.insert(list(rule).index(criteria) + rng.randint(0, 1), other)
    return True


def list_more(rng, tree):
    """A partition or data tag more where some are listed already."""
    found = [each for each in tree.iter() if each.tag in ("partitions", "data_tags")]
    if not found:
        return False
    each = rng.choice(found)
    each.append(documents.partition(rng) if each.tag == "partitions" else documents.data_tag(rng))
    return True


def change_second(rng, tree):
    """The same time in another zone, or a part of a second more or less."""
    found = [each for name in ("not_before", "not_after") for each in tree.iter(name)]
    if not found:
        return False
    element = rng.choice(found)
    element.text = element.text[:19] + rng.choice(words.SAME_DATE + words.OTHER_DATE)
    return True


def same_meaning(rng, tree):
    """An expression respelled; the order of a list, of a document's own elements, or of RDNs changed."""
    found = [each for each in tree.iter() if each.tag in EXPRESSIONS and each.text]
    subjects = list(tree.iter("subject_name"))
    draw = rng.random()
    if found and draw < 0.4:
        element = rng.choice(found)
        element.text = words.same_expression(rng, element.text)
    elif subjects and draw < 0.6:
        element = rng.choice(subjects)
        element.text = ",".join(reversed(element.text.split(",")))
    else:
        parent = rng.choice([each for each in tree.iter() if each.tag in ("topics", "partitions", "data_tags")]
                            or list(tree.iter("domains")))
        parent[:] = parent[::-1]


EDITS = [change_text] * 10 + [remove] * 3 + [insert] * 2 + [swap] * 2 + [set_optional, set_tags, rename] * 2 + [
    split_list, list_more, change_second, same_meaning]


def _range_is_valid(each):
    first, last = each.find("min"), each.find("max")
    return (len(each) > 0 and (first is None or last is None or int(first.text) <= int(last.text)))


def _subject_is_valid(grant):
    name = grant[0]
    if "+" in name.text and name.text.count("=") < name.text.count("+") + name.text.count(",") + 1:
        return False
    if name.tag == "subject_name":
        return not set(name.text) & set("*?[]!\\^-")
    return words.subject_is_defined(name.text)


def _grant_is_valid(grant):
    validity = grant.find("validity")
    return (_subject_is_valid(grant)
            and validity[0].text[:19] < validity[1].text[:10])


def is_valid(tree):
    """What the product must be able to read."""
    for each in tree.iter():
        needed = NEEDED.get(each.tag)
        if needed and not any(child.tag in needed for child in each):
            return False
        if each.tag == "id_range" and not _range_is_valid(each):
            return False
        if each.tag == "grant" and not _grant_is_valid(each):
            return False
    return True


def edited(rng, tree):
    """The tree after one to three edits, valid."""
    for _ in range(rng.choice([1, 1, 2, 2, 3])):
        while True:
            changed = copy.deepcopy(tree)
            if rng.choice(EDITS)(rng, changed) is not False and is_valid(changed):
                tree = changed
                break
    return tree

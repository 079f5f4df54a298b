"""Each line of the product names an example. Here both documents are asked about that example, name by
name with the C library's fnmatch()."""

import itertools

from documents import read_governance, read_permissions
from expressions import matches
from governance_verdict import COVERED, shown
from permissions_verdict import joins

MOST_PLACES = 6  # domains and tags that are tried for one line


def applies(rule, domain, tag):
    return rule.domains.ids >> domain & 1 and any(matches(item, tag) for item in rule.domains.tags)


def rule_for(rules, domain, tag):
    return next((rule for rule in rules if applies(rule, domain, tag)), None)


def topic_rule_for(rule, topic):
    return next((each for each in rule.topic_rules if matches(each.topic, topic)), None)


def places_of(change):
    """Both ends of its ranges of domains, each with the tags that it names."""
    domains = sorted({domain for ends in change["domains"] for domain in ends})
    places = [(domain, bytes.fromhex(tag)) for tag in change["tags"] for domain in domains]
    return places[:MOST_PLACES]


def governance_value(document, change, domain, tag):
    """What the document says of the line's element there, as the line would show it."""
    rule = rule_for(document, domain, tag)
    element = change["element"]
    if element == "domain_rule":
        return COVERED[rule is not None]
    if rule is None:
        return None
    if change["topic"] is None:
        return shown(rule.values[element])
    topic = topic_rule_for(rule, bytes.fromhex(change["topic"]))
    if element == "topic_rule":
        return COVERED[topic is not None]
    return topic and shown(topic.values[element])


def governance_complaints(changes, old_xml, new_xml):
    documents = read_governance(old_xml), read_governance(new_xml)
    for change in changes:
        if change["element"].startswith("allowed_crypto_algorithms"):
            continue
        for domain, tag in places_of(change):
            values = [governance_value(document, change, domain, tag) for document in documents]
            if values != [change["old"], change["new"]]:
                yield f"example of {change}: domain {domain}, tag {tag!r}: the documents say {values}"


def fits(criteria, allow, topic, partitions, data_tags):
    """Whether one element takes an endpoint (10.4.1.5.3.4)."""
    if not any(matches(item, topic) for item in criteria.topics):
        return False
    enough = all if allow else any
    if criteria.partitions is not None:
        taken = enough(any(matches(item, name) for item in criteria.partitions) for name in partitions)
    else:
        taken = not allow or set(partitions) == {b""}
    if criteria.data_tags is not None:
        return taken and enough(tag in criteria.data_tags for tag in data_tags)
    return taken and (not allow or not data_tags)


def allowed(grant, change, domain, tag):
    """The decision of one grant about the line's example; None: no grant."""
    if grant is None:
        return False
    rules = [rule for rule in grant.rules if applies(rule, domain, tag)]
    if change["element"] == "join":
        return joins(rules, grant.default_allow)
    topic = bytes.fromhex(change["topic"])
    partitions = [bytes.fromhex(name) for name in change["partitions"]]
    data_tags = {tuple(pair) for pair in change["data_tags"]}
    for rule in rules:
        for criteria in rule.criteria[change["operation"]]:
            if fits(criteria, rule.allow, topic, partitions, data_tags):
                return rule.allow
    return grant.default_allow and change["operation"] != "relay"


def is_information(change, changes):
    """Rules are compared as well where the validities of a subject's only grants do not meet."""
    return any(other["element"] == "validity" and other["subject"] == change["subject"]
               and other["class"] == "mixed" for other in changes)


def permissions_complaints(changes, old_xml, new_xml, deciding):
    """A line about endpoints or joining must hold for two grants that decide for one subject."""
    every = list(itertools.product(read_permissions(old_xml), read_permissions(new_xml)))
    for change in changes:
        if change["element"] not in ("rule", "join") or change["class"] not in ("wider", "narrower"):
            continue
        wanted = (False, True) if change["class"] == "wider" else (True, False)
        pairs = deciding + (every if is_information(change, changes) else [])
        for domain, tag in places_of(change):
            if not any((allowed(old, change, domain, tag), allowed(new, change, domain, tag)) == wanted
                       for old, new in pairs):
                yield f"example of {change}: domain {domain}, tag {tag!r}: no two grants differ so"

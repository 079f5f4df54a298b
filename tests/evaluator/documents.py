"""Governance and permissions documents read from XML text into plain values, without the product."""

import datetime
import functools
import xml.etree.ElementTree as ET
from typing import NamedTuple

from expressions import expression, literal, split
from subjects import read_subject

BLANKS = " \t\r\n"
EVERY_DOMAIN = (1 << 231) - 1  # the ids 0 to 230, one bit each
FLAGS = ("allow_unauthenticated_participants", "enable_join_access_control", "enable_key_revision")
DOMAIN_KINDS = ("discovery_protection_kind", "liveliness_protection_kind", "rtps_protection_kind",
                "rtps_psk_protection_kind")
TOPIC_FLAGS = ("enable_discovery_protection", "enable_liveliness_protection",
               "enable_read_access_control", "enable_write_access_control")
TOPIC_KINDS = ("metadata_protection_kind", "data_protection_kind")
SIGNATURES = frozenset(["RSASSA-PSS-MGF1SHA256+2048+SHA256", "RSASSA-PKCS1-V1_5+2048+SHA256",
                        "ECDSA+P256+SHA256", "ECDSA+P384+SHA384"])  # 8.2
KEY_ESTABLISHMENTS = frozenset(["DHE+MODP-2048-256", "ECDHE-CEUM+P256", "ECDHE-CEUM+P384"])  # 8.2
CIPHERS = frozenset(["AES128+GCM", "AES256+GCM"])  # 8.1


class Domains(NamedTuple):
    ids: int  # one bit each
    tags: tuple  # items for expressions.combinations


class TopicRule(NamedTuple):
    topic: tuple
    values: dict


class DomainRule(NamedTuple):
    domains: Domains
    values: dict
    algorithms: dict  # list's name -> set of names
    topic_rules: tuple


class Criteria(NamedTuple):
    """One publish, subscribe or relay element; None: the list is absent."""
    topics: tuple
    partitions: tuple | None
    data_tags: frozenset | None


class Rule(NamedTuple):
    allow: bool
    domains: Domains
    criteria: dict  # action -> tuple of Criteria


class Grant(NamedTuple):
    subject: object
    subject_text: str  # as a line of the product names it
    first: int  # second from which it holds
    end: int  # second from which it holds no longer
    rules: tuple
    default_allow: bool


def text_of(parent, name, fallback=None):
    found = parent.find(name)
    return fallback if found is None else (found.text or "").strip(BLANKS)


def flag_of(parent, name, fallback=None):
    text = text_of(parent, name, fallback)
    return {"true": True, "false": False, "1": True, "0": False}[text.lower()]


def read_domains(element):
    ids = 0
    for each in element:
        if each.tag == "id":
            ids |= 1 << int(each.text)
        elif each.tag == "id_range":
            first, last = int(text_of(each, "min", "0")), int(text_of(each, "max", "230"))
            ids |= (1 << last + 1) - (1 << first)
    tags = [(literal if each.tag == "tag" else expression)((each.text or "").strip(BLANKS))
            for each in element if each.tag in ("tag", "tag_expression")]
    return Domains(ids & EVERY_DOMAIN, tuple(tags or [literal("")]))


def read_algorithms(element):
    """An absent list holds every algorithm that the standard names (10.4.1.2.5.9)."""
    lists = {} if element is None else {
        each.tag: frozenset(one.text.strip(BLANKS) for one in each) for each in element}
    signature = lists.get("digital_signature", SIGNATURES)
    chain = lists.get("digital_signature_identity_trust_chain",
                      lists.get("digital_signature_trust_chain", signature))
    return {"digital_signature": signature, "digital_signature_identity_trust_chain": chain,
            "key_establishment": lists.get("key_establishment", KEY_ESTABLISHMENTS),
            "symmetric_cipher": lists.get("symmetric_cipher", CIPHERS)}


def read_topic_rule(element):
    values = {name: flag_of(element, name) for name in TOPIC_FLAGS}
    values |= {name: text_of(element, name) for name in TOPIC_KINDS}
    return TopicRule(expression(text_of(element, "topic_expression")), values)


def read_domain_rule(element):
    values = {name: flag_of(element, name, "false" if name == "enable_key_revision" else None)
              for name in FLAGS}
    values |= {name: text_of(element, name, "NONE" if name == "rtps_psk_protection_kind" else None)
               for name in DOMAIN_KINDS}
    return DomainRule(read_domains(element.find("domains")), values,
                      read_algorithms(element.find("allowed_crypto_algorithms")),
                      tuple(map(read_topic_rule, element.iterfind("topic_access_rules/topic_rule"))))


@functools.lru_cache(maxsize=4)
def read_governance(xml):
    return tuple(map(read_domain_rule, ET.fromstring(xml).iterfind("domain_access_rules/domain_rule")))


def seconds_of(text, round_up):
    """Whole seconds since 1970; without a zone it is UTC (10.4.1.5.3.3)."""
    moment = datetime.datetime.fromisoformat(text.replace("Z", "+00:00"))
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=datetime.timezone.utc)
    whole = moment.replace(microsecond=0)
    return int(whole.timestamp()) + (1 if round_up and whole != moment else 0)


def read_criteria(element):
    partitions, data_tags = element.find("partitions"), element.find("data_tags")
    return Criteria(
        tuple(expression(each.text.strip(BLANKS)) for each in element.find("topics")),
        None if partitions is None else tuple(expression((each.text or "").strip(BLANKS))
                                              for each in partitions),
        None if data_tags is None else frozenset((text_of(each, "name"), text_of(each, "value"))
                                                 for each in data_tags))


def read_rule(element):
    return Rule(element.tag == "allow_rule", read_domains(element.find("domains")),
                {action: tuple(map(read_criteria, element.iterfind(action)))
                 for action in ("publish", "subscribe", "relay")})


def read_grant(element):
    name, expressed = text_of(element, "subject_name"), text_of(element, "subject_name_expression")
    subject = read_subject(name if name is not None else expressed, is_expression=name is None)
    validity = element.find("validity")
    return Grant(subject, "expression " + expressed if name is None else name, seconds_of(text_of(validity, "not_before"), round_up=True),
                 seconds_of(text_of(validity, "not_after"), round_up=False),
                 tuple(read_rule(each) for each in element if each.tag in ("allow_rule", "deny_rule")),
                 text_of(element, "default", "DENY") == "ALLOW")


@functools.lru_cache(maxsize=4)
def read_permissions(xml):
    return tuple(map(read_grant, ET.fromstring(xml).iterfind("permissions/grant")))


def domains_and_tags(rules):
    """Where rules can differ: sets of domain ids, the expressions of tags, and those of each rule as bits."""
    pieces = [EVERY_DOMAIN]
    for rule in rules:
        pieces = split(pieces, rule.domains.ids)
    tags = tuple({tag: None for rule in rules for tag in rule.domains.tags})
    masks = [sum({1 << tags.index(tag) for tag in rule.domains.tags}) for rule in rules]
    return pieces, tags, masks

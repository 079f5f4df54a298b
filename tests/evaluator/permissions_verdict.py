"""What a change of a permissions document comes to, by trying decisions: (subject, time, domain, tag,
action, endpoint), as "What a comparison means" in docs/comparison.md has it."""

from typing import NamedTuple

from documents import domains_and_tags, read_permissions
from endpoints import Elements
from expressions import combinations
from subjects import representatives

ACTIONS = ("publish", "subscribe", "relay")


class Decision(NamedTuple):
    """One that differs between the documents."""
    subject: str
    time: int
    domain: int
    tag: bytes
    action: str
    endpoint: tuple

    def __str__(self):
        where = f"domain {self.domain} tag {self.tag!r}" if self.domain >= 0 else ""
        return f"{self.subject} at {self.time} {where} {self.action} {self.endpoint or ''}"


class Verdict:
    def __init__(self):
        self.wider, self.narrower = [], []
        self.deciding = []  # [(old grant or None, new grant or None)] that decide somewhere

    def note(self, old_allows, new_allows, decision):
        if old_allows != new_allows:
            (self.wider if new_allows else self.narrower).append(decision)

    def word(self):
        if self.wider and self.narrower:
            return "mixed"
        return "wider" if self.wider else "narrower" if self.narrower else "neutral"


def joins(rules, default):
    """Rules for one domain and tag: deny rules about topics say nothing about joining."""
    for rule in rules:
        if rule.allow:
            return True
        if not rule.criteria["publish"] and not rule.criteria["subscribe"]:
            return False
    return default


def places(old, new):
    """[(domain, tag, old rules, new rules)]: every pair of rows of rules that apply somewhere."""
    rules = old.rules + new.rules
    pieces, tags, masks = domains_and_tags(rules)
    found = {}
    for ids in pieces:
        for matched, tag in combinations(tags):
            applying = tuple(i for i, rule in enumerate(rules)
                             if rule.domains.ids & ids and masks[i] & matched)
            found.setdefault(applying, ((ids & -ids).bit_length() - 1, tag))
    for applying, (domain, tag) in found.items():
        yield (domain, tag, [rules[i] for i in applying if i < len(old.rules)],
               [rules[i] for i in applying if i >= len(old.rules)])


def endpoint_decisions(action, old_rules, new_rules, defaults):
    """[(old decision, new decision, endpoint)]"""
    rows = [[(rule.allow, rule.criteria[action]) for rule in rules] for rules in (old_rules, new_rules)]
    if rows[0] == rows[1] and defaults[0] == defaults[1]:
        return  # the same question twice
    elements = Elements(rows[0] + rows[1])
    of_old = (1 << sum(len(several) for _, several in rows[0])) - 1
    for mask, *endpoint in elements.endpoints():
        allowed = []
        for part, default in zip((mask & of_old, mask & ~of_old), defaults):
            first = part & -part
            allowed.append(bool(first & elements.allow) if first else default and action != "relay")
        yield *allowed, tuple(endpoint)


def compare_grants(verdict, old, new, subject, time):
    """Of two grants that decide for the same subject at the same time."""
    defaults = (old.default_allow, new.default_allow)
    for domain, tag, old_rules, new_rules in places(old, new):
        verdict.note(joins(old_rules, defaults[0]), joins(new_rules, defaults[1]),
                     Decision(subject, time, domain, tag, "join", ()))
        for action in ACTIONS:
            for before, after, endpoint in endpoint_decisions(action, old_rules, new_rules, defaults):
                verdict.note(before, after, Decision(subject, time, domain, tag, action, endpoint))


def deciding(grants, time):
    """The index of the first that is valid, or None."""
    return next((i for i, grant in grants if grant.first <= time < grant.end), None)


def compare(old, new):
    verdict, seen = Verdict(), set()
    grants = old + new
    times = sorted({time for grant in grants for time in (grant.first, grant.end)})
    for matched, subject in representatives([grant.subject for grant in grants]):
        sides = [[(i, grants[i]) for i in several if matched >> i & 1]
                 for several in (range(len(old)), range(len(old), len(grants)))]
        for time in times:
            i, j = (deciding(side, time) for side in sides)
            if (i, j) in seen:
                continue
            seen.add((i, j))
            verdict.deciding.append(tuple(None if k is None else grants[k] for k in (i, j)))
            verdict.note(i is not None, j is not None, Decision(subject, time, -1, b"", "hold", ()))
            if i is not None and j is not None:
                compare_grants(verdict, grants[i], grants[j], subject, time)
    return verdict


def evaluate(old_xml, new_xml):
    return compare(read_permissions(old_xml), read_permissions(new_xml))

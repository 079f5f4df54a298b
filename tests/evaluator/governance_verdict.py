"""What a change of a governance document comes to: the lines of docs/comparison.md, its verdict,
and what attackers can do afterwards that they could not do before."""

from documents import (DOMAIN_KINDS, FLAGS, TOPIC_FLAGS, TOPIC_KINDS, domains_and_tags, read_governance)
from expressions import combinations
from protection import properties_of, shares

LEVELS = {"NONE": 0, "SIGN": 1, "ENCRYPT": 2}
ORIGIN = "_WITH_ORIGIN_AUTHENTICATION"
WEAKER, STRONGER = {"weaker", "wider"}, {"stronger", "narrower"}
COVERAGE = {(False, True): "wider", (True, False): "narrower"}
COVERED = {False: "uncovered", True: "covered"}
# The domain rule's kind that gives a topic's flag its effect.
EFFECT_OF_FLAG = {"enable_discovery_protection": "discovery_protection_kind",
                  "enable_liveliness_protection": "liveliness_protection_kind"}


def class_of(less, more):
    """Of a change that takes something away, gives something, or both."""
    return {(1, 0): "weaker", (0, 1): "stronger", (1, 1): "mixed", (0, 0): "neutral"}[less, more]


def kind_class(old, new):
    before, after = (LEVELS[kind.removesuffix(ORIGIN)] for kind in (old, new))
    origin_lost = old.endswith(ORIGIN) and not new.endswith(ORIGIN)
    origin_won = new.endswith(ORIGIN) and not old.endswith(ORIGIN)
    return class_of(after < before or origin_lost, after > before or origin_won)


def flag_class(name, new, old_domain, new_domain):
    if name == "allow_unauthenticated_participants":
        return "weaker" if new else "stronger"
    if name in EFFECT_OF_FLAG:
        deciding = new_domain if new else old_domain
        if deciding.values[EFFECT_OF_FLAG[name]] == "NONE":
            return "neutral"
    return "stronger" if new else "weaker"


def shown(value):
    return {True: "true", False: "false"}.get(value, value)


class Lines:
    """Every element that differs: (element, old, new, class) -> where, and what it has a part in."""

    def __init__(self):
        self.domains, self.lost, self.gained, self.example = {}, {}, {}, {}

    def add(self, line, ids, example):
        self.domains[line] = self.domains.get(line, 0) | ids
        self.example.setdefault(line, example)

    def add_shares(self, line, lost, gained):
        self.lost.setdefault(line, set()).update(lost)
        self.gained.setdefault(line, set()).update(gained)

    def verdict(self):
        classes = {line[3] for line in self.domains}
        if "mixed" in classes or (classes & WEAKER and classes & STRONGER):
            return "mixed"
        return "weaker" if classes & WEAKER else "stronger" if classes & STRONGER else "neutral"


def domain_pairs(old, new):
    """[(ids, tag, old rule, new rule)]: every pair of rules that decide somewhere; None: no rule."""
    rules = old + new
    pieces, tags, masks = domains_and_tags(rules)
    found = {}
    for ids in pieces:
        fitting = [i for i, rule in enumerate(rules) if rule.domains.ids & ids]
        for matched, tag in combinations(tags):
            first = next((i for i in fitting if i < len(old) and masks[i] & matched), None)
            second = next((i for i in fitting if i >= len(old) and masks[i] & matched), None)
            before, tag = found.get((first, second), (0, tag))
            found[first, second] = before | ids, tag
    return [(ids, tag, None if i is None else rules[i], None if j is None else rules[j])
            for (i, j), (ids, tag) in found.items()]


def topic_pairs(old_rules, new_rules):
    """[(name, old topic rule, new topic rule)]; None: no rule matches the name."""
    topics = tuple({rule.topic: None for rule in old_rules + new_rules})
    place = {topic: 1 << i for i, topic in enumerate(topics)}
    found = {}
    for matched, name in combinations(topics):
        pair = [next((i for i, rule in enumerate(rules) if place[rule.topic] & matched), None)
                for rules in (old_rules, new_rules)]
        found.setdefault(tuple(pair), name)
    return [(name, None if i is None else old_rules[i], None if j is None else new_rules[j])
            for (i, j), name in found.items()]


def changed_values(names, kinds, old, new, old_domain, new_domain):
    for name in names:
        if old.values[name] != new.values[name]:
            change = flag_class(name, new.values[name], old_domain, new_domain)
            yield name, shown(old.values[name]), shown(new.values[name]), change
    for name in kinds:
        if old.values[name] != new.values[name]:
            yield name, old.values[name], new.values[name], kind_class(old.values[name], new.values[name])


def changed_algorithms(old, new):
    for name in old.algorithms:
        before, after = old.algorithms[name], new.algorithms[name]
        if before != after:
            change = class_of(less=bool(after - before), more=bool(before - after))
            yield "allowed_crypto_algorithms/" + name, "", "", change


def add_shares(lines, lines_here, before, after):
    """before, after: (domain rule, topic rule)."""
    old, new = properties_of(*before), properties_of(*after)
    for line in lines_here if old != new else ():
        if not line[0].startswith("allowed"):
            lines.add_shares(line, shares(line[0], old - new, before, after),
                             shares(line[0], new - old, after, before))


def compare_rules(lines, ids, tag, old, new):
    """Of two domain rules that decide in the same place."""
    of_domain = list(changed_values(FLAGS, DOMAIN_KINDS, old, new, old, new))
    of_domain += changed_algorithms(old, new)
    for line in of_domain:
        lines.add(line, ids, (tag, None))
    for name, first, second in topic_pairs(old.topic_rules, new.topic_rules):
        here = []
        if first and second:
            here = list(changed_values(TOPIC_FLAGS, TOPIC_KINDS, first, second, old, new))
        elif first or second:
            covered = bool(first), bool(second)
            here = [("topic_rule", *(COVERED[side] for side in covered), COVERAGE[covered])]
        for line in here:
            lines.add(line, ids, (tag, name))
        if first and second and (of_domain or here):
            add_shares(lines, of_domain + here, (old, first), (new, second))


def compare(old, new):
    lines = Lines()
    for ids, tag, first, second in domain_pairs(old, new):
        if first and second:
            compare_rules(lines, ids, tag, first, second)
        elif first or second:
            covered = bool(first), bool(second)
            line = ("domain_rule", *(COVERED[side] for side in covered), COVERAGE[covered])
            lines.add(line, ids, (tag, None))
    return lines


def evaluate(old_xml, new_xml):
    return compare(read_governance(old_xml), read_governance(new_xml))

"""The product's answer to a pair of documents, held against the evaluator's."""

import governance_verdict
import permissions_verdict
import readings
import witnesses
from subjects import representatives


def ids_of(ranges):
    return sum((1 << last + 1) - (1 << first) for first, last in ranges)


def shown_ids(ids):
    return [i for i in range(231) if ids >> i & 1]


class Told:
    """The product's lines, joined where only the place or what it means differs."""

    def __init__(self, changes):
        self.domains, self.lost, self.gained = {}, {}, {}
        for change in changes:
            line = key_of(change)
            self.domains[line] = self.domains.get(line, 0) | ids_of(change["domains"])
            self.lost.setdefault(line, set()).update(change["lost"])
            self.gained.setdefault(line, set()).update(change["gained"])


def key_of(change):
    values = ("", "") if change["element"].startswith("allowed_crypto") else (change["old"], change["new"])
    return (change["element"], *values, change["class"])


def governance_complaints(answer, old_xml, new_xml):
    lines = governance_verdict.evaluate(old_xml, new_xml)
    if answer["verdict"] != lines.verdict():
        yield f"verdict: product {answer['verdict']}, evaluator {lines.verdict()}"
    told = Told(answer["changes"])
    for line in sorted(set(lines.domains) - set(told.domains)):
        yield f"line of the evaluator only: {line}, such as tag and topic {lines.example[line]}"
    for line in sorted(set(told.domains) - set(lines.domains)):
        yield f"line of the product only: {line}"
    for line in sorted(set(told.domains) & set(lines.domains)):
        if told.domains[line] != lines.domains[line]:
            yield (f"{line}: product in domains {shown_ids(told.domains[line])}, "
                   f"evaluator {shown_ids(lines.domains[line])}")
        for word, theirs, ours in (("lost", told.lost, lines.lost), ("gained", told.gained, lines.gained)):
            if theirs[line] != ours.get(line, set()):
                yield (f"{line}: {word}: product only {sorted(theirs[line] - ours.get(line, set()))}, "
                       f"evaluator only {sorted(ours.get(line, set()) - theirs[line])}")
    yield from witnesses.governance_complaints(answer["changes"], old_xml, new_xml)
    yield from readings.complaints(answer["readings"], old_xml, new_xml)


def word_of(classes):
    """The verdict that lines of these classes come to."""
    if len(classes) > 1:
        return "mixed"
    return next(iter(classes), "neutral")


def spelling_complaints(changes, deciding):
    """Lines about subjects that are only written differently."""
    told = {(change["old"], change["new"]) for change in changes if change["element"] == "subject_name"}
    together = {(old.subject_text, new.subject_text) for old, new in deciding
                if old and new and old.subject_text != new.subject_text and is_same(old, new)}
    apart = {(old.subject_text, new.subject_text) for old, _ in deciding for _, new in deciding
             if old and new and is_same(old, new)}
    yield from (f"subject of the evaluator only: {each}" for each in sorted(together - told))
    yield from (f"subject of the product only: {each}" for each in sorted(told - apart))


def is_same(old, new):
    return all(matched == 0b11 for matched, _ in representatives([old.subject, new.subject]))


def permissions_complaints(answer, old_xml, new_xml):
    verdict = permissions_verdict.evaluate(old_xml, new_xml)
    if answer["verdict"] != verdict.word():
        yield f"verdict: product {answer['verdict']}, evaluator {verdict.word()}"
        yield from (f"  wider: {decision}" for decision in verdict.wider[:3])
        yield from (f"  narrower: {decision}" for decision in verdict.narrower[:3])
    classes = {change["class"] for change in answer["changes"]} - {"neutral", "interop"}
    if word_of(classes) != answer["verdict"]:
        yield f"verdict {answer['verdict']} with lines {sorted(classes)}"
    yield from spelling_complaints(answer["changes"], verdict.deciding)
    yield from readings.complaints(answer["readings"], old_xml, new_xml)
    yield from witnesses.permissions_complaints(answer["changes"], old_xml, new_xml, verdict.deciding)


COMPLAINTS = {"governance": governance_complaints, "permissions": permissions_complaints}


def verdict_of(kind, old_xml, new_xml):
    if kind == "governance":
        return governance_verdict.evaluate(old_xml, new_xml).verdict()
    return permissions_verdict.evaluate(old_xml, new_xml).word()


def complaints(kind, answer, old_xml, new_xml):
    if "error" in answer:
        return [answer["error"]]
    return list(COMPLAINTS[kind](answer, old_xml, new_xml))

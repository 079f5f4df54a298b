"""Pairs of documents, each made anew from its kind, seed and number."""

import random
import xml.etree.ElementTree as ET
from xml.sax.saxutils import escape

import random_documents
from edits import edited, is_valid

ROOTS = {"governance": random_documents.governance, "permissions": random_documents.permissions}


def _respelled(rng, tree):
    """Seldom: what the product reads leniently. Blanks around values, TRUE and 1, an element to ignore."""
    for element in tree.iter():
        if len(element) == 0 and element.text and rng.random() < 0.02:
            element.text = rng.choice([" {} ", "\n  {}\n", "\t{}"]).format(element.text)
        if element.text in ("true", "false") and rng.random() < 0.03:
            element.text = rng.choice([element.text.upper(), "1" if element.text == "true" else "0"])
        if element.tag == "digital_signature_identity_trust_chain" and rng.random() < 0.3:
            element.tag = "digital_signature_trust_chain"  # as the text of 10.4.1.2.5.9.2 has it
        if element.tag in ("domain_rule", "grant") and rng.random() < 0.02:
            element.append(ET.Element("com_example_note", must_interpret="false"))


def _write(out, element):
    """As ElementTree.tostring does, in a fifth of its time."""
    attributes = "".join(f' {name}="{value}"' for name, value in element.items())
    out.append(f"<{element.tag}{attributes}>")
    out.append(escape(element.text or ""))
    for child in element:
        _write(out, child)
    out.append(f"</{element.tag}>{element.tail or ''}")


def text_of(rng, tree):
    if rng.random() < 0.1:
        _respelled(rng, tree)
    if rng.random() < 0.2:
        ET.indent(tree)
    out = []
    _write(out, tree)
    return "".join(out)


def pair(kind, seed, number):
    """(old document, new document) as XML text. One in thirty is two documents that share nothing."""
    rng = random.Random(f"{kind}:{seed}:{number}")
    make = ROOTS[kind]
    old = make(rng)
    while not is_valid(old):
        old = make(rng)
    new = edited(rng, old if rng.random() < 0.97 else make(rng))
    return text_of(rng, old), text_of(rng, new)

#!/usr/bin/env python3
"""Holds cli/schema and the lists of cli/results.md to the field lists of the results.

With --write as the last word, brings both up to date: tests/cli/results_test.py DDSSEC RESULTS --write
"""

import json
import pathlib
import re
import subprocess
import sys
import unittest

from member_lists import page_of

CLI = pathlib.Path(__file__).resolve().parent.parent.parent / "cli"
SCHEMA = CLI / "schema/ddssec-2.schema.json"
PAGE = CLI / "results.md"
WIDTH = 110


def shapes(program):
    """command -> its shape."""
    return json.loads(subprocess.run([program], capture_output=True, check=True, timeout=60).stdout)


def definitions(shapes_of):
    """$defs entry -> what the field lists make of it."""
    out = {}
    for command, shape in shapes_of.items():
        out.update(shape["definitions"], **{f"result of {command}": shape["schema"]})
    return out


def packed(value, indent):
    """JSON, on one line if it fits."""
    line = json.dumps(value, ensure_ascii=False)
    if len(line) + indent <= WIDTH or not isinstance(value, (dict, list)):
        return line
    pad = " " * (indent + 1)
    if isinstance(value, dict):
        rows = [f"{pad}{json.dumps(key)}: {packed(inner, indent + 1)}" for key, inner in value.items()]
        return "{\n" + ",\n".join(rows) + "\n" + " " * indent + "}"
    return "[\n" + ",\n".join(pad + packed(inner, indent + 1) for inner in value) + "\n" + " " * indent + "]"


def plain(schema):
    """The same without what only helps to read it."""
    if isinstance(schema, dict):
        return {key: sorted(inner) if key == "required" else plain(inner)
                for key, inner in schema.items() if key != "description" or not isinstance(inner, str)}
    return [plain(inner) for inner in schema] if isinstance(schema, list) else schema


def with_definition(text, name, value):
    """The schema file with another entry of $defs."""
    entry = re.compile(rf'^  {re.escape(json.dumps(name))}: (?:\{{.*\}}|\{{\n(?:   .*\n)*?  \}})(?=,?$)', re.M)
    found = entry.findall(text)
    assert len(found) == 1, f"{name}: {len(found)} entries of $defs"
    return entry.sub(lambda _: f"  {json.dumps(name)}: {packed(value, 2)}", text)


def sections(shapes_of):
    """What a heading of the page names -> the lists below it."""
    out = {}
    for command, shape in shapes_of.items():
        out[command] = page_of(shape["members"])
        out.update({f"{command}, each of `{name}`": page_of(members) for name, members in shape["rows"].items()})
    return out


def section_of(page, about):
    """The section of the page about the command, or a member: (heading, text below it); None: none or several."""
    def is_about(heading):
        return about in ([heading] if "`" in heading else heading.split(", "))
    found = [(heading, text) for heading, text in re.findall(r"^### (.*)\n\n((?:(?!#).*\n)*)", page, re.M) if is_about(heading)]
    return (found[0][0], found[0][1].rstrip("\n") + "\n") if len(found) == 1 else None


def write(shapes_of):
    text, page = SCHEMA.read_text(), PAGE.read_text()
    present = json.loads(text)["$defs"]
    for name, value in definitions(shapes_of).items():
        if name not in present:
            text = text.replace(' "$defs": {\n', f' "$defs": {{\n  {json.dumps(name)}: {packed(value, 2)},\n', 1)
        elif plain(present[name]) != plain(value):
            text = with_definition(text, name, value)
    for about, lists in sections(shapes_of).items():
        section = section_of(page, about)
        if section:
            page = page.replace(f"### {section[0]}\n\n{section[1]}", f"### {section[0]}\n\n{lists}")
        else:
            print(f"{about} needs one section of its own:\n\n### {about}\n\n{lists}")
    SCHEMA.write_text(text)
    PAGE.write_text(page)


class Results(unittest.TestCase):
    maxDiff = None

    def test_the_schema_is_that_of_the_field_lists(self):
        present = json.loads(SCHEMA.read_text())["$defs"]
        for name, value in definitions(SHAPES).items():
            with self.subTest(name):
                self.assertEqual(plain(present.get(name)), plain(value))

    def test_the_page_is_that_of_the_field_lists(self):
        page = PAGE.read_text()
        for about, lists in sections(SHAPES).items():
            with self.subTest(about):
                section = section_of(page, about)
                self.assertIsNotNone(section, "one section of cli/results.md")
                self.assertEqual(section[1], lists)


if __name__ == "__main__":
    if sys.argv[-1] == "--write":
        write(shapes(sys.argv[2]))
    else:
        SHAPES = shapes(sys.argv.pop(2))
        sys.argv.pop(1)
        unittest.main()

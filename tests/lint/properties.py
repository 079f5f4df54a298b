#!/usr/bin/env python3
"""The table of properties in docs/configuration.md has every property of plugins/spi/property_names.hpp
that configures a participant, and no other one of ddssec.

Exit 1 and a line for each property that only one of the two has.
"""

import pathlib
import re
import sys

CONSTANT = re.compile(r'constexpr std::string_view (k\w+)\s*=\s*"([^"]+)"')
LIST = re.compile(r"kOfParticipants\[\] = \{([^}]*)\}")
NAME = re.compile(r"`((?:org\.ddssec|org\.eclipse|dds\.sec)\.[\w.]+)`")


def of_code(text):
    values = dict(CONSTANT.findall(text.split("namespace ddssec::spi::class_id")[0]))
    return {values[name.strip()] for name in LIST.search(text).group(1).split(",")}


def of_table(text):
    """The names in the first column of the first table after the heading."""
    section = text.split("\n## Properties\n", 1)[1].split("\n#", 1)[0]
    rows = [line.split("|")[1] for line in section.splitlines() if line.startswith("|")]
    return {name for row in rows for name in NAME.findall(row)}


def main():
    root = pathlib.Path(sys.argv[1])
    code = of_code((root / "plugins/spi/property_names.hpp").read_text(encoding="utf-8"))
    table = of_table((root / "docs/configuration.md").read_text(encoding="utf-8"))
    lines = [f"docs/configuration.md: no row for the property {name}" for name in sorted(code - table)]
    lines += [f"docs/configuration.md: no such property in plugins/spi/property_names.hpp: {name}"
              for name in sorted(table - code)]
    print("\n".join(lines) if lines else f"each of {len(code)} properties has its row")
    return 1 if lines or not code else 0


if __name__ == "__main__":
    sys.exit(main())

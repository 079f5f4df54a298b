#!/usr/bin/env python3
"""Holds the version of CMakeLists.txt to CHANGELOG.md, and to what the documents and examples ask for.

- It is the newest released version of CHANGELOG.md, and that file's headings have the form of Keep a Changelog, the newest
  first, after [Unreleased]. A released version has at most 90 lines, so that users read it.
- README.md names it, and each find_package(ddssec ...) asks for its minor version.
- plugins/README.md shows it in the line by which a process says that our plugins are in use.

Exit 1 and a line for each fault.
"""

import datetime
import pathlib
import re
import subprocess
import sys

HEADING = re.compile(r"\[(\d+)\.(\d+)\.(\d+)\] - (\d{4}-\d{2}-\d{2})")
MAX_LINES = 90  # of a released version
PARTS = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}


def is_date(text):
    try:
        return bool(datetime.date.fromisoformat(text))
    except ValueError:
        return False


def changelog_faults(text, version):
    headings = re.findall(r"^## (.*)$", text, re.M)
    if headings[:1] != ["[Unreleased]"]:
        yield "the first section is not [Unreleased]"
    releases = [HEADING.fullmatch(heading) for heading in headings[1:]]
    for heading, release in zip(headings[1:], releases):
        if not release or not is_date(release[4]):
            yield f'"{heading}" is not of the form [1.2.3] - 2026-11-27'
    numbers = [tuple(map(int, release.groups()[:3])) for release in releases if release]
    if numbers != sorted(set(numbers), reverse=True):
        yield "the released versions do not stand in order, the newest first"
    newest = ".".join(map(str, numbers[0])) if numbers else "none"
    if newest != version:
        yield f"the newest released version is {newest}, and that of CMakeLists.txt is {version}"
    for section in re.split(r"^## ", text, flags=re.M)[2:]:
        if section.count("\n") > MAX_LINES:
            yield f"{section.splitlines()[0]} has {section.count(chr(10))} lines, {MAX_LINES} are allowed"
    for part in re.findall(r"^### (.*)$", text, re.M):
        if part not in PARTS:
            yield f'"{part}" is none of {", ".join(sorted(PARTS))}'


def asked_for(root):
    """(file, version) of each find_package(ddssec VERSION ...) that is tracked."""
    names = subprocess.run(["git", "-C", root, "ls-files", "*.md", "*CMakeLists.txt"], capture_output=True, text=True,
                           check=True).stdout.split()
    for name in names:
        text = (root / name).read_text(encoding="utf-8") if (root / name).is_file() else ""
        yield from ((name, version) for version in re.findall(r"find_package\(ddssec (\d[\d.]*)", text))


def sample_line_faults(text, version):
    """The line of the event plugins_in_use in plugins/README.md has the version."""
    shown = re.findall(r"cryptography of ddssec ([\d.]+);.*\[plugins_in_use", text)
    if shown != [version]:
        yield f"the sample line of plugins_in_use has {' and '.join(shown) or 'no version'}, and this is {version}"


def main():
    root = pathlib.Path(sys.argv[1])
    version = re.search(r"project\(ddssec VERSION (\d+\.\d+\.\d+)", (root / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
    minor = version.rpartition(".")[0]
    found = [f"CHANGELOG.md: {fault}"
             for fault in changelog_faults((root / "CHANGELOG.md").read_text(encoding="utf-8"), version)]
    if not re.search(rf"^Version {re.escape(version)}\.(\s|$)", (root / "README.md").read_text(encoding="utf-8"), re.M):
        found.append(f'README.md: no line begins with "Version {version}."')
    found += [f"plugins/README.md: {fault}"
              for fault in sample_line_faults((root / "plugins/README.md").read_text(encoding="utf-8"), version)]
    asking = list(asked_for(root))
    found += [f"{name}: it asks for ddssec {asked}, and this is {version}" for name, asked in asking if asked not in (minor, version)]
    if not asking:
        found.append("no find_package(ddssec VERSION) was found: this test looks at nothing")
    print("\n".join(found) if found else f"{version} everywhere")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Holds the version of CMakeLists.txt to CHANGELOG.md, and to what the documents and examples ask for.

- It is the newest released version of CHANGELOG.md, and that file's headings have the form of Keep a Changelog, the newest
  first, after [Unreleased].
- The section of a version with a tag is what it was in the tag. SHORTENED has those that were shortened after their
  release: they are what they were on 2026-11-30. The section of a version that has no tag yet has at most 90 lines, so
  that users read it. In a clone without tags neither is looked at, and the last line says so.
- README.md names it, and each find_package(ddssec ...) asks for its minor version.
- plugins/README.md shows it in the line by which a process says that our plugins are in use.

Exit 1 and a line for each fault.
"""

import datetime
import hashlib
import os
import pathlib
import re
import subprocess
import sys

HEADING = re.compile(r"\[(\d+)\.(\d+)\.(\d+)\] - (\d{4}-\d{2}-\d{2})")
MAX_LINES = 90  # of a version that is about to be released
SHORTENED = {  # the SHA-256 of their sections
    "0.3.0": "2dd79ec8547be36a37f0db3505c84347bbd32afcdfcd4718435d429c5bbdcbbc",
    "0.2.0": "085b18899ef7bb460d66d7b68bd5b0e3274e35f4d27dbef0c25d8cece8dcbcb6",
}
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
    for part in re.findall(r"^### (.*)$", text, re.M):
        if part not in PARTS:
            yield f'"{part}" is none of {", ".join(sorted(PARTS))}'


def git(root, *words):
    """What git prints; nothing if it fails."""
    return subprocess.run(["git", "-C", root, *words], capture_output=True, text=True, check=False).stdout


def sections(text):
    """{version: its section, with the heading and without empty lines at the end}"""
    found = re.findall(r"^(## \[(\d[\d.]*)\].*?)(?=^## |\Z)", text, re.M | re.S)
    return {version: section.rstrip() for section, version in found}


def released_faults(root, text, tags):
    """Faults of the sections of released versions, compared with their tags."""
    for version, section in sections(text).items():
        if version in SHORTENED:
            if hashlib.sha256(section.encode()).hexdigest() != SHORTENED[version]:
                yield f"[{version}] is released: its section is not edited any more"
        elif f"v{version}" in tags:
            if section != sections(git(root, "show", f"v{version}:CHANGELOG.md")).get(version):
                yield f"[{version}] is not what it was in the tag v{version}: a released section is not edited any more"
        elif tags and len(section.splitlines()) > MAX_LINES:
            yield f"[{version}] has {len(section.splitlines())} lines, {MAX_LINES} are allowed at a release"


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
    tags = git(root, "tag", "--list", "v*").split()
    found += [f"CHANGELOG.md: {fault}"
              for fault in released_faults(root, (root / "CHANGELOG.md").read_text(encoding="utf-8"), tags)]
    if not re.search(rf"^Version {re.escape(version)}\.(\s|$)", (root / "README.md").read_text(encoding="utf-8"), re.M):
        found.append(f'README.md: no line begins with "Version {version}."')
    found += [f"plugins/README.md: {fault}"
              for fault in sample_line_faults((root / "plugins/README.md").read_text(encoding="utf-8"), version)]
    asking = list(asked_for(root))
    found += [f"{name}: it asks for ddssec {asked}, and this is {version}" for name, asked in asking if asked not in (minor, version)]
    if not asking:
        found.append("no find_package(ddssec VERSION) was found: this test looks at nothing")
    if not tags and os.environ.get("DDSSEC_NEEDS_TAGS"):
        found.append("this clone has no tags, and DDSSEC_NEEDS_TAGS is set: fetch them with git fetch --tags")
    print("\n".join(found) if found else f"{version} everywhere")
    if not tags:
        print("this clone has no tags: released sections of CHANGELOG.md that were never shortened are not compared with them")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Holds every #include of ours to the arrows of the architecture. Exit 1 and a line each otherwise.
Usage: includes.py ROOT [--write]     --write makes the table of docs/architecture.md from the arrows."""

import pathlib
import re
import sys

# folder -> folders it may include (itself always). The longest matching folder counts.
ARROWS = {
    "base": [],
    "pki": ["base"],
    "governance": ["base", "pki"],
    "governance/compare": ["base", "pki", "governance"],
    "governance/doctor": ["base", "pki", "governance", "governance/compare"],
    "plugins/spi": ["base"],
    "plugins/authentication": ["base", "wire", "plugins/spi", "pki"],
    "plugins/access_control": ["base", "plugins/spi", "pki", "governance"],
    "plugins/cryptography": ["base", "wire", "plugins/spi"],
    "plugins/cyclonedds": ["base", "plugins", "wire"],
    "wire": ["base"],
    "rtps/budget": ["base", "wire"],
    "rtps/transport": ["base", "wire"],
    "rtps/memory": ["base", "wire"],
    "rtps/cdr": ["base", "wire"],
    "rtps/filter": ["base", "rtps/cdr"],
    "rtps/qos": ["base", "wire"],
    "rtps/types": ["base", "rtps/qos"],
    "rtps/reliability": ["base", "wire", "rtps/budget", "rtps/cdr", "rtps/qos", "rtps/transport"],
    "rtps/discovery": ["base", "wire", "plugins/spi", "rtps/cdr", "rtps/filter", "rtps/qos", "rtps/types"],
    "rtps/security": ["base", "wire", "plugins/spi", "rtps/budget", "rtps/cdr", "rtps/discovery",
                      "rtps/memory", "rtps/reliability"],
    "rtps/participant": ["base", "wire", "rtps/budget", "rtps/discovery", "rtps/qos", "rtps/reliability",
                         "rtps/security", "rtps/transport", "rtps/types"],
    "rtps/durability": ["base", "rtps/qos", "rtps/reliability"],
    "rtps/dcps": ["base", "wire", "rtps/cdr", "rtps/discovery", "rtps/durability", "rtps/filter", "rtps/participant",
                  "rtps/qos", "rtps/reliability", "rtps/security", "rtps/transport", "rtps/types"],
    "rtps/keeper": ["base", "rtps/dcps", "rtps/discovery", "rtps/durability", "rtps/participant"],
    "rtps/observer": ["base", "wire", "rtps/discovery", "rtps/security", "rtps/transport"],
    "secured": ["base", "pki", "rtps", "plugins/spi", "plugins/authentication",
                "plugins/access_control", "plugins/cryptography"],
    "programs": ["base", "pki", "rtps", "secured"],
    "idl": [],
    "cli/frame": ["base", "pki"],
    "cli/inputs": ["cli/frame", "base", "pki", "governance"],
    "cli/folders": ["cli/frame", "cli/inputs", "base", "pki"],
    "cli/documents": ["cli/frame", "cli/inputs", "base", "pki", "governance", "governance/doctor"],
    "cli/ca": ["cli/frame", "cli/inputs", "cli/folders", "cli/documents", "base", "pki", "governance",
               "governance/doctor"],
    "cli/participant": ["cli/frame", "cli/inputs", "cli/documents", "cli/ca", "base", "pki", "governance",
                        "governance/doctor"],
    "cli/agent": ["cli/frame", "cli/inputs", "cli/documents", "cli/ca", "cli/participant", "base", "pki", "governance"],
    "cli/diff": ["cli/frame", "cli/inputs", "cli/folders", "cli/documents", "base", "pki", "governance",
                 "governance/compare", "plugins/access_control"],
    "cli/doctor": ["cli/frame", "cli/inputs", "cli/documents", "cli/ca", "base", "pki", "governance",
                   "governance/doctor", "plugins/spi", "plugins/authentication", "plugins/access_control",
                   "plugins/cryptography", "secured"],
    "cli/explain": ["cli/frame", "base"],
    "cli/commands": ["cli/frame", "cli/inputs", "cli/folders", "cli/documents", "cli/ca", "cli/participant",
                     "cli/agent", "cli/diff", "cli/doctor", "cli/explain", "base", "pki", "governance",
                     "governance/compare", "governance/doctor", "plugins/spi", "wire", "rtps/observer"],
    "cli": ["cli/frame", "cli/inputs", "cli/agent", "cli/commands", "base", "pki"],
}

# libraries of others -> the folders whose headers may show them / whose sources may use them.
FOREIGN = {
    "openssl/": {".hpp": ["plugins/cryptography"],
                 ".cpp": ["base", "pki", "plugins/cryptography"]},
    "sodium": {".hpp": [], ".cpp": ["base", "plugins/cryptography"]},
    "intel-ipsec-mb": {".hpp": [], ".cpp": ["plugins/cryptography"]},
    "sqlite3": {".hpp": [], ".cpp": ["rtps/durability"]},
    "tinyxml2": {".hpp": ["governance"], ".cpp": ["governance"]},
    "dds/": {".hpp": ["plugins/cyclonedds"], ".cpp": ["plugins/cyclonedds"]},
}
# Headers that only their own folder's sources include may show what the sources use.
INTERNAL_HEADERS = {f"pki/{name}.hpp" for name in (
    "certificate_context", "mime", "openssl", "openssl_guards", "openssl_pointers", "pem_block", "pkcs11",
    "pki_access", "self_signed", "signing_time", "unverified_document")}

PAGE = "docs/architecture.md"
SECTION = "\n## Which folder may include which\n"

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]', re.M)


def folder_of(path):
    fits = [f for f in ARROWS if path == f or path.startswith(f + "/")]
    return max(fits, key=len, default=None)


def names(entry, folder):
    """Is the folder one that this entry of a list names: itself, or a part of something that is no folder of ARROWS?"""
    return folder == entry or entry not in ARROWS and folder.startswith(entry + "/")


def complaints(root, file):
    name = file.relative_to(root).as_posix()
    here = folder_of(name)
    for kind, target in INCLUDE.findall(file.read_text(encoding="utf-8")):
        if kind == '"':
            there = folder_of(target)
            if not (root / target).exists():
                yield f'{name}: "{target}" is not named from the root'
            elif there != here and not any(names(entry, there) for entry in ARROWS[here]):
                yield f"{name}: {here} may not include {there} ({target})"
            if target in INTERNAL_HEADERS and here != folder_of(target):
                yield f"{name}: {target} is internal to {folder_of(target)}"
        else:
            for library, allowed in FOREIGN.items():
                if not target.startswith(library) or name in INTERNAL_HEADERS:
                    continue
                if here not in allowed[file.suffix]:
                    yield f"{name}: {here} may not show or use <{target}> in a {file.suffix} file"


def circles():
    """The arrows themselves may not lead back to where they start."""
    def reached(folder, seen):
        for target in ARROWS[folder]:
            for other in (f for f in ARROWS if names(target, f)):
                if other != folder and other not in seen:
                    seen.add(other)
                    reached(other, seen)
        return seen
    return [f"{folder} leads back to itself" for folder in ARROWS if folder in reached(folder, set())]


def page_with_table(text):
    """The page with the arrows as the table of its section, up to the next heading."""
    rows = "".join(f"| `{folder}/` | {', '.join(f'`{target}`' for target in targets) or 'nothing of ddssec'} |\n"
                   for folder, targets in ARROWS.items())
    before, heading, after = text.partition(SECTION)
    head, line, rest = after.partition("|---|---|\n")
    return before + heading + head + line + rows + rest[re.match(r"(?:\|.*\n)*", rest).end():]


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    page = root / PAGE
    text = page.read_text(encoding="utf-8")
    if sys.argv[2:] == ["--write"]:
        page.write_text(page_with_table(text), encoding="utf-8")
        return 0
    files = [p for folder in ARROWS for p in (root / folder).glob("*.[ch]pp")]
    files += [p for folder in ARROWS for p in (root / folder).glob("*/*.[ch]pp")
              if folder_of(p.relative_to(root).as_posix()) == folder]
    found = [] if text == page_with_table(text) else [f"{PAGE}: the table differs from ARROWS: --write makes it"]
    found += circles() + [line for file in sorted(set(files)) for line in complaints(root, file)]
    print("\n".join(found) if found else f"{len(files)} files keep to the arrows")
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main())

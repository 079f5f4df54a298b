#!/usr/bin/env python3
"""Finds what the house style forbids and a machine can see. Exit 1 and a line each otherwise."""

import pathlib
import re
import sys

SOURCES = ["base", "idl", "pki", "governance", "plugins", "rtps", "secured", "cli", "programs",
           "examples"]
MOST_LINES = 500

RULES = [
    (re.compile(r"\bmemcmp\s*\("), "memcmp: secrets and MACs are compared by constant_time_equal",
     lambda name: True),
    (re.compile(r"\b[A-Z][A-Z0-9_]*_free\s*\("), "a free by hand: use the handle types",
     lambda name: not name.startswith(("base/", "pki/"))),
    (re.compile(r"\breinterpret_cast\b"), "reinterpret_cast outside the C ABI and the transports",
     lambda name: not name.startswith(("plugins/cyclonedds/", "rtps/transport/", "base/bytes.hpp",
                                       "pki/", "plugins/cryptography/"))),
    (re.compile(r"\b(TODO|FIXME|XXX)\b"), "a left-over mark", lambda name: True),
    (re.compile(r"(?<!std::)\bget_[a-z]"), "get_ says nothing: name what it is",
     lambda name: not name.startswith("plugins/cyclonedds/")),
    (re.compile(r"\bthrow\b"), "we throw nothing", lambda name: True),
    (re.compile(r"\bstd::j?thread\s*[({]|\bpthread_create\b|\bstd::async\b"),
     "a thread that takes the host's signals: use start_background_thread",
     lambda name: not name.startswith("base/background_thread.")),
    (re.compile(r"\b(PKCS7_(verify|dataDecode|dataVerify|signatureVerify)|CMS_(verify|SignerInfo_verify\w*))\s*\("),
     "OpenSSL reads a signature unguarded: use pki/openssl_guards.hpp",
     lambda name: name != "pki/openssl_guards.cpp"),
    (re.compile(r"\bX509_check_purpose\s*\("),
     "OpenSSL reads extensions that check_distribution_points may not have seen",
     lambda name: name != "pki/certificate.cpp"),
]


def code_only(line):
    return re.sub(r'"(\\.|[^"\\])*"', '""', line).split("//")[0]


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    files = [p for folder in SOURCES for p in sorted((root / folder).rglob("*"))
             if p.suffix in (".cpp", ".hpp", ".c", ".h")]
    found = []
    for file in files:
        name = file.relative_to(root).as_posix()
        lines = file.read_text(encoding="utf-8").splitlines()
        if len(lines) > MOST_LINES:
            found.append(f"{name}: {len(lines)} lines; is it one thing?")
        for number, line in enumerate(lines, 1):
            for pattern, why, applies in RULES:
                if applies(name) and pattern.search(code_only(line)):
                    found.append(f"{name}:{number}: {why}")
    print("\n".join(found) if found else f"{len(files)} files have the shape they should")
    return 1 if found or not files else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""A header that defines exactly one type has the type's name, or its plural if it is about many: `class EventLoop` is in event_loop.hpp,
`struct QosPreset` may be in presets.hpp. Other headers stand in type_names_exceptions.txt, with the reason. That list may only
shrink: an exception that is not needed any more is an error, too. Exit 1 and a line for each fault."""

import pathlib
import re
import sys

FOLDERS = ("base", "wire", "pki", "governance", "plugins", "rtps", "secured", "cli", "programs")
EXCEPTIONS = "tests/lint/type_names_exceptions.txt"
MAX_EXCEPTIONS = 35  # lower it with each line that goes
TYPE = re.compile(r"^(?:template ?<.*>\s)?(?:enum class|enum|class|struct)\s+(?:\[\[\w+\]\]\s*)?(?:alignas\(\w+\)\s*)?"
                  r"([A-Z]\w+)\b(?!\s*;)[^;{]*(?:\{|$)|^using ([A-Z]\w+) =", re.M)


def types_in(text):
    return [one or alias for one, alias in TYPE.findall(text)]


def fits(stem, name):
    """Without underscores and case: AckNack is in acknack.hpp. A plural may be short: QosPreset is in presets.hpp."""
    file, kind = stem.replace("_", ""), name.lower()
    return file == kind or (kind + "s").endswith(file) or re.sub("y$", "ies", kind) == file


def exceptions(path):
    """The headers of the list, and a line for each without a reason."""
    rows = [line.partition(": ") for line in path.read_text(encoding="utf-8").splitlines()
            if line and not line.startswith("#")]
    return [name for name, _, _ in rows], [f"{EXCEPTIONS}: {name}: no reason" for name, _, why in rows if not why.strip()]


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    excepted, found = exceptions(root / EXCEPTIONS)
    headers = [p for folder in FOLDERS for p in sorted((root / folder).rglob("*.hpp"))]
    unfit = {}
    for path in headers:
        names = types_in(path.read_text(encoding="utf-8"))
        if len(names) == 1 and not fits(path.stem, names[0]):
            unfit[path.relative_to(root).as_posix()] = names[0]
    found += [f"{name}: its only type is {kind}: give both one name" for name, kind in unfit.items() if name not in excepted]
    found += [f"{EXCEPTIONS}: {name}: needs no exception" for name in excepted if name not in unfit]
    if len(excepted) != MAX_EXCEPTIONS:
        found.append(f"{EXCEPTIONS} has {len(excepted)} entries, and MAX_EXCEPTIONS is {MAX_EXCEPTIONS}: lower it")
    print("\n".join(found) if found else f"{len(headers)} headers have the names of their types, {len(excepted)} with a reason do not")
    return 1 if found or not headers else 0


if __name__ == "__main__":
    sys.exit(main())

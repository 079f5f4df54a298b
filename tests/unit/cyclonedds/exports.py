#!/usr/bin/env python3
"""Checks what a plugin library exports, and that it destroys nothing at exit() while threads still use it.

Usage: exports.py LIBRARY ENTRY_POINT...   Exit 1 and a line for each complaint.
"""

import subprocess
import sys


def lines(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()


def main():
    library, *entry_points = sys.argv[1:]
    exported = {line.split()[-1] for line in lines("nm", "-D", "--defined-only", library)}
    imported = {line.split()[-1].split("@")[0] for line in lines("nm", "-D", "--undefined-only", library)}
    needed = [line.split()[-1] for line in lines("objdump", "-p", library) if "NEEDED" in line]
    complaints = []
    if exported != set(entry_points):
        complaints.append(f"exports {sorted(exported)}, not {sorted(entry_points)}")
    complaints += [f"needs {name}" for name in needed if "dds" in name]
    complaints += [f"registers a destructor with {name}: use NeverDestroyed (base/never_destroyed.hpp)"
                   for name in ("__cxa_atexit", "atexit", "on_exit") if name in imported]
    print("\n".join(complaints) if complaints else f"{library}: {', '.join(sorted(exported))}")
    return 1 if complaints or not needed else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Installs the headers and compiles the public ones with nothing else of ddssec in reach: all of them, first to last and
last to first; with --alone, each as the only #include of a file. The installed headers must be those of the lists in
cmake/public_headers.cmake, and no others.
Usage: headers_test.py SOURCE BUILD [--alone]"""

import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "lint"))
from public_headers import lists  # noqa: E402

COMPILE = [os.environ.get("CXX", "c++"), "-std=c++23", "-fsyntax-only", "-Wall", "-Wextra", "-Wconversion", "-Wshadow",
           "-Werror", "-x", "c++", "-"]


def refusal(include, headers):
    """What the compiler says of a file that includes the headers; empty if it compiles."""
    lines = "".join(f"#include <{header}>\n" for header in headers)
    run = subprocess.run([*COMPILE, f"-I{include}"], input=lines, capture_output=True, text=True)
    return "" if run.returncode == 0 else f"<{headers[0]}> first: does not compile:\n{run.stderr}"


def main():
    source, build = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    is_alone = sys.argv[3:] == ["--alone"]
    of_cmake = lists((source / "cmake/public_headers.cmake").read_text(encoding="utf-8"))
    public, carried = of_cmake["DDSSEC_PUBLIC_HEADERS"], of_cmake["DDSSEC_CARRIED_HEADERS"]
    with tempfile.TemporaryDirectory() as prefix:
        subprocess.run(["cmake", "--install", build, "--component", "dev", "--prefix", prefix], check=True,
                       stdout=subprocess.DEVNULL)
        include = pathlib.Path(prefix) / "include/ddssec"
        installed = {path.relative_to(include).as_posix() for path in include.rglob("*") if path.is_file()}
        found = [f"installed, but in no list: {name}" for name in sorted(installed - {*public, *carried})]
        found += [f"in a list, but not installed: {name}" for name in sorted({*public, *carried} - installed)]
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            files = [[header] for header in public] if is_alone else [public, public[::-1]]
            found += filter(None, pool.map(lambda headers: refusal(include, headers), files))
    print("\n".join(found) if found else f"{len(public)} public headers compile in {len(files)} files, "
          f"with {len(carried)} others in reach")
    return 1 if found or not public else 0


if __name__ == "__main__":
    sys.exit(main())

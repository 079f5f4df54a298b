#!/usr/bin/env python3
"""Does what a page of docs/ says with the installed package: writes the files of its blocks, then runs its commands.
A block that begins ```LANGUAGE FILE is a part of FILE, one that begins ```sh is run; there are no others.
Usage: page_test.py PAGE BUILD LINE ...     each LINE must be a part of the output"""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

PATIENCE = 200  # seconds for all commands, compilers included
BLOCK = re.compile(r"^```(\S+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def write_files(page, folder):
    """The commands that are left."""
    commands = []
    for language, name, text in BLOCK.findall(page):
        if name:
            with open(folder / name, "a", encoding="utf-8") as file:
                file.write(text)
        elif language == "sh":
            commands.append(text)
        else:
            sys.exit(f"a block of {language} is no file and no command: it would not be tested")
    return "".join(commands)


def run(commands, folder, installed):
    """Exit code and output; whatever the commands have started is ended."""
    process = subprocess.Popen(["bash", "-euo", "pipefail", "-xc", commands], cwd=folder, text=True,
                               env={**os.environ, "installed": str(installed), "CMAKE_GENERATOR": "Ninja"},
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    try:
        output, _ = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        output = process.communicate()[0] + f"\nnot done after {PATIENCE} s"
    return process.returncode, output


def main():
    page, build, *lines = sys.argv[1:]
    with tempfile.TemporaryDirectory() as scratch:
        top = pathlib.Path(scratch)
        subprocess.run(["cmake", "--install", build, "--prefix", top / "installed"], check=True,
                       stdout=subprocess.DEVNULL)
        (top / "project").mkdir()
        commands = write_files(pathlib.Path(page).read_text(encoding="utf-8"), top / "project")
        code, output = run(commands, top / "project", top / "installed")
    print(output)
    missing = [line for line in lines if line not in output]
    for line in missing:
        print(f"the output lacks: {line}")
    return 1 if code != 0 or missing else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Does what a page of docs/ says with the installed package: writes files and runs commands, block by block in the
order of the page, so that a block that needs a later one fails. A block that begins ```LANGUAGE FILE is a part of FILE,
one that begins ```sh is run; there are no others. Then the page's writer and reader run on two hosts (network
namespaces joined by a veth pair), each with its own folder alone.
Usage: page_test.py PAGE BUILD LINE ...     each LINE must be a part of the output"""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop_rtps"))
from two_hosts_test import Ethernet  # noqa: E402

PATIENCE = 200  # seconds for all commands, compilers included
MEETING = 30    # seconds for two hosts
BLOCK = re.compile(r"^```(\S+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def commands_of(page, blocks):
    """One script. The files' blocks lie in a folder of their own, and the script appends each in its turn."""
    commands = []
    for number, (language, name, text) in enumerate(BLOCK.findall(page)):
        if name:
            (blocks / str(number)).write_text(text, encoding="utf-8")
            commands.append(f"cat {blocks / str(number)} >> {name}\n")
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


def host_folder(project, top, program, participant):
    """What a host is given: a program and its participant's folder."""
    folder = top / program
    shutil.copytree(project / "demo" / participant, folder / "demo" / participant)
    shutil.copy(project / "build" / program, folder)
    return folder


def run_on_two_hosts(project, top):
    """What both programs print."""
    try:
        ethernet = Ethernet()
    except (RuntimeError, subprocess.CalledProcessError) as refusal:
        return f"SKIPPED: no two hosts can be made here: {refusal}"
    processes = []
    try:
        for host, program, participant in zip(ethernet.hosts, ("reader", "writer"), ("listener", "talker")):
            processes.append(subprocess.Popen(host.enter([f"./{program}"]), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                              cwd=host_folder(project, top, program, participant), text=True))
        return "".join(f"on its own host: {line}\n" for process in processes
                       for line in process.communicate(timeout=MEETING)[0].splitlines())
    finally:
        for process in processes:
            process.kill()
        ethernet.close()


def main():
    page, build, *lines = sys.argv[1:]
    with tempfile.TemporaryDirectory() as scratch:
        top = pathlib.Path(scratch)
        subprocess.run(["cmake", "--install", build, "--prefix", top / "installed"], check=True,
                       stdout=subprocess.DEVNULL)
        for folder in ("project", "blocks"):
            (top / folder).mkdir()
        commands = commands_of(pathlib.Path(page).read_text(encoding="utf-8"), top / "blocks")
        code, output = run(commands, top / "project", top / "installed")
        if code == 0:
            output += run_on_two_hosts(top / "project", top)
    print(output)
    if "SKIPPED: no two hosts" in output:
        lines = [line for line in lines if not line.startswith("on its own host")]
    missing = [line for line in lines if line not in output]
    for line in missing:
        print(f"the output lacks: {line}")
    return 1 if code != 0 or missing else 0


if __name__ == "__main__":
    sys.exit(main())

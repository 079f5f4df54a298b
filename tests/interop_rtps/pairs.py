#!/usr/bin/env python3
"""Runs the embedded participant against itself, Cyclone DDS and Fast DDS, each pair alone on a
loopback of its own, and holds them to their outcomes. Usage: pairs.py BUILD [FILTER]"""

import concurrent.futures
import pathlib
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
import fields  # noqa: E402
from pair import Namespace  # noqa: E402

OURS, CYCLONE, FAST = "embedded_peer", "cyclone_peer", "fastdds_peer"
PAIRS = [(OURS, OURS), (OURS, CYCLONE), (CYCLONE, OURS), (OURS, FAST), (FAST, OURS)]
# name, arguments of the publisher, of the subscriber, exit codes of both
CASES = [
    ("small", [], [], (0, 0)),
    ("fragments", ["--payload", "200000"], ["--payload", "200000"], (0, 0)),
    ("partition", ["--partition", "room1"], ["--partition", "room*"], (0, 0)),
    ("other partition", ["--partition", "a"], ["--partition", "b"], (4, 4)),
    ("other topic", ["--topic", "A"], ["--topic", "B"], (4, 4)),
]
TIMEOUT = 8
# Packets come to the capture in order: once this one is in its file, all before it are.
LAST_PACKET = b"the capture's last packet"
# What the vendors' libraries say when they cannot read us.
COMPLAINTS = ("malformed", "Malformed")


def send_last_packet(space):
    script = f"import socket; socket.socket(type=socket.SOCK_DGRAM).sendto({LAST_PACKET!r}, ('127.0.0.1', 9))"
    subprocess.run(space.enter([sys.executable, "-c", script]), check=True)


class Capture:
    """tshark on the namespace's loopback; `faults` are the packets it calls malformed."""

    def __init__(self, space, path):
        self.space, self.path = space, path
        self.process = subprocess.Popen(
            space.enter(["tshark", "-q", "-i", "lo", "-w", str(path)]),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        # It says "Capturing" before it does; its file comes after.
        while not path.exists() and self.process.poll() is None:
            time.sleep(0.01)

    def _packets(self, display_filter):
        read = subprocess.run(["tshark", "-r", str(self.path), "-Y", display_filter, "-T", "fields",
                               "-e", "frame.number", "-e", "rtps.sm.id"],
                              capture_output=True, text=True, check=False)
        return read.stdout.splitlines()

    def faults(self, topics):
        send_last_packet(self.space)
        end = time.monotonic() + TIMEOUT
        while LAST_PACKET not in self.path.read_bytes() and time.monotonic() < end:
            time.sleep(0.02)
        self.process.terminate()
        self.process.wait()
        faults = [] if LAST_PACKET in self.path.read_bytes() else ["the capture lacks its last packet"]
        faults += [f"tshark calls packet {line} malformed" for line in self._packets("_ws.malformed")]
        # The submessages that every pair must have exchanged, so that "no fault" means something.
        for kind, name in ((0x15, "DATA"), (0x07, "HEARTBEAT"), (0x06, "ACKNACK")):
            if not self._packets(f"rtps.vendorId == 0x01d5 && rtps.sm.id == {kind}"):
                faults.append(f"the capture holds no {name} of ours")
        return faults + fields.faults_in(self.path, topics)


def start(space, build, peer, role, arguments, log):
    command = [str(build / "bin" / peer), role, "--plain", "--timeout", str(TIMEOUT), *arguments]
    return subprocess.Popen(space.enter(command), stdin=subprocess.DEVNULL, stdout=log, stderr=log)


def topic_of(arguments):
    return arguments[arguments.index("--topic") + 1] if "--topic" in arguments else "Square"


def run(build, pair, case, folder):
    publisher, subscriber = pair
    _, publish, subscribe, expected = case
    space = Namespace()
    logs = [open(folder / f"{end}.log", "w+", encoding="utf-8", errors="replace")
            for end in ("publisher", "subscriber")]
    faults = []
    capture = Capture(space, folder / "capture.pcapng") if case[0] != "fragments" else None
    ends = [start(space, build, subscriber, "--subscribe", subscribe, logs[1]),
            start(space, build, publisher, "--publish", publish, logs[0])]
    try:
        codes = (ends[1].wait(TIMEOUT + 10), ends[0].wait(TIMEOUT + 10))
        if codes != expected:
            faults.append(f"exit codes {codes}, expected {expected}")
    except subprocess.TimeoutExpired:
        faults.append("a peer hung")
        for end in ends:
            end.kill()
            end.wait()
    if capture is not None:
        ends_of_ours = [arguments for peer, arguments in zip(pair, (publish, subscribe)) if peer == OURS]
        faults += capture.faults({topic_of(arguments) for arguments in ends_of_ours})
    space.close()
    for log in logs:
        log.seek(0)
        text = log.read()
        faults += [f"{log.name}: {line}" for line in text.splitlines()
                   if any(word in line for word in COMPLAINTS)]
        log.close()
    return faults


def tried(build, pair, case):
    """The case's name and its faults."""
    with tempfile.TemporaryDirectory() as folder:
        return f"{case[0]}: {pair[0]} > {pair[1]}", run(build, pair, case, pathlib.Path(folder))


def main():
    build, wanted = pathlib.Path(sys.argv[1]).resolve(), (sys.argv[2:] or [""])[0]
    chosen = [(pair, case) for pair in PAIRS for case in CASES
              if wanted in f"{case[0]}: {pair[0]} > {pair[1]}"]
    failed = 0
    # They mostly wait.
    with concurrent.futures.ThreadPoolExecutor(max_workers=4) as pool:
        for name, faults in pool.map(lambda chosen: tried(build, *chosen), chosen):
            print(f"{'FAILED' if faults else 'ok':8}{name}", flush=True)
            for fault in faults[:5]:
                print("        " + fault)
            failed += bool(faults)
    return 1 if failed or not chosen else 0


if __name__ == "__main__":
    sys.exit(main())

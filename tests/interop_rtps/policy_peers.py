"""The policy peers of the three stacks, and what a case asks them."""

import itertools
import subprocess
import sys
import time

OURS, CYCLONE, FAST = "embedded", "cyclone", "fastdds"
ALL = OURS, CYCLONE, FAST
# A reader of Fast DDS is not told, and believes that it matched.
NOT_FAST = OURS, CYCLONE
PATIENCE = 10.0  # seconds until what must happen has happened


class Peer:
    """One stack's policy peer: commands in, answers out."""

    def __init__(self, space, build, kind, log, *options):
        self.kind = kind
        self.process = subprocess.Popen(space.enter([str(build / "bin" / f"policy_{kind}"), *options]), text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log)
        if self.process.stdout.readline().strip() != "ready":
            raise RuntimeError(f"policy_{kind} did not start")

    def ask(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline().strip()
        if answer in ("refused", "unknown command", ""):
            raise AssertionError(f"{self.kind}: {command}: {answer or 'gone'}")
        return answer

    def status(self, endpoint):
        return {key: int(value) for key, value in
                (word.split("=") for word in self.ask(f"status {endpoint}").split()[1:])}

    def take(self, endpoint):
        return self.ask(f"take {endpoint}").split()[1:]

    def close(self):
        self.process.stdin.close()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise AssertionError(f"policy_{self.kind} hung at its end") from None
        finally:
            self.process.stdout.close()


class Case:
    """What the scenarios are written in: `w` and `r` are the writer's and the reader's side; the
    generators yield how many seconds to wait."""

    def __init__(self, writer, reader, name, space):
        self.w, self.r, self.space = writer, reader, space
        self.name = f"{name}: {writer.kind} > {reader.kind}"
        self.topic = "".join(c if c.isalnum() else "_" for c in self.name)
        self.endpoints = itertools.count()
        self.got = {}

    def writer(self, policies="", topic=""):
        endpoint = f"{self.topic}_{next(self.endpoints)}"
        self.w.ask(f"writer {endpoint} {self.topic}{topic} {policies}")
        return endpoint

    def reader(self, policies="", topic=""):
        endpoint = f"{self.topic}_{next(self.endpoints)}"
        self.r.ask(f"reader {endpoint} {self.topic}{topic} {policies}")
        return endpoint

    def until(self, what, ready):
        end = time.monotonic() + PATIENCE
        while not ready():
            if time.monotonic() > end:
                raise AssertionError(f"never {what}")
            yield 0.05

    def matched(self, writer, reader, readers=1, writers=1):
        yield from self.until("matched", lambda: self.w.status(writer)["matched"] == readers and
                              self.r.status(reader)["matched"] == writers)

    def pair(self, offered="", requested=None):
        """A matched writer and reader."""
        writer = self.writer(offered)
        reader = self.reader(offered if requested is None else requested)
        yield from self.matched(writer, reader)
        return writer, reader

    def collect(self, reader):
        self.got.setdefault(reader, []).extend(self.r.take(reader))
        return self.got[reader]

    def comes(self, reader, *expected):
        """Exactly these samples come; what came is forgotten."""
        yield from self.until(f"exactly {expected}, but {self.got.get(reader)}",
                              lambda: len(self.collect(reader)) >= len(expected))
        came = self.got.pop(reader)
        if came != list(expected):
            raise AssertionError(f"expected {expected}, came {came}")

    def check(self, what, is_so):
        if not is_so:
            raise AssertionError(what)

    def packets_with(self, text):
        """Says the traffic class of each IPv4 packet on the loopback that holds the text."""
        program = ("import socket, sys\n"
                   "s = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))\n"
                   "print('ready', flush=True)\n"
                   "while True:\n"
                   "    packet = s.recv(65535)\n"
                   "    if sys.argv[1].encode() in packet: print(packet[1], flush=True)\n")
        seen = subprocess.Popen(self.space.enter([sys.executable, "-c", program, text]), text=True,
                                stdout=subprocess.PIPE)
        self.check("no packets", seen.stdout.readline() == "ready\n")
        return seen

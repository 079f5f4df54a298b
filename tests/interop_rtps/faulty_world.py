"""Peers with a faulty link between them, or on one loopback: each runs in the background and says
what it saw."""

import pathlib
import subprocess
import sys
import threading
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
from documents import DOMAIN, TOPIC, Keys, Side  # noqa: E402
from pair import Namespace, Programs  # noqa: E402
from scenarios import GOVERNANCES  # noqa: E402

ADDRESSES = tuple(f"10.80.0.{n}" for n in range(1, 51))
# Each way. The 30 % are of IP packets; the devices take whole RTPS messages (65,535 octets).
FAULTS = "loss 0.3 duplicate 0.1 delay 0.3 25"


class Link:
    """Namespaces and the program that carries packets between them."""

    def __init__(self, build, seed, ends=2):
        self.spaces = [Namespace()]
        self.spaces += [Namespace(beside=self.spaces[0]) for _ in range(ends - 1)]
        program = [str(build / "bin" / "faulty_link"), str(seed), *(space.path for space in self.spaces)]
        self._process = subprocess.Popen(self.spaces[0].enter(program), text=True,
                                         stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                         stderr=subprocess.PIPE)
        if self._process.stdout.readline() != "ready\n":
            reason = self._process.stderr.read().strip()
            self.close()
            raise RuntimeError(f"cannot make a link of {ends} tun devices: {reason}; run this as root "
                               "where /dev/net/tun is")
        for space, own in zip(self.spaces, ADDRESSES):
            setup = (f"ip addr add {own}/24 dev link0 && "
                     "ip link set link0 up multicast on mtu 65535 txqueuelen 10000 && "
                     "ip route replace 224.0.0.0/4 dev link0")
            subprocess.run(space.enter(["sh", "-c", setup]), check=True)

    def do(self, command):
        print(command, file=self._process.stdin, flush=True)
        answer = self._process.stdout.readline().strip()
        if answer != "ok":
            raise RuntimeError(f"faulty_link answers {answer!r} to {command!r}")

    def taken(self):
        """How many messages it has lost or held by "lose" or "hold"."""
        print("taken", file=self._process.stdin, flush=True)
        return int(self._process.stdout.readline())

    def close(self):
        """What the link did, for a report."""
        did, _ = self._process.communicate()
        for space in self.spaces:
            space.close()
        return did.replace("\n", "; ")


class Loopback:
    """Both ends on one loopback."""

    def __init__(self):
        self.spaces = [Namespace()] * 2

    def close(self):
        self.spaces[0].close()
        return ""


class Peer:
    """A running peer; `samples` are the indexes it received with their times."""

    def __init__(self, command, environment, log):
        self.samples, self.said = [], []
        self._news = threading.Condition()
        with open(log, "ab") as errors:
            errors.write((" ".join(command) + "\n").encode())
            errors.flush()
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, env=environment,
                                            stdout=subprocess.PIPE, stderr=errors, text=True)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            word, *rest = line.split()
            with self._news:
                if word == "sample" and len(rest) == 2:
                    self.samples.append((time.monotonic(), int(rest[0])))
                else:
                    self.said.append((time.monotonic(), line.strip()))
                self._news.notify_all()
        with self._news:
            self.said.append((time.monotonic(), "end"))
            self._news.notify_all()

    def numbers(self):
        return [number for _, number in self.samples]

    def times(self, word, since=0.0):
        """When it said something that begins with `word`."""
        return [at for at, line in self.said if at >= since and line.startswith(word)]

    def wait(self, condition, seconds):
        """The seconds until condition(self), or None if it did not come."""
        begin = time.monotonic()
        with self._news:
            came = self._news.wait_for(lambda: condition(self), seconds)
        return time.monotonic() - begin if came else None

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self._reader.join()
        self.process.stdout.close()


class World:
    """Starts peers of the kinds embedded, stock and fast at the two ends of a link or loopback."""

    def __init__(self, build, folder, network, pki):
        self.network, self.pki = network, pki
        self._folder = pathlib.Path(folder)
        self._programs = Programs(str(build / "bin"), str(build / "dropin"), str(folder))
        self._peers = []
        self.starter = 0  # the end whose identity starts the handshake
        self.governance = GOVERNANCES["sros2"]

    def start(self, kind, role, options, secured=False):
        """role: "publish" (the first end, who starts the handshake) or "subscribe"."""
        end = 0 if role == "publish" else 1
        linked = isinstance(self.network, Link)
        addresses = ["--address", ADDRESSES[end], "--peer", ADDRESSES[1 - end]] if linked else []
        documents = ["--plain"]
        if secured:
            documents = Side(governance=self.governance).arguments(self.pki, Keys(), end == self.starter)
        command = [*self._programs.command(kind), f"--{role}", "--topic", TOPIC, "--domain",
                   str(DOMAIN), *addresses, *documents, *map(str, options)]
        peer = Peer(self.network.spaces[end].enter(command), self._programs.environment(kind),
                    self._folder / f"{role}.log")
        self._peers.append(peer)
        return peer

    def close(self):
        for peer in self._peers:
            peer.kill()
        return self.network.close()

    def logs(self):
        lines = []
        for path in sorted(self._folder.glob("*.log")):
            text = path.read_text(errors="replace").splitlines()
            lines += [f"  {path.stem}: {line[:300]}" for line in text[:1] + text[1:][-8:]]
        return "\n".join(lines)

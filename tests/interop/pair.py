"""Runs one pair of peers in a network namespace of its own and says what happened."""

import functools
import os
import select
import selectors
import signal
import subprocess
import time
from dataclasses import dataclass, field

from documents import DOMAIN, TOPIC
from scenarios import CUT, DATA, EXPIRY_SECONDS, HALF, MATCHED, NONE, PARTIAL, REFUSED

SAMPLES = 10
POSITIVE_LIMIT = 15.0   # seconds a pair that should exchange data may take
NEGATIVE_LIMIT = 3.0    # seconds after both were created until "nothing came" is believed
CREATION_LIMIT = 12.0   # seconds until both must have been created or refused
SETUP_LIMIT = 60.0      # seconds until a network namespace must be there
STOP_LIMIT = 4.0        # seconds from SIGTERM to SIGKILL
SILENCE = 2.5           # seconds without a sample after which a flow (10 samples/s) is cut
CUT_LIMIT = EXPIRY_SECONDS + 15.0  # seconds a flow may take to be cut, SILENCE not counted

CRASHED, HUNG, SILENT = "crashed", "hung", "silent"
CIPHER_VARIABLE = "DDSSEC_SYMMETRIC_CIPHER_ALGORITHM"


class Namespace:
    """A network namespace with a loopback interface, held by a sleeping process."""

    SETUP = ("ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"
             " && echo ready && exec sleep 900")

    def __init__(self, beside=None):
        """`beside`: a namespace of the same owner, so that one process may enter both."""
        self.as_root = os.geteuid() == 0
        unshare = (["unshare", "-n"] if self.as_root else beside.enter(["unshare", "-n"]) if beside
                   else ["unshare", "-rn"])
        self._holder = subprocess.Popen([*unshare, "sh", "-c", self.SETUP], text=True,
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE)
        if not self._is_ready():
            self._holder.kill()  # otherwise it may keep stderr open while it sleeps
            reason = self._holder.stderr.read().strip()
            self.close()
            raise RuntimeError(f"cannot make a network namespace: {reason}; run this as root, "
                               "or allow user namespaces (sysctl kernel.unprivileged_userns_clone)")

    def _is_ready(self):
        return (select.select([self._holder.stdout], [], [], SETUP_LIMIT)[0]
                and self._holder.stdout.readline().strip() == "ready")

    @property
    def path(self):
        return f"/proc/{self._holder.pid}/ns/net"

    def enter(self, command):
        """The command line that runs `command` inside; its process id is the command's."""
        user = [] if self.as_root else ["-U", "--preserve-credentials"]
        return ["nsenter", "-t", str(self._holder.pid), *user, "-n", *command]

    @property
    def pid(self):
        """A process that lives in it."""
        return self._holder.pid

    def run(self, command):
        """Runs a command inside to its end."""
        subprocess.run(self.enter(command.split()), check=True, stdout=subprocess.DEVNULL)

    def close(self):
        self._holder.kill()
        self._holder.wait()
        self._holder.stdout.close()
        self._holder.stderr.close()


@dataclass
class Peer:
    """One running peer and the milestones it printed."""
    process: subprocess.Popen
    log: str
    lines: list = field(default_factory=list)
    created: float = 0.0
    first_sample: float = 0.0
    last_sample: float = 0.0
    killed: bool = False
    stopped: bool = False
    _rest: bytes = b""

    def read(self):
        """Takes what the peer printed; False at the end of its output."""
        octets = os.read(self.process.stdout.fileno(), 65536)
        *lines, self._rest = (self._rest + octets).split(b"\n")
        for line in lines:
            self._milestone(line.decode(errors="replace"))
        return bool(octets)

    def _milestone(self, line):
        self.lines.append(line)
        if line == "created":
            self.created = time.monotonic()
        elif line.startswith("sample "):
            self.last_sample = time.monotonic()
            self.first_sample = self.first_sample or self.last_sample

    def said(self, word):
        return any(line.split(" ")[0] == word for line in self.lines)

    @property
    def ended(self):
        return self.process.poll() is not None

    @property
    def settled(self):
        """Created or at an end, so that waiting for its creation is over."""
        return bool(self.created) or self.ended

    def stop(self):
        if not self.ended and not self.stopped:
            self.stopped = True
            self.process.send_signal(signal.SIGTERM)

    def kill(self):
        if not self.ended:
            self.killed = True
            self.process.kill()
        self.process.wait()


@dataclass
class Outcome:
    word: str
    seconds: float          # from start to end
    first_sample: float     # from start to the first sample; 0 if none came
    detail: str             # who refused, or how a process ended
    report: str             # both peers' output, for a failure


@dataclass(frozen=True)
class Programs:
    """Where the programs and the plugins are, and where the logs go."""
    bin: str
    dropin: str
    logs: str

    def command(self, kind):
        names = {"fast": "fastdds_peer", "embedded": "embedded_peer"}
        return [os.path.join(self.bin, names.get(kind, "cyclone_peer"))]

    def environment(self, kind):
        environment = dict(os.environ)
        for name in ("CYCLONEDDS_URI", "FASTRTPS_DEFAULT_PROFILES_FILE", "LD_LIBRARY_PATH",
                     CIPHER_VARIABLE):
            environment.pop(name, None)
        environment["TZ"] = "UTC"  # Fast DDS reads the dates of permissions as local time
        if kind != "embedded":  # stock Cyclone DDS leaks
            environment.setdefault("ASAN_OPTIONS", "detect_leaks=0")
        if kind.startswith("ddssec"):
            environment["LD_LIBRARY_PATH"] = self.plugins(kind)
        return environment

    def plugins(self, kind):
        """The folder that stands before the stock plugins: all of ours, or just one of them."""
        return self.dropin if kind == "ddssec" else os.path.join(self.logs, "dropin-" + kind)


@functools.cache
def major_version_of_fast_dds(program):
    return int(subprocess.run([program, "--version"], check=True, text=True, capture_output=True).stdout)


def those_that_meet(programs, cases, kinds_of):
    """Without the pairs of Cyclone DDS 0.10 and Fast DDS 3, which Debian 13 has. Since 2.10 Fast DDS discovers no secured
    participant that does not write DCPSParticipantsSecure, and Cyclone DDS does not write it, with any plugins."""
    def can_meet(case):
        hosts = {kind if kind in ("fast", "embedded") else "cyclone" for kind in kinds_of(case)}
        return hosts != {"fast", "cyclone"} or major_version_of_fast_dds(*programs.command("fast")) < 3
    cases = list(cases)
    kept = [case for case in cases if can_meet(case)]
    if len(kept) != len(cases):
        print(f"left out: {len(cases) - len(kept)} pairs of Cyclone DDS and Fast DDS 3, "
              "which do not discover each other when secured", flush=True)
    return kept



def start(programs, namespace, kind, arguments, log, variables=None):
    """Starts a peer inside the namespace; its log begins with its command line."""
    limit = str(int(POSITIVE_LIMIT + CREATION_LIMIT))
    command = [*programs.command(kind), "--timeout", limit, *arguments, "--topic", TOPIC, "--domain", str(DOMAIN),
               "--samples", str(SAMPLES)]
    with open(log, "wb") as errors:
        errors.write((" ".join(command) + "\n").encode())
        errors.flush()
        process = subprocess.Popen(namespace.enter(command), stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=errors,
                                   env=programs.environment(kind) | (variables or {}))
    return Peer(process, log)


class _Watch:
    """Follows both peers until the outcome is clear, then stops them. `on_data` is called when the
    first sample has come."""

    def __init__(self, publisher, subscriber, case, on_data=None):
        self.publisher, self.subscriber = publisher, subscriber
        self.both = (publisher, subscriber)
        self.wants_data = DATA in case.allowed
        self.expires = case.expires
        self.on_data = on_data
        self.begin = time.monotonic()

    def deadline(self):
        if not all(peer.settled for peer in self.both):
            return self.begin + CREATION_LIMIT
        if self.expires:
            return self.begin + CUT_LIMIT + SILENCE
        if self.wants_data:
            return self.begin + POSITIVE_LIMIT
        return max([self.begin, *(peer.created for peer in self.both)]) + NEGATIVE_LIMIT

    def cut(self):
        """Samples came and then none for a while."""
        last = self.subscriber.last_sample
        return self.expires and bool(last) and time.monotonic() - last > SILENCE

    def clear(self):
        if self.cut():
            return True
        if all(peer.ended for peer in self.both):
            return True
        if self.expires:
            return not all(peer.settled for peer in self.both) and any(
                peer.ended for peer in self.both)
        # An end before the other side is done (a refusal, a crash) cannot get better any more.
        for peer, other in (self.both, self.both[::-1]):
            if peer.ended and peer.process.returncode != 0:
                return other.settled
        return False

    def follow(self):
        with selectors.DefaultSelector() as selector:
            for peer in self.both:
                selector.register(peer.process.stdout, selectors.EVENT_READ, peer)
            while not self.clear() and time.monotonic() < self.deadline():
                for key, _ in selector.select(0.05):
                    if not key.data.read():
                        selector.unregister(key.fileobj)
                if self.on_data and self.subscriber.last_sample:
                    self.on_data()
                    self.on_data = None
                if self.publisher.said("acknowledged") and self.subscriber.said("received"):
                    self.subscriber.stop()  # ends its linger

    def stop(self):
        for peer in self.both:
            peer.stop()
        end = time.monotonic() + STOP_LIMIT
        for peer in self.both:
            try:
                peer.process.wait(max(0.01, end - time.monotonic()))
            except subprocess.TimeoutExpired:
                pass
            peer.kill()
            while peer.read():
                pass
            peer.process.stdout.close()


def judge(publisher, subscriber, was_cut):
    """The outcome word of a finished pair, and a detail."""
    names = ((publisher, "publisher"), (subscriber, "subscriber"))
    for peer, name in names:
        if peer.killed:
            return HUNG, f"{name} did not end on SIGTERM"
        if peer.process.returncode not in (0, 3, 4, 5):
            return CRASHED, f"{name} ended with {peer.process.returncode}"
    refused = [name for peer, name in names if peer.process.returncode == 3]
    if refused:
        return REFUSED, " and ".join(refused)
    if was_cut:
        return CUT, f"{subscriber.last_sample - subscriber.first_sample:.1f} s after the first"
    if "stopped" in publisher.lines and subscriber.said("sample"):
        return DATA, "never cut"
    if subscriber.said("received") and publisher.said("acknowledged"):
        return DATA, ""
    if subscriber.said("sample"):
        return PARTIAL, "" if not subscriber.said("received") else "never acknowledged"
    matched = [name for peer, name in names if peer.said("matched")]
    if len(matched) == 1:
        return HALF, f"{matched[0]} only"
    return (MATCHED if matched else NONE), ""


def _report(case, peers):
    parts = []
    for kind, peer in zip((case.publisher, case.subscriber), peers):
        with open(peer.log, errors="replace") as file:
            errors = file.read().splitlines()
        parts.append(f"  {kind}: exit {peer.process.returncode}; said "
                     f"{'; '.join(line[:80] for line in peer.lines[-4:]) or 'nothing'}")
        parts += [f"    | {line[:200]}" for line in errors[:1] + errors[1:][-10:]]
    return "\n".join(parts)


def _variables(side):
    return {CIPHER_VARIABLE: side.process_cipher} if side.process_cipher else {}


def _gives_reason(case, peers):
    """Whether a peer of ddssec says why, where it has to."""
    if not case.reason:
        return True
    for peer in peers:
        with open(peer.log, errors="replace") as file:
            if case.reason in file.read():
                return True
    return False


def _revocation(case, pki, subscribe):
    """What revokes the publisher for the subscriber, if that is the case."""
    side = case.sides[1]
    if side.crl != "later":
        return None
    path = subscribe[subscribe.index("--crl") + 1]
    return lambda: side.revoke_peer(pki, case.keys, not case.publisher_starts, path)


def run(case, programs, pki, number):
    """Runs the case and returns its Outcome."""
    publisher_side, subscriber_side = case.sides
    starts = case.publisher_starts
    publish = publisher_side.arguments(pki, case.keys, starts)
    subscribe = subscriber_side.arguments(pki, case.keys, not starts)
    namespace = Namespace()
    peers = []
    try:
        begin = time.monotonic()
        for kind, role, arguments, side in (
                (case.subscriber, "--subscribe", subscribe, subscriber_side),
                (case.publisher, "--publish", publish, publisher_side)):
            log = os.path.join(programs.logs, f"{number}{role}.log")
            more = ["--hold"] if case.expires else []
            more += ["--payload", str(case.payload)] if case.payload else []
            peers.append(start(programs, namespace, kind, [role, *more, *arguments], log,
                               _variables(side)))
        subscriber, publisher = peers
        watch = _Watch(publisher, subscriber, case, _revocation(case, pki, subscribe))
        watch.follow()
        was_cut = watch.cut()
        watch.stop()
        word, detail = judge(publisher, subscriber, was_cut)
        if not _gives_reason(case, (publisher, subscriber)):
            word, detail = SILENT, f"{word}, and nobody said {case.reason}"
        first = subscriber.first_sample - begin if subscriber.first_sample else 0.0
        return Outcome(word, time.monotonic() - begin, first, detail,
                       _report(case, (publisher, subscriber)))
    finally:
        for peer in peers:
            peer.kill()
        namespace.close()

#!/usr/bin/env python3
"""The scenarios of policy_cases.py between two secured processes whose samples go through shared memory, one after
the other. The traffic of each scenario shows that they did. Usage: memory_policies.py BUILD [FILTER]"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
import policy_cases  # noqa: E402
from documents import Governance, Keys, Permissions, Side  # noqa: E402
from pair import Namespace  # noqa: E402
from pki import Pki  # noqa: E402
from policy_peers import OURS, Case, Peer  # noqa: E402

SAMPLE = 20_000  # octets, as policy_embedded fills them
BEFORE = 5       # samples that it writes before, some of which go by network
MANY = 5         # scenarios of so many samples must use memory
# Those that the samples before the first one (which policy_embedded writes) would disturb, those of an
# appendable type, and what says nothing about samples.
LEFT_OUT = ("resource limits", "purge", "born disabled", "marked packets", "appendable", "told to the other", "mismatch")
FILES = {"--identity_ca": "identity_ca.pem", "--identity_certificate": "cert.pem", "--private_key": "key.pem",
         "--permissions_ca": "permissions_ca.pem", "--governance": "governance.p7s",
         "--permissions": "permissions.p7s", "--crl": "crl.pem"}
GOVERNANCE = Governance(discovery="ENCRYPT", liveliness="ENCRYPT", rtps="SIGN", metadata="ENCRYPT", data="ENCRYPT")
ALLOWED = Permissions(domain=3, publish=("*",), subscribe=("*",), partition="*")


@policy_cases.case_of("PRESENTATION", writers=(OURS,), readers=(OURS,))
def coherent_sets(case):
    writer = case.writer("scope=topic coherent=on history=all")
    reader = case.reader("scope=topic coherent=on history=all")
    yield from case.matched(writer, reader)
    case.w.ask(f"write {writer} RED 0")
    yield from case.comes(reader, "RED:0:A")
    case.w.ask(f"begin {writer}")
    for x in range(1, 6):
        case.w.ask(f"write {writer} RED {x}")
    yield 0.5
    case.check("part of a set was seen", case.collect(reader) == [])
    case.w.ask(f"end {writer}")
    yield from case.comes(reader, *(f"RED:{x}:A" for x in range(1, 6)))


class Counting(Peer):
    """Counts the samples that it writes."""
    written = 0

    def ask(self, command):
        self.written += command.startswith("write ")
        return super().ask(command)


def folder(pki, path, starts):
    path.mkdir()
    options = Side(GOVERNANCE, ALLOWED).arguments(pki, Keys(), starts)
    for option, source in zip(options[::2], options[1::2]):
        shutil.copy(source, path / FILES[option])
    (path / "security.properties").write_text("org.ddssec.shm = on\n")
    return path


def octets_on_loopback(space):
    text = subprocess.run(space.enter(["cat", "/proc/net/dev"]), capture_output=True, text=True).stdout
    return int(next(line for line in text.splitlines() if line.strip().startswith("lo:")).split(":")[1].split()[0])


def run_one(case, steps):
    try:
        for wait in steps:
            time.sleep(wait)
    except AssertionError as fault:
        return str(fault)
    return None


def main():
    build, wanted = pathlib.Path(sys.argv[1]).resolve(), (sys.argv[2:] or [""])[0]
    failed = done = through_memory = 0
    with tempfile.TemporaryDirectory() as top, tempfile.TemporaryFile("w+") as log:
        space, pki = Namespace(), Pki(top)
        peers = [Counting(space, build, OURS, log, "memory", str(folder(pki, pathlib.Path(top) / name, starts)))
                 for name, starts in (("one", True), ("other", False))]
        for policy, name, steps, writers, readers, _ in policy_cases.CASES:
            title = f"{policy}: {name}"
            if (OURS not in writers or OURS not in readers or wanted not in title or
                    any(word in title for word in LEFT_OUT)):
                continue
            case = Case(*peers, title, space)
            before, written = octets_on_loopback(space), peers[0].written
            fault = run_one(case, steps(case))
            written = peers[0].written - written
            by_network = octets_on_loopback(space) - before
            if not fault and written >= MANY and by_network > (written + BEFORE) * SAMPLE * 0.8:
                fault = "samples went by network"
            through_memory += by_network < (written + BEFORE) * SAMPLE * 0.8
            done, failed = done + 1, failed + bool(fault)
            print(f"{'FAILED' if fault else 'ok':8}{title} ({written} samples, {by_network} octets by network)"
                  f"{': ' + fault if fault else ''}", flush=True)
        for peer in peers:
            peer.close()
        space.close()
        log.seek(0)
        print(*[line for line in log.read().splitlines() if "rtps_memory_unused" in line][:5], sep="\n")
    print(f"{done} scenarios, {failed} failed, {through_memory} with less traffic than samples")
    return 1 if failed or not done else 0


if __name__ == "__main__":
    sys.exit(main())

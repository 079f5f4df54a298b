#!/usr/bin/env python3
"""Every QoS policy of DDS 1.4, and two of XTypes, between the embedded participant and itself, and Cyclone
DDS and Fast DDS each way: match, mismatch (the status names the policy), effect. All at once in one network
namespace and one discovery, each case on topics of its own. Usage: policies.py BUILD [FILTER], or
policies.py --table README.md [--write]: that its table is of these cases."""

import heapq
import itertools
import pathlib
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
from pair import Namespace  # noqa: E402
from policy_cases import CASES  # noqa: E402
from policy_peers import ALL, CYCLONE, FAST, NOT_FAST, OURS, Case, Peer  # noqa: E402

# Options of ddssec-shapes, whose driver tries them with two processes of ours.
SHAPES = {"PRESENTATION": ("coherent", "ordered"), "DURABILITY": ("persistent", "keeper"),
          "OWNERSHIP": ("ownership", "shared"), "TIME_BASED_FILTER": ("time_filter",)}
PAIRS = (OURS, OURS), (OURS, CYCLONE), (CYCLONE, OURS), (OURS, FAST), (FAST, OURS)


def scenarios(worlds, wanted, space):
    for writer, reader in PAIRS:
        for policy, name, steps, writers, readers, _ in CASES:
            peers, second = worlds[getattr(steps, "appendable", False)]
            if writer not in peers or reader not in peers:
                continue
            ends = peers[writer], second if writer == reader else peers[reader]
            case = Case(*ends, f"{policy}: {name}", space)
            if wanted in case.name and writer in writers and reader in readers:
                yield case, steps(case)


def table():
    """Returns a line for each case: which products try it with each other, and why others do not."""
    lines = ["| policy | case | ddssec to ddssec | to Cyclone DDS | from Cyclone DDS | to Fast DDS | from Fast DDS | |",
             "|---|---|---|---|---|---|---|---|"]
    rows = [(policy, name, ["yes" if w in writers and r in readers else "" for w, r in PAIRS], because)
            for policy, name, _, writers, readers, because in CASES]
    rows += [(policy, f"`shapes.py {name}`", ["yes", "", "", "", ""], "") for policy, names in SHAPES.items()
             for name in names]
    for policy, name, marks, because in sorted(rows, key=lambda row: row[0].lower()):
        lines.append(f"| {policy} | {name} | " + " | ".join(marks) + f" | {because} |")
    return "\n".join(lines) + "\n"


def compare_table(readme, write):
    import shapes
    known = {scenario.__name__ for scenario in shapes.CASES}
    missing = [name for names in SHAPES.values() for name in names if name not in known]
    begin, end = "<!-- policies.py --table -->\n", "<!-- end -->"
    text = readme.read_text()
    before, rest = text.split(begin)
    stands, after = rest.split(end)
    if write:
        readme.write_text(before + begin + table() + end + after)
    elif stands != table() or missing:
        print(f"{readme}: not the table of policies.py; write it with --write", *missing)
        return 1
    return 0


def run(all_scenarios):
    """Steps each scenario when its time has come; the faults, by name. They begin one by one: who has a
    lease to keep cannot wait until all have begun."""
    order, begin = itertools.count(), time.monotonic()
    waiting = [(begin + i * 0.02, next(order), case, steps) for i, (case, steps) in enumerate(all_scenarios)]
    faults = {case.name: None for _, _, case, _ in waiting}
    while waiting:
        due, _, case, steps = heapq.heappop(waiting)
        time.sleep(max(0.0, due - time.monotonic()))
        try:
            heapq.heappush(waiting, (time.monotonic() + next(steps), next(order), case, steps))
        except StopIteration:
            pass
        except AssertionError as fault:
            faults[case.name] = str(fault)
    return faults


def main():
    if sys.argv[1] == "--table":
        return compare_table(pathlib.Path(sys.argv[2]), "--write" in sys.argv)
    build, wanted = pathlib.Path(sys.argv[1]).resolve(), (sys.argv[2:] or [""])[0]
    space = Namespace()
    with tempfile.TemporaryFile("w+") as log:
        worlds = {}
        for appendable, kinds in ((False, ALL), (True, NOT_FAST)):
            options = ["appendable"] if appendable else []
            worlds[appendable] = ({kind: Peer(space, build, kind, log, *options) for kind in kinds},
                                  Peer(space, build, OURS, log, *options))
        faults = run(list(scenarios(worlds, wanted, space)))
        for peers, second in worlds.values():
            for peer in (*peers.values(), second):
                peer.close()
        space.close()
        log.seek(0)
        complaints = [line for line in log.read().splitlines() if "malformed" in line.lower() or "deserialization" in line.lower()]
    for name, fault in faults.items():
        print(f"{'FAILED' if fault else 'ok':8}{name}{': ' + fault if fault else ''}")
    print("\n".join(complaints[:10]))
    return 1 if complaints or any(faults.values()) or not faults else 0


if __name__ == "__main__":
    sys.exit(main())

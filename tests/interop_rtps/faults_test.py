#!/usr/bin/env python3
"""Real peers over a link that loses, repeats, delays, reorders and is cut: reliable keep-all loses
nothing and keeps order, keep-last keeps its bounds, and after a heal both go on.
Secured, the embedded participant starts the handshake: a Cyclone DDS that starts sends its Final once
and forgets the handshake 0.1 s later, so that a lost one is never repeated (two of them together
stall as often), and a Fast DDS that starts needs up to 30 s.
Usage: faults_test.py BUILD [--chosen] [--seed N] [--filter TEXT]"""

import argparse
import concurrent.futures
import pathlib
import sys
import tempfile
import time

from faulty_world import FAULTS, Link, World
from pki import Pki

PAIRS = [("embedded", "embedded"), ("embedded", "stock"), ("stock", "embedded"),
         ("embedded", "fast"), ("fast", "embedded")]
LIMIT = 40   # seconds a peer may run
DEPTH = 5


class Failure(Exception):
    pass


def count_for(pair, secured, most):
    """A secured Fast DDS writer ends itself (an assertion of its own, with Fast DDS readers too) when
    what it repeats fills a message: fewer samples then."""
    return min(most, 100) if secured and pair[0] == "fast" else most


def expect(condition, text):
    if not condition:
        raise Failure(text)


def excerpt(numbers):
    wrong = next((i for i, number in enumerate(numbers) if number != i), len(numbers))
    return f"{len(numbers)} samples, from {wrong}: {numbers[wrong:wrong + 8]}"


def keep_all(world, pair, secured):
    """Under every fault from the first announcement to the last acknowledgement."""
    count = count_for(pair, secured, 300)
    world.network.do(FAULTS)
    subscriber = world.start(pair[1], "subscribe", ["--samples", count, "--timeout", LIMIT], secured)
    publisher = world.start(pair[0], "publish", ["--samples", count, "--timeout", LIMIT], secured)
    taken = subscriber.wait(lambda peer: len(peer.samples) >= count or peer.times("end"), LIMIT)
    expect(subscriber.numbers() == list(range(count)), excerpt(subscriber.numbers()))
    acknowledged = publisher.wait(lambda peer: peer.times("acknowledged") or peer.times("end"), LIMIT)
    expect(publisher.times("acknowledged"), f"the publisher says {publisher.said}")
    return f"all {taken:.1f} s, acknowledged {acknowledged:.1f} s later"


def partition(world, pair, secured):
    """Cut in mid-flow and healed within the lease: nothing is lost."""
    count, half = count_for(pair, secured, 400), 50
    world.network.do("loss 0.05")
    subscriber = world.start(pair[1], "subscribe", ["--samples", count, "--timeout", LIMIT], secured)
    world.start(pair[0], "publish", ["--samples", count, "--timeout", LIMIT], secured)
    expect(subscriber.wait(lambda peer: len(peer.samples) >= half, 15), "no flow before the cut")
    world.network.do("cut")
    time.sleep(3)  # the cut itself: long enough for retransmissions into it, shorter than the lease
    before = len(subscriber.samples)
    expect(before < count, "all came before the cut")
    world.network.do("heal")
    resumed = subscriber.wait(lambda peer: len(peer.samples) > before, 10)
    expect(resumed is not None, "nothing came within 10 s of the heal")
    subscriber.wait(lambda peer: len(peer.samples) >= count, 15)
    expect(subscriber.numbers() == list(range(count)), excerpt(subscriber.numbers()))
    return f"goes on {resumed:.2f} s after the heal"


def keep_last(world, pair, secured):
    """What is written while the link is cut: the last DEPTH come, no others, in order."""
    count = 300
    subscriber = world.start(pair[1], "subscribe",
                             ["--samples", count, "--hold", "--timeout", LIMIT], secured)
    publisher = world.start(pair[0], "publish", ["--samples", count, "--keep-last", DEPTH,
                                                 "--interval", 10, "--timeout", LIMIT], secured)
    expect(subscriber.wait(lambda peer: len(peer.samples) >= 50, 15), "no flow before the cut")
    world.network.do("cut")
    before = subscriber.numbers()
    expect(publisher.wait(lambda peer: peer.times("written"), 8) is not None,
           "the publisher waits for a reader although it keeps the last samples only")
    time.sleep(0.2)  # what was on its way before the cut
    before = subscriber.numbers()
    world.network.do("heal " + FAULTS)
    taken = subscriber.wait(lambda peer: count - 1 in peer.numbers(), 15)
    expect(taken is not None, f"the last sample did not come: {subscriber.numbers()[-5:]}")
    time.sleep(0.2)  # in which nothing else may come
    after = subscriber.numbers()[len(before):]
    expect(after == list(range(count - DEPTH, count)), f"after the heal came {after}")
    expect(before == sorted(set(before)), "out of order before the cut")
    return f"the last {DEPTH} {taken:.2f} s after the heal"


def long_partition(world, pair, secured):
    """Cut for longer than the lease: both sides see the other go, and match again."""
    lease = 3
    options = ["--samples", 10000, "--hold", "--lease", lease, "--timeout", LIMIT]
    subscriber = world.start(pair[1], "subscribe", options, secured)
    publisher = world.start(pair[0], "publish", options, secured)
    expect(subscriber.wait(lambda peer: len(peer.samples) >= 5, 15), "no flow before the cut")
    world.network.do("cut")
    for peer, name in ((subscriber, "subscriber"), (publisher, "publisher")):
        expect(peer.wait(lambda peer: peer.times("unmatched"), lease + 4) is not None,
               f"the {name} does not see the lease end")
    before = len(subscriber.samples)
    world.network.do("heal")
    resumed = subscriber.wait(lambda peer: len(peer.samples) > before + 5, 15)
    expect(resumed is not None, "nothing came within 15 s of the heal")
    return f"goes on {resumed:.2f} s after the heal"


SCENARIOS = [keep_all, partition, keep_last, long_partition]
SECURED = {(keep_all, pair) for pair in PAIRS} | {
    (scenario, pair) for scenario in (partition, long_partition)
    for pair in (("embedded", "embedded"), ("embedded", "stock"), ("fast", "embedded"))}


def cases():
    for scenario in SCENARIOS:
        for pair in PAIRS:
            for secured in (False, True):
                if not secured or (scenario, pair) in SECURED:
                    yield scenario, pair, secured


def is_chosen(scenario, pair, secured):
    if secured:
        return scenario is keep_all and pair in PAIRS[:2]
    return scenario is not long_partition and (scenario is keep_all or pair in PAIRS[:2])


def attempt(build, pki, network, case):
    """Whether it is as it must be, and what to print. `network()` makes the network."""
    scenario, pair, secured = case
    with tempfile.TemporaryDirectory() as folder:
        world = World(build, folder, network(), pki)
        world.starter = pair.index("embedded")
        try:
            good, text = True, scenario(world, pair, secured)
        except Failure as failure:
            good, text = False, str(failure)
        did = world.close()
        return good, text if good else f"{text}\n  {did}\n{world.logs()}"


def name_of(case):
    scenario, pair, secured = case
    return f"{scenario.__name__} {'>'.join(pair)}{' secured' if secured else ''}"


def run_cases(every, chosen_ones, network, text):
    """Runs the cases that the command line asks for; the exit status. `network(build, seed)`."""
    parser = argparse.ArgumentParser(description=text)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--filter", default="")
    parser.add_argument("--chosen", action="store_true", help="the part that the normal tests run")
    parser.add_argument("--jobs", type=int, default=6)
    options = parser.parse_args()
    chosen = [case for case in every if options.filter in name_of(case)
              and (not options.chosen or chosen_ones(*case))]
    failed = 0
    with tempfile.TemporaryDirectory() as folder, \
            concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        pki, build = Pki(folder), options.build.resolve()
        tried = [(name_of(case), pool.submit(attempt, build, pki,
                                             lambda seed=options.seed + i: network(build, seed), case))
                 for i, case in enumerate(chosen)]
        for name, future in tried:
            good, said = future.result()
            print(f"{'ok' if good else 'FAILED':8}{name}: {said}", flush=True)
            failed += not good
    print(f"{len(chosen)} cases, {failed} failed, seed {options.seed}")
    return 1 if failed or not chosen else 0


if __name__ == "__main__":
    sys.exit(run_cases(cases(), is_chosen, Link, __doc__))

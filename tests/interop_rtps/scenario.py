#!/usr/bin/env python3
"""Small systems as they are built with DDS, each process a process: what happens to them when something
breaks. Usage: scenario.py BUILD [FILTER]"""

import signal
import sys
import time

from shapes_process import Namespace, check, run

DEADLINE = 0.3  # seconds
# What a loaded machine and the reader's own period may add to it.
SLACK = 1.5
EXCLUSIVE = "-k 0 -r -f 300"


def redundant_pipelines(case):
    """Two perception pipelines see the same; the better one is killed: within the deadline and what a
    read takes, the other is heard, and nothing of it before."""
    sub = case.start(f"-S -t Objects -s 0 {EXCLUSIVE} --read-period 10")
    case.start(f"-P -t Objects -s 5 -z 50 {EXCLUSIVE} --write-period 20")
    better = case.start(f"-P -t Objects -s 10 -z 100 {EXCLUSIVE} --write-period 20")
    sub.says(r"\[100\]")
    check("the worse one was heard", set(sub.sizes_for(1)) == {100})
    better.process.send_signal(signal.SIGKILL)
    begin = time.monotonic()
    sub.says(r"\[50\]")
    took = time.monotonic() - begin
    check(f"the other one took over after {took:.2f} s", took < DEADLINE + SLACK)
    again = case.start(f"-P -t Objects -s 10 -z 101 {EXCLUSIVE} --write-period 20")
    sub.says(r"\[101\]")
    check("two are heard", set(sub.sizes_for(1)) == {101})
    check("exit codes", again.interrupt() == 0 and sub.interrupt() == 0)


def radar_that_degrades(case):
    """Two radars track one target; the stronger finds itself degraded and says so."""
    sub = case.start(f"-S -t Track -s 0 {EXCLUSIVE} --read-period 10")
    strong, weak = case.tool("Track 200 20"), case.tool("Track 100 10")
    sub.says(r"\[200\]")
    check("the weak one was heard", set(sub.sizes_for(1)) == {200})
    strong.tell("5")
    sub.says(r"\[100\]")
    check("the degraded one was heard", set(sub.sizes_for(1)) == {100})
    strong.tell("20")
    sub.says(r"\[200\]")
    check("the weak one was heard again", set(sub.sizes_for(1)) == {200})
    weak.tell("30")
    sub.says(r"\[100\]")


def alarms(case):
    """A sensor's process hangs: the deadline's alarm comes, then that of its liveliness; it goes on,
    and is alive again."""
    sub = case.start("-S -t Sensor -s 0 -f 300 --read-period 10")
    sensor = case.tool("Sensor 7 1 800")
    sub.says(r"on_liveliness_changed\(\) .* \(alive = 1, not_alive = 0\)")
    sub.says(r"\[7\]")
    sensor.process.send_signal(signal.SIGSTOP)
    begin = time.monotonic()
    sub.says(r"on_requested_deadline_missed\(\)")
    check("late", time.monotonic() - begin < DEADLINE + SLACK)
    sub.says(r"on_liveliness_changed\(\) .* \(alive = 0, not_alive = 1\)")
    check("late", 0.5 < time.monotonic() - begin < 0.8 + SLACK)
    sensor.process.send_signal(signal.SIGCONT)
    sub.says(r"on_liveliness_changed\(\) .* \(alive = 1, not_alive = 0\)")
    sub.says(r"\[7\]")


def partition(case, seconds):
    """Two halves of a system on a link that is cut: each goes on with its own leader; when it heals,
    both have the one that is stronger again."""
    here, there = Namespace(), Namespace()
    try:
        here.run(f"ip link add v0 type veth peer name v1 netns {there.pid}")
        for space, name, address in ((here, "v0", "10.76.0.1/24"), (there, "v1", "10.76.0.2/24")):
            space.run(f"ip addr add {address} dev {name}")
            space.run(f"ip link set {name} up")
        subs = [case.start(f"-S -t Leader -s 0 {EXCLUSIVE} --read-period 20", space=space)
                for space in (here, there)]
        for space, size, strength in ((here, 10, 10), (there, 5, 5)):
            case.start(f"-P -t Leader -z {size} -s {strength} {EXCLUSIVE}", space=space)
        for sub in subs:
            sub.says(r"\[10\]")
            check("two leaders", set(sub.sizes_for(1)) <= {10})
        here.run("ip link set v0 down")
        subs[1].says(r"\[5\]")
        end = time.monotonic() + seconds
        subs[0].sizes_for(0.5)
        check("a half lost its leader", set(subs[0].sizes_for(0.5)) == {10} and
              set(subs[1].sizes_for(0.5)) == {5})
        time.sleep(max(0.0, end - time.monotonic()))
        here.run("ip link set v0 up")
        subs[1].sizes_for(0.2)
        subs[1].says(r"\[10\]", 20)
        for sub in subs:
            sub.sizes_for(0.3)
            check("split", set(sub.sizes_for(1)) == {10})
    finally:
        here.close()
        there.close()


def short_partition(case):
    partition(case, 2)


def long_partition(case):
    """Longer than a participant's lease: both sides have forgotten the other."""
    partition(case, 12)


def latched_map(case):
    """A map is published once; who comes later has it, and whole."""
    pub = case.start("-P -t Map -D l -k 1 --write-period 60000 --additional-payload-size 1000000 -w")
    pub.hears(1)
    for _ in range(2):
        late = case.start("-S -t Map -D l -k 1 -r")
        got = late.hears(1)
        check(f"not the map: {got}", got == [("Map", "BLUE", 20, "255")])
        check("a second one", not late.says_within(r"\[", 0.5))
        check("exit code", late.interrupt() == 0)


CASES = [long_partition, redundant_pipelines, radar_that_degrades, alarms, short_partition, latched_map]


if __name__ == "__main__":
    sys.exit(run(CASES, range(170, 176), workers=6))

#!/usr/bin/env python3
"""Every option of ddssec-shapes, two processes at a time, each case in a domain of its own.
Usage: shapes.py BUILD [FILTER]"""

import pathlib
import re
import resource
import stat
import sys
import tempfile
import time

from shapes_process import Namespace, check, run  # puts the folders of what follows in place
from documents import Permissions
from pki import Pki
from surroundings import ENCRYPT, make_folder

OTHER_DOMAIN = 189


# ---- lines and codes ----------------------------------------------------------------------------------

def lines(case):
    pub, sub = case.pair("-w", "")
    status = r"\(\) topic: 'Square'  type: 'ShapeType' : matched "
    pub.says("^on_publication_matched" + status + r"readers 1 \(change = 1\)$")
    sub.says("^on_subscription_matched" + status + r"writers 1 \(change = 1\)$")
    topic, color, size, octet = sub.hears(1)[0]
    check("a sample", (topic, color, size, octet) == ("Square", "BLUE", 20, None))
    check("its columns", re.fullmatch(r"Square     BLUE       \d{3} \d{3} \[20\]", sub.lines[-1]))
    check("what was written", pub.says(re.escape(sub.lines[-1])))
    check("the first lines of a publisher", pub.lines[:2] ==
          ["Create topic: Square", "Create writer for topic: Square color: BLUE"])
    check("the first lines of a subscriber", sub.lines[:2] ==
          ["Create topic: Square", "Create reader for topic: Square"])
    check("a subscriber's exit code", sub.interrupt() == 0)
    pub.says("^on_publication_matched" + status + r"readers 0 \(change = -1\)$")
    check("a publisher's exit code", pub.interrupt() == 0)
    check("nothing is missing", not any("not supported" in line for line in pub.lines + sub.lines))


def writes_at_once(case):
    pub = case.start("-P -w")
    check("unmatched", len(pub.hears(3, 3)) == 3 and "matched" not in " ".join(pub.lines))


def ends_by_itself(case):
    begin = time.monotonic()
    pub = case.start("-P --num-iterations 3 --write-period 100 -w")
    check("its code", pub.end() == 0)
    check("its samples", sum("[20]" in line for line in pub.lines) == 3)
    check("its periods", time.monotonic() - begin > 0.3)
    check("a subscriber's code", case.start("-S --num-iterations 2 --read-period 50").end() == 0)


def bad_arguments(case):
    for arguments in ("", "-P -S", "-P -k -1", "-P -s -2", "-P -D x", "-P -x 3", "-P -z -1", "-P -v q",
                      "-S --access-scope x", "-P --final-instance-state x", "-P --num-instances 0",
                      "-P --coherent-sample-count 1", "-P --nonsense", "-S extra", "-P -d 300",
                      "-P --final --additional-payload-size 1"):
        process = case.start(arguments)
        check(f"the code of '{arguments}'", process.end() == 1)
        check(f"the words for '{arguments}'", process.lines)
    check("help", case.start("-h").end() == 0)


# ---- which programs talk to each other --------------------------------------------------------------------------------

def nobody(case, publisher, subscriber, **other):
    sub = case.start("-S " + subscriber, **other)
    pub = case.start("-P " + publisher)
    check("matched", not pub.says_within("matched|incompatible", 2))
    check("heard", not sub.says_within(r"matched|incompatible|\[", 0.1))


def other_domain(case):
    nobody(case, "", "", domain=OTHER_DOMAIN)


def other_topic(case):
    nobody(case, "-t Square", "-t Circle")
    pub, sub = case.pair("-t Triangle", "-t Triangle")
    check("its topic", sub.hears(1)[0][0] == "Triangle")
    pub.says("on_publication_matched.*'Triangle'")


def partitions(case):
    nobody(case, "-p p1", "-p p2")
    _, sub = case.pair("-p x1 -c RED", "-p x*")
    case.start("-P -p p3 -c GREEN")
    check("another partition's sample", {color for _, color, *_ in sub.hears(20)} == {"RED"})


MISMATCHES = [("-b", "-r", 11), ("-D v", "-D l", 2), ("-D l", "-D t", 2), ("-D t", "-D p", 2),
              ("-x 1", "-x 2", 23), ("-x 2", "-x 1", 23), ("-s -1", "-s 1", 6), ("-s 3", "-s -1", 6),
              ("-f 7000", "-f 5000", 4), ("--access-scope i", "--access-scope t", 3)]


def mismatch(case):
    started = [(*case.pair(f"{offered} -t T{i}", f"{requested} -t T{i}"), offered, requested, number)
               for i, (offered, requested, number) in enumerate(MISMATCHES)]
    for pub, sub, offered, requested, number in started:
        pub.says(rf"^on_offered_incompatible_qos\(\) topic: '\w+'  type: 'ShapeType' : {number} \(")
        sub.says(rf"^on_requested_incompatible_qos\(\) topic: '\w+'  type: 'ShapeType' : {number} \(")
        check(f"{offered} > {requested}: matched", not pub.says_within("matched", 0.2))


MATCHES = [("-r", "-b"), ("-b", "-b"), ("-x 2", "-x 2"), ("-x 2 --final", "-x 2 --final"),
           ("--final", "--final"), ("-D l", "-D v"), ("-D t", "-D t"), ("-D t", "-D l"),
           ("-D p", "-D p"), ("-D p", "-D t"), ("-f 3000", "-f 5000"), ("-s 2", "-s 1"),
           ("--access-scope g", "--access-scope t")]


def match(case):
    started = [(*case.pair(f"{offered} -t T{i}", f"{requested} -t T{i}"), offered, requested)
               for i, (offered, requested) in enumerate(MATCHES)]
    for pub, sub, offered, requested in started:
        pub.says("on_publication_matched")
        check(f"{offered} > {requested}", sub.hears(2))


# ---- effects ------------------------------------------------------------------------------------------

def nothing_lost(case):
    pub, sub = case.pair("-k 0 -z 0 -w --write-period 5", "-k 0")
    got = [size for _, _, size, _ in sub.hears(200)]
    check("lost or out of order", got == list(range(got[0], got[0] + 200)))
    pub.says(re.escape(sub.lines[-1]))


def colours_instances_topics(case):
    _, sub = case.pair("-c RED --num-instances 3 --num-topics 2 -k 0", "-k 0 --num-topics 2")
    check("who came", {sample[:2] for sample in sub.hears(30)} ==
          {(topic, color) for topic in ("Square", "Square1") for color in ("RED", "RED1", "RED2")})
    check("its lines", sub.lines[:4] == ["Create topic: Square", "Create topic: Square1",
                                         "Create reader for topic: Square",
                                         "Create reader for topic: Square1"])


def size_modulo(case):
    sizes = [int(s) for s in re.findall(r"\[(\d+)\]", "\n".join(
        written(case.start("-P -w -z 0 --size-modulo 4 --num-iterations 9 --write-period 5"))))]
    check(f"sizes {sizes}", sizes == [1, 2, 3, 4, 1, 2, 3, 4, 1])


def written(pub):
    check("its code", pub.end() == 0)
    return [line for line in pub.lines if "[" in line]


def moves(case):
    places = [tuple(map(int, re.search(r" (\d{3}) (\d{3}) \[", line).groups())) for line in
              written(case.start("-P -w --num-iterations 400 --write-period 1"))]
    steps = [(abs(b[0] - a[0]), abs(b[1] - a[1])) for a, b in zip(places, places[1:])]
    check("it left its area", all(0 <= x <= 240 and 0 <= y <= 270 for x, y in places))
    check("it ran", all(x <= 5 and y <= 5 for x, y in steps))
    check("it stood still", steps.count((0, 0)) < 20)  # as it may where it turns


def deadline_missed(case):
    pub, sub = case.pair("-f 300 --write-period 700", "-f 300")
    pub.says(r"^on_offered_deadline_missed\(\) .*\(total = 1, change = 1\)$")
    sub.hears(1)
    sub.says(r"^on_requested_deadline_missed\(\) ")


def ownership(case):
    sub = case.start("-S -s 1 -k 0")
    weak = case.start("-P -s 3 -k 0 -z 20")
    sub.hears(1)
    strong = case.start("-P -s 4 -k 0 -z 30")
    sub.says(r"\[30\]")
    check("the weak was heard", {size for _, _, size, _ in sub.hears(30)} == {30})
    check("the strong one's code", strong.interrupt() == 0)
    sub.says(r"\[20\]")
    check("the weak one's code", weak.interrupt() == 0)


def shared(case):
    sub = case.start("-S -k 0")
    case.start("-P -k 0 -z 20")
    case.start("-P -k 0 -z 30")
    sub.says(r"\[20\]")
    sub.says(r"\[30\]")
    sub.says(r"\[20\]")


def late_joiner(case):
    for durability in "lv":
        pub = case.start(f"-P -D {durability} -k 0 -z 0 -w -t {durability}")
        pub.hears(20)
        first = case.start(f"-S -D {durability} -k 0 -t {durability}").hears(1)[0][2]
        check(f"-D {durability}: begins at {first}", first == 1 if durability == "l" else first > 5)


def sizes(process, count):
    return [size for _, _, size, _ in process.hears(count)]


def persistent(case):
    """What a publisher wrote before it was killed, and the next one's, in one order."""
    with tempfile.TemporaryDirectory() as folder:
        words = f"-P -D p --durability-directory {folder} -k 0 -z 0 -w --write-period 20"
        pub = case.start(words)
        pub.hears(60)  # the last ones may not be stored yet: they are committed in groups
        pub.process.kill()
        pub.process.wait()
        again = case.start(words)
        again.hears(10)
        got = sizes(case.start("-S -D p -k 0 -r"), 30)
        kept = got[:got.index(1, 1)] if 1 in got[1:] else got
        check(f"not what was written: {got}", kept == list(range(1, len(kept) + 1)) and len(kept) > 20)
        other = case.start(words)
        check("a store has one owner", other.end() == 2 and "locked" in " ".join(other.lines))


def keeper(case, security=lambda who: ""):
    """A durability service: the writer goes, the service is killed; a late joiner has all of it."""
    with tempfile.TemporaryDirectory() as folder:
        store = pathlib.Path(folder) / "kept"

        def start():
            service = case.start(f"--store {store} {security('keeper')}", case.program.parent / "ddssec-keeper")
            return service, int(service.says(r"^Keeping domain \d+: (\d+) topics known$")[1])

        service, known = start()
        check("knows something", known == 0)
        stays = case.start("-S -D t -k 0 " + security("stays"))
        written = {}
        for kind in "tp":
            pub = case.start(f"-P -D {kind} -k 0 -z 0 -w --write-period 10 -c {kind} -p {kind} {security(kind)}")
            pub.says("matched readers")
            pub.hears(60)
            check("its code", pub.interrupt() == 0)
            written[kind] = pub.samples()
            says = f"topic Square, type ShapeType, partition {kind}: the keeper keeps the topic from now on"
            service.says(re.escape(says))
        # A publisher ends when all is acknowledged, and the keeper acknowledges what is stored.
        service.process.kill()
        service.process.wait()
        service, known = start()
        check(f"{known} topics", known == 2)
        for kind in "tp":
            late = case.start(f"-S -D {kind} -k 0 -p {kind} {security('late')}")
            late.hears(50)
            late.sizes_for(0.3)
            got = late.samples()
            check(f"{kind}: {got} of {written[kind]}", got == written[kind][:len(got)])
        check("heard another partition", not stays.says_within(r"\[", 0.1))
        check("its code", service.interrupt() == 0)
        check("its file is for others too", stat.S_IMODE(store.stat().st_mode) == 0o600)


def secured_keeper(case):
    with tempfile.TemporaryDirectory() as base:
        pki, allowed = Pki(base), Permissions(("*",), ("*",), "*", case.domain)
        keeper(case, lambda who: "--security " + make_folder(pki, who, ENCRYPT, allowed))


def keeper_without_right(case):
    """A writer in a partition that the keeper may not read: the keeper says why it does not keep the topic."""
    with tempfile.TemporaryDirectory() as base:
        pki = Pki(base)
        security = {who: "--security " + make_folder(pki, who, ENCRYPT,
                                                     Permissions(("*",), ("*",), partition, case.domain))
                    for who, partition in (("pub", "*"), ("keeper", "here"))}
        service = case.start(security["keeper"], case.program.parent / "ddssec-keeper")
        service.says("^Keeping domain")
        case.start(f"-P -D t -p elsewhere {security['pub']}")
        service.says(r"not_allowed 142\d")
        told = [line for line in service.lines if "not_allowed" in line]
        check(f"names no topic: {told}", all("topic Square is not kept now" in line for line in told))
        check("keeps it", service.interrupt() == 0 and "Done: 0 topics kept" in service.lines)


def keeper_without_room(case):
    """A full store: what is not stored is counted, is no acknowledged sample, and costs the exit code; after
    kill -9 the keeper starts without room and serves what it has."""
    with tempfile.TemporaryDirectory() as folder:
        store = pathlib.Path(folder) / "kept"

        def start(octets):
            service = case.start(f"--store {store} --store-octets {octets}", case.program.parent / "ddssec-keeper")
            return service, int(service.says(r"^Keeping domain \d+: (\d+) topics known$")[1])

        service, _ = start(200_000)
        pub = case.start("-P -D t -k 0 -z 0 -w --write-period 10 --additional-payload-size 2000")
        service.says("samples could not be stored.*reached its limit")
        pub.hears(20)
        check("its code", service.interrupt() == 3)
        check(f"its last lines: {service.lines[-3:]}",
              any(re.match(r"Lost: [1-9]\d* samples are not stored; none of them was acknowledged$", line)
                  for line in service.lines))
        check("said why", any("are not in the store" in line and "limit" in line for line in service.lines))
        service, known = start(200_000)
        check(f"{known} topics", known == 1)
        service.has_said("samples could not be stored.*reached its limit")
        service.process.kill()
        service.process.wait()
        check("the publisher's code", pub.interrupt() == 0)
        service, known = start(200_000)
        check(f"{known} topics after it was killed", known == 1)
        late = case.start("-S -D t -k 0")
        got = [size for _, _, size, _ in late.hears(20)]
        check(f"what was kept: {got}", got == list(range(1, 21)))
        check("its code with nothing to lose", service.interrupt() == 0)


def full_disk(case):
    """A persistent publisher whose file may not grow says why."""
    with tempfile.TemporaryDirectory() as folder:
        words = f"-P -D p --durability-directory {folder} -k 0 -z 0 --write-period 10 --additional-payload-size 2000"
        pub = case.start(words, preexec=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, -1)))
        pub.says("failed to write", 30)
        pub.says("ddssec-shapes: .*File too large")
        check("its code", pub.end() == 3)


def keep_last(case):
    _, sub = case.pair("-k 3 -z 0 --write-period 10", "-k 3 --read-period 500")
    sub.hears(6)
    sizes = [size for _, _, size, _ in sub.hears(6)]
    check(f"not three in a row, twice: {sizes}", sizes[1:3] == [sizes[0] + 1, sizes[0] + 2] and
          sizes[3] > sizes[2] + 1 and sizes[4:] == [sizes[3] + 1, sizes[3] + 2])


def lifespan(case):
    _, sub = case.pair("-k 0 -z 0 --write-period 100 --lifespan 250", "-k 0 --read-period 500")
    sub.hears(4)
    sizes = [size for _, _, size, _ in sub.hears(10)]
    gaps = [i for i, (a, b) in enumerate(zip(sizes, sizes[1:])) if b != a + 1]
    check(f"2 or 3 a read: {sizes}", gaps and all(b - a in (2, 3) for a, b in zip(gaps, gaps[1:])))


def filters(case):
    case.start("-P -c BLUE -k 0 -z 0 --write-period 10 --size-modulo 50")
    case.start("-P -c RED -k 0 -z 0 --write-period 10")
    red = case.start("-S -c RED -k 0")
    check("another colour", {color for _, color, *_ in red.hears(30)} == {"RED"})
    words = case.start("-S -k 0 --cft shapesize<=20")
    check("too large", all(size <= 20 for _, color, size, _ in words.hears(30) if color == "BLUE"))
    bad = case.start("-S --cft nothing=3")
    check("its code", bad.end() == 2)
    check("its line", "failed to create content filtered topic" in bad.lines)


def time_filter(case):
    _, sub = case.pair("-k 0 -z 0 --write-period 20", "-k 0 --time-filter 500 --read-period 10")
    sizes = [size for _, _, size, _ in sub.hears(4)]
    check(f"too near: {sizes}", all(b - a > 10 for a, b in zip(sizes, sizes[1:])))


def ordered(case):
    case.start("-P -k 0 --ordered --access-scope t -z 0 --num-instances 4 --write-period 50")
    for scope, changes in (("i", False), ("t", True)):
        sub = case.start(f"-S -k 0 --ordered --access-scope {scope} --take-read --read-period 400")
        sub.says("^Reading with ordered access, iteration 0$")
        sub.says("^Reading with ordered access, iteration [3-9]$")
        colors = [color for _, color, *_ in sub.hears(16)]
        differ = sum(a != b for a, b in zip(colors, colors[1:]))
        check(f"scope {scope}: {colors}", (differ > 8) == changes)


def coherent(case):
    # Samples that come together: of an instance, of all of a topic's two, of both topics.
    for scope, whole in (("i", 3), ("t", 6), ("g", 12)):
        case.start(f"-P -k 0 --coherent --access-scope {scope} --coherent-sample-count 3 -t {scope} "
                   "--num-topics 2 --num-instances 2 -z 0 --write-period 60")
        sub = case.start(f"-S -k 0 --coherent --access-scope {scope} --take-read --read-period 60 "
                         f"-t {scope} --num-topics 2")
        sub.says("^Reading coherent sets, iteration 0$")
        sub.hears(1)
        for _ in range(4):
            sub.says("^Reading coherent sets")
            count = 0
            while (line := sub.next_line()) is not None and not line.startswith("Reading"):
                count += "[" in line
            check(f"scope {scope}: {count} at once", count % whole == 0)


def read_not_take(case):
    case.start("-P -D l --write-period 60000")
    for how in ("-R", "-R --take-read"):
        sub = case.start(f"-S -D l {how}")
        sub.hears(3)
        said = [line for line in sub.lines if "[" in line]
        check("again and again", len(set(said)) == 1)


def take_read(case):
    _, sub = case.pair("-k 0 -z 0 --num-instances 2", "-k 0 --take-read --read-period 300")
    check("both instances", {color for _, color, *_ in sub.hears(20)} == {"BLUE", "BLUE1"})


def final_states(case):
    for letter, state in (("u", "NO_WRITERS"), ("d", "DISPOSED"), ("", "NO_WRITERS")):
        option = f"--final-instance-state {letter}" if letter else ""
        letter = letter or "n"
        sub = case.start(f"-S -k 0 -t {letter}")
        sub.says("Create reader")
        pub = case.start(f"-P -k 0 -t {letter} --num-instances 2 --num-iterations 30 "
                         f"{option}")
        # Nothing promises an order of two instances.
        ended = {sub.says(rf"^{letter}          (BLUE1?) *NOT_ALIVE_{state}_INSTANCE_STATE$")[1] for _ in range(2)}
        check(f"ended {ended}", ended == {"BLUE", "BLUE1"})
        check("the publisher's code", pub.end() == 0)


def ended_publisher(case):
    pub, sub = case.pair("-c RED", "")
    sub.hears(1)
    check("its code", pub.interrupt() == 0)
    sub.says("^Square     RED        NOT_ALIVE_NO_WRITERS_INSTANCE_STATE$")


def large_payload(case):
    for size in (1, 1000, 200000):
        _, sub = case.pair(f"-k 0 -t T{size} --write-period 100 --additional-payload-size {size}",
                           f"-k 0 -t T{size}")
        check("the last octet", {octet for *_, octet in sub.hears(3)} == {"255"})


def fragments_and_announcements(case):
    _, sub = case.pair("-k 0 --datafrag-size 1000 --periodic-announcement 200 --additional-payload-size 5500",
                       "-k 0 --periodic-announcement 200")
    check("the last octet", {octet for *_, octet in sub.hears(3)} == {"255"})


def two_machines(case):
    """Each in a network namespace of its own, on interfaces that are no loopback."""
    here, there = Namespace(), Namespace()
    try:
        here.run(f"ip link add v0 type veth peer name v1 netns {there.pid}")
        for space, name, address in ((here, "v0", "10.77.0.1/24"), (there, "v1", "10.77.0.2/24")):
            space.run(f"ip addr add {address} dev {name}")
            space.run(f"ip link set {name} up")
        sub = case.start("-S", space=here)
        case.start("-P", space=there)
        check("heard", sub.hears(3))
    finally:
        here.close()
        there.close()


def vendors(case):
    """Cyclone DDS and Fast DDS as they come, multicast discovery on an interface that is no loopback."""
    space = Namespace()
    try:
        space.run("ip link add v0 type veth peer name v1")
        space.run("ip addr add 10.78.0.1/24 dev v0")
        space.run("ip link set v0 up")
        space.run("ip link set v1 up")
        for vendor in ("cyclone", "fastdds"):
            theirs = case.program.parent / f"shapes_{vendor}"
            sub = case.start(f"-S --final -k 0 -t {vendor}", space=space)
            case.vendor(f"-P {case.domain} {vendor}", theirs, space)
            got = sub.hears(5)
            check(f"{vendor}: {got}", {sample[:2] for sample in got} == {(vendor, "GREEN")} and
                  [b[2] - a[2] for a, b in zip(got, got[1:])] == [1] * 4)
            heard = case.vendor(f"-S {case.domain} {vendor}2", theirs, space)
            pub = case.start(f"-P --final -t {vendor}2 -k 0 --num-iterations 100 "
                             "--final-instance-state d", space=space)
            check("heard", {sample[:2] for sample in heard.hears(5)} == {(f"{vendor}2", "BLUE")})
            pub.says("on_publication_matched")
            heard.says("disposed$")
            for process in (sub, pub):
                check("exit code", process.interrupt() == 0 or process is pub)
    finally:
        space.close()


CASES = [vendors, lines, writes_at_once, ends_by_itself, bad_arguments, other_domain, other_topic,
         partitions, mismatch, match, nothing_lost, colours_instances_topics, size_modulo, moves,
         deadline_missed, ownership, shared, late_joiner, persistent, keeper, secured_keeper,
         keeper_without_right, keeper_without_room, full_disk, keep_last, lifespan, read_not_take, take_read,
         final_states, filters, time_filter, ordered, coherent, ended_publisher, large_payload,
         fragments_and_announcements, two_machines]


if __name__ == "__main__":
    sys.exit(run(CASES, range(160, 188), workers=5))

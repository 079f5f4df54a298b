"""The cases of policies.py: for each policy a mismatch, an effect or both."""

from policy_peers import ALL, CYCLONE, FAST, NOT_FAST, OURS

(DURABILITY, PRESENTATION, DEADLINE, LATENCY_BUDGET, OWNERSHIP, LIVELINESS, RELIABILITY, DESTINATION_ORDER,
 DATA_REPRESENTATION, TYPE_CONSISTENCY) = 2, 3, 4, 5, 6, 8, 11, 12, 23, 24
# Cyclone DDS counts this policy behind two of its own; Fast DDS 2.9 checks none of those below, and
# refuses a reader that orders by source.
NUMBER_AT = {(CYCLONE, DATA_REPRESENTATION): 25}
FAST_DOES_NOT_CHECK = (PRESENTATION, LATENCY_BUDGET, DESTINATION_ORDER, DATA_REPRESENTATION, TYPE_CONSISTENCY)


CASES = []


def case_of(policy, writers=ALL, readers=ALL, because=""):
    """What follows tries `policy`, with these stacks as writers and readers, as the others cannot."""
    def register(steps):
        CASES.append((policy, steps.__name__.replace("_", " "), steps, writers, readers, because))
        return steps
    return register


# ---- mismatch ---------------------------------------------------------------------------------------

def mismatch(case, offered, requested, policy):
    writer, reader = case.writer(offered), case.reader(requested)
    for peer, endpoint in ((case.w, writer), (case.r, reader)):
        if peer.kind == FAST and policy in FAST_DOES_NOT_CHECK:
            continue
        number = NUMBER_AT.get((peer.kind, policy), policy)
        yield from case.until(f"said policy {number} at {peer.kind}",
                              lambda p=peer, e=endpoint, n=number: p.status(e)["incompatible"] == n)
        case.check(f"{peer.kind} matched", peer.status(endpoint)["matched"] == 0)


UNCHECKED = "Fast DDS 2.9 does not check it"


def mismatch_of(policy, what, offered, requested, number, writers=ALL, readers=ALL, because=""):
    def steps(case):
        return mismatch(case, offered, requested, number)
    CASES.append((policy, f"{what}, mismatch", steps, writers, readers, because))


mismatch_of("RELIABILITY", "kind", "reliability=best_effort", "reliability=reliable", RELIABILITY)
mismatch_of("DURABILITY", "kind", "durability=volatile", "durability=transient_local", DURABILITY)
mismatch_of("PRESENTATION", "access scope", "", "scope=topic", PRESENTATION, readers=NOT_FAST, because=UNCHECKED)
mismatch_of("PRESENTATION", "coherent access", "", "coherent=on", PRESENTATION, writers=NOT_FAST, readers=NOT_FAST,
            because=UNCHECKED)
mismatch_of("DEADLINE", "period", "deadline=2000", "deadline=1000", DEADLINE)
mismatch_of("LATENCY_BUDGET", "duration", "budget=300", "budget=100", LATENCY_BUDGET, readers=NOT_FAST,
            because=UNCHECKED)
mismatch_of("OWNERSHIP", "kind", "ownership=exclusive", "ownership=shared", OWNERSHIP)
mismatch_of("LIVELINESS", "kind", "liveliness=automatic", "liveliness=topic", LIVELINESS)
mismatch_of("LIVELINESS", "lease", "lease=20000", "lease=10000", LIVELINESS)
mismatch_of("DESTINATION_ORDER", "kind", "order=reception", "order=source", DESTINATION_ORDER, readers=NOT_FAST,
            because="Fast DDS 2.9 refuses readers that order by source")
mismatch_of("DATA_REPRESENTATION", "XCDR2", "representation=2", "representation=1", DATA_REPRESENTATION,
            writers=NOT_FAST, readers=NOT_FAST, because=UNCHECKED)
mismatch_of("TYPE_CONSISTENCY_ENFORCEMENT", "forced validation", "describe=no", "describe=no types=known",
            TYPE_CONSISTENCY, readers=NOT_FAST, because=UNCHECKED)


# ---- effect -----------------------------------------------------------------------------------------

@case_of("PARTITION")
def partitions(case):
    writer = case.writer("partition=room1")
    elsewhere, reader = case.reader("partition=hall"), case.reader("partition=room*")
    yield from case.matched(writer, reader)
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")
    case.check("another partition matched", case.r.status(elsewhere)["matched"] == 0)
    if case.r.kind != CYCLONE:  # there it is one; in DDS 1.4 it is not
        case.check("a partition is called incompatible", case.r.status(elsewhere)["incompatible"] == 0)


@case_of("DEADLINE")
def deadline(case):
    writer, reader = yield from case.pair("deadline=300")
    case.w.ask(f"write {writer} RED 1")
    yield from case.until("missed a deadline", lambda: case.r.status(reader)["deadline"] >= 1 and
                          case.w.status(writer)["deadline"] >= 1)


@case_of("LIFESPAN")
def lifespan(case):
    offered = "durability=transient_local history=all lifespan=800"
    requested = "durability=transient_local history=all"
    if case.r.kind == FAST:  # a reader of it goes by its own LIFESPAN
        requested += " lifespan=800"
    writer, reader = yield from case.pair(offered, requested)
    case.w.ask(f"write {writer} RED 1")
    yield 1.2
    case.check("a sample outlived its lifespan", case.r.take(reader) == [])
    late = case.reader(requested)
    yield from case.matched(writer, late, readers=2)
    case.w.ask(f"write {writer} RED 2")
    yield from case.comes(late, "RED:2:A")


@case_of("OWNERSHIP_STRENGTH")
def ownership(case):
    weak = case.writer("ownership=exclusive strength=5 history=all")
    strong = case.writer("ownership=exclusive strength=10 history=all")
    reader = case.reader("ownership=exclusive history=all")
    yield from case.matched(weak, reader, writers=2)
    yield from case.matched(strong, reader, writers=2)
    case.w.ask(f"write {strong} RED 1")
    yield from case.comes(reader, "RED:1:A")
    for x in range(2, 5):
        case.w.ask(f"write {weak} RED {100 + x}")
        case.w.ask(f"write {strong} RED {x}")
    yield from case.comes(reader, "RED:2:A", "RED:3:A", "RED:4:A")
    case.w.ask(f"delete {strong}")
    yield from case.until("gone", lambda: case.r.status(reader)["matched"] == 1)
    case.w.ask(f"write {weak} RED 200")
    yield from case.until("taken over", lambda: "RED:200:A" in case.collect(reader))


@case_of("WRITER_DATA_LIFECYCLE")
def states(case):
    writer, reader = yield from case.pair("history=all")
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")
    case.w.ask(f"dispose {writer} RED")
    yield from case.until("disposed", lambda: "RED:-:D" in case.collect(reader))
    case.w.ask(f"write {writer} RED 2")
    yield from case.until("alive again", lambda: "RED:2:A" in case.collect(reader))
    if case.r.kind == FAST:  # reports no instances without writers, with any writer
        return
    case.w.ask(f"unregister {writer} RED")
    yield from case.until("without writers", lambda: "RED:-:N" in case.collect(reader))
    case.w.ask(f"write {writer} GREEN 3")
    yield from case.until("there", lambda: "GREEN:3:A" in case.collect(reader))
    case.got.clear()
    case.w.ask(f"delete {writer}")
    yield from case.until("left alone", lambda: "GREEN:-:N" in case.collect(reader))


@case_of("WRITER_DATA_LIFECYCLE")
def deletion_disposes(case):
    """Fast DDS only unregisters, and Cyclone DDS tells its own kind alone, by a vendor's parameter."""
    ends = "D" if case.w.kind == OURS else "N"
    writer, reader = yield from case.pair("history=all autodispose=on")
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")
    case.w.ask(f"delete {writer}")
    yield from case.until("ended", lambda: "RED:-:" + ends in case.collect(reader))


@case_of("WRITER_DATA_LIFECYCLE")
def keys_of_every_length(case):
    """A dispose is of the instance that was meant: Fast DDS 2.9 takes short keys for key hashes."""
    writer, reader = yield from case.pair("history=all")
    colors = ["A" * length for length in (1, 3, 4, 7, 8, 11, 12, 15, 16, 40)]
    for color in colors:
        case.w.ask(f"write {writer} {color} 1")
    written = {f"{color}:1:A" for color in colors}
    yield from case.until("there", lambda: written <= set(case.collect(reader)))
    for color in colors:
        case.w.ask(f"dispose {writer} {color}")
        yield from case.until(f"disposed {color}, but {case.got.get(reader)}",
                              lambda c=color: f"{c}:-:D" in case.collect(reader))


@case_of("WRITER_DATA_LIFECYCLE", writers=NOT_FAST, readers=NOT_FAST, because="Fast DDS 2.9 has no XCDR2")
def states_of_an_appendable_type(case):
    writer, reader = yield from case.pair("history=all representation=2")
    for color in ("RED", "a_rather_long_colour"):
        case.w.ask(f"write {writer} {color} 1")
        yield from case.comes(reader, f"{color}:1:A")
        case.w.ask(f"dispose {writer} {color}")
        yield from case.comes(reader, f"{color}:-:D")
        case.w.ask(f"write {writer} {color} 2")
        yield from case.comes(reader, f"{color}:2:A")
        case.w.ask(f"unregister {writer} {color}")
        yield from case.comes(reader, f"{color}:-:N")


states_of_an_appendable_type.appendable = True  # with peers that have such a type


@case_of("READER_DATA_LIFECYCLE", readers=(OURS,), because="what others do with what they hold is not between us")
def purge(case):
    writer, reader = yield from case.pair("history=all purge=300")
    kept = case.reader("history=all")
    yield from case.matched(writer, kept, readers=2)
    case.w.ask(f"write {writer} RED 1")
    case.w.ask(f"dispose {writer} RED")
    yield 1.0
    yield from case.until("kept", lambda: "RED:1:D" in case.collect(kept))
    case.check(f"not purged: {case.collect(reader)}", not case.collect(reader))


@case_of("DURABILITY")
def late_joiner(case):
    writer = case.writer("durability=transient_local history=2")
    for x in range(5):
        case.w.ask(f"write {writer} RED {x}")
        case.w.ask(f"write {writer} BLUE {x}")
    reader = case.reader("durability=transient_local history=all")
    yield from case.until("got the history", lambda: len(case.collect(reader)) >= 4)
    case.check(f"not the newest two of each: {case.got[reader]}",
               sorted(case.got[reader]) == ["BLUE:3:A", "BLUE:4:A", "RED:3:A", "RED:4:A"])
    young = case.reader("history=all")
    yield from case.matched(writer, young, readers=2)
    case.w.ask(f"write {writer} RED 9")
    # Cyclone DDS sends any volatile reader what it keeps for others.
    old = ["RED:3:A", "BLUE:3:A", "RED:4:A", "BLUE:4:A"] if case.w.kind == CYCLONE else []
    yield from case.until("got the new sample", lambda: "RED:9:A" in case.collect(young))
    case.check(f"got something old: {case.got[young]}",
               set(case.got[young]) <= {"RED:9:A", *old})


@case_of("HISTORY")
def keep_last(case):
    writer, reader = yield from case.pair("history=all", "history=2")
    for x in range(6):
        case.w.ask(f"write {writer} RED {x}")
    case.w.ask(f"write {writer} BLUE 1")
    yield 1.0
    case.check("not the newest two", sorted(case.r.take(reader)) == ["BLUE:1:A", "RED:4:A", "RED:5:A"])


@case_of("RESOURCE_LIMITS", readers=(OURS,), because="what others hold is not between us")
def resource_limits(case):
    writer, reader = yield from case.pair("history=all", "history=all samples=2")
    for x in range(5):
        case.w.ask(f"write {writer} RED {x}")
    yield from case.until("rejected", lambda: case.r.status(reader)["rejected"] >= 1)
    yield from case.comes(reader, *(f"RED:{x}:A" for x in range(5)))


@case_of("LIVELINESS")
def manual_by_topic(case):
    # A lease that a busy machine does not miss; the assertions go on for longer than it.
    writer, reader = yield from case.pair("liveliness=topic lease=1500 history=all",
                                          "history=all lease=1500")
    case.w.ask(f"write {writer} RED 1")
    for _ in range(10):
        yield 0.2
        case.w.ask(f"assert {writer}")
    case.check("not asserted", case.r.status(reader)["alive"] == 1)
    if case.r.kind == FAST:  # never loses the liveliness of a writer of this kind
        return
    yield from case.until("lost its writer", lambda: case.r.status(reader)["not_alive"] == 1)
    yield from case.until("lost its liveliness", lambda: case.w.status(writer)["lost"] >= 1)
    case.w.ask(f"write {writer} RED 2")
    yield from case.until("found its writer again", lambda: case.r.status(reader)["alive"] == 1)


def pair_with_older_reader(case, liveliness):
    """A new reader of Fast DDS pairs with the writers it knows before its liveliness is watched, and for
    good misses what any writer asserts in between. So the reader is there first."""
    reader = case.reader(liveliness + " history=all")
    yield 0.3
    writer = case.writer(liveliness + " history=all")
    yield from case.matched(writer, reader)
    return writer, reader


@case_of("LIVELINESS")
def manual_by_participant(case):
    writer, reader = yield from pair_with_older_reader(case, "liveliness=participant lease=1500")
    for _ in range(10):
        yield 0.2
        case.w.ask(f"assert {writer}")
    case.check("not asserted", case.r.status(reader)["alive"] == 1)


@case_of("LIVELINESS")
def automatic(case):
    writer, reader = yield from pair_with_older_reader(case, "liveliness=automatic lease=700")
    case.w.ask(f"write {writer} RED 1")
    for _ in range(10):
        yield 0.2
        case.check("not asserted", case.r.status(reader)["alive"] == 1)


@case_of("DESTINATION_ORDER", writers=NOT_FAST, readers=NOT_FAST, because="Fast DDS 2.9 has no source order")
def by_source(case):
    writer = case.writer("order=source history=all")
    other = case.writer("order=source history=all")
    reader = case.reader("order=source history=all")
    yield from case.matched(writer, reader, writers=2)
    yield from case.matched(other, reader, writers=2)
    case.w.ask(f"write {writer} RED 2 2000")
    yield from case.comes(reader, "RED:2:A")
    case.w.ask(f"write {other} RED 1 1000")
    case.w.ask(f"write {other} RED 3 3000")
    yield from case.comes(reader, "RED:3:A")


@case_of("DATA_REPRESENTATION", writers=NOT_FAST, readers=NOT_FAST, because="Fast DDS 2.9 has no XCDR2")
def representation_2(case):
    writer, reader = yield from case.pair("representation=2 history=all")
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")


@case_of("TYPE_CONSISTENCY_ENFORCEMENT", writers=NOT_FAST, readers=NOT_FAST, because="Fast DDS 2.9 tells nothing of types")
def type_consistency(case):
    """A reader that wants to know the type, and the same."""
    writer, reader = yield from case.pair("history=all", "history=all types=same")
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")


@case_of("content filter", readers=(OURS, FAST), because="filters of Cyclone DDS are functions of its application")
def content_filter(case):
    few = case.reader("history=all filter=x>2")  # Fast DDS cannot read x>=2 without spaces
    blue = case.reader("history=all filter=color='BLUE'")
    writer = case.writer("history=all")
    for reader in (few, blue):
        yield from case.matched(writer, reader, readers=2)
    for x in range(6):
        case.w.ask(f"write {writer} RED {x}")
    case.w.ask(f"write {writer} BLUE 1")
    yield from case.comes(few, "RED:3:A", "RED:4:A", "RED:5:A")
    yield from case.comes(blue, "BLUE:1:A")
    if case.r.kind == OURS:
        case.check("what was filtered counts as lost", case.r.status(few)["samples_lost"] == 0)


@case_of("content filter", readers=(OURS, FAST), because="filters of Cyclone DDS are functions of its application")
def filtered_history(case):
    """A late joiner asks for what its filter lets pass, and the writer answers with GAP for the rest."""
    writer = case.writer("durability=transient_local history=all")
    for x in range(6):
        case.w.ask(f"write {writer} RED {x}")
    few = case.reader("durability=transient_local history=all filter=x>3")
    yield from case.matched(writer, few)
    yield from case.comes(few, "RED:4:A", "RED:5:A")


@case_of("TIME_BASED_FILTER", readers=(OURS,), because="neither Cyclone DDS 0.10 nor Fast DDS 2.9 has it")
def time_based_filter(case):
    writer, reader = yield from case.pair("history=all", "history=all separation=3000")
    for x in range(10):
        case.w.ask(f"write {writer} RED {x}")
    yield from case.comes(reader, "RED:0:A")
    yield 0.3
    case.check("more than one came", case.collect(reader) == [])
    yield from case.comes(reader, "RED:9:A")


@case_of("RELIABILITY")
def in_order_and_whole(case):
    writer, reader = yield from case.pair("history=all")
    for x in range(100):
        case.w.ask(f"write {writer} RED {x}")
        if x % 5 == 4:
            yield 0.01  # others have leases to keep
    yield from case.comes(reader, *(f"RED:{x}:A" for x in range(100)))


@case_of("LATENCY_BUDGET", writers=(OURS, FAST), because="Cyclone DDS may batch until its application flushes")
def batching(case):
    """Our writer waits for more samples to send together. Those that were written still arrive in time."""
    writer, reader = yield from case.pair("budget=200 history=all", "budget=400 history=all")
    for x in range(5):
        case.w.ask(f"write {writer} RED {x}")
    yield from case.comes(reader, *(f"RED:{x}:A" for x in range(5)))


@case_of("DURABILITY_SERVICE", writers=NOT_FAST, because="Fast DDS 2.9 does not use it")
def service_depth(case):
    """HISTORY keeps one for those that are there, the service three for who comes late."""
    kind = "transient" if case.w.kind == OURS else "transient_local"
    writer = case.writer(f"durability={kind} history=1 service=3")
    for x in range(5):
        case.w.ask(f"write {writer} RED {x}")
    reader = case.reader("durability=transient_local history=all")
    yield from case.comes(reader, "RED:2:A", "RED:3:A", "RED:4:A")


def told(policy, word, readers=ALL, because=""):
    def steps(case):
        writer, reader = yield from case.pair(f"{word}=from_writer", f"{word}=from_reader")
        for peer, endpoint, data in ((case.w, writer, "from_reader"), (case.r, reader, "from_writer")):
            yield from case.until(f"told {peer.kind}, but {peer.ask(f'told {endpoint}')}",
                                  lambda p=peer, e=endpoint, d=data: f"{word}={d}" in p.ask(f"told {e}").split())
    CASES.append((policy, "told to the other", steps, ALL, readers, because))


told("USER_DATA", "user")
told("TOPIC_DATA", "topic", readers=NOT_FAST, because="readers of Fast DDS 2.9 do not announce it")
told("GROUP_DATA", "group")


@case_of("ENTITY_FACTORY", writers=(OURS, FAST), because="Cyclone DDS 0.10 has none")
def born_disabled(case):
    writer, reader = case.writer("factory=off history=all"), case.reader("history=all")
    yield 1.0
    case.check("announced before it was enabled", case.r.status(reader)["matched"] == 0)
    case.w.ask(f"enable {writer}")
    yield from case.matched(writer, reader)
    case.w.ask(f"write {writer} RED 1")
    yield from case.comes(reader, "RED:1:A")


@case_of("TRANSPORT_PRIORITY", writers=(OURS,), because="neither Cyclone DDS 0.10 nor Fast DDS 2.9 marks what it sends")
def marked_packets(case):
    """What goes over the network says so in its traffic class."""
    color = "C" + case.topic[-12:]
    seen = case.packets_with(color)
    try:
        writer, reader = yield from case.pair("priority=46 history=all", "history=all")
        case.w.ask(f"write {writer} {color} 1")
        yield from case.comes(reader, f"{color}:1:A")
        case.check("no packet of the highest class", seen.stdout.readline().strip() == str(46 << 2))
    finally:
        seen.kill()
        seen.wait()
        seen.stdout.close()

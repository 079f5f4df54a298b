"""The fleet of never_restart_test.py: its processes and endpoints, the report of a run, and what a run must show."""

import collections
import os
import time

from shapes_process import check  # puts the folders of what follows in place
from surroundings import machine

OUT = 2.0     # seconds after its end until a participant that is not renewed is out
LONG = 3600   # seconds that documents last which must not end
SLOW = 8.0    # seconds that a loaded machine may add to it
LEFT = "e6"   # the participant that is not renewed
NARROWED = "e5"
DENIED = "c4"  # loses a right for good
EMBEDDED = [f"e{i}" for i in range(1, 7)]
CYCLONE = [f"c{i}" for i in range(1, 5)]
TOPICS = ["Steady", "Video", "Mixed", "Ping", "Pong", "Narrow", "Left", "Raised", "Fleeting", "Denied"]
JUDGED = ("Steady", "Mixed", "Further", "Raised", "Fleeting", "Ping", "Pong")  # no sample may be lost
UNDISTURBED = ("Steady", "Video", "Raised", "Ping", "Pong")  # embedded writers: no instance may end
RAISED = ["e1", "e2", "e3", "e4"]  # the participants that use the topic whose protection is raised
FURTHER = [("e2", "writer Further durable 20000 64"), ("e4", "reader Further durable"),
           (DENIED, "reader Further durable")]  # made after a change of governance
RATED = ("Steady", "Video")  # topics whose rates the proof asks for
RATE = 0.9    # the share of them that an idle machine must reach
RENEWED = {"short": 2, "long": 15}  # certificates and permissions that each participant must load


def endpoints(is_short):
    """(participant, command) of each; the rates of the long form are those that the proof asks for."""
    steady, video = (5000, "7800 8192") if is_short else (1000, "780 8192")
    yield "e1", f"writer Steady reliable {steady} 64"
    for reader in EMBEDDED[1:]:
        yield reader, "reader Steady reliable"
    yield "e2", f"writer Video best_effort {video}"
    for reader in ("e3", "c1"):
        yield reader, "reader Video best_effort"
    for writer in ("e3", "c1"):
        yield writer, "writer Mixed durable 20000 64"
    for reader in ("e1", "e4", "e5", "e6", "c2", "c3", "c4"):
        yield reader, "reader Mixed durable"
    for writer in ("e3", "c1"):  # VOLATILE: samples sent between two sessions are lost
        yield writer, "writer Fleeting reliable 20000 64"
    for reader in ("e1", "e4", "c2", "c3"):
        yield reader, "reader Fleeting reliable"
    yield "e1", "writer Ping reliable 20000 64"
    yield "e4", "writer Pong reliable 0 64"
    yield "e4", "reader Ping reliable Pong"
    yield "e1", "reader Pong reliable"
    yield "e2", "writer Denied reliable 50000 64"
    yield DENIED, "reader Denied reliable"
    yield "e2", "writer Narrow reliable 50000 64"
    yield NARROWED, "reader Narrow reliable"
    yield RAISED[0], "writer Raised reliable 5000 64"
    for reader in RAISED[1:]:
        yield reader, "reader Raised reliable"
    yield LEFT, "writer Left durable 20000 64"
    for reader in ("e1", "c1"):
        yield reader, "reader Left durable"


def expected_streams(commands):
    """{(topic, writer, reader)} of these endpoints."""
    ends = collections.defaultdict(set)
    for name, command in commands:
        kind, topic = command.split()[:2]
        ends[kind, topic].add(name)
    return {(topic, writer, reader) for (kind, topic), writers in list(ends.items()) if kind == "writer"
            for writer in writers for reader in ends["reader", topic]}


def is_embedded(topic, writer, reader):
    return writer in EMBEDDED and reader in EMBEDDED


def endpoint_of(report, name, kind, topic):
    return next(one for one in report[name][kind] if one["topic"] == topic)


def streams(report, name, topic):
    return endpoint_of(report, name, "readers", topic)["streams"]


def gap_of(stream, began):
    """The worst gap, and the second of the run in which it ended."""
    at = stream["worst_gap_at_s"] + time.time() - time.monotonic() - began
    return f"{stream['worst_gap_ms']:.0f} ms" + (f" (ended at {at:.1f} s)" if stream["worst_gap_at_s"] else "")


def rows(story):
    """(what, without changes, with changes)."""
    quiet, changing = story.quiet, story.changing
    for title, name, topic, writer in (("round trip, embedded", "e1", "Pong", "e4"),):
        one, other = (streams(report, name, topic)[writer] for report in (quiet, changing))
        for field in ("p50_ms", "p99_ms"):
            yield f"{title}, {field[:3]}", f"{one[field]:.1f} ms", f"{other[field]:.1f} ms"
    for title, name, topic, writer in (
            ("worst gap, best effort, embedded to embedded", "e3", "Video", "e2"),
            ("worst gap, best effort, embedded to Cyclone DDS", "c1", "Video", "e2"),
            ("worst gap, reliable, embedded to embedded", "e2", "Steady", "e1"),
            ("worst gap, reliable, Cyclone DDS to Cyclone DDS", "c2", "Fleeting", "c1"),
            ("worst gap, reliable, embedded to Cyclone DDS", "c2", "Fleeting", "e3"),
            ("worst gap, reliable, Cyclone DDS to embedded", "e4", "Fleeting", "c1")):
        yield (title, *(gap_of(streams(report, name, topic)[writer], story.began) for report in (quiet, changing)))


def rates(story):
    """(topic, writer, samples per second that are asked for, written, octets of each, refused attempts) while the
    documents changed."""
    for writer, command in endpoints(story.is_short):
        kind, topic, _, *numbers = command.split()
        if kind == "writer" and topic in RATED:
            before, after = (endpoint_of(report, writer, "writers", topic) for report in (story.quiet, story.changing))
            written = (after["written"] - before["written"]) / story.changing_seconds
            yield topic, writer, 1e6 / int(numbers[0]), written, int(numbers[1]), after["refused"] - before["refused"]


def print_rates(story):
    for topic, writer, wanted, written, octets, refused in rates(story):
        received = []
        for reader in sorted(one[2] for one in expected_streams(endpoints(story.is_short)) if one[0] == topic):
            before, after = (streams(report, reader, topic)[writer]["received"] for report in (story.quiet, story.changing))
            received.append(f"{reader} {(after - before) / story.changing_seconds:.0f}")
        print(f"{topic}: {written:.0f} samples/s written of {wanted:.0f}, {written * octets / 1e6:.2f} MB/s; received per "
              f"second: {', '.join(received)}; attempts that the writer refused, and repeated: {refused}")


def kind_of(name):
    return "embedded" if name in EMBEDDED else "Cyclone DDS"


def print_report(story, totals):
    print(f"{machine()} {time.strftime('%H:%M')}, load {os.getloadavg()[0]:.1f}, {story.form} form, "
          f"{time.time() - story.began:.0f} s")
    print(f"processors idle: {story.idle:.0%} before the run, {story.changing_idle:.0%} while the documents changed, "
          f"{story.idle_after:.0%} after it" +
          ("; documents were signed by processes of low priority (nice 10)" if story.is_strict else "") + "\n")
    for at, text in story.steps:
        print(f"{at:6.1f} s  {text}")
    print("\n| measured | quiet | documents change |\n|---|---|---|")
    for row in rows(story):
        print("| " + " | ".join(row) + " |")
    print("\n| reliable samples | written and read | lost | came again |\n|---|---|---|---|")
    for kind, (received, missing, repeated) in totals.items():
        print(f"| {kind} | {received - repeated} | {missing} | {repeated} |")
    names = ("identity_renewed", "permissions_renewed")
    print("\n| participant | certificates taken | permissions taken |\n|---|---|---|")
    for name in story.renewed:
        print(f"| {name} | " + " | ".join(str(len(story.peers[name].events(event))) for event in names) + " |")
    print()
    print_rates(story)
    print(f"agent: {story.agent.count('renewed')} certificates renewed, killed {story.agent.killed} times, "
          f"failures {dict(story.agent.failures())}")
    print(f"told of the end of an instance (reader, topic, times): {ends_of(story) or 'none'}")
    print(f"slowest command of ddssec: {story.folders.slowest:.1f} s")
    print(f"restarts 0; {LEFT} out {story.figures['out']:.1f} s after its end; right lost after "
          f"{story.figures['narrowed']:.1f} s (in Cyclone DDS {story.figures['denied']:.1f} s), back after {story.figures['widened']:.1f} s; "
          f"a new topic read in Cyclone DDS after {story.figures['gained']:.1f} s; protection raised after "
          f"{story.figures['raised']:.1f} s")
    for kind, group in (("embedded", EMBEDDED), ("Cyclone DDS", CYCLONE)):
        seen = collections.Counter(event["name"] for name in group for event in story.peers[name].events())
        print(f"events, {kind}: " + ", ".join(f"{name} {count}" for name, count in sorted(seen.items())))


def totals_of(pairs):
    totals = {}
    for topic, writer, reader, missing, stream in pairs:
        kind = f"{topic}: {kind_of(writer)} to {kind_of(reader)}"
        before = totals.get(kind, (0, 0, 0))
        totals[kind] = (before[0] + stream["received"], before[1] + missing, before[2] + stream["repeated"])
    return totals


def ends_of(story):
    """(reader, topic, samples that told it of the end of an instance)."""
    return [(name, reader["topic"], reader["ends"]) for name in EMBEDDED + CYCLONE if name != LEFT
            for reader in story.changing[name]["readers"] if reader["ends"]]


def judge(story):
    ended = [one for one in ends_of(story) if one[0] in EMBEDDED and one[1] in UNDISTURBED]
    check(f"instances ended between embedded participants: {ended}", not ended)
    told = {one[:2] for one in ends_of(story)}
    check(f"a lost match tells readers of the end: {told}", {(NARROWED, "Narrow"), ("e1", "Left")} <= told)
    check_streams(story.found, story.is_short)
    lost = [one for one in story.losses if is_embedded(*one[:3])]
    check(f"lost between embedded participants: {lost}", not lost)
    check(f"lost with Cyclone DDS on one side: {story.losses}", not story.losses)
    check_renewals(story)
    for name in EMBEDDED[:5]:
        outlived = [event for event in story.peers[name].events("session_outlived_documents")
                    if event["peer_subject"].removeprefix("CN=") in EMBEDDED]
        check(f"{name} ended a session with an embedded one: {outlived[:2]}", not outlived)
    check_times(story)


def check_streams(found, is_short):
    """A reader that never received a sample of a writer lost all of them, and has no count of it."""
    wanted = {one for one in expected_streams([*endpoints(is_short), *FURTHER]) if one[0] in JUDGED and one[2] != LEFT}
    check(f"no sample of these (topic, writer, reader) ever arrived: {sorted(wanted - found)}", wanted <= found)
    check(f"no such endpoints were asked for: {sorted(found - wanted)}", found <= wanted)


def check_renewals(story):
    folders, seconds = story.folders, time.time() - story.changing_since
    slow = f": this machine is too slow for the proof, its documents last {folders.pace:.1f} times as long" if (
        folders.pace > 1) else ""
    for name in story.renewed:
        for event, period in (("identity_renewed", folders.certificate),
                              ("permissions_renewed", folders.permissions / 2)):
            least = max(int(seconds / period) - 2, RENEWED[story.form])
            taken = len(story.peers[name].events(event))
            check(f"{name} says {event} {taken} times, not {least}{slow}", taken >= least)


def check_times(story):
    """What a change may cost is measured on a machine that does nothing else; on others, nothing may take seconds."""
    quiet, changing = (streams(report, "e1", "Pong")["e4"]["p99_ms"] for report in (story.quiet, story.changing))
    is_idle = story.is_idle()
    trip, gap, late = (2 * quiet, 50, OUT) if is_idle else (1000, 5000, OUT + SLOW)
    print(f"the limits are those of {'an idle' if is_idle else 'a busy'} machine: round trip, 99 % {trip:.1f} ms, gap {gap} ms, "
          f"out and rights within {late:.0f} s")
    measured = [(f"99 % of the round trips within {changing} ms, without changes {quiet} ms", changing, trip)]
    measured.append(("gap of best effort between embedded participants, in ms",
                     streams(story.changing, "e3", "Video")["e2"]["worst_gap_ms"], gap))
    measured += [(f"seconds until {what}", story.figures[key], late) for key, what in (
        ("out", f"{LEFT} was out after its end"), ("narrowed", f"{NARROWED} had lost a right on both sides"),
        ("widened", f"{NARROWED} had it again"), ("denied", f"{DENIED} had lost a right on both sides"))]
    faults = [f"{what}: {value:.1f}, and the limit is {limit:.1f}" for what, value, limit in measured if value > limit]
    faults += [f"{topic}: {written:.0f} samples/s written, and {wanted:.0f} are asked for"
               for topic, _, wanted, written, _, _ in rates(story) if is_idle and written < RATE * wanted]
    check("; ".join(faults), not faults)

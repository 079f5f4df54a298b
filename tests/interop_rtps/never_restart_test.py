#!/usr/bin/env python3
"""Six embedded and four Cyclone DDS processes on our plugins exchange data while all their documents change. None is
restarted: certificates and permissions of seconds, both CAs, rights, governance, a broken document, an agent that is
killed twice, protection of a topic raised from SIGN to ENCRYPT, one participant that is not renewed. Prints what was lost, and how long it took.
Usage: never_restart_test.py BUILD [--short]"""

import collections
import json
import os
import pathlib
import sys
import tempfile
import time

sys.dont_write_bytecode = True
from steady_fleet import LOOKS, START, Agent, Folders, Namespace, Peer, PermissionsRenewer, check, replace_file
from surroundings import machine

WAIT = 60.0   # seconds until an event on a loaded machine
OUT = 2.0     # seconds after its end until a participant that is not renewed is out
LONG = 3600   # seconds that documents last which must not end
SLOW = 8.0    # seconds that a loaded machine may add to it
QUIET = 1.0   # the load before a run whose times count
LEFT = "e6"   # the participant that is not renewed
NARROWED = "e5"
DENIED = "c4"  # loses a right for good
EMBEDDED = [f"e{i}" for i in range(1, 7)]
CYCLONE = [f"c{i}" for i in range(1, 5)]
TOPICS = ["Steady", "Video", "Mixed", "Ping", "Pong", "Narrow", "Left", "Raised", "Fleeting", "Denied"]
JUDGED = ("Steady", "Mixed", "Further", "Raised", "Fleeting")  # no sample may be lost
UNDISTURBED = ("Steady", "Video", "Raised", "Ping", "Pong")  # embedded writers: no instance may end
RAISED = ["e1", "e2", "e3", "e4"]  # the participants that use the topic whose protection is raised
ENDS = {"identity": ("identity_ca_renewed", "identity_renewed"),
        "permissions": ("permissions_ca_renewed", "permissions_renewed")}


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


class Story:
    def __init__(self, is_short):
        self.is_short, self.peers, self.agent, self.renewer, self.space = is_short, {}, None, None, None
        self.form = "short" if is_short else "long"
        self.quiet_seconds, self.duration = (12, 110) if is_short else (15, 600)
        self.figures, self.steps, self.began, self.load = {}, [], time.time(), os.getloadavg()[0]
        self.renewed = [name for name in EMBEDDED + CYCLONE if name != LEFT]

    def start(self, build, at):
        self.folders, self.space = Folders(build, at, EMBEDDED + CYCLONE, TOPICS, self.form), Namespace()
        self.left_end = self.folders.put_certificates(EMBEDDED + CYCLONE, int(START * self.folders.certificate))[LEFT]
        self.note("the documents are made")
        self.began = time.time()
        for name in EMBEDDED + CYCLONE:
            self.peers[name] = Peer(build, self.space, self.folders, name)
        for peer in self.peers.values():
            peer.answer()
        self.pids = {name: peer.process.pid for name, peer in self.peers.items()}

    def note(self, text):
        self.steps.append((time.time() - self.began, text))

    def until(self, what, is_so, seconds=WAIT):
        end = time.monotonic() + seconds
        while not is_so():
            check(f"never: {what}", time.monotonic() < end)
            check(f"the permissions: {self.renewer and self.renewer.fault}", not (self.renewer and self.renewer.fault))
            time.sleep(0.1)

    def all_say(self, event, after, names=None):
        missing = set(names or self.renewed)

        def is_so():
            missing.difference_update([name for name in missing if self.peers[name].events(event, after)])
            return not missing
        try:
            self.until(event, is_so)
        except AssertionError as fault:
            raise AssertionError(f"{fault}, by {sorted(missing)}") from None

    def endpoint(self, name, kind, topic):
        found = [one for one in self.peers[name].ask("report")[kind] if one["topic"] == topic]
        return found[0]

    def stream(self, name, topic, writer):
        return self.endpoint(name, "readers", topic)["streams"].get(writer)

    def phase(self):
        return {name: peer.ask("phase") for name, peer in self.peers.items()}

    # ---- the steps, in their order

    def begin(self):
        wanted = collections.Counter()
        commands = list(endpoints(self.is_short))
        for name, command in commands:
            check(f"{name}: {command}: {self.peers[name].last_words()}", self.peers[name].ask(command)["ok"])
        for _, command in commands:
            wanted[tuple(command.split()[:2])] += 1

        def all_match():
            for name, command in commands:
                kind, topic = command.split()[:2]
                other = "reader" if kind == "writer" else "writer"
                if self.endpoint(name, kind + "s", topic)["matched"] < wanted[other, topic]:
                    return False
            return True
        self.until("all match", all_match)
        self.note("all match")
        self.phase()
        time.sleep(self.quiet_seconds)  # what is measured without changes
        self.quiet = self.phase()
        self.note("the quiet phase is over")
        while time.time() + self.folders.certificate <= self.left_end:  # a running participant takes no earlier end
            time.sleep(0.2)
        self.folders.put_certificates(self.renewed, self.folders.certificate)
        self.agent = Agent(self.folders, self.renewed)
        self.renewer = PermissionsRenewer(self.folders, self.renewed)
        self.changing_since = time.time()
        self.note(f"certificates last {self.folders.certificate} s, permissions {self.folders.permissions} s")

    def not_renewed(self):
        is_theirs, left = {"peer_subject": f"CN={LEFT}"}, max(0.0, self.left_end - time.time())
        for name in ("e1", "c1"):
            self.until(f"{name} says that {LEFT} has ended", lambda name=name: any(
                is_theirs.items() <= event.items() for event in self.peers[name].events("identity_ended")),
                WAIT + left)
        self.until(f"{LEFT} says that it has ended", lambda: self.peers[LEFT].events("identity_ended"))
        time.sleep(OUT)  # what may still come
        to_wall = time.time() - time.monotonic()
        last = [self.stream(name, topic, writer)["last_s"] + to_wall - self.left_end for name, topic, writer in (
            ("e1", "Left", LEFT), ("c1", "Left", LEFT), (LEFT, "Steady", "e1"), (LEFT, "Mixed", "e3"),
            (LEFT, "Mixed", "c1"))]
        self.figures["out"] = max(last)
        check(f"{LEFT} was out {last} s after its end", max(last) < OUT + SLOW)
        self.note(f"{LEFT} is out; both sides say so")

    def kill_agent(self):
        self.agent.kill_and_start()
        self.note("the agent was killed")

    def present(self):
        return self.renewed if "out" in self.figures else EMBEDDED + CYCLONE

    def rotate(self, role):
        """Rotates with an overlap: no permissions are signed with a successor that others do not know."""
        authority, own = ENDS[role]
        folders = [f"demo/{name}" for name in self.present()]

        def step(*words):
            at = time.time()
            self.folders.ddssec("ca", "rotate", "demo", *folders, "--role", role, *words)
            return at
        with self.folders.signing:
            self.all_say(authority, step("--overlap", "1d"), self.present())
        self.note(f"{role} CA: the successor is accepted")
        at = step("--move")
        if role == "permissions":  # what was signed anew says the same, and is not reported again within seconds
            at = time.time()
            with self.folders.signing:
                for name in self.present():
                    self.folders.put_permissions(name, LONG if name == LEFT else 0)
        self.all_say(own, at, self.present())
        self.folders.distribute(self.renewed)
        self.note(f"{role} CA: all have moved, and have the list")
        time.sleep(2 * LOOKS)  # docs/renew-without-restart.md: peers were shown the new documents, or read the list
        self.all_say(authority, step("--end"), self.present())
        self.note(f"{role} CA: the former one has ended")

    def narrow(self):
        def matched():
            return (self.endpoint("e2", "writers", "Narrow")["matched"],
                    self.endpoint(NARROWED, "readers", "Narrow")["matched"])

        def put(denied):
            self.folders.denied.update(denied)
            with self.folders.signing:
                self.folders.put_permissions(NARROWED)
            return time.monotonic()
        at = put({NARROWED: ("subscribe", "Narrow")})
        self.until("the right is lost on both sides", lambda: matched() == (0, 0))
        self.figures["narrowed"] = time.monotonic() - at
        before = self.stream(NARROWED, "Narrow", "e2")["received"]
        at = put({NARROWED: None})
        self.until("the right is back", lambda: self.stream(NARROWED, "Narrow", "e2")["received"] > before)
        self.figures["widened"] = time.monotonic() - at
        self.note(f"{NARROWED} lost a right, and has it again")

    def deny(self):
        """A Cyclone DDS participant loses a right: its sessions begin again, without that match."""
        self.folders.denied[DENIED] = ("subscribe", "Denied")
        at, began = time.time(), time.monotonic()
        with self.folders.signing:
            self.folders.put_permissions(DENIED)
        self.until("the right is lost on both sides", lambda: (
            self.endpoint("e2", "writers", "Denied")["matched"], self.endpoint(DENIED, "readers", "Denied")["matched"]) == (0, 0))
        self.figures["denied"] = time.monotonic() - began
        for writer in ("c1", "e3"):
            before = self.stream(DENIED, "Mixed", writer)["received"]
            self.until(f"{DENIED} reads {writer}'s topic again", lambda writer=writer, before=before:
                       self.stream(DENIED, "Mixed", writer)["received"] > before + 50)
        told = self.peers[DENIED].events("own_rights_lost", at)
        check(f"own_rights_lost: {told}", len(told) == 1 and "Denied" in told[0]["sentence"])
        check("the match is back", self.endpoint("e2", "writers", "Denied")["matched"] == 0)
        self.note(f"{DENIED} lost a right")

    def govern(self):
        """A further topic rule, which running participants take, and endpoints of that topic."""
        old = self.folders.at / "old.xml"
        old.write_bytes((self.folders.at / "demo/governance.xml").read_bytes())
        at = time.time()
        with self.folders.signing:
            self.folders.topics.append("Further")
            self.folders.put_governance(self.present())
        diff = self.folders.ddssec("governance", "diff", str(old), "demo/governance.xml", "--format", "json")
        check(f"not live: {diff}", json.loads(diff)["result"]["live"]["ddssec"] == "live")
        self.all_say("governance_renewed", at, self.present())
        at = time.time()
        with self.folders.signing:
            for name in self.renewed:
                self.folders.put_permissions(name)
        self.all_say("permissions_renewed", at)
        # The session of e2 and c4 ends with the former permissions, since it needs a right that they do not give.
        for name, command in (("e2", "writer Further durable 20000 64"), ("e4", "reader Further durable"),
                              (DENIED, "reader Further durable")):
            check(f"{name}: {command}: {self.peers[name].last_words()}", self.peers[name].ask(command)["ok"])
        for name in ("e4", DENIED):
            self.until(f"{name} reads the further topic", lambda name=name: self.stream(name, "Further", "e2"),
                       WAIT + self.folders.permissions)
        self.note("a further governance rule is in force, and its topic is used")

    def raise_protection(self):
        """From SIGN to ENCRYPT for a topic in use: in two phases where it is used, at once by the others."""
        old = self.folders.at / "signed.xml"
        old.write_bytes((self.folders.at / "demo/governance.xml").read_bytes())
        before = {name: self.peers[name].ask("report") for name in RAISED}
        at, began = time.time(), time.monotonic()
        with self.folders.signing:
            self.folders.kinds["Raised"] = "ENCRYPT", "ENCRYPT"
            self.folders.put_governance(self.present())
        live = json.loads(self.folders.ddssec("governance", "diff", str(old), "demo/governance.xml", "--format",
                                              "json"))["result"]["live"]
        check(f"forecast: {live}", (live["embedded"], live["cyclonedds"]) == ("two phases", "live unless in use"))
        self.all_say("governance_changing", at, RAISED)
        self.all_say("governance_renewed", at, self.present())
        self.figures["raised"] = time.monotonic() - began
        for name in self.present():
            phased = bool(self.peers[name].events("governance_changing", at))
            check(f"{name}: two phases {phased}", phased == (name in RAISED))
            refused = self.peers[name].events("governance_renewal_refused", at)
            check(f"{name} refused the raised protection: {refused[:1]}", not refused)
        for name in RAISED:
            for event in ("governance_peer_behind", "rtps_security_info_mismatch"):
                check(f"{name}: {event}", not self.peers[name].events(event, at))
        for name in RAISED[1:]:
            seen = before[name]["readers"]
            received = next(one for one in seen if one["topic"] == "Raised")["streams"][RAISED[0]]["received"]
            self.until(f"{name} reads the raised topic", lambda name=name, received=received:
                       self.stream(name, "Raised", RAISED[0])["received"] > received + 100)
        self.note("the protection of a topic in use was raised from SIGN to ENCRYPT")

    def roll_back(self):
        """A signed document of before is put back."""
        at, name = time.time(), RAISED[1]
        present = (self.folders[name] / "governance.p7s").read_bytes()
        replace_file(self.folders[name] / "governance.p7s", self.folders.first_governance)
        self.all_say("governance_renewal_refused", at, [name])
        replace_file(self.folders[name] / "governance.p7s", present)
        self.note("an old governance document was refused")

    def push_broken(self):
        at, broken = time.time(), ("e2", "c2")
        with self.folders.signing:
            for name in broken:
                whole = (self.folders[name] / "permissions.p7s").read_bytes()
                replace_file(self.folders[name] / "permissions.p7s", whole[:len(whole) // 2])
            self.all_say("permissions_renewal_refused", at, broken)
            for name in broken:
                self.folders.put_permissions(name)
        self.note("a broken document was refused")

    def end(self):
        while (left := self.began + self.duration - time.time()) > 0:
            time.sleep(min(left, 1.0))
            check(f"the permissions: {self.renewer.fault}", not self.renewer.fault)
        self.changing = self.phase()
        for peer in self.peers.values():
            peer.ask("stop")
        end = time.monotonic() + WAIT
        while self.lost() and time.monotonic() < end:
            time.sleep(0.5)
        self.totals, self.losses = totals_of(self.pairs()), self.lost()
        for name, peer in self.peers.items():
            check(f"{name} was restarted", peer.process.pid == self.pids[name] and peer.process.poll() is None)
            peer.ask("quit")
        for name, peer in self.peers.items():
            check(f"{name} ended with {peer.process.wait(WAIT)}: {peer.last_words()}", peer.process.returncode == 0)

    def pairs(self, kinds=JUDGED):
        """(topic, writer, reader, samples that never came, of the reader's stream)."""
        reports = {name: peer.ask("report") for name, peer in self.peers.items() if peer.process.poll() is None}
        for name, report in reports.items():
            for reader in report["readers"] if name != LEFT else []:
                for writer, stream in reader["streams"].items() if reader["topic"] in kinds else []:
                    written = [one["written"] for one in reports[writer]["writers"] if one["topic"] == reader["topic"]]
                    yield reader["topic"], writer, name, stream["missing"] + written[0] - 1 - stream["highest"], stream

    def lost(self):
        return [(topic, writer, reader, missing) for topic, writer, reader, missing, _ in self.pairs() if missing]

    def close(self):
        if self.renewer:
            self.renewer.close()
        if self.agent:
            self.agent.close()
        for peer in self.peers.values():
            peer.close()
        if self.space:
            self.space.close()


def is_embedded(topic, writer, reader):
    return writer in EMBEDDED and reader in EMBEDDED


def streams(report, name, topic):
    return next(one["streams"] for one in report[name]["readers"] if one["topic"] == topic)


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
        gaps = [streams(report, name, topic)[writer]["worst_gap_ms"] for report in (quiet, changing)]
        yield (title, *(f"{gap:.0f} ms" for gap in gaps))


def kind_of(name):
    return "embedded" if name in EMBEDDED else "Cyclone DDS"


def print_report(story, totals):
    print(f"{machine()} {time.strftime('%H:%M')}, load {os.getloadavg()[0]:.1f}, "
          f"{'short' if story.is_short else 'long'} form, {time.time() - story.began:.0f} s\n")
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
    print(f"\nagent: {story.agent.count('renewed')} certificates renewed, killed {story.agent.killed} times, "
          f"failures {dict(story.agent.failures())}")
    print(f"told of the end of an instance (reader, topic, times): {ends_of(story) or 'none'}")
    print(f"slowest command of ddssec: {story.folders.slowest:.1f} s")
    print(f"restarts 0; {LEFT} out {story.figures['out']:.1f} s after its end; right lost after "
          f"{story.figures['narrowed']:.1f} s (in Cyclone DDS {story.figures['denied']:.1f} s), back after {story.figures['widened']:.1f} s; protection raised after "
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
    lost = [one for one in story.losses if is_embedded(*one[:3])]
    check(f"lost between embedded participants: {lost}", not lost)
    check(f"lost with Cyclone DDS on one side: {story.losses}", not story.losses)
    folders = story.folders
    for name in story.renewed:
        for event, seconds in (("identity_renewed", folders.certificate),
                               ("permissions_renewed", folders.permissions / 2)):
            least, taken = int((time.time() - story.changing_since) / seconds) - 2, len(story.peers[name].events(event))
            check(f"{name} says {event} {taken} times, not {least}", taken >= least)
    for name in EMBEDDED[:5]:
        outlived = [event for event in story.peers[name].events("session_outlived_documents")
                    if event["peer_subject"].removeprefix("CN=") in EMBEDDED]
        check(f"{name} ended a session with an embedded one: {outlived[:2]}", not outlived)
    check_times(story)


def check_times(story):
    """What a change may cost is measured on a machine that does nothing else; on others, nothing may take seconds."""
    quiet, changing = (streams(report, "e1", "Pong")["e4"]["p99_ms"] for report in (story.quiet, story.changing))
    gap = streams(story.changing, "e3", "Video")["e2"]["worst_gap_ms"]
    out = story.figures["out"]
    is_quiet = story.load < QUIET
    limits = (2 * quiet, 50, 2) if is_quiet else (1000, 5000, 10)
    print(f"load {story.load:.1f} at the start, so the limits are those of a {'quiet' if is_quiet else 'busy'} machine: round "
          f"trip, 99 % {limits[0]:.1f} ms, gap {limits[1]} ms, out within {limits[2]} s")
    check(f"99 % of the round trips within {changing} ms, without changes {quiet} ms", changing <= limits[0])
    check(f"a gap of {gap} ms between embedded participants", gap <= limits[1])
    check(f"{LEFT} was out {out} s after its end", out <= limits[2])


def run(build, at, is_short):
    story = Story(is_short)
    try:
        for step in (lambda: story.start(build, at), story.begin, story.narrow, story.deny, lambda: story.rotate("permissions"),
                     story.kill_agent, story.push_broken, story.govern, story.raise_protection, story.roll_back,
                     story.not_renewed,
                     lambda: story.rotate("identity"), story.kill_agent):
            step()
        story.end()
        print_report(story, story.totals)
        judge(story)
        print("ok")
    except AssertionError as fault:
        said = [f"{event['at'] - story.began:.1f} {name} {event['sentence'][:160]}"
                for name, peer in story.peers.items()
                for event in peer.events(after=time.time() - WAIT - 15) if event["severity"] != "informational"][-12:]
        if story.renewer:
            said.append(f"slowest command of ddssec: {story.folders.slowest:.1f} s (usually below 0.1 s)")
        raise SystemExit("\n".join([f"FAILED {fault}", *(f"{at:.1f} {text}" for at, text in story.steps), *said,
                                    *(story.agent.log() if story.agent else ())])) from None
    finally:
        story.close()


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    # In memory: on a disk that others keep busy, one command may take longer than a certificate lasts.
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="ddssec-never-restart-", dir=memory) as folder:
        run(build, folder, "--short" in sys.argv[2:])


if __name__ == "__main__":
    main()

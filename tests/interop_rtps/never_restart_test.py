#!/usr/bin/env python3
"""Six embedded and four Cyclone DDS processes on our plugins exchange data while all their documents change. None is
restarted: certificates and permissions of seconds, both CAs, rights, governance, a broken document, an agent that is
killed twice, protection of a topic raised from SIGN to ENCRYPT, one participant that is not renewed. Prints what was lost, and how long it took.
Usage: never_restart_test.py BUILD [--short] [--strict]
--strict: waits three minutes at most for an idle machine, and does nothing on a busy one (exit status 3, "NOT JUDGED").
Without it, a busy machine has wide limits."""

import collections
import json
import os
import pathlib
import sys
import tempfile
import time

sys.dont_write_bytecode = True
from steady_fleet import LOOKS, START, Agent, Folders, Namespace, Peer, PermissionsRenewer, check, replace_file
from never_restart_judge import (CYCLONE, DENIED, EMBEDDED, FURTHER, JUDGED, LEFT, LONG, NARROWED, OUT, RAISED, SLOW, TOPICS,
                                 endpoints, expected_streams, judge, print_report, totals_of)
from processors import IDLE, idle_now, idle_share, processor_time

WAIT = 60.0   # seconds until an event on a loaded machine
UNTIL_IDLE = 180.0  # seconds that --strict waits for an idle machine
NOT_JUDGED = 3
# What readers with losses said of their documents and sessions is printed.
ABOUT_LOSSES = {"identity_ca_renewed", "identity_ca_withdrawn", "identity_renewed", "renewal_list_taken",
                "peer_renewal_listed", "session_reset_by_peer", "session_not_resumed", "session_outlived_documents",
                "permissions_ca_renewed", "identity_ended"}
ENDS = {"identity": ("identity_ca_renewed", "identity_renewed"),
        "permissions": ("permissions_ca_renewed", "permissions_renewed")}


class Story:
    def __init__(self, is_short, is_strict, idle):
        self.is_short, self.is_strict, self.idle = is_short, is_strict, idle
        self.peers, self.agent, self.renewer, self.space = {}, None, None, None
        self.form = "short" if is_short else "long"
        self.quiet_seconds, self.duration = (12, 110) if is_short else (15, 600)
        self.figures, self.steps, self.losses, self.began = {}, [], [], time.time()
        self.renewed = [name for name in EMBEDDED + CYCLONE if name != LEFT]

    def start(self, build, at):
        before = ("nice", "-n", "10") if self.is_strict else ()  # a CA is on another machine, and agents are not
        self.folders, self.space = Folders(build, at, EMBEDDED + CYCLONE, TOPICS, self.form, before), Namespace()
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

    def streams_without_a_sample(self, commands):
        """Samples before the first one of a stream are not counted, so that each must begin before the changes."""
        reports = {name: peer.ask("report") for name, peer in self.peers.items()}
        found = {(one["topic"], writer, name) for name, report in reports.items() for one in report["readers"]
                 for writer in one["streams"]}
        return expected_streams(commands) - found

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
        self.until("every reader has a sample of each writer", lambda: not self.streams_without_a_sample(commands))
        self.phase()
        time.sleep(self.quiet_seconds)  # what is measured without changes
        self.quiet, self.quiet_until, self.processors = self.phase(), time.time(), processor_time()
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
        at = time.time()
        with self.folders.signing:
            self.folders.put_permissions(DENIED)
        began = time.monotonic()
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
        """A further topic rule, which running participants take, and endpoints of that topic. Its right is new to the
        peers of the Cyclone DDS participant: its sessions begin again."""
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
        at, began = time.time(), time.monotonic()
        for name, command in FURTHER:
            check(f"{name}: {command}: {self.peers[name].last_words()}", self.peers[name].ask(command)["ok"])
        for name in ("e4", DENIED):
            self.until(f"{name} reads the further topic", lambda name=name: self.stream(name, "Further", "e2"))
        self.figures["gained"] = time.monotonic() - began
        told = self.peers[DENIED].events("own_rights_gained", at)
        check(f"own_rights_gained: {told}", len(told) == 1 and "Further" in told[0]["sentence"])
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
        self.changing, self.changing_seconds = self.phase(), time.time() - self.quiet_until
        self.changing_idle = idle_share(self.processors)
        for peer in self.peers.values():
            peer.ask("stop")
        end = time.monotonic() + WAIT
        while self.lost() and time.monotonic() < end:
            time.sleep(0.5)
        pairs = list(self.pairs())
        self.totals, self.losses, self.found = totals_of(pairs), self.lost(), {pair[:3] for pair in pairs}
        for name, peer in self.peers.items():
            check(f"{name} was restarted", peer.process.pid == self.pids[name] and peer.process.poll() is None)
            peer.ask("quit")
        for name, peer in self.peers.items():
            check(f"{name} ended with {peer.process.wait(WAIT)}: {peer.last_words()}", peer.process.returncode == 0)
        self.renewer.close()
        self.agent.close()
        self.idle_after = idle_now()

    def is_idle(self):
        """Only --strict applies the limits of an idle machine: in the suite, other tests run beside this one."""
        return self.is_strict

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


def run(build, at, story):
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
        for name in sorted({reader for _, _, reader, _ in story.losses}):
            said += [f"{event['at'] - story.began:.1f} {name} {event['name']} {event['peer_subject']} {event['found']}"
                     for event in story.peers[name].events() if event["name"] in ABOUT_LOSSES]
        if story.renewer:
            said.append(f"slowest command of ddssec: {story.folders.slowest:.1f} s (usually below 0.1 s)")
        raise SystemExit("\n".join([f"FAILED {fault}", *(f"{at:.1f} {text}" for at, text in story.steps), *said,
                                    *(story.agent.log() if story.agent else ())])) from None
    finally:
        story.close()


def idle_before(is_strict):
    """The share of idle processors; with --strict, there is a run on an idle machine only."""
    end, idle = time.monotonic() + UNTIL_IDLE, idle_now()
    while is_strict and idle <= IDLE:
        if time.monotonic() > end:
            print(f"NOT JUDGED: the processors are {idle:.0%} idle, and the limits hold from {IDLE:.0%} on. End what else runs, or "
                  "run tests/interop_rtps/never_restart_test.py without --strict, which has wide limits on a busy machine")
            sys.exit(NOT_JUDGED)
        idle = idle_now()
    return idle


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    is_short, is_strict = ("--" + word in sys.argv[2:] for word in ("short", "strict"))
    story = Story(is_short, is_strict, idle_before(is_strict))
    # In memory: on a disk that others keep busy, one command may take longer than a certificate lasts.
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="ddssec-never-restart-", dir=memory) as folder:
        run(build, folder, story)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Four Cyclone DDS processes on our plugins, with certificates and permissions of seconds and a renewal list that `ddssec` makes and
distributes. One is renewed, and its samples flow across the ends of its former documents. One is not, and is out in time. One is
renewed, listed and revoked, and stays out, also when the list of before its revocation is put back.
Usage: renewal_list_test.py BUILD"""

import pathlib
import sys
import tempfile
import time

sys.dont_write_bytecode = True
from steady_fleet import LOOKS, Folders, Namespace, Peer, check, replace_file

RENEWED, LEFT, REVOKED, WATCHER = NAMES = ["c1", "c2", "c3", "c4"]
TOPICS = {RENEWED: "Steady", LEFT: "Left", REVOKED: "Gone"}
CERTIFICATE, PERMISSIONS = 30, 36  # seconds that they last; the processes have to start meanwhile
AFTER = 8      # seconds that are watched after the last end
OUT = 2.0      # seconds after its end until a participant that is not renewed is out
SLOW = 8.0     # seconds that a loaded machine may add to it
WAIT = 60.0    # seconds until an event on a loaded machine
LONG = 3600
GAP_MS = 1000  # the longest time without a sample of the renewed one


class Story:
    def __init__(self, build, at):
        self.peers, self.space = {}, None
        self.folders = Folders(build, at, NAMES, list(TOPICS.values()), "short")
        self.folders.put_permissions(RENEWED, PERMISSIONS)
        self.permissions_end = time.time() + PERMISSIONS
        ends = self.folders.put_certificates([RENEWED, LEFT, REVOKED], CERTIFICATE)
        self.certificate_end, self.left_end = ends[RENEWED], ends[LEFT]
        self.space = Namespace()
        for name in NAMES:
            self.peers[name] = Peer(build, self.space, self.folders, name)
        for peer in self.peers.values():
            peer.answer()

    def until(self, what, is_so, seconds=WAIT):
        end = time.monotonic() + seconds
        while not is_so():
            check(f"never: {what}", time.monotonic() < end)
            time.sleep(0.1)

    def stream(self, name):
        """What the watcher has of that participant."""
        readers = self.peers[WATCHER].ask("report")["readers"]
        (reader,) = [one for one in readers if one["topic"] == TOPICS[name]]
        return reader["streams"].get(name)

    def said(self, peer, event, about=None):
        return [one for one in self.peers[peer].events(event)
                if about is None or one.get("peer_subject") == f"CN={about}"]

    def late(self, name, end):
        return self.stream(name)["last_s"] + time.time() - time.monotonic() - end

    # ---- the steps, in their order

    def begin(self):
        for name, topic in TOPICS.items():
            check(name, self.peers[name].ask(f"writer {topic} reliable 20000 64")["ok"])
            check(topic, self.peers[WATCHER].ask(f"reader {topic} reliable")["ok"])
        self.until("samples of all", lambda: all(self.stream(name) for name in TOPICS))
        self.peers[WATCHER].ask("phase")

    def renew(self):
        for name in (RENEWED, REVOKED):
            self.folders.ddssec("identity", "renew", f"demo/{name}", "--ca", "demo", "--days", "5")
        self.folders.put_permissions(RENEWED, LONG)
        self.folders.ddssec("crl", "distribute", "--ca", "demo")
        self.until("the list is taken", lambda: self.said(WATCHER, "renewal_list_taken"))
        check("renewed in time", time.time() < self.certificate_end)

    def revoke(self):
        before = (self.folders[WATCHER] / "renewed.pem").read_bytes()
        self.folders.ddssec("identity", "revoke", f"demo/{REVOKED}", "--ca", "demo")
        self.folders.ddssec("crl", "distribute", "--ca", "demo")
        self.until("the revocation", lambda: self.said(WATCHER, "certificate_revoked", REVOKED))
        check("still listed", len((self.folders[WATCHER] / "renewed.pem").read_bytes()) < len(before))
        replace_file(self.folders[WATCHER] / "renewed.pem", before)
        return time.time()

    def not_renewed(self):
        self.until(f"{LEFT} ends", lambda: self.said(WATCHER, "identity_ended", LEFT),
                   max(0.0, self.left_end - time.time()) + WAIT)
        self.until(f"{LEFT} says so", lambda: self.said(LEFT, "identity_ended"))
        time.sleep(OUT)
        late = self.late(LEFT, self.left_end)
        check(f"{LEFT} was out {late:.2f} s after its end", late < OUT + SLOW)
        return late

    def watch(self):
        time.sleep(max(0.0, max(self.certificate_end, self.permissions_end) + AFTER - time.time()))
        stream = self.stream(RENEWED)
        for name, peer in self.peers.items():
            check(f"{name} has ended", peer.process.poll() is None)
        for event in ("peer_renewal_listed", "peer_permissions_listed"):
            check(f"{event} of {RENEWED}", self.said(WATCHER, event, RENEWED))
        for one, other in ((RENEWED, WATCHER), (WATCHER, RENEWED)):
            for event in ("session_outlived_documents", "identity_ended", "grant_expired", "session_reset_by_peer"):
                found = self.said(one, event, other)
                check(f"{one} said {event}: {found}", not found)
        check(f"samples are missing or came twice: {stream}", (stream["missing"], stream["repeated"]) == (0, 0))
        check(f"a gap: {stream}", stream["worst_gap_ms"] < GAP_MS)
        return stream

    def close(self):
        for peer in self.peers.values():
            peer.close()
        if self.space:
            self.space.close()


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="ddssec-list-") as at:
        story = None
        try:
            story = Story(build, at)
            story.begin()
            story.renew()
            out = story.revoke()
            late = story.not_renewed()
            stream = story.watch()
            gone = story.late(REVOKED, out)
            check(f"{REVOKED} came back {gone} s after its revocation", gone < 2 * LOOKS + OUT)
        except AssertionError as fault:
            print(f"FAILED: {fault}")
            for name, peer in (story.peers if story else {}).items():
                for event in peer.events():
                    print(f"{event['time']} {name} {event['name']} {event.get('peer_subject', '')} {event.get('sentence', '')[:300]}")
            return 1
        finally:
            if story:
                story.close()
    print(f"ok: {stream['received']} samples across the end of the certificate and of the permissions, none lost or twice, longest gap "
          f"{stream['worst_gap_ms']:.0f} ms, p99 {stream['p99_ms']:.2f} ms; not renewed: out {late:.2f} s after its end")
    return 0


if __name__ == "__main__":
    sys.exit(main())

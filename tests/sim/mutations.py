#!/usr/bin/env python3
"""Shows that the simulation finds faults: removes one check of the product at a time and runs seeds until one fails.

Copies the tree to a scratch folder, makes each fault there a branch that the variable DDSSEC_FAULT chooses, and
builds once. Nothing of it is in the product. Exit 1 if a fault is not found, or seeds fail without one."""

import argparse
import os
import pathlib
import re
import subprocess
import sys
import time

HEADER = """#pragma once
#include <cstdlib>
inline bool ddssec_fault(int number) {
  static const int chosen = [] {
    const char* text = std::getenv("DDSSEC_FAULT");
    return text != nullptr ? std::atoi(text) : 0;
  }();
  return chosen == number;
}
"""

# What is removed, where, the text that stands there, and what replaces it; FAULT is true if this fault is chosen.
FAULTS = [
    ("the tag of signed messages", "plugins/cryptography/transform_decode.cpp",
     "if (!key.verify(message.header.iv, message.content, message.footer.tag())) return false;",
     "if (!key.verify(message.header.iv, message.content, message.footer.tag()) && !FAULT) return false;"),
    ("the receiver's MAC", "plugins/cryptography/transform_decode.cpp",
     "if (origin && !session->receiver->verify(",
     "if (origin && !FAULT && !session->receiver->verify("),
    ("that messages are protected", "rtps/security/keyring_transform.cpp",
     "own_.attributes().is_rtps_protected() && !shield.message && !may_come_bare;",
     "own_.attributes().is_rtps_protected() && !shield.message && !may_come_bare && !FAULT;"),
    ("that submessages are protected by their sender", "rtps/security/keyring_transform.cpp",
     "local->attributes.is_submessage_protected() && !by_remote;",
     "local->attributes.is_submessage_protected() && !by_remote && !FAULT;"),
    ("that payloads are protected", "rtps/security/keyring_transform.cpp",
     "if (!size) return undecodable(size.error(), writer.prefix);",
     "if (!size && FAULT) return payload;\n  if (!size) return undecodable(size.error(), writer.prefix);"),
    ("a dispose without a protected key", "rtps/security/keyring_transform.cpp",
     "if (proven || !local", "if (FAULT || proven || !local"),
    ("the protection of payloads that are sent", "rtps/security/keyring_transform.cpp",
     "{.payload = local->attributes.is_payload_protected(),",
     "{.payload = local->attributes.is_payload_protected() && !FAULT,"),
    ("permissions of remote writers", "rtps/security/admission.cpp",
     "  const auto names = views_of(remote.partitions);",
     "  if (FAULT && is_reader(local)) return Permission{};\n  const auto names = views_of(remote.partitions);"),
    ("permissions of remote readers", "rtps/security/admission.cpp",
     "  const auto names = views_of(remote.partitions);",
     "  if (FAULT && !is_reader(local)) return Permission{};\n  const auto names = views_of(remote.partitions);"),
    ("the domain in signed data", "rtps/security/admission.cpp",
     "if (is_of_domain(proven", "if (FAULT || is_of_domain(proven"),
    ("that protected topics are announced securely", "rtps/security/admission.cpp",
     "is_discovery_protected && !remote.is_secure)", "is_discovery_protected && !remote.is_secure && !FAULT)"),
    ("whose submessages a protected message holds", "rtps/participant/message_receiver.cpp",
     "context.shield.message && source == context.source;",
     "context.shield.message && (source == context.source || FAULT);"),
    ("whose endpoints a participant announces", "rtps/participant/discovery.cpp",
     "if (!data || data->guid.prefix != remote->prefix()) {\n    ++core_.counters.refused_discovery;\n    if (!data) core_",
     "if (!data || (data->guid.prefix != remote->prefix() && !FAULT)) {\n    ++core_.counters.refused_discovery;\n"
     "    if (!data) core_"),
    ("that nothing clear unsays what was announced securely", "rtps/participant/discovery.cpp",
     "secure || known == remote->endpoints.end() ||", "FAULT || secure || known == remote->endpoints.end() ||"),
    ("that secure announcements replace clear ones", "rtps/participant/discovery.cpp",
     "    core_.counters.refused_discovery += good ? 0 : 1;",
     "    if (FAULT && known != remote->endpoints.end() && known->second.data.by_secure_discovery != secure) return false;\n"
     "    core_.counters.refused_discovery += good ? 0 : 1;"),
    ("that old samples are not delivered", "rtps/reliability/stateful_reader.cpp",
     "data.sequence_number < proxy->next()) return false;\n  // DDS",
     "(data.sequence_number < proxy->next() && !FAULT)) return false;\n"
     "  if (FAULT && data.sequence_number < proxy->next()) {\n"
     "    auto again = received_change(from, data, time);\n    return common_.deliver(again);\n  }\n  // DDS"),
    ("that old heartbeats are no news", "rtps/reliability/writer_proxy.cpp",
     "  if (!is_new) return false;\n", "  if (!is_new) return FAULT;\n"),
    ("the bound on participants", "rtps/participant/remote_participants.cpp",
     "return remotes_.size() >= kMostParticipants ||", "return (remotes_.size() >= kMostParticipants && !FAULT) ||"),
    ("patience with handshakes", "rtps/security/handshakes.cpp",
     "if (core_.now < handshake.next_tick() || !may_tick(peer)) return;",
     "if (core_.now < handshake.next_tick() || !may_tick(peer) || (FAULT && handshake.is_overdue())) return;"),
    ("the limit on messages to silent addresses", "rtps/security/handshakes.cpp",
     "if (is_silent && !silent_.take(", "if (is_silent && !FAULT && !silent_.take("),
    ("the binding of a GUID to its certificate", "plugins/authentication/peer.cpp",
     "if (is_bound_to(", "if (FAULT || is_bound_to("),
    ("that only news is a sign of life", "rtps/participant/discovery.cpp",
     "(signs.is_news && may_count))", "((signs.is_news || FAULT) && may_count))"),
    ("that signed addresses replace announced ones", "rtps/participant/discovery.cpp",
     "remote->user = usable(proven.default_unicast, remote->user);",
     "if (!FAULT) remote->user = usable(proven.default_unicast, remote->user);"),
]


def patch(scratch):
    (scratch / "base/fault.hpp").write_text(HEADER)
    for number, (what, name, old, new) in enumerate(FAULTS, 1):
        file = scratch / name
        text = file.read_text(encoding="utf-8")
        if text.count(old) != 1:
            sys.exit(f"{what}: {name} holds its text {text.count(old)} times")
        text = text.replace(old, new.replace("FAULT", f"::ddssec_fault({number})"))
        if "base/fault.hpp" not in text:
            text = '#include "base/fault.hpp"\n' + text
        file.write_text(text, encoding="utf-8")


def copy(root, scratch):
    scratch.mkdir(parents=True, exist_ok=True)
    files = subprocess.run(["git", "-C", root, "ls-files", "-z"], check=True, capture_output=True).stdout
    pack = subprocess.Popen(["tar", "-C", root, "--null", "-T", "-", "-cf", "-"], stdin=subprocess.PIPE,
                            stdout=subprocess.PIPE)
    unpack = subprocess.Popen(["tar", "-C", scratch, "-xf", "-"], stdin=pack.stdout)
    pack.stdin.write(files)
    pack.stdin.close()
    if pack.wait() or unpack.wait():
        sys.exit("the tree could not be copied")


def build(scratch):
    folder = scratch / "build/mutations"
    subprocess.run(["cmake", "-S", scratch, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DDDSSEC_BUILD_TESTS=ON"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder, "--target", "ddssec_sim"], check=True, stdout=subprocess.DEVNULL)
    return folder / "bin/ddssec_sim"


def hunt(binary, number, seconds):
    """The seed that finds the fault and the invariant that it violates; None: no seed did in so many seconds of CPU."""
    env = dict(os.environ, DDSSEC_FAULT=str(number))
    run = subprocess.run([binary, "--seed", "1", "--seconds", str(seconds)], env=env, text=True, capture_output=True)
    found = re.search(r"VIOLATED in step \d+ of seed (\d+): (.*)", run.stdout)
    if found:
        return int(found[1]), found[2]
    return None if run.returncode == 0 else (0, f"it ended with {run.returncode}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("scratch", type=pathlib.Path, help="a folder for the changed copy")
    parser.add_argument("--seconds", type=float, default=60, help="of CPU for each fault")
    parser.add_argument("--patch-only", action="store_true", help="only make the changed copy")
    parser.add_argument("--binary", type=pathlib.Path, help="of a changed copy that was built already")
    options = parser.parse_args()
    binary = options.binary
    if binary is None:
        copy(options.root.resolve(), options.scratch)
        patch(options.scratch)
        if options.patch_only:
            return 0
        binary = build(options.scratch.resolve())
    missed = 0
    for number in range(0, len(FAULTS) + 1):
        began = time.monotonic()
        found = hunt(binary, number, options.seconds)
        what = FAULTS[number - 1][0] if number else "no fault"
        missed += (found is None) == (number > 0)
        answer = f"seed {found[0]}, {found[1]}" if found else "not found" if number else "as it should be"
        print(f"{number:2} {what}: {answer} ({time.monotonic() - began:.0f} s)", flush=True)
    print(f"{len(FAULTS)} faults, {missed} not found or wrongly found")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())

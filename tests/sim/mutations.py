#!/usr/bin/env python3
"""Shows that the simulation finds faults: removes one check of the product at a time and runs seeds until one fails.

Copies the tree to a scratch folder, makes each fault there a branch that the variable DDSSEC_FAULT chooses, and
builds once. Nothing of it is in the product. seeds.txt names the seed that finds each fault; it is tried first.
Exit 1 if a fault is not found, or seeds fail without one."""

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

SEEDS = pathlib.Path(__file__).parent / "seeds.txt"
TITLE = """# What each of these seeds finds if a check of the product is removed, and the invariant that it violates then. Each
# past finding of the simulation is among them: its repair is what is removed. Written by mutations.py --record.
# The normal test runs these seeds besides its first ones. A change of the simulation can make them find something
# else, so run mutations.py after it.
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
     "phases_.must_protect_messages(remote.prefix) && !opened_by.message && !may_come_bare;",
     "phases_.must_protect_messages(remote.prefix) && !opened_by.message && !may_come_bare && !FAULT;"),
    ("that submessages are protected by their sender", "rtps/security/keyring_transform.cpp",
     "return local.attributes.is_submessage_protected() && !by_remote;",
     "return local.attributes.is_submessage_protected() && !by_remote && !FAULT;"),
    ("that payloads are protected", "rtps/security/keyring_transform.cpp",
     "  if (!plain && plain.error().code() != Code::crypto_not_matched)",
     "  if (!plain && FAULT) return payload;\n  if (!plain && plain.error().code() != Code::crypto_not_matched)"),
    ("a dispose without a protected key", "rtps/security/keyring_transform.cpp",
     "if (opened_by.message || opened_by.submessage == remote)", "if (FAULT || opened_by.message || opened_by.submessage == remote)"),
    ("the protection of payloads that are sent", "rtps/security/keyring_transform.cpp",
     "{.payload = local->attributes.is_payload_protected(),",
     "{.payload = local->attributes.is_payload_protected() && !FAULT,"),
    ("permissions of remote writers", "rtps/security/admission.cpp",
     "  if (local.reads) {\n    DDSSEC_RETURN_IF_ERROR(", "  if (FAULT && local.reads) return Permission{};\n"
     "  if (local.reads) {\n    DDSSEC_RETURN_IF_ERROR("),
    ("permissions of remote readers", "rtps/security/admission.cpp",
     "  DDSSEC_ASSIGN_OR_RETURN(\n      const auto answer,", "  if (FAULT) return Permission{};\n"
     "  DDSSEC_ASSIGN_OR_RETURN(\n      const auto answer,"),
    ("the domain in signed data", "rtps/security/admission.cpp",
     "if (is_of_domain(proven", "if (FAULT || is_of_domain(proven"),
    ("that protected topics are announced securely", "rtps/security/admission.cpp",
     "is_discovery_protected && !remote.is_secure)", "is_discovery_protected && !remote.is_secure && !FAULT)"),
    ("whose submessages a protected message holds", "rtps/participant/message_receiver.cpp",
     "context.opened_by.message && source == context.source;",
     "context.opened_by.message && (source == context.source || FAULT);"),
    ("whose endpoints a participant announces", "rtps/participant/discovery.cpp",
     "if (!data || data->guid.prefix != remote->prefix()) {\n    ++core_.counters.refused_discovery;\n    if (!data) raise",
     "if (!data || (data->guid.prefix != remote->prefix() && !FAULT)) {\n    ++core_.counters.refused_discovery;\n"
     "    if (!data) raise"),
    ("that nothing clear unsays what was announced securely", "rtps/participant/discovery.cpp",
     "is_by_secure_topic || known == remote->endpoints.end() ||", "FAULT || is_by_secure_topic || known == remote->endpoints.end() ||"),
    ("that secure announcements replace clear ones", "rtps/participant/discovery.cpp",
     "    const auto known = remote->endpoints.find(id);\n",
     "    const auto known = remote->endpoints.find(id);\n"
     "    if (FAULT && known != remote->endpoints.end() && known->second.data.by_secure_discovery != is_by_secure_topic) return false;\n"),
    ("that old samples are not delivered", "rtps/reliability/stateful_reader.cpp",
     "data.sequence_number < proxy->next()) return false;\n  // DDS",
     "(data.sequence_number < proxy->next() && !FAULT)) return false;\n"
     "  if (FAULT && data.sequence_number < proxy->next()) {\n"
     "    auto again = received_change(from, data, time, Payload::copy_of(data.payload));\n    return common_.deliver(again);\n  }\n  // DDS"),
    ("that old heartbeats are no news", "rtps/reliability/writer_proxy.cpp",
     "if (!heartbeats_.accept(heartbeat, is_protected, age)) return false;",
     "if (!heartbeats_.accept(heartbeat, is_protected, age)) return FAULT;"),
    ("the bound on participants", "rtps/participant/remote_participants.cpp",
     "return remotes_.size() >= kMaxParticipants ||", "return (remotes_.size() >= kMaxParticipants && !FAULT) ||"),
    ("patience with handshakes", "rtps/security/handshakes_time.cpp",
     "if (core_.now < handshake.next_tick() || !may_tick(peer)) return;",
     "if (core_.now < handshake.next_tick() || !may_tick(peer) || (FAULT && handshake.is_overdue())) return;"),
    ("that leases that end together are handled in turns", "rtps/participant/remote_participants.cpp",
     "out.ended_leases.size() < kMaxEndsAtOnce", "(FAULT || out.ended_leases.size() < kMaxEndsAtOnce)"),
    ("the limit on handshakes with strangers", "rtps/security/handshakes_time.cpp",
     "if (!handshake.is_started() && !may_start()) {", "if (!FAULT && !handshake.is_started() && !may_start()) {"),
    ("the binding of a GUID to its certificate", "plugins/authentication/judged_peer.cpp",
     "if (is_bound_to(", "if (FAULT || is_bound_to("),
    ("that only news is a sign of life", "rtps/participant/message_receiver.hpp",
     "signs.is_proof |= is_new && is_proof;", "signs.is_proof |= (is_new || FAULT) && is_proof;"),
    ("that only what is protected is a sign of life", "rtps/participant/discovery.cpp",
     "  if (anything_counts || signs.is_proof || (signs.is_news",
     "  if (FAULT || anything_counts || signs.is_proof || (signs.is_news"),
    ("that signed addresses replace announced ones", "rtps/participant/discovery.cpp",
     "      adopt_signed_addresses(core_, *remote, std::move(metatraffic), std::move(user));",
     "      !FAULT && adopt_signed_addresses(core_, *remote, std::move(metatraffic), std::move(user));"),
    ("that announcements change no signed addresses", "rtps/participant/discovery.cpp",
     "  if (remote.has_signed_addresses && ", "  if (!FAULT && remote.has_signed_addresses && "),
    ("that an announcement counts again when it is repeated", "rtps/participant/discovery.cpp",
     "  const bool has_changed = data != remote.data;\n",
     "  const bool has_changed = data != remote.data;\n  if (FAULT && !has_changed) return;\n"),
    ("that a clear dispose ends no authenticated participant", "rtps/participant/discovery.cpp",
     "else if (is_authenticated || (core_.security", "else if ((is_authenticated && !FAULT) || (core_.security"),
    ("that announcements renew no proven lease", "rtps/participant/discovery.cpp",
     "  const bool is_fixed = core_.is_authenticated(prefix);",
     "  const bool is_fixed = core_.is_authenticated(prefix);\n"
     "  if (FAULT) parts_.remotes.renew_lease(remote, data);"),
    ("that only protected news renews a lease", "rtps/participant/discovery.cpp",
     "  if (anything_counts || is_proof) parts_.remotes.renew_lease",
     "  if (FAULT || anything_counts || is_proof) parts_.remotes.renew_lease"),
    ("that a peer that asks again is probed first", "rtps/security/handshakes.cpp",
     "  if (peer.state.association() == nullptr) return request_resend(peer);\n",
     "  if (peer.state.association() == nullptr) return request_resend(peer);\n"
     "  if (FAULT) return core_.host.on_ended(GuidPrefix(peer.prefix()));\n"),
    ("that key exchange is protected", "rtps/security/keyring_transform.cpp",
     "      local.is_volatile ? prefix == remote.prefix &&\n",
     "      local.is_volatile ? FAULT ? true : prefix == remote.prefix &&\n"),
    ("that announcements need the pre-shared key", "rtps/security/keyring_messages.cpp",
     "if (pre_shared_.are_due())", "if (pre_shared_.are_due() && !FAULT)"),
    ("the tag of encrypted messages", "plugins/cryptography/transform_decode.cpp",
     "    return key.open(message.header.iv, {}, message.content, place, message.footer.tag());",
     "    return key.open(message.header.iv, {}, message.content, place, message.footer.tag()) || FAULT;"),
    ("that messages from before a key was given are old", "plugins/cryptography/transform_decode.cpp",
     "if (key.precedes_key_exchange(message.header.iv)) return", "if (!FAULT && key.precedes_key_exchange(message.header.iv)) return"),
    ("the chain of certificates", "pki/chain.cpp",
     "if (X509_verify_cert(context.get()) != 1) {", "if (X509_verify_cert(context.get()) != 1 && !FAULT) {"),
    ("the signature of permissions", "pki/smime.cpp",
     "  DDSSEC_ASSIGN_OR_RETURN(auto* signer, only_signer(cms.get()));\n",
     "  if (FAULT) return cas.front();\n  DDSSEC_ASSIGN_OR_RETURN(auto* signer, only_signer(cms.get()));\n"),
    ("that the key of the pair protects key exchange", "rtps/security/keyring_transform.cpp",
     "(entity == kVolatileMessageWriter || entity == kVolatileMessageReader)",
     "(FAULT || entity == kVolatileMessageWriter || entity == kVolatileMessageReader)"),
    ("that loopback addresses count only if they are announced here", "rtps/participant/discovery.cpp",
     "  if (core.is_from_elsewhere)\n    std::erase_if(", "  if (core.is_from_elsewhere && !FAULT)\n    std::erase_if("),
    ("one GAP for all numbers that were used up", "rtps/reliability/retransmissions.cpp",
     "return skip(number, from_.history_.next_held(number));",
     "return skip(number, FAULT ? number.next() : from_.history_.next_held(number));"),
    ("that history costs what is held", "rtps/reliability/stateful_writer.cpp",
     "       number = history_.previous_held(number)) {\n",
     "       number = FAULT ? SequenceNumber{number.value - 1} : history_.previous_held(number)) {\n"
     "    if (FAULT && history_.find(number) == nullptr) continue;\n"),
    ("that the source with most invented participants gives way", "rtps/participant/unproven_participants.cpp",
     "return at == shares_.end() ? std::nullopt : std::optional(at->first);",
     "if (FAULT) return newcomer;\n  return at == shares_.end() ? std::nullopt : std::optional(at->first);"),
    ("that sources with few requests have a budget", "rtps/budget/source_budget.hpp",
     "return (at->second.try_spend(now) ? few_ : many_).try_spend(now);",
     "return (FAULT || at->second.try_spend(now) ? few_ : many_).try_spend(now);"),
    ("the share of one certificate in the places", "rtps/budget/subject_shares.hpp",
     "{ return count(prefix) < places_ - taken_; }", "{ return FAULT || count(prefix) < places_ - taken_; }"),
    ("that a forged count makes no endpoint ignore honest messages", "rtps/reliability/recent_messages.hpp",
     "(!is_protected && std::ranges::find(", "(!is_protected && !FAULT && std::ranges::find("),
    ("that hosts at which a peer does not answer are doubted", "rtps/participant/discovery.cpp",
     "if (remote == nullptr || !switch_doubted_hosts(", "if (FAULT || remote == nullptr || !switch_doubted_hosts("),
    ("that permissions are for the subject of the certificate", "governance/grant.cpp",
     "    if (!is_for(grant, subject)) continue;\n    auto status",
     "    if (!is_for(grant, subject) && !FAULT) continue;\n    auto status"),
    ("that the unknown prefix names no participant", "rtps/participant/discovery.cpp",
     "|| source == GuidPrefix{})", "|| (source == GuidPrefix{} && !FAULT))"),
]


# Checks that are made twice, by two parts of the product: what else is replaced for that fault.
ALSO = {
    "the domain in signed data": ("plugins/authentication/participant_data.cpp",
                                  "if (is_same_id && is_same_tag && !peer.is_ambiguous) return {};",
                                  "if (FAULT || (is_same_id && is_same_tag && !peer.is_ambiguous)) return {};"),
    # Of other addresses, only those at hosts from which the participant was heard are used.
    "that signed addresses replace announced ones": (
        "rtps/participant/remote_addresses.cpp", "  auto out = only_proven(core, remote, announced);\n",
        "  auto out = FAULT ? announced : only_proven(core, remote, announced);\n"),
    # A newcomer that speaks first has another budget.
    "that sources with few requests have a budget": (
        "rtps/security/handshakes_time.cpp", "return peer.has_spoken ? budgets_.may_begin_again(core_.now)",
        "return peer.has_spoken && !FAULT ? budgets_.may_begin_again(core_.now)"),
}


def replacements():
    """Of each fault: its number, what is removed, and where."""
    for number, (what, *where) in enumerate(FAULTS, 1):
        yield number, what, where
        if what in ALSO:
            yield number, what, ALSO[what]


def patched(root):
    """{name of a file: its text with all faults}. Each fault's text must stand in its file once, also when the faults
    before it are in; a change of the product must change it here, too."""
    texts, wrong = {}, []
    for number, what, (name, old, new) in replacements():
        original = (root / name).read_text(encoding="utf-8")
        text = texts.get(name, original)
        if original.count(old) != 1 or text.count(old) != 1:
            wrong.append(f"{what}: {name} holds its text {original.count(old)} times, and {text.count(old)} times with"
                         " the faults before it")
        texts[name] = text.replace(old, new.replace("FAULT", f"::ddssec_fault({number})"))
    if wrong:
        sys.exit("\n".join(wrong))
    return texts


def patch(scratch):
    texts = patched(scratch)
    (scratch / "base/fault.hpp").write_text(HEADER)
    for name, text in texts.items():
        (scratch / name).write_text('#include "base/fault.hpp"\n' + text, encoding="utf-8")


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


def recorded():
    """{what is removed: the seed that notices}"""
    lines = SEEDS.read_text(encoding="utf-8").splitlines() if SEEDS.exists() else []
    rows = [line.split("\t") for line in lines if line and not line.startswith("#")]
    return {what: int(seed) for seed, what, _ in rows}


def record(found):
    rows = "".join(f"{seed}\t{what}\t{invariant}\n" for what, (seed, invariant) in found.items())
    SEEDS.write_text(TITLE + rows, encoding="utf-8")


def hunt(binary, number, first, count):
    """The seed that finds the fault, of so many, and the invariant that it violates; None: none does."""
    env = dict(os.environ, DDSSEC_FAULT=str(number))
    command = [binary, "--seed", str(first), "--seeds", str(count), "--verbose"]
    run = subprocess.run(command, env=env, text=True, capture_output=True)
    found = re.search(r"VIOLATED in step \d+ of seed (\d+): (.*)", run.stdout)
    if found:
        return int(found[1]), found[2]
    if run.returncode == 0:
        return None
    return int(re.findall(r"^seed (\d+)", run.stdout, re.MULTILINE)[-1]), f"it ends with {run.returncode}"


def find(binary, number, seeds, known):
    """By the recorded seed of the fault, or the first that finds it."""
    return (known and hunt(binary, number, known, 1)) or hunt(binary, number, 1, seeds)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("scratch", type=pathlib.Path, nargs="?", help="a folder for the changed copy")
    parser.add_argument("--seeds", type=int, default=200, help="that are tried for each fault")
    parser.add_argument("--record", action="store_true", help="write seeds.txt anew")
    parser.add_argument("--check", action="store_true", help="only whether each fault fits the sources")
    parser.add_argument("--patch-only", action="store_true", help="only make the changed copy")
    parser.add_argument("--binary", type=pathlib.Path, help="of a changed copy that was built already")
    options = parser.parse_args()
    if options.check:
        patched(options.root)
        print(f"{len(FAULTS)} faults fit the sources")
        return 0
    if options.scratch is None and options.binary is None:
        parser.error("a folder for the changed copy is needed")
    binary = options.binary
    if binary is None:
        copy(options.root.resolve(), options.scratch)
        patch(options.scratch)
        if options.patch_only:
            return 0
        binary = build(options.scratch.resolve())
    known, rows = recorded(), {}
    healthy = hunt(binary, 0, 1, options.seeds)
    print(f"no fault: {healthy or 'as it should be'}", flush=True)
    for number, (what, *_) in enumerate(FAULTS, 1):
        began = time.monotonic()
        found = find(binary, number, options.seeds, known.get(what))
        if found:
            rows[what] = found
        answer = f"seed {found[0]}, {found[1]}" if found else "not found"
        print(f"{number:2} {what}: {answer} ({time.monotonic() - began:.0f} s)", flush=True)
    if options.record:
        record(rows)
    print(f"{len(FAULTS)} faults, {len(rows)} found")
    return 1 if healthy or len(rows) < len(FAULTS) else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Real ROS 2 nodes on our plugins, secured with strategy Enforce by a keystore of `ddssec` or of sros2: they start,
talk with nodes on stock plugins in every combination of roles, and are refused as they should be.

Usage: nodes_test.py BUILD ROS2 [FILTER]      exit 77 if the nodes cannot run here
"""

import concurrent.futures
import os
import pathlib
import sys
import tempfile
import time

sys.dont_write_bytecode = True

import nodes  # noqa: E402
from nodes import OURS, STOCK, Fault, Keystore, Setting, check  # noqa: E402

BUILD, ROS2 = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
# About this machine's OpenSSL there may be a warning.
TROUBLE = r"ddssec (warning|error|critical)(?!.*openssl_known_unsafe)"
IN_USE = r"authentication, access control and cryptography.*\[plugins_in_use 1620\]"


def no_trouble(*all_nodes):
    for node in all_nodes:
        node.uses(node.kind)
        no_trouble_in_log(node)


def no_trouble_in_log(node):
    check(node.count(TROUBLE) == 0, f"{node.name} complains:\n{node.log}")
    check(node.count(IN_USE) == (node.kind == OURS),
          f"{node.name} on {node.kind} plugins says {node.count(IN_USE)} times whose plugins it uses:\n{node.log}")


def talk(setting, keystore, publisher, subscriber):
    listener = setting.start("listener", subscriber, keystore)
    talker = setting.start("talker", publisher, keystore)
    listener.until("I heard")
    no_trouble(talker, listener)


def call(setting, keystore, server, client):
    serving = setting.start("add_two_ints_server", server, keystore)
    calling = setting.start("add_two_ints_client", client, keystore)
    calling.until("add_two_ints: 5")
    serving.until("Incoming request")
    no_trouble(serving)
    no_trouble_in_log(calling)  # it may have ended


def refused(node, code, *parts):
    """It ends, and its log says why exactly once."""
    status = node.ends()
    check(status != 0, f"{node.name} ended well:\n{node.log}")
    sentences = [line for line in node.log.splitlines() if f"{code}]" in line]
    check(len(sentences) == 1, f"'{code}' is said {len(sentences)} times:\n{node.log}")
    missing = [part for part in parts if str(part) not in sentences[0]]
    check(not missing, f"the sentence lacks {missing}: {sentences[0]}")


def outside_the_policy(setting, keystore):
    talker = setting.start("talker", OURS, keystore, "-r", "chatter:=forbidden")
    refused(talker, "topic_not_allowed 1423", keystore.enclave("talker") / "permissions.p7s", "line ", "rt/forbidden",
            'grant "/talker_listener/talker"', "allow the topic in the enclave's policy", "ddssec keystore permission")


def changed(keystore, setting, name, change):
    """A copy of the keystore in which a file of the talker's enclave is changed; and the file."""
    own = keystore.copy(setting.folder)
    file = own.enclave("talker") / name
    content = file.read_bytes()
    file.unlink()  # may be a link into the keystore
    file.write_bytes(change(content, own))
    return own, file


def foreign_key(setting, keystore):
    own, key = changed(keystore, setting, "key.pem", lambda _, own: (own.enclave("listener") / "key.pem").read_bytes())
    refused(setting.start("talker", OURS, own), "key_mismatch 1123", key, key.with_name("cert.pem"))


def tampered_permissions(setting, keystore):
    own, file = changed(keystore, setting, "permissions.p7s", lambda octets, _: octets.replace(b"chatter", b"chatteR"))
    refused(setting.start("talker", OURS, own), "smime_signature_invalid 1172", file)


def cut_certificate(setting, keystore):
    own, file = changed(keystore, setting, "cert.pem", lambda octets, _: octets[:len(octets) // 2])
    refused(setting.start("talker", OURS, own), "certificate_malformed 1110", file)


def wrong_ca(setting, keystore):
    own, file = changed(keystore, setting, "identity_ca.cert.pem",
                        lambda _, own: (own.enclave("talker") / "permissions_ca.cert.pem").read_bytes())
    refused(setting.start("talker", OURS, own), "issuer_unknown 1142", file, file.with_name("cert.pem"))


def unsecured_if_permissive(setting, keystore, kind):
    """A keystore that lacks a file: rcl decides before any plugin is loaded, so ours behaves as stock."""
    own = keystore.copy(setting.folder)
    (own.enclave("talker") / "permissions.p7s").unlink()
    talker = setting.start("talker", kind, own, strategy="Permissive")
    talker.until("Publishing")
    talker.uses(None)


def revoked(setting, keystore, listed_before):
    keystore = Keystore(setting.folder, BUILD / "bin" / "ddssec", ROS2)
    if listed_before:
        keystore.run("crl", "new", "--ca", keystore.path)
        keystore.distribute()
    else:
        for node in ("talker", "listener"):
            (keystore.enclave(node) / "crl.pem").unlink(missing_ok=True)
    listener = setting.start("listener", OURS, keystore)
    talker = setting.start("talker", OURS, keystore)
    listener.until("I heard")
    keystore.run("identity", "revoke", keystore.enclave("talker"), "--ca", keystore.path)
    keystore.distribute()
    listener.until(r"CN=/talker_listener/talker.*certificate_revoked 1144")
    heard, said = listener.count("I heard"), talker.count("Publishing")
    talker.until("Publishing", said + 2)
    check(listener.count("I heard") <= heard + 1, f"the listener hears on:\n{listener.log}")


def denial_first(setting, _, publisher, subscriber):
    """sros2 writes the denials of a policy as the first rule; such a node starts, and may do what a later rule allows."""
    keystore = Keystore(setting.folder, BUILD / "bin" / "ddssec", ROS2)
    for node in ("talker", "listener"):
        document, signed = (keystore.enclave(node) / f"permissions.{end}" for end in ("xml", "p7s"))
        text = document.read_text(encoding="utf-8")
        denial = ("<deny_rule><domains><id>0</id></domains><publish><topics><topic>rt/denied</topic></topics></publish>"
                  "</deny_rule>")
        document.write_text(text.replace("<allow_rule>", denial + "<allow_rule>", 1), encoding="utf-8")
        signed.unlink()
        keystore.run("permissions", "sign", document, "--ca", keystore.path, "-o", signed)
    talk(setting, keystore, publisher, subscriber)


def talk_with_sros2_keystore(setting, _, publisher, subscriber):
    talk(setting, nodes.keystore_of_sros2(setting.folder), publisher, subscriber)


def rows():
    both = (STOCK, OURS)
    for a in both:
        for b in both:
            yield f"talker {a}, listener {b}", talk, (a, b)
            yield f"server {a}, client {b}", call, (a, b)
            yield f"sros2's keystore, talker {a}, listener {b}", talk_with_sros2_keystore, (a, b)
    yield "denial first, ours", denial_first, (OURS, OURS)
    yield "denial first, ours and stock", denial_first, (OURS, STOCK)
    for name, row in (("topic outside the policy", outside_the_policy), ("another enclave's private key", foreign_key),
                      ("tampered permissions", tampered_permissions), ("cut certificate", cut_certificate),
                      ("wrong CA", wrong_ca)):
        yield name, row, ()
    for kind in both:
        yield f"file missing, Permissive, {kind}", unsecured_if_permissive, (kind,)
    yield "revoked, list at start", revoked, (True,)
    yield "revoked, no list at start", revoked, (False,)


def tried(number, row, keystore, folder):
    name, run, arguments = row
    begin, fault = time.monotonic(), None
    try:
        with Setting(os.path.join(folder, str(number)), BUILD, ROS2) as setting:
            run(setting, keystore, *arguments)
    except Fault as one:
        fault = one
    print(f"{'FAILED' if fault else 'ok':8}{name} ({time.monotonic() - begin:.1f} s)" + (f": {fault}" if fault else ""),
          flush=True)
    return fault is None


def main():
    if status := nodes.refuse_to_run(ROS2):
        return status
    wanted = (sys.argv[3:] or [""])[0]
    with tempfile.TemporaryDirectory(prefix="ddssec-ros2-") as folder:
        keystore = Keystore(folder, BUILD / "bin" / "ddssec", ROS2)
        chosen = [row for row in rows() if wanted in row[0]]
        chosen.sort(key=lambda row: row[1] is not revoked)  # the longest first
        with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
            outcomes = list(pool.map(lambda one: tried(*one, keystore, folder), enumerate(chosen)))
    return 0 if outcomes and all(outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())

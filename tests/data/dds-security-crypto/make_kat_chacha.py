#!/usr/bin/env python3
"""Writes kat-chacha.json: what kat-crypto.json has of kinds 1 to 4, for ddssec's own kinds 0x91 and
0x92, from the same inputs. Checks itself: kinds 3 and 4 must come out as they stand in the other
file. Needs the Python package `cryptography`, which shares no code of ours."""

import hashlib
import hmac
import json
import os
import struct

from cryptography.hazmat.primitives.ciphers.aead import AESGCM, ChaCha20Poly1305

HERE = os.path.dirname(os.path.abspath(__file__))
KNOWN = json.load(open(os.path.join(HERE, "kat-crypto.json")))
INPUTS = {name: bytes.fromhex(value) for name, value in KNOWN["inputs"].items()}
SALT, SENDER, RECEIVER = (INPUTS[name] for name in (
    "master_salt32", "master_sender_key32", "master_receiver_specific_key32"))
SESSION, IV = INPUTS["session_id"], INPUTS["iv"]
SENDER_ID, RECEIVER_ID = INPUTS["sender_key_id"], INPUTS["receiver_specific_key_id"]
NAMES = {0x91: "CHACHA20_POLY1305_MAC", 0x92: "CHACHA20_POLY1305"}


def aead(kind):
    return ChaCha20Poly1305 if kind in NAMES else AESGCM


def derive(key, label):
    return hmac.new(key, label + SALT + SESSION, hashlib.sha256).digest()


def header(kind):
    return struct.pack(">I", kind) + SENDER_ID + IV


def protect(kind, plain):
    """Content and common MAC."""
    cipher = aead(kind)(derive(SENDER, b"SessionKey"))
    if kind % 2:
        return plain, cipher.encrypt(IV, b"", plain)
    sealed = cipher.encrypt(IV, plain, b"")
    return struct.pack(">I", len(plain)) + sealed[:-16], sealed[-16:]


def footer(kind, mac, with_receiver):
    if not with_receiver:
        return mac + bytes(4)
    own = aead(kind)(derive(RECEIVER, b"SessionReceiverKey")).encrypt(IV, b"", mac)
    return mac + struct.pack(">I", 1) + RECEIVER_ID + own


def submessage(number, content):
    content += bytes(-len(content) % 4)
    return struct.pack("<BBH", number, 1, len(content)) + content


def group(kind, plain, with_receiver, prefix):
    content, mac = protect(kind, plain)
    inside = content if kind % 2 else submessage(0x30, content)
    return (submessage(prefix, header(kind)) + inside +
            submessage(prefix + 1, footer(kind, mac, with_receiver)))


def payload(kind, plain):
    content, mac = protect(kind, plain)
    return header(kind) + content + footer(kind, mac, False)


def message(kind, plain, with_receiver):
    source = struct.pack("<BBHI", 0x0c, 1, 20, 0) + plain[4:20]
    return plain[:20] + group(kind, source + plain[20:], with_receiver, 0x33)


def key_material(kind, with_receiver):
    def sequence(octets):
        return struct.pack(">I", len(octets)) + octets
    return (struct.pack(">I", kind) + sequence(SALT) + SENDER_ID + sequence(SENDER) +
            (RECEIVER_ID + sequence(RECEIVER) if with_receiver else bytes(8)))


def vectors(kinds):
    out = {"session_keys": [], "keymat": [], "payload": [], "submessage": [], "rtps": []}
    for kind in kinds:
        out["session_keys"].append({
            "kind": kind, "name": NAMES.get(kind, ""),
            "session_key": derive(SENDER, b"SessionKey").hex(),
            "session_receiver_specific_key": derive(RECEIVER, b"SessionReceiverKey").hex()})
        out["payload"].append({"kind": kind,
                               "encoded": payload(kind, INPUTS["plain_payload"]).hex()})
        odd = bytes(range(13))
        out["payload"].append({"kind": kind, "plain": odd.hex(),
                               "encoded": payload(kind, odd).hex()})
        for with_receiver in (False, True):
            common = {"kind": kind, "receiver_specific": with_receiver}
            out["keymat"].append(common | {"cdr": key_material(kind, with_receiver).hex()})
            out["submessage"].append(common | {"encoded": group(
                kind, INPUTS["plain_data_submessage"], with_receiver, 0x31).hex()})
            out["rtps"].append(common | {"encoded": message(
                kind, INPUTS["plain_rtps_message"], with_receiver).hex()})
    return out


def check():
    for section, entries in vectors((3, 4)).items():
        for entry in entries:
            same = [known for known in KNOWN[section] if all(
                known.get(name) == entry.get(name)
                for name in ("kind", "receiver_specific", "plain"))]
            for name in ("session_key", "session_receiver_specific_key", "cdr", "encoded"):
                assert all(known.get(name) == entry.get(name) for known in same), (section, entry)


check()
with open(os.path.join(HERE, "kat-chacha.json"), "w") as file:
    json.dump(vectors((0x91, 0x92)), file, indent=1)
    file.write("\n")

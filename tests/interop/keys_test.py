#!/usr/bin/env python3
"""Keys that are used for other endpoints than their owner's. Every participant in a domain holds the keys of
the others' secure discovery and liveliness writers. Cyclone DDS takes a submessage for the words of the
writer that it names if any key of that writer's participant opened it, so our cryptography has to say whose
key it was.

An insider with a valid certificate, and without any right to the topic, says what keys it is given
(insider/insider.cpp). With each of them this test protects messages in the name of the honest publisher's
writer and multicasts them. The subscriber must get none, and the honest pair goes on without a gap.

Usage: keys_test.py BUILD [FILTER]
"""

import ctypes
import ctypes.util
import hashlib
import hmac
import os
import pathlib
import re
import struct
import subprocess
import sys
import time

sys.dont_write_bytecode = True

from documents import Governance  # noqa: E402
from insider_test import (ELSEWHERE, FORGED, HONEST, begin, check, go_on, play, said, samples)  # noqa: E402
from scenarios import E, EO  # noqa: E402

SHARED_DISCOVERY = Governance(discovery=E, liveliness=E, metadata=EO)
SHARED_KEYS = Governance(discovery=E, liveliness=E, metadata=E)
WRITERS = [bytes.fromhex(f"0000{number:02x}{kind:02x}") for number in range(1, 6) for kind in (2, 3)]
FAR = 1 << 30  # a sequence number that the honest writer does not reach

# Sends each line to every UDP port of the namespace: the prefix in it says which participant it is for.
SENDER = """import socket, sys, time
ports = {int(line.split()[1].split(":")[1], 16) for line in list(open("/proc/net/udp"))[1:]}
out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
for line in sys.stdin:
    for port in ports:
        try:
            out.sendto(bytes.fromhex(line), ("127.0.0.1", port))
        except ConnectionRefusedError:
            pass
    time.sleep(0.0002)
print("sent", len(ports), flush=True)
"""


class Aes:
    """AES-GCM of libcrypto, which our plugins need anyway."""
    SET_TAG_LENGTH, GET_TAG = 0x9, 0x10

    def __init__(self):
        self.lib = ctypes.CDLL(ctypes.util.find_library("crypto"))
        for name in ("EVP_CIPHER_CTX_new", "EVP_aes_128_gcm", "EVP_aes_256_gcm"):
            getattr(self.lib, name).restype = ctypes.c_void_p

    def seal(self, key, iv, plain, also_signed=b""):
        """Ciphertext and tag."""
        lib, context = self.lib, ctypes.c_void_p(self.lib.EVP_CIPHER_CTX_new())
        cipher = ctypes.c_void_p((lib.EVP_aes_256_gcm if len(key) == 32 else lib.EVP_aes_128_gcm)())
        out, size, tag = ctypes.create_string_buffer(len(plain) + 16), ctypes.c_int(), ctypes.create_string_buffer(16)
        lib.EVP_EncryptInit_ex(context, cipher, None, key, iv)
        if also_signed:
            lib.EVP_EncryptUpdate(context, None, ctypes.byref(size), also_signed, len(also_signed))
        lib.EVP_EncryptUpdate(context, out, ctypes.byref(size), plain, len(plain))
        lib.EVP_EncryptFinal_ex(context, None, ctypes.byref(size))
        check("libcrypto makes no tag", lib.EVP_CIPHER_CTX_ctrl(context, self.GET_TAG, 16, tag) == 1)
        lib.EVP_CIPHER_CTX_free(context)
        return out.raw[:len(plain)] + tag.raw


class Key:
    """KeyMaterial_AES_GCM_GMAC (DDS-Security 1.2, clause 10.5.2.1.1), to protect with as its owner does."""

    def __init__(self, aes, octets):
        self.aes, self.kind = aes, octets[:4]
        salt, rest = self.sequence(octets[4:])
        self.id, rest = rest[:4], rest[4:]
        master = self.sequence(rest)[0]
        self.session, self.count = os.urandom(4), 0
        text = b"SessionKey" + salt + self.session
        self.session_key = hmac.new(master, text, hashlib.sha256).digest()[:len(master)]

    @staticmethod
    def sequence(octets):
        size = int.from_bytes(octets[:4], "big")
        return octets[4:4 + size], octets[4 + size:]

    def protect(self, plain):
        """A group of SEC_PREFIX, SEC_BODY or what is signed, and SEC_POSTFIX without receivers' MACs."""
        self.count += 1
        iv = self.session + self.count.to_bytes(8, "big")
        if self.kind[3] in (2, 4):
            sealed = self.aes.seal(self.session_key, iv, plain)
            content = len(plain).to_bytes(4, "big") + sealed[:-16] + bytes(-len(plain) % 4)
            body = struct.pack("<BBH", 0x30, 1, len(content)) + content
        else:
            sealed, body = self.aes.seal(self.session_key, iv, b"", plain), plain
        return (struct.pack("<BBH", 0x31, 1, 20) + self.kind + self.id + iv + body
                + struct.pack("<BBH", 0x32, 1, 20) + sealed[-16:] + bytes(4))


def sequence_number(number):
    return struct.pack("<iI", number >> 32, number & 0xffffffff)


def data(writer, number):
    """A sample of topic Square with FORGED octets of payload, to all readers."""
    sample = (b"\0\1\0\0" + struct.pack("<I", 4) + b"RED\0" + struct.pack("<iii", number, 0, 0)
              + struct.pack("<I", FORGED) + bytes(FORGED))
    body = struct.pack("<HH", 0, 16) + bytes(4) + writer + sequence_number(number) + sample
    return struct.pack("<BBH", 0x15, 0x05, len(body)) + body


def heartbeat(writer):
    """All samples before FAR are gone."""
    return (struct.pack("<BBH", 0x07, 0x03, 28) + bytes(4) + writer + sequence_number(FAR)
            + sequence_number(FAR + 1) + struct.pack("<I", FAR))


def gap(writer):
    """All samples before FAR are irrelevant."""
    return (struct.pack("<BBH", 0x08, 0x01, 28) + bytes(4) + writer + sequence_number(1)
            + sequence_number(FAR) + struct.pack("<I", 0))


def keys_of(insider):
    found = re.findall(r"insider: writer key ([0-9a-f]+)", pathlib.Path(insider.log).read_text(errors="replace"))
    aes = Aes()
    return [Key(aes, bytes.fromhex(one)) for one in found if one[:8] != "00000000"]


def prefixes(insider):
    """The victim's and the subscriber's."""
    text = pathlib.Path(insider.log).read_text()
    victim = re.search(r"insider: victim prefix ([0-9a-f]{24})", text)[1]
    others = set(re.findall(r"insider: other prefix ([0-9a-f]{24})", text)) - {victim}
    check(f"not one subscriber: {others}", len(others) == 1)
    return bytes.fromhex(victim), bytes.fromhex(others.pop())


def send(world, messages):
    """Sends them within the namespace."""
    command = world.namespace.enter([sys.executable, "-c", SENDER])
    done = subprocess.run(command, input="".join(one.hex() + "\n" for one in messages), text=True,
                          stdout=subprocess.PIPE, timeout=30, check=True)
    check("the forged messages were not sent", done.stdout.startswith("sent "))


def silent(subscriber, now):
    """At ten samples a second."""
    return now - subscriber.last_sample > 3


def forge(world, words):
    subscriber = begin(world)
    insider = world.insider("subscribe", "keys", ELSEWHERE)
    world.until("the insider meeting its victim", lambda: said(insider, "victim prefix"))
    # Discovery's three writers, liveliness's, and the participant's own, of both honest participants.
    world.until("the keys", lambda: len(keys_of(insider)) >= 8)
    keys, (victim, to) = keys_of(insider), prefixes(insider)
    check("the insider got nothing of the topic", not samples(insider, HONEST))
    after = max(samples(subscriber, HONEST)) + 1
    header = b"RTPS\2\1\1\x10" + victim + struct.pack("<BBH", 0x0e, 1, 12) + to
    send(world, [header + key.protect(word) for key in keys for writer in WRITERS
                      for word in words(writer, after)])
    refusals = lambda: world.events("submessage_not_of_sender")
    world.until("what was forged having an effect",
                lambda: refusals() or samples(subscriber, FORGED) or silent(subscriber, time.monotonic()))
    check(f"{len(samples(subscriber, FORGED))} forged samples came", not samples(subscriber, FORGED))
    go_on(world, subscriber)
    check(f"{len(samples(subscriber, FORGED))} forged samples came", not samples(subscriber, FORGED))
    check("no refusal was reported", refusals())


def cases():
    many = {"data": lambda writer, after: [data(writer, number) for number in range(after, after + 15)],
            "heartbeat": lambda writer, _: [heartbeat(writer)], "gap": lambda writer, _: [gap(writer)]}
    for kind in ("ddssec", "ddssec-crypto"):
        yield f"data-origin/{kind}", kind, SHARED_DISCOVERY, lambda world: forge(world, many["data"])
        for name in ("data", "heartbeat", "gap"):
            yield f"{name}/{kind}", kind, SHARED_KEYS, lambda world, n=name: forge(world, many[n])


if __name__ == "__main__":
    sys.exit(play(cases(), "keys"))

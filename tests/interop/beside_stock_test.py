#!/usr/bin/env python3
"""Our access control, or our cryptography, alone beside two stock plugins in every process: participants talk, one is
refused by its permissions, and a running one takes other permissions CAs and a further topic rule. The same with all
three of ours.

Usage: beside_stock_test.py BUILD [FILTER]
"""

import os
import shutil
import sys
from dataclasses import replace

sys.dont_write_bytecode = True

import stories  # noqa: E402
from documents import TOPIC, Permissions, Side  # noqa: E402
from insider_test import World, check, said, samples  # noqa: E402
from scenarios import SROS2  # noqa: E402

FIRST, SECOND = 32, 48  # octets of payload, by which the publishers are told apart
TALKING = 12            # samples, at ten a second
ON_ITS_WAY = 2          # seconds a sample may come after the end
LATE = 15               # seconds until the process makes an entity of the topic Further
NEW, FORMER = "second", "main"  # permissions CAs


def set_option(words, name, value):
    words[words.index("--" + name) + 1] = str(value)


class Beside(World):
    """Three participants on the same plugins: a subscriber, and up to two publishers."""

    def __init__(self, folder, kind):
        super().__init__(folder, kind, SROS2)
        properties = os.path.join(folder, "properties")
        with open(properties, "w", encoding="utf-8") as file:
            file.write("org.ddssec.files_poll_interval = 1\n")
        self.settings = {"DDSSEC_PROPERTIES": properties}

    def join(self, name, role, words, payload, more=()):
        events = os.path.join(self.folder, f"{name}.events")
        return self.start(name, self.kind,
                          ["--" + role, "--payload", str(payload), "--timeout", "200", *more, *words],
                          {"DDSSEC_EVENT_LOG": events, **self.settings})

    def cas(self, *names):
        return self.pki.bundle(*[self.pki.ca(f"permissions-{name}", self.keys.permissions_ca) for name in names])

    def put(self, name, source):
        """A file of the subscriber's own that may be replaced while it runs."""
        path = os.path.join(self.folder, "own-" + name)
        shutil.copy(source, path + ".new")
        os.replace(path + ".new", path)
        return path

    def signed(self, text):
        ca = self.pki.ca(f"permissions-{NEW}", self.keys.permissions_ca)
        return self.pki.sign(text, f"{ca}/cert.pem", f"{ca}/key.pem")

    def first_pair(self, change=lambda words: None, more=()):
        """The subscriber, whose options `change` may change, and the first publisher; all signed by the new CA."""
        side = Side(SROS2, permissions_by=NEW, permissions_ca=NEW, governance_by=NEW)
        own, other = (side.arguments(self.pki, self.keys, starts) for starts in (False, True))
        set_option(other, "permissions_ca", self.cas(NEW, FORMER))
        change(own)
        subscriber = self.join("subscribe", "subscribe", own, FIRST, more)
        self.join("publish", "publish", other, FIRST)
        self.go_on(subscriber, FIRST)
        return subscriber

    def second_publisher(self, name, permissions=Permissions(), by=FORMER):
        """A publisher that trusts both CAs."""
        side = replace(self.side, permissions=permissions, permissions_by=by, governance_by=by)
        words = side.of("second-publisher", self.pki, self.keys)
        set_option(words, "permissions_ca", self.cas(NEW, FORMER))
        return self.join(name, "publish", words, SECOND)

    def go_on(self, subscriber, payload):
        before = len(samples(subscriber, payload))
        self.until(f"hearing {payload} octets",
                   lambda: len(samples(subscriber, payload)) >= before + TALKING)


def refused_by_permissions(world):
    """A participant whose permissions name another topic makes no endpoint of this one."""
    subscriber = world.first_pair()
    refused = world.second_publisher("refused", Permissions(publish=("Elsewhere",), subscribe=("Elsewhere",)), NEW)
    world.until("the refusal", lambda: refused.ended)
    check(f"it ended with {refused.process.returncode}", refused.process.returncode == 3)
    check("no log says why", said(refused, "topic_not_allowed 1423" if world.kind != "ddssec-crypto" else TOPIC))
    world.go_on(subscriber, FIRST)
    check("it was heard", not samples(subscriber, SECOND))


def authorities(world):
    """A permissions CA joins the file of a running participant, and leaves it again."""
    subscriber = world.first_pair(
        lambda words: set_option(words, "permissions_ca", world.put("cas.pem", world.cas(NEW))))
    unknown = world.second_publisher("unknown")
    world.until("the refusal", lambda: world.events("smime_signer_not_permissions_ca"))
    world.go_on(subscriber, FIRST)
    check("a participant of an unknown CA was heard", not samples(subscriber, SECOND))
    unknown.kill()

    world.put("cas.pem", world.cas(NEW, FORMER))
    world.until("the further CA", lambda: len(world.events("permissions_ca_renewed")) == 1)
    world.second_publisher("known")
    world.go_on(subscriber, SECOND)
    check("a CA was withdrawn", not world.events("permissions_ca_withdrawn"))

    world.put("cas.pem", world.cas(NEW))
    world.until("the CA's end", lambda: world.events("permissions_ca_withdrawn"))
    world.passes(ON_ITS_WAY)
    heard = len(samples(subscriber, SECOND))
    world.go_on(subscriber, FIRST)
    check("it is heard without its CA", len(samples(subscriber, SECOND)) == heard)
    check("others were cut off", len(world.events("permissions_ca_withdrawn")) == 1)


def governance(world, is_extended):
    """A running participant takes a rule for a further topic, and makes the topic; without the rule it is refused."""
    square = SROS2.xml().replace("<topic_expression>*<", f"<topic_expression>{TOPIC}<")
    begin, end = square.index("<topic_rule>"), square.index("</topic_rule>") + len("</topic_rule>")
    rule = square[begin:end]
    extended = square.replace(rule, rule + rule.replace(TOPIC, "Further"))
    world.side = replace(world.side, permissions=Permissions((TOPIC, "Further"), (TOPIC, "Further")))

    def change(words):
        set_option(words, "governance", world.put("governance.p7s", world.signed(square)))
        own = replace(world.side, permissions_by=NEW).arguments(world.pki, world.keys, False)
        set_option(words, "permissions", own[own.index("--permissions") + 1])

    subscriber = world.first_pair(change, ["--late", str(LATE)])
    if is_extended:
        world.put("governance.p7s", world.signed(extended))
        world.until("the further rule", lambda: len(world.events("governance_renewed")) == 1)
        check("it came too late", not any(line.startswith("late: ") for line in subscriber.lines))
    world.until("the further topic", lambda: any(line.startswith("late: ") for line in subscriber.lines))
    outcome = "late: topic created" if is_extended else "late: topic Not Allowed By Security"
    check(f"not '{outcome}': {subscriber.lines[-3:]}", any(line.startswith(outcome) for line in subscriber.lines))
    world.go_on(subscriber, FIRST)


def cases():
    for kind in ("ddssec-ac", "ddssec-crypto", "ddssec"):
        yield f"refused by permissions/{kind}", kind, refused_by_permissions
    for kind in ("ddssec-ac", "ddssec"):
        yield f"permissions CAs/{kind}", kind, authorities
        yield f"further topic rule/{kind}", kind, lambda world: governance(world, True)
    yield "no further topic rule/ddssec-ac", "ddssec-ac", lambda world: governance(world, False)


if __name__ == "__main__":
    sys.exit(stories.run(cases(), stories.attempt_in(Beside, "beside"), at_once=8))

#!/usr/bin/env python3
"""cli/schema describes what every command prints with --format json, and nothing else."""

import copy
import unittest

from ocsp_responder import index_line, responder
from shown_process import running_participant
from transcript import ANSWERS, DATA, NOW, SCHEMA, Transcript, answers_of, main

FREE = ("--no-passphrase",)
POLICY = DATA / "sros2/upstream/policies/talker_listener.policy.xml"


def objects_of(node, path=""):
    """Every schema of an object that is not only a condition."""
    if isinstance(node, dict):
        if node.get("type") == "object":
            yield path, node
        for key, value in node.items():
            if key not in ("if", "then", "else"):
                yield from objects_of(value, f"{path}/{key}")
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from objects_of(value, f"{path}/{index}")


def objects_in(value, path=()):
    """The path of every object of a document."""
    if isinstance(value, dict):
        yield path
        for key, inner in value.items():
            yield from objects_in(inner, path + (key,))
    elif isinstance(value, list):
        for index, inner in enumerate(value[:2]):
            yield from objects_in(inner, path + (index,))


def at(value, path):
    for key in path:
        value = value[key]
    return value


class EveryCommand(Transcript):
    """One run of each command, in an order in which each finds what it needs."""

    def setUp(self):
        super().setUp()
        self.answers = []

    def ask(self, *words, exit=0):
        self.answers.append(self.json(*words, *NOW, exit=exit))

    def ask_certificates(self):
        self.ask("ca", "create", "ca", *FREE)
        self.ask("ca", "import", "again", "--cert", "ca/identity/ca.pem", "--key",
                 "ca/identity/ca.key.pem", *FREE)
        self.ask("ca", "renew", "ca")
        self.ask("identity", "issue", "a", "--ca", "ca", "-o", "a", "--publish", "x")
        (self.at / "fleet.toml").write_text('[[participant]]\nname = "b"\n')
        self.ask("identity", "issue", "--from", "fleet.toml", "--ca", "ca", "-o", "fleet")
        self.ask("identity", "csr", "device", "-o", "device")
        self.ask("identity", "sign-csr", "device/request.pem", "--ca", "ca", "--yes")
        self.ask("identity", "show", "a")
        self.ask_ocsp()
        self.ask("identity", "renew", "a", "--ca", "ca")
        self.ask("identity", "renew", "a", "--ca", "ca", "--within", "3")
        self.ask("identity", "revoke", "device", "--ca", "ca")
        self.ask("identity", "revoke", "device", "--ca", "ca")
        self.ask("crl", "new", "--ca", "ca")
        self.ask("ca", "show", "ca")
        self.ask("crl", "show", "ca")
        self.ask("crl", "verify", "ca", "--ca", "ca")
        self.ask("crl", "distribute", "--ca", "ca")
        self.ask("ca", "rotate", "ca", "--role", "identity")

    def ask_ocsp(self):
        """The responder goes by the clock of the machine, and so do its CA and the certificate."""
        self.run_program("ca", "create", "today", *FREE)
        self.run_program("identity", "issue", "t", "--ca", "today", "-o", "t")
        serial = self.json("identity", "show", "t")["result"]["serial"]
        (self.at / "index").write_text(index_line("V", serial, "t"))
        with responder(self.at / "index", self.at / "today/identity") as url:
            self.answers.append(self.json("identity", "ocsp", "t", "--url", url))

    def ask_documents(self):
        trust = ("--ca", "ca/permissions/ca.pem")
        self.ask("governance", "new", "--topic", "x:data=SIGN", "-o", "g.xml")
        self.ask("governance", "new", "--profile", "open", "-o", "open.xml")
        self.ask("permissions", "new", "--cert", "a/cert.pem", "--publish", "x", "-o", "p.xml")
        self.ask("permissions", "new", "--cert", "a/cert.pem", "--subscribe", "y", "-o", "q.xml")
        self.ask("permissions", "from-ros-policy", POLICY, "-o", "ros.xml")
        self.ask("governance", "show", "g.xml")
        self.ask("governance", "show", "g.xml", "--topic", "x")
        self.ask("permissions", "show", "p.xml")
        for group, old, new in (("governance", "g.xml", "open.xml"), ("permissions", "p.xml", "q.xml")):
            self.ask(group, "lint", new)
            self.ask(group, "sign", old, "--ca", "ca")
            self.ask(group, "verify", old[0] + ".p7s", *trust)
            self.ask(group, "verify", old[0] + ".p7s", "--ca", "ca/identity/ca.pem", exit=1)
            self.ask(group, "diff", old[0] + ".p7s", new)

    def ask_keystore(self):
        self.ask("keystore", "create", "ks", "--single-ca", *FREE)
        self.ask("keystore", "enclave", "ks", "/a", "--allow-all")
        self.ask("keystore", "list", "ks")
        self.ask("keystore", "permission", "ks", "/a", "--publish", "rt/x")
        (self.at / "ks/enclaves/a/key.pem").chmod(0o644)
        self.ask("keystore", "verify", "ks", exit=1)
        self.ask("keystore", "import", "ks")
        self.ask("keystore", "split-ca", "ks")
        self.ask("keystore", "rotate", "ks", "--role", "identity")

    def ask_questions(self):
        self.ask("init", "demo")
        self.ask("init", "robot", "--layout", "sros2")
        self.ask("can", "demo/talker", "publish", "x")
        self.ask("check", "demo/talker", "demo/listener", "--topics", "x")
        self.ask("expiry", "demo")
        with running_participant(self.at / "status", self.at / "demo/talker"):
            self.ask("trust", "status", "demo/talker", "--status-dir", "status", exit=1)
        self.ask("doctor", "demo/talker", "--peer", "demo/listener")
        self.ask("inspect", DATA / "captures/two_participants.pcap")
        self.ask("explain", "usage")
        self.ask("explain", "GOV010")
        self.ask("completion", "fish")
        self.ask("man")
        self.ask("version")
        self.ask("agent", "demo/talker", "--ca", "demo", "--once")
        self.answers.append(self.json("agent", "demo/talker", "--ca", "demo", "--once", "--now", "2027-09-01"))

    def test_each_result_is_of_a_closed_schema(self):
        self.ask_certificates()
        self.ask_documents()
        self.ask_keystore()
        self.ask_questions()
        rows = self.run_program("--help").stdout.splitlines()
        commands = [row[2:30].strip() for row in rows if row.startswith("  ")]
        self.assertCountEqual(SCHEMA["properties"]["command"]["enum"], ["", *commands])
        answered = {answer["command"] for answer in self.answers if answer["result"]}
        self.assertEqual(answered, set(commands))
        for answer in self.answers:
            self.assert_closed(answer)

    def assert_closed(self, answer):
        """No object of the answer may have one member more."""
        for path in objects_in(answer):
            changed = copy.deepcopy(answer)
            at(changed, path)["unheard_of"] = 1
            self.assertFalse(ANSWERS.is_valid(changed), f"{answer['command']} {path}")
            self.assertFalse(answers_of(answer["command"]).is_valid(changed), f"{answer['command']} {path}")
        for name in answer["result"]:
            changed = copy.deepcopy(answer)
            changed["result"][name] = {"of": ["no", "sense"]}
            self.assertFalse(ANSWERS.is_valid(changed), f"{answer['command']} {name}")
            self.assertFalse(answers_of(answer["command"]).is_valid(changed), f"{answer['command']} {name}")


class Schema(unittest.TestCase):
    def test_every_command_has_its_part(self):
        rules = SCHEMA["allOf"][1:]
        parts = {rule["if"]["properties"]["command"]["const"]:
                 rule["then"]["properties"]["result"]["$ref"] for rule in rules}
        self.assertEqual(list(parts), SCHEMA["properties"]["command"]["enum"][1:])
        for command, part in parts.items():
            self.assertEqual(part, f"#/$defs/result of {command}")
            self.assertIn(f"result of {command}", SCHEMA["$defs"])

    def test_every_object_is_closed(self):
        for path, schema in objects_of(SCHEMA):
            if path == "/properties/result":  # closed by the part of its command
                continue
            self.assertIn("additionalProperties", schema, path)
            self.assertIsNot(schema["additionalProperties"], True, path)

    def test_a_success_says_something_and_a_failure_is_no_success(self):
        empty = {"schema": "ddssec/2", "command": "can", "ok": True, "exit": 0, "result": {},
                 "diagnostics": [], "files_written": []}
        self.assertFalse(ANSWERS.is_valid(empty))
        self.assertFalse(ANSWERS.is_valid({**empty, "ok": False}))
        self.assertTrue(ANSWERS.is_valid({**empty, "ok": False, "exit": 1}))
        self.assertFalse(ANSWERS.is_valid({**empty, "ok": False, "exit": 1, "command": "cannot"}))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Permissions that are longer than ddssec's plugins send, or take from a peer (measured: a participant with them
does not start on ddssec's plugins, and starts on those of Cyclone DDS)."""

from transcript import Transcript, main

NOW = ("--now", "2026-11-20T00:00:00Z")
MOST = 1024 * 1024
DOCUMENT = """<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions><grant name="talker"><subject_name>CN=talker</subject_name>
<validity><not_before>2026-01-01T00:00:00Z</not_before><not_after>2027-11-01T00:00:00Z</not_after></validity>
<allow_rule><domains><id>0</id></domains><publish><topics>{}</topics></publish></allow_rule>
<default>DENY</default></grant></permissions></dds>
"""


class LongPermissions(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)

    def write(self, size):
        """A plain document of this many octets, lines ending in CR LF as in the signed one."""
        short = DOCUMENT.format("<topic>a</topic><topic></topic>").replace("\n", "\r\n")
        text = DOCUMENT.format(f"<topic>a</topic><topic>{'b' * (size - len(short))}</topic>").replace("\n", "\r\n")
        self.assertEqual(len(text), size)
        (self.at / "permissions.xml").write_bytes(text.encode())

    def write_topics(self, count):
        topics = "".join(f"<topic>{'t' * 200}{i}</topic>" for i in range(count))
        (self.at / "permissions.xml").write_text(DOCUMENT.format(topics))

    def sign(self, *more, exit=0):
        return self.json("permissions", "sign", "permissions.xml", "--ca", "demo", "-o", "demo/talker/permissions.p7s",
                         "--replace", *more, *NOW, exit=exit)

    def about_length(self, *words, exit):
        return [d for d in self.json(*words, *NOW, exit=exit)["diagnostics"] if d["id"] == "PERM042"]

    def test_no_command_that_signs_permissions_makes_them(self):
        self.write_topics(5200)
        document = ("--permissions", "permissions.xml", *NOW)
        told = self.refused("smime_too_large", 1, "identity", "issue", "talker", "--ca", "demo", "-o", "new", *document)
        self.assertIn(f"expected at most {MOST} octets", told["message"])
        self.run_program("identity", "issue", "talker", "--ca", "demo", "-o", "new", *NOW)
        self.refused("smime_too_large", 1, "identity", "issue", "talker", "--ca", "demo", "-o", "new", *document)
        self.run_program("permissions", "sign", "permissions.xml", "--ca", "demo", "-o", "new/permissions.p7s", "--no-lint",
                         *NOW)
        (self.at / "new/permissions_ca.pem").write_bytes((self.at / "demo/talker/permissions_ca.pem").read_bytes())
        self.refused("smime_too_large", 1, "identity", "renew", "new", "--ca", "demo", "--permissions",
                     "--now", "2027-10-15T00:00:00Z")
        self.run_program("keystore", "create", "ks", "--no-passphrase", *NOW)
        text = (self.at / "permissions.xml").read_text().replace("CN=talker", "CN=/a")
        (self.at / "permissions.xml").write_text(text)
        self.refused("smime_too_large", 1, "keystore", "enclave", "ks", "/a", *document)
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.refused("smime_too_large", 1, "keystore", "permission", "ks", "/a", *document)

    def test_lint_and_sign_refuse_them(self):
        self.write_topics(6000)
        (told,) = self.about_length("permissions", "lint", "permissions.xml", exit=1)
        self.assertEqual(told["severity"], "error")
        self.assertIn(f"{MOST} at most: a participant with it does not start on them, and is not accepted by "
                      "participants on them", told["message"])
        before = (self.at / "demo/talker/permissions.p7s").read_bytes()
        self.assertIn("PERM042", [d["id"] for d in self.sign(exit=1)["diagnostics"]])
        self.assertEqual((self.at / "demo/talker/permissions.p7s").read_bytes(), before)

    def test_doctor_check_and_can_foretell_what_happens(self):
        self.write_topics(6000)
        self.sign("--no-lint")
        (told,) = self.about_length("doctor", "demo/talker", exit=1)
        self.assertEqual((told["vendors"], told["file"]), (["ddssec"], "demo/talker/permissions.p7s"))
        self.assertEqual(len(self.about_length("permissions", "lint", "demo/talker", exit=1)), 1)
        because = self.json("can", "demo/talker", "publish", "t" * 200 + "1", *NOW, exit=1)["result"]["because"]
        self.assertIn("the participant does not start: PERM042", because)
        self.assertEqual(self.accepted("cyclonedds", "cyclonedds"), True)
        self.assertEqual(self.accepted("cyclonedds", "ddssec"), False)

    def accepted(self, talkers, listeners):
        out = self.run_program("check", "demo/talker", "demo/listener", "--vendor", f"A={talkers}", "--vendor",
                               f"B={listeners}", *NOW, exit=None).stdout
        (line,) = [line for line in out.splitlines() if line.startswith("permissions ")]
        return "listener accepts talker: ok" in line

    def test_the_signature_counts(self):
        self.write(MOST - 100)
        self.assertEqual(self.about_length("permissions", "lint", "permissions.xml", exit=None), [])
        self.assertIn("PERM042", [d["id"] for d in self.sign(exit=1)["diagnostics"]])
        self.write(MOST - 8 * 1024)
        self.assertNotIn("PERM042", [d["id"] for d in self.sign(exit=None)["diagnostics"]])


if __name__ == "__main__":
    main()

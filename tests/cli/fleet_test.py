#!/usr/bin/env python3
"""identity issue --from: a fleet in one command, all of it or nothing."""

import signal
import subprocess
import time

from transcript import NOW, PROGRAM, Transcript, main

FLEET = """
domain = 3
days = 30
subscribe = ["rt/clock"]

[[participant]]
name = "talker"
publish = ["rt/chatter", "rt/<a>"]

[[participant]]
name = "listener"
subject = "CN=listener,O=Acme"
domain = 4
days = 60
subscribe = []
"""


class Fleet(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)

    def issue(self, text, name="fleet.toml"):
        (self.at / name).write_text(text)
        return ("identity", "issue", "--from", name, "--ca", "ca", "-o", "out", *NOW)

    def wrong(self, text, line, code="fleet_malformed", exit=3):
        told = self.refused(code, exit, *self.issue(text))
        self.assertEqual((told["file"], told.get("line")), ("fleet.toml", line))
        return told["message"]

    def test_each_participant_gets_what_the_file_says(self):
        self.run_program("governance", "new", "--sign", "--ca", "ca", "-o", "governance.xml", *NOW)
        out = self.json(*self.issue(FLEET), "--governance", "governance.p7s")
        rows = out["result"]["participants"]
        self.assertEqual([(r["name"], r["dir"], r["subject"], r["not_after"]) for r in rows],
                         [("talker", "out/talker", "CN=talker", "2026-12-21T00:00:00Z"),
                          ("listener", "out/listener", "CN=listener,O=Acme", "2027-01-20T00:00:00Z")])
        self.assertEqual(len(list((self.at / "out/talker").iterdir())), 9)
        self.assertIn(f"file:{self.at}/out/talker/permissions.p7s", (self.at / "out/talker/cyclonedds.xml").read_text())
        document = (self.at / "out/talker/permissions.p7s").read_text()
        for text in ("<id>3</id>", "rt/chatter", "rt/&lt;a&gt;", "rt/clock"):
            self.assertIn(text, document)
        # Without any right, there is nothing to sign.
        self.assertFalse((self.at / "out/listener/permissions.p7s").exists())
        self.assertEqual(self.json("ca", "show", "ca", *NOW)["result"]["issued"], 2)

    def test_two_with_one_subject_are_told(self):
        fleet = ('[[participant]]\nname = "a"\nsubject = "CN=x,O=Acme"\n[[participant]]\nname = "b"\n'
                 '[[participant]]\nname = "c"\nsubject = "O=Acme,CN=x"\n')
        told = self.json(*self.issue(fleet), "--dry-run")["diagnostics"]
        self.assertEqual([(d["id"], d["severity"], d["file"]) for d in told],
                         [("subject_shared", "warning", "fleet.toml")])
        self.assertIn("(found a and c: O=Acme,CN=x)", told[0]["message"])
        fleet = fleet.replace("O=Acme,CN=x", "CN=x,O=Acme")
        self.assertIn("warning[subject_shared]", self.run_program(*self.issue(fleet)).stderr)
        # What the warning says is so: who revokes one revokes both.
        self.run_program("identity", "revoke", "out/a", "--ca", "ca", *NOW)
        self.assertEqual(self.json("ca", "show", "ca", *NOW)["result"]["revoked"], 2)

    def test_a_document_of_ones_own_stands_beside_the_file(self):
        self.run_program("identity", "issue", "a", "--ca", "ca", "-o", "a", "--publish", "x", *NOW)
        signed = (self.at / "a/permissions.p7s").read_text()
        (self.at / "sub").mkdir()
        (self.at / "sub/a.xml").write_text(signed[signed.index("<?xml"):signed.index("</dds>") + 7])
        fleet = '[[participant]]\nname = "a"\npermissions = "a.xml"\n'
        self.json(*self.issue(fleet, "sub/fleet.toml"))
        self.assertTrue((self.at / "out/a/permissions.p7s").exists())

    def test_a_file_with_a_mistake_issues_nothing(self):
        self.wrong("[[participant]\nname = 1", 1)
        self.assertIn("rigths", self.wrong('[[participant]]\nname = "a"\nrigths = ["x"]\n', 3))
        self.wrong('[[participant]]\nname = 7\n', 2)
        self.wrong('[[participant]]\npublish = ["x"]\n', 1)
        self.wrong('[[participant]]\nname = "a"\npublish = "x"\n', 3)
        self.wrong('[[participant]]\nname = "a"\npublish = ["x", 1]\n', 3)
        self.wrong('[[participant]]\nname = "a"\ndomain = 231\n', 3)
        self.wrong('[[participant]]\nname = "a"\ndays = 0\n', 3)
        self.wrong('[[participant]]\nname = "a"\nkey = "dsa"\n', 3)
        self.wrong('[[participant]]\nname = "a"\n[[participant]]\nname = "a"\n', 3)
        self.wrong('domian = 1\n[[participant]]\nname = "a"\n', 1)
        self.wrong("participant = 3\n", 1)
        self.wrong('[[participant]]\nname = "../evil"\n', 1, "name_unusable", 2)
        self.wrong("a = " + "[" * 100_000, 1)
        self.wrong("# nobody\n", 1)
        self.refused("fleet_malformed", 3, *self.issue("[[participant]]\n"))

    def test_a_drop_in_folder_is_for_every_participant(self):
        self.run_program(*self.issue(FLEET), "--dropin", "/opt/dropin")
        for name in ("talker", "listener"):
            text = (self.at / "out" / name / "cyclonedds.xml").read_text()
            self.assertEqual(text.count('<Library path="/opt/dropin/libdds_security_'), 3)

    def test_an_unknown_key_is_answered_with_those_that_are_known(self):
        for key, meant in (("publishes", "publish"), ("dommain", "domain"), ("topics_subscribe", "subscribe")):
            told = self.wrong(f'[[participant]]\nname = "a"\n{key} = ["x"]\n', 3)
            self.assertIn("expected one of name, subject, domain, days", told)
            self.assertIn(f'did you mean "{meant}"?', told)

    def test_a_fleet_grows_by_what_the_file_has_more(self):
        self.json(*self.issue(FLEET))
        before = {file: (self.at / file).read_bytes() for file in self.files() if file.startswith("out/")}
        more = FLEET.replace('"rt/chatter", ', "") + '[[participant]]\nname = "third"\npublish = ["x"]\n'
        self.json(*self.issue(more), "--dry-run")
        self.assertFalse((self.at / "out/third").exists())
        out = self.json(*self.issue(more))
        self.assertEqual([row["dir"] for row in out["result"]["participants"]], ["out/third"])
        self.assertEqual({file: (self.at / file).read_bytes() for file in before}, before, "the others stay")
        self.assertIn(f"file:{self.at}/out/third/key.pem", (self.at / "out/third/cyclonedds.xml").read_text())
        self.assertEqual(self.json("ca", "show", "ca", *NOW)["result"]["issued"], 3)
        self.assertIn("every participant of the file", self.refused("would_overwrite", 4, *self.issue(more))["message"])
        (self.at / "out/fourth").write_text("")
        self.refused("would_overwrite", 4, *self.issue(more + '[[participant]]\nname = "fourth"\n'))
        (self.at / "other").mkdir()
        self.refused("would_overwrite", 4, *self.issue(FLEET)[:-3], "other", *NOW)
        same = more + '[[participant]]\nname = "fifth"\nsubject = "CN=talker,OU=x"\n'
        self.refused("subject_taken", 4, *self.issue(same))

    def test_a_name_is_given_here_or_in_the_file(self):
        issue = self.issue(FLEET)
        self.refused("usage", 2, "identity", "issue", "x", *issue[2:])
        self.refused("usage", 2, "identity", "issue", "--ca", "ca", "-o", "x")
        self.refused("usage", 2, *issue, "--subject", "CN=x")

    def test_one_that_cannot_be_issued_stops_all(self):
        self.refused("outlives_ca", 4, *self.issue(FLEET.replace("60", "36000")))
        told = self.refused("subject_name_malformed", 2, *self.issue(FLEET.replace("CN=listener", "listener")))
        self.assertEqual(told["file"], "fleet.toml")

    def test_a_long_run_says_how_far_it_is_and_ends_cleanly_when_interrupted(self):
        fleet = "\n".join(f'[[participant]]\nname = "p{i}"\nkey = "rsa3072"' for i in range(3000))
        running = subprocess.Popen([PROGRAM, *self.issue(fleet)], cwd=self.at, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertRegex(running.stderr.readline(), r"^\d+ of 3000 participants$")
        running.send_signal(signal.SIGINT)
        out, said = running.communicate(timeout=60)
        self.assertEqual((running.returncode, out), (5, ""))
        self.assertIn("error[interrupted]", said)
        self.assertEqual({p.name for p in self.at.iterdir()}, {"ca", "fleet.toml"})
        self.assertFalse((self.at / "ca/identity/issued.jsonl").exists())

    def test_a_thousand_with_permissions_in_far_less_than_a_minute(self):
        fleet = "\n".join(f'[[participant]]\nname = "p{i}"\npublish = ["rt/p{i}"]' for i in range(1000))
        began = time.monotonic()
        done = self.run_program(*self.issue(fleet))
        self.assertLess(time.monotonic() - began, 60)
        self.assertEqual(len(done.stdout.splitlines()), 1002)  # the last two are about all folders
        self.assertEqual(len(list((self.at / "out").iterdir())), 1000)


    def test_dotted_keys_and_nested_values_are_bounded(self):
        for begin, end in (("", " = 1"), ("[", "]"), ("x = {", " = 1}"), ('"=".', " = 1")):
            self.wrong("\n" + begin + ".".join(["a"] * 200_000) + end + "\n", 2)
        self.wrong("x = " + "[" * 200 + "]" * 200 + "\n", 1)


if __name__ == "__main__":
    main()

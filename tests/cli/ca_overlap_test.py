#!/usr/bin/env python3
"""ca rotate --overlap, --move and --end: a CA and its successor side by side."""

import json
import shutil

from transcript import AT_THAT_TIME, NOW, Transcript, main

ROLES = ("identity", "permissions")


class Overlap(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "--participant", "talker", "--participant", "listener", *NOW)
        self.root = {role: self.text(f"demo/ca/{role}/ca.pem") for role in ROLES}

    def text(self, path):
        return (self.at / path).read_text()

    def rotate(self, role, *words, exit=0, at=NOW):
        return self.json("ca", "rotate", "demo", *words, "--role", role, *at, exit=exit)["result"]

    def both(self, *words):
        for role in ROLES:
            self.rotate(role, *words)

    def certificates(self, path):
        text = self.text(path)
        return [part + "-----END CERTIFICATE-----\n" for part in text.split("-----END CERTIFICATE-----\n")[:-1]]

    def talks(self, a, b, *vendors):
        words = [word for vendor in vendors for word in ("--vendor", vendor)]
        return self.json("check", a, b, *words, *NOW, exit=None)["exit"] == 0

    def copy(self, name, as_name):
        shutil.copytree(self.at / "demo" / name, self.at / as_name)
        for file in (self.at / as_name).glob("*.xml"):
            file.unlink()
        return as_name

    def test_the_successor_is_accepted_before_it_issues_anything(self):
        certificate = self.text("demo/talker/cert.pem")
        out = self.rotate("identity", "--overlap", "30d")
        self.assertEqual((out["step"], out["until"]), ("begun", "2026-12-21T00:00:00Z"))
        self.assertEqual(out["folders"], [str(self.at / "demo" / name) for name in ("talker", "listener")])
        self.assertEqual(self.text("demo/talker/cert.pem"), certificate)
        successor, former = self.certificates("demo/ca/identity/ca.pem")
        self.assertEqual(former, self.root["identity"])
        self.assertEqual(self.certificates("demo/talker/identity_ca.pem"), [former, successor])
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "demo/ca/identity/ca.pem", "demo/talker/cert.pem")
        self.assertTrue(self.talks("demo/talker", "demo/listener"))
        self.assertEqual(self.files()["demo/ca/identity/ca.key.pem"], 0o600)
        lists = self.json("crl", "show", "demo/talker", *NOW)["result"]
        self.assertEqual(len(lists["others"]), 1, "a list of each key")

    def test_both_cas_pass_from_one_to_the_other(self):
        self.both("--overlap", "30d")
        out = self.rotate("identity", "demo/talker", "--move")
        self.assertEqual((out["step"], out["folders"]), ("moved", ["demo/talker"]))
        self.rotate("permissions", "demo/talker", "--move")
        for role in ROLES:
            successor, former = self.certificates(f"demo/ca/{role}/ca.pem")
            self.assertEqual(self.certificates(f"demo/talker/{role}_ca.pem"), [successor, former])
            self.assertEqual(self.certificates(f"demo/listener/{role}_ca.pem"), [former, successor])
        self.json("governance", "verify", "demo/talker/governance.p7s", "--ca", "demo/talker/permissions_ca.pem", *NOW)
        self.assertTrue(self.talks("demo/talker", "demo/listener"), "one moved, the other not")
        self.both("--end")
        for role in ROLES:
            self.assertEqual(len(self.certificates(f"demo/ca/{role}/ca.pem")), 1)
            for name in ("talker", "listener"):
                self.assertEqual(self.text(f"demo/{name}/{role}_ca.pem"), self.text(f"demo/ca/{role}/ca.pem"))
        self.assertEqual([path for path in self.files() if "overlap" in path], [])
        self.assertTrue(self.talks("demo/talker", "demo/listener"))
        self.assertEqual(self.json("crl", "show", "demo/talker", *NOW)["result"]["others"], [])
        self.json("doctor", "demo/listener", *NOW)

    def test_check_says_who_would_lose_whom_at_each_step(self):
        self.copy("talker", "old")
        self.both("--overlap", "30d")
        unmoved = self.copy("listener", "unmoved")
        self.both("--move")
        moved = "demo/talker"
        for one, other, want in ((moved, unmoved, True), (unmoved, moved, True), ("old", unmoved, True),
                                 ("old", moved, False)):
            self.assertEqual(self.talks(one, other, "ddssec"), want, f"{one} {other}")
        self.assertTrue(self.talks(moved, "demo/listener", "cyclonedds"))
        self.assertTrue(self.talks("old", unmoved, "cyclonedds"))
        self.assertFalse(self.talks(moved, unmoved, "cyclonedds"))
        self.assertFalse(self.talks(moved, unmoved, "A=ddssec", "B=cyclonedds"))
        self.both("--end")
        self.assertFalse(self.talks(moved, unmoved, "ddssec"))
        self.assertTrue(self.talks(moved, "demo/listener", "fastdds"))

    def test_the_end_waits_for_its_date_and_moves_who_has_not_moved(self):
        self.both("--overlap", "30d")
        before = {path: self.text(path) for path in self.files()}
        out = self.rotate("identity", "--end", "--when-due")
        self.assertEqual((out["step"], out["folders"]), ("not due", []))
        self.assertEqual({path: self.text(path) for path in self.files()}, before)
        out = self.rotate("identity", "--end", "--when-due", at=("--now", "2026-12-21T00:00:00Z"))
        self.assertEqual((out["step"], len(out["folders"])), ("ended", 2))
        self.assertEqual(len(self.certificates("demo/ca/identity/ca.pem")), 1)

    def test_who_comes_during_the_overlap_accepts_both(self):
        self.both("--overlap", "30d")
        self.run_program("identity", "issue", "radar", "--ca", "demo", "-o", "demo/radar", "--publish", "x",
                         "--governance", "demo/governance.p7s", *NOW)
        self.assertTrue(self.talks("demo/radar", "demo/listener"))
        self.assertEqual(self.certificates("demo/radar/identity_ca.pem"), self.certificates("demo/ca/identity/ca.pem"))

    def test_a_compromised_ca_still_ends_at_once(self):
        self.both("--overlap", "30d")
        for role in ROLES:
            self.assertEqual(self.rotate(role)["step"], "replaced")
            self.assertEqual(len(self.certificates(f"demo/talker/{role}_ca.pem")), 1)
            self.assertNotIn(self.root[role], self.text(f"demo/ca/{role}/ca.pem"))
        self.assertTrue(self.talks("demo/talker", "demo/listener"))
        self.refused("no_overlap", 1, "ca", "rotate", "demo", "--role", "identity", "--move", *NOW)
        self.both("--overlap", "30d")

    def test_steps_out_of_order_are_refused(self):
        for step in ("--move", "--end"):
            self.refused("no_overlap", 1, "ca", "rotate", "demo", "--role", "identity", step, *NOW)
        self.refused("usage", 2, "ca", "rotate", "demo", "--role", "identity", "--move", "--end", *NOW)
        self.refused("usage", 2, "ca", "rotate", "demo", "--role", "identity", "--when-due", *NOW)
        self.rotate("identity", "--overlap", "30d")
        self.refused("overlap_under_way", 1, "ca", "rotate", "demo", "--role", "identity", "--overlap", "1d", *NOW)
        record = self.at / "demo/ca/identity/ca.overlap.json"
        self.assertEqual(sorted(json.loads(record.read_text())), ["former", "until"])
        for text in ("nonsense", "[]", '{"until": "soon", "former": []}'):
            record.write_text(text)
            self.refused("overlap_unreadable", 1, "ca", "rotate", "demo", "--role", "identity", "--end", *NOW)

    def rotation(self, role):
        return self.json("ca", "show", "demo", "--role", role, *NOW)["result"]["rotation"]

    def folders(self, *names):
        return [str(self.at / "demo" / name) for name in names]

    def test_ca_show_in_an_overlap_tells_who_has_moved_and_the_next_step(self):
        for role in ROLES:
            self.assertIsNone(self.rotation(role))
            self.rotate(role, "--overlap", "30d")
            told = self.rotation(role)
            self.assertEqual((told["until"], told["folders"], len(told["former"])), ("2026-12-21T00:00:00Z", 2, 1))
            self.assertEqual(told["left"], self.folders("talker", "listener"))
            self.rotate(role, "demo/talker", "--move")
            self.assertEqual(self.rotation(role)["left"], self.folders("listener"))
            text = self.run_program("ca", "show", "demo", "--role", role, *NOW).stdout
            self.assertIn("until 2026-12-21; 1 of 2 folders has moved", text)
            self.assertIn(f"ddssec ca rotate demo --role {role} --move", text)
            again = ("ca", "rotate", "demo", "--role", role, "--overlap", "1d", *NOW)
            told = self.refused("overlap_under_way", 1, *again)
            self.assertIn("1 of 2 folders has moved", told["message"])
            self.assertIn("--move; when all have moved, --end", told["hint"])
            text = self.run_program("ca", "rotate", "demo", "--role", role, "--move", *NOW).stdout
            self.assertIn("Cyclone DDS: ddssec crl distribute --ca demo\n", text)
            self.assertTrue(self.refused("overlap_under_way", 1, *again)["hint"].endswith("--role ROLE --end"))
            text = self.run_program("ca", "show", "demo", "--role", role, *NOW).stdout
            self.assertIn("next   ddssec crl distribute --ca demo\n", text)
            self.assertIn(f"then   ddssec ca rotate demo --role {role} --end\n", text)
            self.rotate(role, "--end")
            self.assertIsNone(self.rotation(role))

    def only_warning(self, words, answer, file):
        self.assertEqual([(f"{d['severity']}[{d['id']}]", d["file"]) for d in answer["diagnostics"]], [(words, file)])

    def test_step_while_a_folder_is_away_says_no_and_show_names_it_until_the_next_end(self):
        for role in ROLES:
            self.rotate(role, "--overlap", "30d")
            (self.at / "demo/listener").rename(self.at / "away")
            for step in ("--move", "--end"):
                out = self.rotate(role, step, exit=1)
                self.assertEqual(out["elsewhere"], self.folders("listener"))
                self.assertEqual(self.rotation(role)["elsewhere"], self.folders("listener"))
            self.assertEqual(out["folders"], self.folders("talker"))
            shown = self.run_program("ca", "show", "demo", "--role", role, *NOW).stdout
            self.assertIn("rotation not finished: 1 folder still has", shown)
            self.assertIn(f"  not here  {self.folders('listener')[0]}\n", shown)
            (self.at / "away").rename(self.at / "demo/listener")
            self.assertEqual(self.rotation(role)["left"], self.folders("listener"))
            self.assertIsNone(self.rotation(role)["until"])
            key = self.text(f"demo/ca/{role}/ca.key.pem")
            self.assertEqual(self.rotate(role, "--end")["folders"], self.folders("listener"))
            self.assertEqual(self.text(f"demo/ca/{role}/ca.key.pem"), key)
            self.assertEqual(self.text(f"demo/listener/{role}_ca.pem"), self.text(f"demo/ca/{role}/ca.pem"))
            self.assertIsNone(self.rotation(role))
            self.refused("no_overlap", 1, "ca", "rotate", "demo", "--role", role, "--end", *NOW)
            self.assertEqual([path for path in self.files() if "unreached" in path], [])
        self.assertTrue(self.talks("demo/talker", "demo/listener"))

    def steps_shown(self, role, place):
        """The commands that `ca show` proposes, with the place of the folder that is not here."""
        shown = self.run_program("ca", "show", "demo", "--role", role, *NOW).stdout
        return [line.split()[2:] for line in shown.replace("PLACES --", f"{place} --").splitlines()
                if line.startswith(("  next ", "  then "))]

    def without_the_listener(self, role):
        self.rotate(role, "--overlap", "30d")
        (self.at / "demo/listener").rename(self.at / "away")

    def steps_end_an_overlap(self, role):
        self.without_the_listener(role)
        (step,) = self.steps_shown(role, "away")  # for the talker
        self.assertEqual(step[-1], "--move")
        self.run_program(*step, *NOW, exit=1)
        steps = self.steps_shown(role, "away")
        self.assertEqual([step[-1] for step in steps], ["--move", "demo", "--end"])
        self.assertEqual(steps[1], ["crl", "distribute", "--ca", "demo"])
        for step in steps:
            self.run_program(*step, *NOW)
        self.assertIsNone(self.rotation(role))

    def step_ends_what_an_end_has_left(self, role):
        self.without_the_listener(role)
        self.rotate(role, "--end", exit=1)
        (step,) = self.steps_shown(role, "away")
        self.run_program(*step, *NOW)
        self.assertIsNone(self.rotation(role))

    def test_steps_that_show_proposes_of_an_identity_ca_reach_a_folder_that_is_elsewhere(self):
        self.steps_end_an_overlap("identity")

    def test_steps_that_show_proposes_of_a_permissions_ca_reach_a_folder_that_is_elsewhere(self):
        self.steps_end_an_overlap("permissions")

    def test_step_that_show_proposes_after_the_end_of_an_identity_ca_reaches_a_folder_that_is_elsewhere(self):
        self.step_ends_what_an_end_has_left("identity")

    def test_step_that_show_proposes_after_the_end_of_a_permissions_ca_reaches_a_folder_that_is_elsewhere(self):
        self.step_ends_what_an_end_has_left("permissions")

    def test_folder_that_is_gone_of_a_revoked_participant_is_not_waited_for(self):
        self.rotate("identity", "--overlap", "30d")
        self.json("identity", "revoke", "demo/listener", "--ca", "demo", *NOW, exit=1)
        (self.at / "demo/listener").rename(self.at / "away")
        self.rotate("identity", "--end")
        self.assertIsNone(self.rotation("identity"))

    def test_certificate_outside_the_log_leaves_its_folder_and_every_step_says_so(self):
        """As a hook of the agent may put it into the folder: the CA issued it with another tool."""
        shutil.copytree(self.at / "demo", self.at / "copy")
        self.json("identity", "renew", "copy/listener", "--ca", "copy", *NOW)
        shutil.copy(self.at / "copy/listener/cert.pem", self.at / "demo/listener/cert.pem")
        shutil.rmtree(self.at / "copy")
        folder = self.folders("listener")
        self.assertEqual(self.rotate("identity", "--overlap", "30d")["folders"], self.folders("talker", "listener"))
        for step in ("--move", "--end"):
            answer = self.json("ca", "rotate", "demo", "--role", "identity", step, *NOW, exit=1)
            self.assertEqual((answer["result"]["folders"], answer["result"]["elsewhere"]), (self.folders("talker"), []))
            self.assertIn("certificate_unlogged", [one["id"] for one in answer["diagnostics"]])
            self.assertEqual(self.rotation("identity")["left"], folder)
        self.refused("issuer_unknown", 1, "ca", "rotate", "demo", "--role", "identity", "--end", *NOW)
        self.assertEqual(self.rotation("identity")["left"], folder)

    def test_end_of_one_folder_warns_of_the_others(self):
        for role in ROLES:
            self.rotate(role, "--overlap", "30d")
            answer = self.json("ca", "rotate", "demo", "demo/talker", "--role", role, "--end", *NOW)
            self.only_warning("warning[rotation_unfinished]", answer, *self.folders("listener"))
            self.rotate(role, "--end")
        self.assertTrue(self.talks("demo/talker", "demo/listener"))

    def test_overlap_of_one_folder_is_completed_by_the_next_overlap_and_move_warns(self):
        for role in ROLES:
            self.rotate(role, "demo/talker", "--overlap", "30d")
            answer = self.json("ca", "rotate", "demo", "demo/talker", "--role", role, "--move", *NOW)
            self.only_warning("warning[successor_unknown]", answer, *self.folders("listener"))
            key = self.text(f"demo/ca/{role}/ca.key.pem")
            out = self.rotate(role, "--overlap", "1d")
            self.assertEqual((out["folders"], out["until"]), (self.folders("listener"), "2026-12-21T00:00:00Z"))
            self.assertEqual(self.text(f"demo/ca/{role}/ca.key.pem"), key)
            self.assertEqual(len(self.certificates(f"demo/listener/{role}_ca.pem")), 2)
            self.assertTrue(self.talks("demo/talker", "demo/listener"))
            self.assertEqual(self.json("ca", "rotate", "demo", "--role", role, "--move", *NOW)["diagnostics"], [])
            self.rotate(role, "--end")

    def test_move_and_end_of_a_folder_without_key_or_permissions_warn_that_its_participant_does_not_take_them(self):
        missing = {"identity": "key.pem", "permissions": "permissions.p7s"}
        for role, name in missing.items():
            self.rotate(role, "--overlap", "30d")
            (self.at / "demo/listener" / name).rename(self.at / name)
            for step in ("--move", "--end"):
                answer = self.json("ca", "rotate", "demo", "--role", role, step, *NOW)
                self.only_warning("warning[renewal_not_taken]", answer, *self.folders(f"listener/{name}"))
            (self.at / name).rename(self.at / "demo/listener" / name)

    def test_doctor_of_a_folder_that_the_end_did_not_reach_tells_of_the_former_ca(self):
        for role in ROLES:
            self.rotate(role, "--overlap", "30d")
            (self.at / "demo/listener").rename(self.at / "away")
            self.rotate(role, "--end", exit=1)
            (self.at / "away").rename(self.at / "demo/listener")
        for words in (("doctor", "demo/listener"),):
            told = [d for d in self.json(*words, *NOW, exit=None)["diagnostics"] if d["id"] == "DOC111"]
            self.assertEqual([d["severity"] for d in told], ["note", "note"], words)
            for role, one in zip(ROLES, told):
                self.assertIn(f"ddssec ca rotate CA --role {role} --end", one["hint"])

    def test_revoked_participant_is_not_left_after_the_end(self):
        self.rotate("identity", "--overlap", "30d")
        self.json("identity", "revoke", "demo/talker", "--ca", "demo", *NOW, exit=1)
        self.assertEqual(self.rotation("identity")["folders"], 1)
        text = self.run_program("ca", "show", "demo", "--role", "identity", *NOW).stdout
        self.assertIn("; 0 of 1 folder have moved, 1 revoked\n", text)
        self.rotate("identity", "--end")
        self.assertIsNone(self.rotation("identity"))
        self.refused("no_overlap", 1, "ca", "rotate", "demo", "--role", "identity", "--end", *NOW)

    def test_a_participant_that_has_not_moved_is_not_renewed(self):
        self.both("--overlap", "30d")
        self.refused("not_moved_yet", 1, "identity", "renew", "demo/talker", "--ca", "demo", "--permissions", *NOW)
        self.both("--move")
        self.run_program("identity", "renew", "demo/talker", "--ca", "demo", "--permissions", *NOW)
        self.assertTrue(self.talks("demo/talker", "demo/listener"))

    def test_a_revocation_during_the_overlap_ends_with_it(self):
        self.run_program("identity", "issue", "radar", "--ca", "demo", "-o", "demo/radar", "--publish", "x",
                         "--governance", "demo/governance.p7s", *NOW)
        self.both("--overlap", "30d")
        out = self.json("identity", "revoke", "demo/talker", "--ca", "demo", *NOW, exit=1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["revoked_after_overlap"])
        self.json("crl", "distribute", "--ca", "demo", *NOW)
        answer = self.json("doctor", "demo/talker", "--vendor", "cyclonedds", *NOW)
        (told,) = [one for one in answer["diagnostics"] if one["id"] == "DOC024"]
        self.assertEqual(told["severity"], "warning")
        self.assertIn("accept it while the former CA is in their files", told["message"])
        self.assertTrue(self.talks("demo/talker", "demo/listener"), "as it is (interop_rtps.overlap)")
        told = self.run_program("identity", "revoke", "demo/listener", "--ca", "demo", *NOW, exit=1).stderr
        self.assertIn("warning[revoked_after_overlap]", told)
        out = self.rotate("identity", "--end")
        self.assertEqual(out["revoked"], [str(self.at / "demo" / name) for name in ("talker", "listener")])
        for name in ("talker", "listener"):
            self.assertFalse(self.talks(f"demo/{name}", "demo/radar"))

    def begin(self, folder):
        return self.json("identity", "show", folder, "--now", "2026-11-26T00:00:00Z")["result"]["not_before"]

    def test_move_of_a_certificate_that_began_less_than_a_day_ago_does_not_begin_before_it(self):
        """A running participant takes no certificate that begins before the one in force."""
        before = self.begin("demo/talker")
        for step in (("--overlap", "30d"), ("--move",)):
            self.rotate("identity", *step, at=("--now", "2026-11-20T12:00:00Z"))
        self.assertEqual(self.begin("demo/talker"), before)

    def test_move_of_an_older_certificate_begins_a_day_ago(self):
        for step in (("--overlap", "30d"), ("--move",)):
            self.rotate("identity", *step, at=("--now", "2026-11-26T00:00:00Z"))
        self.assertEqual(self.begin("demo/talker"), "2026-11-25T00:00:00Z")

    def test_dry_run_writes_nothing(self):
        before = {path: self.text(path) for path in self.files()}
        self.rotate("identity", "--overlap", "30d", "--dry-run")
        self.assertEqual({path: self.text(path) for path in self.files()}, before)


if __name__ == "__main__":
    main()

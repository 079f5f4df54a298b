#!/usr/bin/env python3
"""identity revoke and crl: from one command to a peer that is refused."""

import json
import pathlib
import subprocess

from transcript import NOW, PROGRAM, Transcript, main

DATA = pathlib.Path(__file__).resolve().parent.parent / "data"
LATER = ("--now", "2026-11-22T00:00:00Z")


class Revocation(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        for name in ("talker", "listener"):
            self.issue(name)

    def issue(self, name):
        return self.json("identity", "issue", name, "--ca", "ca", "-o", name, *NOW)["result"]

    def log(self):
        return [json.loads(line) for line in (self.at / "ca/identity/issued.jsonl").read_text().splitlines()]

    def crl_text(self, path="ca/identity/crl.pem"):
        return self.openssl("crl", "-in", path, "-noout", "-text")

    def test_what_is_issued_is_in_the_log_before_anybody_has_it(self):
        self.assertEqual([(e["event"], e["subject"], e["not_after"]) for e in self.log()],
                         [("issued", "CN=talker", "2027-11-21T00:00:00Z"),
                          ("issued", "CN=listener", "2027-11-21T00:00:00Z")])
        self.assertEqual(self.log()[0]["folder"], str(self.at / "talker"))
        shown = self.json("ca", "show", "ca", *NOW)["result"]
        self.assertEqual((shown["issued"], shown["revoked"]), (2, 0))

    def test_the_first_list_is_made_with_the_ca_and_names_nothing(self):
        self.openssl("crl", "-in", "ca/identity/crl.pem", "-noout", "-CAfile", "ca/identity/ca.pem")
        self.assertIn("No Revoked Certificates", self.crl_text())
        shown = self.json("ca", "show", "ca", *NOW)["result"]
        self.assertEqual(shown["crl"], {"number": 1, "next_update": shown["not_after"]})
        self.assertNotIn("ca/permissions/crl.pem", self.files())
        for name in ("talker", "listener"):
            self.json("crl", "verify", name, "--ca", "ca", *NOW)
        out = self.json("crl", "distribute", "--ca", "ca", *NOW)["result"]  # without crl new before
        self.assertEqual((out["number"], len(out["folders"])), (1, 2))
        self.run_program("ca", "create", "below", "--role", "identity", "--intermediate-of", "ca",
                         "--no-passphrase", "--clamp", *NOW)
        self.json("crl", "verify", "below", "--ca", "below", *NOW)

    def test_revoke_says_which_participants_notice_it_when(self):
        self.issue("third")
        (self.at / "third/crl.pem").unlink()
        self.issue("away")
        (self.at / "away").rename(self.at / "robot")
        out = self.json("identity", "revoke", "talker", "--ca", "ca", "--dry-run", *LATER)["result"]
        self.assertEqual((out["without_list"], out["elsewhere"]), ([f"{self.at}/third"], [f"{self.at}/away"]))
        told = self.run_program("identity", "revoke", "talker", "--ca", "ca", *LATER).stdout
        self.assertRegex(told, r"ddssec's plugins .*within 2 s")
        self.assertRegex(told, r"stock plugins .*only when it starts again")
        self.assertIn(f"no list so far, so that nothing is revoked there:\n    {self.at}/third\n", told)
        self.assertIn(f"copy ca/identity/crl.pem there as crl.pem:\n    {self.at}/away\n", told)
        self.run_program("crl", "distribute", "--ca", "ca", *LATER)
        told = self.run_program("identity", "revoke", "listener", "--ca", "ca", *LATER).stdout
        self.assertNotIn("no list so far", told)

    # Measured: no product reads the list in the CA's folder (interop: a stock pair goes on talking).
    def test_before_the_list_is_distributed_peers_accept_a_revoked_participant(self):
        for vendor in ("cyclonedds", "fastdds", "ddssec"):
            self.assertTrue(self.meet(vendor, 0)["result"]["talk"])
        self.run_program("identity", "revoke", "demo/x", "--ca", "demo", *NOW)
        for vendor in ("cyclonedds", "fastdds", "ddssec"):
            answer = self.meet(vendor, 0)
            (told,) = [one for one in answer["diagnostics"] if one["id"] == "DOC024"]
            self.assertEqual(told["severity"], "warning")
            self.assertRegex(told["message"], "^x: cert.pem of CN=x .* is revoked by list 2 of the CA, .*; crl.pem here is "
                             "list 1; participants that do not have that list yet accept it$")
            self.assertIn("ddssec crl distribute", told["hint"])
            verdicts = self.json("doctor", "demo/x", "--vendor", vendor, *NOW, exit=1)["result"]["verdicts"]
            self.assertEqual(list(verdicts.values()), ["unsafe"])
        told = self.json("can", "demo/x", "publish", "Square", *NOW, exit=1)
        self.assertIn("which crl.pem here lacks: participants without that list still accept it", told["result"]["because"])
        self.assertIn("ddssec crl distribute", told["diagnostics"][0]["hint"])
        out = self.json("crl", "distribute", "--ca", "demo", *NOW)["result"]
        self.assertEqual(out["of_revoked"], [str(self.at / "demo/x")])
        self.assertNotIn(str(self.at / "demo/x"), out["folders"])
        for vendor in ("cyclonedds", "fastdds", "ddssec"):
            self.assertFalse(self.meet(vendor, 1)["result"]["talk"])

    def test_distribute_with_a_revoked_participant_says_why_its_folder_is_left_out_and_doctor_advises_no_circle(self):
        self.meet("ddssec", 0)
        self.run_program("identity", "revoke", "demo/x", "--ca", "demo", *NOW)
        told = self.run_program("crl", "distribute", "--ca", "demo", *NOW).stdout
        self.assertRegex(told, f"left out: the certificate is revoked, so that other participants refuse .*:\n    {self.at}/demo/x\n")
        (told,) = [d for d in self.json("doctor", "demo/x", *NOW, exit=1)["diagnostics"] if d["id"] == "DOC024"]
        self.assertRegex(told["hint"], "cannot be undone.*identity issue --replace.*crl distribute.*leaves out this folder$")
        out = self.json("crl", "distribute", "demo/x", "--ca", "demo", *NOW)["result"]  # as the text says
        self.assertEqual((out["folders"], out["of_revoked"]), (["demo/x"], []))
        (told,) = [d for d in self.json("doctor", "demo/x", *NOW, exit=1)["diagnostics"] if d["id"] == "DOC024"]
        self.assertIn("was revoked", told["message"])
        self.run_program("identity", "issue", "x", "--ca", "demo", "-o", "demo/x", "--publish", "Square", "--replace", *NOW)
        out = self.json("crl", "distribute", "--ca", "demo", *NOW)["result"]
        self.assertEqual(out["of_revoked"], [])
        self.assertIn(str(self.at / "demo/x"), out["folders"])

    def meet(self, vendor, exit):
        if not (self.at / "demo").exists():
            self.run_program("init", "demo", *NOW)
            for name in ("x", "y"):
                self.run_program("identity", "issue", name, "--ca", "demo", "-o", f"demo/{name}", "--publish", "Square",
                                 "--subscribe", "Square", "--governance", "demo/governance.p7s", *NOW)
        return self.json("check", "demo/x", "demo/y", "--topics", "Square", "--vendor", vendor, *NOW, exit=exit)

    def test_revoke_makes_a_list_that_openssl_believes(self):
        out = self.json("identity", "revoke", "talker", "--ca", "ca", "--reason", "keyCompromise",
                        *LATER)
        serial = self.log()[0]["serial"]
        self.assertEqual(out["result"]["serials"], [serial])
        self.assertEqual(out["result"]["crl"]["number"], 2)
        self.assertEqual(out["result"]["folders"], [str(self.at / "listener")])
        self.assertEqual([f["path"] for f in out["files_written"]], ["ca/identity/crl.pem"])
        text = self.crl_text()
        self.assertIn(f"Serial Number: {serial}", text)
        self.assertIn("Key Compromise", text)
        self.openssl("crl", "-in", "ca/identity/crl.pem", "-noout", "-CAfile", "ca/identity/ca.pem")
        self.assertEqual(self.log()[-1], {"event": "revoked", "time": "2026-11-22T00:00:00Z",
                                          "serial": serial, "reason": "keyCompromise"})
        shown = self.json("ca", "show", "ca/identity", *LATER)["result"]
        self.assertEqual(shown["crl"], {"number": 2, "next_update": "2027-05-21T00:00:00Z"})
        self.assertEqual((shown["issued"], shown["revoked"]), (2, 1))

    def test_revoking_again_is_no_failure_and_no_new_list(self):
        self.run_program("identity", "revoke", "talker", "--ca", "ca", *LATER)
        out = self.json("identity", "revoke", "talker", "--ca", "ca", *LATER)
        self.assertEqual((out["result"]["serials"], out["files_written"]), ([], []))

    def test_earlier_certificates_of_the_same_key_go_as_well(self):
        self.run_program("identity", "renew", "talker", "--ca", "ca", *LATER)
        serials = [e["serial"] for e in self.log() if e["subject"] == "CN=talker"]
        self.assertEqual(len(serials), 2)
        out = self.json("identity", "revoke", "talker", "--ca", "ca", *LATER)["result"]
        self.assertEqual(sorted(out["serials"]), sorted(serials))
        self.assertEqual(self.crl_text().count("Serial Number:"), 2)

    def test_a_clock_that_is_ahead_leaves_no_certificate_out(self):
        self.run_program("identity", "issue", "talker", "--ca", "ca", "-o", "talker", "--replace", *LATER)
        self.run_program("identity", "renew", "talker", "--ca", "ca", "--days", "3000", "--clamp", *LATER)
        serials = [e["serial"] for e in self.log() if e["subject"] == "CN=talker"]
        out = self.json("identity", "revoke", "talker", "--ca", "ca", "--clock-is-right", "--now",
                        "2029-01-01T00:00:00Z")["result"]
        self.assertEqual((len(serials), sorted(out["serials"])), (3, sorted(serials)))

    def test_one_serial_number_in_either_case(self):
        serial = self.log()[1]["serial"]
        out = self.json("identity", "revoke", serial.lower(), "--ca", "ca", *LATER)["result"]
        self.assertEqual((out["subject"], out["serials"]), ("CN=listener", [serial]))
        self.refused("serial_unknown", 1, "identity", "revoke", "0A", "--ca", "ca", *LATER)

    def test_lists_follow_one_another_and_lose_nothing(self):
        self.run_program("identity", "revoke", "talker", "--ca", "ca", *NOW)
        log = self.at / "ca/identity/issued.jsonl"
        log.write_text("\n".join(log.read_text().splitlines()[:-1]) + "\n")  # only the list knows
        self.run_program("identity", "revoke", "listener", "--ca", "ca", *LATER)
        out = self.json("crl", "new", "--ca", "ca", "--next-update", "7", *LATER)["result"]
        self.assertEqual((out["number"], out["revoked"], out["next_update"]),
                         (4, 2, "2026-11-29T00:00:00Z"))
        shown = self.json("crl", "show", "ca")["result"]
        self.assertEqual([e["time"] for e in sorted(shown["revoked"], key=lambda e: e["time"])],
                         ["2026-11-21T00:00:00Z", "2026-11-22T00:00:00Z"])

    def test_revoked_by_several_at_once_all_are_on_the_list(self):
        names = [f"robot{i}" for i in range(12)]
        for name in names:
            self.issue(name)
        running = [subprocess.Popen([PROGRAM, "identity", "revoke", name, "--ca", "ca", *NOW], cwd=self.at,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) for name in names]
        self.assertEqual([(p.communicate()[1], p.returncode) for p in running], [(b"", 0)] * len(names))
        shown = self.json("crl", "show", "ca")["result"]
        self.assertEqual((len(shown["revoked"]), shown["number"]), (len(names), len(names) + 1))

    def test_a_list_that_lacks_what_the_log_says_is_made_anew_and_not_given_to_anybody(self):
        before = (self.at / "ca/identity/crl.pem").read_bytes()
        self.run_program("identity", "revoke", "talker", "--ca", "ca", *NOW)
        (self.at / "ca/identity/crl.pem").write_bytes(before)  # the machine stopped between the two
        self.refused("crl_incomplete", 1, "crl", "distribute", "--ca", "ca", *NOW)
        done = self.run_program("identity", "revoke", "talker", "--ca", "ca", *LATER)
        self.assertIn("CN=talker  revoked already, but the list did not say so; revocation list 2", done.stdout)
        self.assertEqual([e["event"] for e in self.log()], ["issued", "issued", "revoked"])
        self.assertEqual(self.json("crl", "distribute", "--ca", "ca", *LATER)["result"]["number"], 2)
        self.assertIn(f"Serial Number: {self.log()[0]['serial']}", self.crl_text("listener/crl.pem"))

    def test_who_joins_later_knows_who_was_revoked(self):
        self.run_program("crl", "new", "--ca", "ca", *NOW)
        self.issue("third")
        self.json("crl", "verify", "third", "--ca", "ca", *NOW)
        self.run_program("identity", "revoke", "talker", "--ca", "ca", *NOW)
        self.issue("fourth")
        (self.at / "fleet.toml").write_text('[[participant]]\nname = "fifth"\n')
        self.run_program("identity", "issue", "--from", "fleet.toml", "--ca", "ca", "-o", "fleet", *NOW)
        for folder in ("fourth", "fleet/fifth"):
            self.assertEqual(self.files()[folder + "/crl.pem"], 0o644)
            self.json("crl", "verify", folder, "--ca", "ca", *NOW)
        after = ("--now", "2027-06-01T00:00:00Z")  # an expired list would exclude all participants
        self.run_program("identity", "issue", "sixth", "--ca", "ca", "-o", "sixth", *after)
        self.assertNotIn("sixth/crl.pem", self.files())

    def test_a_log_cut_short_by_a_crash_is_taken_up_again(self):
        log = self.at / "ca/identity/issued.jsonl"
        whole = log.read_text()
        log.write_text(whole + '{"event":"issued","time":"2026-')
        self.assertEqual(self.json("ca", "show", "ca", *NOW)["result"]["issued"], 2)
        self.issue("third")
        self.assertTrue(log.read_text().startswith(whole))
        self.assertEqual(len(self.log()), 3)

    def test_log_without_its_last_line_end_forgets_no_revocation(self):
        self.run_program("identity", "revoke", "talker", "--ca", "ca", *NOW)
        log = self.at / "ca/identity/issued.jsonl"
        whole = log.read_text()
        log.write_text(whole.removesuffix("\n"))
        self.assertEqual(self.json("ca", "show", "ca", *NOW)["result"]["revoked"], 1)
        self.issue("third")
        self.assertTrue(log.read_text().startswith(whole))
        self.assertEqual(len(self.log()), len(whole.splitlines()) + 1)

    def test_log_whose_last_line_is_cut_short_says_so(self):
        log = self.at / "ca/identity/issued.jsonl"
        whole = log.read_text()
        log.write_text(whole + '{"event":"revoked","time":"2026-')
        told = self.json("ca", "show", "ca", *NOW)["diagnostics"]
        self.assertEqual([(d["id"], d["line"]) for d in told], [("log_line_unreadable", len(whole.splitlines()) + 1)])

    def test_a_damaged_line_of_the_log_stops_no_revocation_and_is_told_once(self):
        log = self.at / "ca/identity/issued.jsonl"
        first, second = log.read_text().splitlines()
        far_too_long = first.replace("CN=", "CN=" + "\\\\A0" * 20_000)
        log.write_text("\n".join(["nonsense", first, far_too_long, second]) + "\n")
        for words in (("identity", "revoke", "talker"), ("crl", "new"), ("crl", "distribute"),
                      ("identity", "renew", "listener")):
            out = self.json(*words, "--ca", "ca", *NOW)
            self.assertEqual([(d["id"], d["file"], d["line"]) for d in out["diagnostics"]],
                             [("log_line_unreadable", "ca/identity/issued.jsonl", 1)])
            self.assertIn("lines 1, 3", out["diagnostics"][0]["message"])
        done = self.run_program("crl", "new", "--ca", "ca", *NOW)
        self.assertEqual(done.stderr.count("warning[log_line_unreadable]"), 1)
        self.assertEqual(self.json("crl", "show", "ca")["result"]["revoked"][0]["serial"], json.loads(first)["serial"])

    def test_what_a_damaged_line_was_about_is_not_trusted(self):
        log = self.at / "ca/identity/issued.jsonl"
        first, second = log.read_text().splitlines()
        log.write_text(first[:-5] + "\n" + second + "\n")
        out = self.json("identity", "renew", "talker", "--ca", "ca", *NOW, exit=1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["certificate_unlogged", "log_line_unreadable"])

    def test_distribute_reaches_every_folder_that_the_log_knows(self):
        self.run_program("identity", "revoke", "talker", "--ca", "ca", *NOW)
        out = self.json("crl", "distribute", "--ca", "ca", *NOW)
        self.assertEqual(out["result"]["folders"], [str(self.at / "listener")])
        self.json("crl", "verify", "listener", "--ca", "ca", *NOW)
        self.json("crl", "verify", "listener/crl.pem", "--ca", "ca/identity/ca.pem", *NOW)
        out = self.json("crl", "distribute", "talker", "--ca", "ca", *NOW)
        self.assertEqual([f["path"] for f in out["files_written"]], ["talker/crl.pem"])
        self.openssl("crl", "-in", "talker/crl.pem", "-noout", "-CAfile", "talker/identity_ca.pem")

    def test_distribute_says_whom_it_cannot_reach(self):
        self.run_program("crl", "new", "--ca", "ca", *NOW)
        (self.at / "talker").rename(self.at / "robot")
        done = self.run_program("crl", "distribute", "--ca", "ca", *NOW)
        self.assertIn("is in 1 folder, holds until 2027-05-20\n", done.stdout)
        self.assertIn("not on this machine, copy ca/identity/crl.pem there as crl.pem:\n"
                      f"    {self.at}/talker\n", done.stdout)
        (self.at / "listener").rename(self.at / "other")
        out = self.json("crl", "distribute", "--ca", "ca", *NOW, exit=1)
        self.assertEqual(out["result"]["elsewhere"], [f"{self.at}/{name}" for name in ("talker", "listener")])
        self.json("crl", "distribute", "robot", "other", "--ca", "ca", *NOW)
        (self.at / "ca/identity/issued.jsonl").unlink()
        told = self.refused("usage", 2, "crl", "distribute", "--ca", "ca", *NOW)
        self.assertIn("name them", told["message"])

    def test_distribute_says_that_copies_are_not_reached(self):
        done = self.run_program("crl", "distribute", "--ca", "ca", *NOW)
        self.assertIn("  copies of these folders on other machines are not reached: copy ca/identity/crl.pem there as "
                      "crl.pem\n", done.stdout)

    def test_distribute_names_a_folder_that_a_rotation_left_behind(self):
        (self.at / "talker/identity_ca.pem").rename(self.at / "kept")
        (self.at / "talker/identity_ca.pem").mkdir()
        self.json("ca", "rotate", "ca", "--role", "identity", *NOW, exit=4)
        (self.at / "talker/identity_ca.pem").rmdir()
        (self.at / "kept").rename(self.at / "talker/identity_ca.pem")
        out = self.json("crl", "distribute", "--ca", "ca", *NOW)
        places = {name: out["result"][name] for name in ("folders", "elsewhere", "left_behind", "of_other_cas")}
        self.assertEqual(places, {"folders": [f"{self.at}/listener"], "elsewhere": [],
                                  "left_behind": [f"{self.at}/talker"], "of_other_cas": []})
        told = self.run_program("crl", "distribute", "--ca", "ca", *NOW).stdout
        self.assertRegex(told, f"the CA as it was before a rotation, .*rotate the CA once more:\n    {self.at}/talker\n")
        self.assertNotIn("not on this machine", told)
        self.json("ca", "rotate", "ca", "--role", "identity", *NOW)
        self.assertEqual(self.json("crl", "distribute", "--ca", "ca", *NOW)["result"]["left_behind"], [])

    def test_distribute_names_a_folder_with_another_cas_certificate(self):
        self.run_program("ca", "create", "other", "--no-passphrase", *NOW)
        self.run_program("identity", "issue", "talker", "--ca", "other", "-o", "talker2", *NOW)
        (self.at / "talker2/cert.pem").replace(self.at / "talker/cert.pem")
        out = self.json("crl", "distribute", "--ca", "ca", *NOW)["result"]
        self.assertEqual((out["elsewhere"], out["of_other_cas"]), ([], [f"{self.at}/talker"]))
        self.assertIn("the certificate in the folder is of another CA:\n",
                      self.run_program("crl", "distribute", "--ca", "ca", *NOW).stdout)

    def test_one_is_not_written_as_many(self):
        done = self.run_program("identity", "revoke", "talker", "--ca", "ca", *LATER)
        self.assertIn("revoked (1 certificate);", done.stdout)
        self.assertIn("(puts the list into 1 folder)", done.stdout)
        self.assertIn("issued   2 certificates, 1 revoked", self.run_program("ca", "show", "ca").stdout)

    def test_distribute_after_the_only_participant_was_revoked_has_nothing_to_do(self):
        for ca in ("ks", "alone"):
            make = ("keystore", "create", ca) if ca == "ks" else ("ca", "create", ca)
            self.run_program(*make, "--no-passphrase", *NOW)
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.run_program("identity", "issue", "one", "--ca", "alone", "-o", "one", *NOW)
        for ca, folder in (("ks", "ks/enclaves/a"), ("alone", "one")):
            done = self.run_program("identity", "revoke", folder, "--ca", ca, *NOW)
            self.assertIn("no other participant in the CA's log needs the list", done.stdout)
            self.assertNotIn("next:", done.stdout)
            self.assertEqual(self.json("crl", "distribute", "--ca", ca, *NOW)["result"]["folders"], [])
            self.assertIn("every participant in the CA's log is revoked",
                          self.run_program("crl", "distribute", "--ca", ca, *NOW).stdout)
        self.run_program("ca", "create", "new", "--no-passphrase", *NOW)
        self.assertIn("knows no folder", self.refused("usage", 2, "crl", "distribute", "--ca", "new", *NOW)["message"])

    def test_distribute_writes_through_no_link(self):
        self.run_program("crl", "new", "--ca", "ca", *NOW)
        (self.at / "mine").write_text("mine")
        (self.at / "talker/crl.pem").unlink()
        (self.at / "talker/crl.pem").symlink_to("../mine")
        out = self.json("crl", "distribute", "talker", "listener", "--ca", "ca", *NOW, exit=4)
        self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"]], [("would_overwrite", "talker/crl.pem")])
        self.assertEqual(out["result"]["folders"], ["listener"])  # which the other does not keep from it
        self.assertEqual([f["path"] for f in out["files_written"]], ["listener/crl.pem"])
        self.json("crl", "verify", "listener", "--ca", "ca", *NOW)
        done = self.run_program("crl", "distribute", "talker", "listener", "--ca", "ca", *NOW, exit=4)
        self.assertIn("is in 1 folder, holds until", done.stdout)
        self.assertEqual((self.at / "mine").read_text(), "mine")
        self.refused("file_not_found", 3, "crl", "distribute", "nobody", "--ca", "ca", *NOW)

    def test_distribute_reaches_whom_it_can_and_names_the_others(self):
        self.run_program("crl", "new", "--ca", "ca", *NOW)
        for folder, mode in ((".", 0o755), ("ca", 0o755), ("listener", 0o777), ("talker", 0)):
            (self.at / folder).chmod(mode)
        self.addCleanup((self.at / "talker").chmod, 0o700)
        out = self.json_as_nobody("crl", "distribute", "--ca", "ca", *NOW, exit=5)
        self.assertEqual([(d["id"], d["file"]) for d in out["diagnostics"]],
                         [("file_unwritable", str(self.at / "talker/crl.pem"))])
        self.assertIn("Permission denied", out["diagnostics"][0]["message"])
        self.assertEqual((out["result"]["folders"], out["result"]["elsewhere"]), ([str(self.at / "listener")], []))
        self.json("crl", "verify", "listener", "--ca", "ca", *NOW)

    def test_verify_refuses_old_early_foreign_and_broken_lists(self):
        (self.at / "ca/identity/crl.pem").unlink()
        self.refused("file_not_found", 3, "crl", "verify", "ca", "--ca", "ca", *NOW)
        self.run_program("crl", "new", "--ca", "ca", "--next-update", "7", *NOW)
        verify = ("crl", "verify", "ca", "--ca", "ca")
        self.refused("crl_expired", 1, *verify, "--now", "2026-11-28T00:00:00Z")
        self.refused("crl_not_yet_valid", 1, *verify, "--now", "2026-11-20T00:00:00Z")
        self.refused("crl_signature_invalid", 1, "crl", "verify", "ca", "--ca", "ca/permissions/ca.pem",
                     *NOW)
        self.refused("crl_expired", 1, "crl", "distribute", "--ca", "ca", "--now", "2026-11-28T00:00:00Z")
        (self.at / "ca/identity/crl.pem").write_text("no list")
        self.refused("crl_malformed", 3, *verify, *NOW)

    def test_partitioned_lists_are_no_lists_for_participants(self):
        # ddssec's plugins start with none of these, stock Cyclone DDS with the first (measured).
        (self.at / "index.txt").touch()
        for part in ("onlyuser=TRUE", "onlyCA=TRUE", "indirectCRL=TRUE", "onlysomereasons=keyCompromise",
                     "fullname=URI:http://x/y.crl"):
            for critical in ("critical,", ""):
                (self.at / "ca.cnf").write_text(
                    f"[ca]\ndefault_ca=c\n[c]\ndatabase={self.at}/index.txt\ndefault_md=sha256\ndefault_crl_days=30\n"
                    f"crl_extensions=e\n[e]\nissuingDistributionPoint={critical}@p\n[p]\n{part}\n")
                self.openssl("ca", "-gencrl", "-config", "ca.cnf", "-cert", "ca/identity/ca.pem", "-keyfile",
                             "ca/identity/ca.key.pem", "-out", "listener/crl.pem")
                soon = ("--now", "+1d")
                told = self.refused("crl_missing", 1, "crl", "verify", "listener", "--ca", "ca", *soon)
                self.assertIn("found a list of a part of them (issuingDistributionPoint)", told["message"])
                self.assertIn("complete list", told["hint"])
                told = [d["message"] for d in self.json("doctor", "listener", *soon, exit=1)["diagnostics"]
                        if d["id"] == "DOC023"]
                self.assertIn("about a part of the CA's certificates (issuingDistributionPoint)", told[0])

    def test_delta_lists_are_refused(self):
        delta = DATA / "nist-pkits/crls/deltaCRLCA1deltaCRL.crl"
        self.run_program("crl", "new", "--ca", "ca", *NOW)
        complete = (self.at / "ca/identity/crl.pem").read_text()
        pem = self.openssl("crl", "-inform", "DER", "-in", delta)
        before = (self.at / "talker/crl.pem").read_bytes()
        (self.at / "ca/identity/crl.pem").write_text(complete + pem)
        for command in (("show", "ca"), ("verify", "ca", "--ca", "ca", *NOW),
                        ("distribute", "talker", "--ca", "ca", *NOW)):
            told = self.refused("crl_is_delta", 3, "crl", *command)
            self.assertEqual(told["file"], "ca/identity/crl.pem")
            self.assertIn("expected a complete list of CN=deltaCRL CA1", told["message"])
        self.assertEqual((self.at / "talker/crl.pem").read_bytes(), before)

    def test_only_what_this_ca_issued_is_revoked_or_renewed(self):
        self.run_program("ca", "create", "other", "--no-passphrase", "--role", "identity",
                         "--subject", "CN=ca Identity CA", *NOW)
        for command in ("revoke", "renew"):
            self.refused("issuer_unknown", 1, "identity", command, "talker", "--ca", "other", *NOW)
        self.refused("usage", 2, "identity", "revoke", "talker", "--ca", "ca", "--reason", "bored")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Revocation lists that are dated in the future: how a command keeps from making one, and the way out if there is one."""

import os
import shutil

from transcript import NOW, Transcript, main

LATER = ("--now", "2026-11-22T00:00:00Z")
YEAR_LATER = ("--now", "2027-11-22T00:00:00Z")
FUTURE = ("--now", "2030-01-01T00:00:00Z")
BEFORE_CA = ("--now", "2020-01-01T00:00:00Z")
DAY = 1795219200  # 2026-11-21
SURE = ("--clock-is-right",)


class Future(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *(w for n in ("talker", "listener", "third") for w in ("--participant", n)), *NOW)
        self.set_times()

    def set_times(self, time=DAY):
        """Every file was written then, whatever the clock of this machine says."""
        for folder, _, names in os.walk(self.at):
            for name in names:
                os.utime(os.path.join(folder, name), (time, time))

    def shown(self, where="demo"):
        return self.json("crl", "show", where)["result"]

    def log(self):
        return (self.at / "demo/ca/identity/issued.jsonl").read_text()

    def serial(self, name):
        return self.json("identity", "show", name, *NOW)["result"]["serial"]

    def revoke(self, name, *more, ca="demo"):
        return ("identity", "revoke", f"demo/{name}", "--ca", ca, *more)

    def in_the_future(self):
        """As it was before commands looked: the list is in every folder."""
        self.run_program(*self.revoke("talker"), *SURE, *FUTURE)
        self.run_program("crl", "distribute", "--ca", "demo", *SURE, *FUTURE)


class Refused(Future):
    def test_a_date_far_ahead_of_all_that_the_ca_knows(self):
        before = self.files(), self.log()
        for command in (self.revoke("talker"), ("crl", "new", "--ca", "demo")):
            told = self.refused("crl_not_yet_valid", 1, *command, *FUTURE)
            self.assertIn("400 days after 2026-11-21T00:00:00Z", told["message"])
            self.assertIn("--clock-is-right", told["hint"])
        self.assertEqual((self.files(), self.log()), before)
        self.run_program(*self.revoke("talker"), *LATER)
        self.assertEqual(self.shown()["this_update"], "2026-11-22T00:00:00Z")

    def test_a_ca_is_not_rotated_into_the_future(self):
        for role in ("identity", "permissions"):
            told = self.refused("crl_not_yet_valid", 1, "ca", "rotate", "demo", "--role", role, *FUTURE)
            self.assertIn("--clock-is-right", told["hint"])
            self.run_program("ca", "rotate", "demo", "--role", role, *LATER)
            self.set_times()
        self.run_program("ca", "rotate", "demo", "--role", "permissions", "--clock-is-right", "--dry-run", *YEAR_LATER)
        self.run_program("keystore", "create", "ks", "--no-passphrase", *NOW)
        self.run_program("keystore", "enclave", "ks", "/a", "--allow-all", *NOW)
        self.set_times()
        for role in ("identity", "permissions"):
            self.refused("crl_not_yet_valid", 1, "keystore", "rotate", "ks", "--role", role, *FUTURE)
            self.run_program("keystore", "rotate", "ks", "--role", role, *LATER)
            self.set_times()

    def test_a_list_of_the_future_is_not_distributed(self):
        self.run_program(*self.revoke("talker"), *SURE, *FUTURE)
        self.set_times()
        before = (self.at / "demo/listener/crl.pem").read_bytes()
        told = self.refused("crl_not_yet_valid", 1, "crl", "distribute", "--ca", "demo", *FUTURE)
        self.assertIn("--clock-is-right", told["hint"])
        self.assertEqual((self.at / "demo/listener/crl.pem").read_bytes(), before)

    def test_a_ca_that_rested_for_a_year_is_not_asked(self):
        self.run_program(*self.revoke("talker"), *YEAR_LATER)
        self.run_program("crl", "distribute", "--ca", "demo", *YEAR_LATER)
        self.assertEqual(self.shown("demo/listener")["number"], 2)

    def test_nor_an_imported_one_without_a_log(self):
        shutil.rmtree(self.at / "demo/ca/permissions")
        (self.at / "demo/ca/identity/issued.jsonl").unlink()
        self.set_times(DAY + 4 * 365 * 86400)
        self.run_program("crl", "new", "--ca", "demo", *FUTURE)


class WayOut(Future):
    def setUp(self):
        super().setUp()
        self.in_the_future()

    def test_without_it_the_command_says_what_to_do(self):
        told = self.run_program(*self.revoke("third"), *LATER).stdout
        self.assertIn("Set the clock, if it is behind.", told)
        self.assertIn("ddssec crl new --ca demo --date-now", told)
        told = self.refused("crl_not_yet_valid", 1, "crl", "distribute", "--ca", "demo", *LATER)
        self.assertIn("ddssec crl new --ca demo --date-now", told["hint"])

    def test_a_list_of_today_takes_its_place_and_loses_nobody(self):
        revoked = {self.serial("demo/talker"), self.serial("demo/third")}
        self.run_program(*self.revoke("third"), *LATER)
        told = self.run_program("crl", "new", "--ca", "demo", "--date-now", *LATER).stdout
        self.assertIn("participants that refused to start", told)
        shown = self.shown()
        self.assertEqual((shown["number"], shown["this_update"]), (4, "2026-11-22T00:00:00Z"))
        self.assertEqual({e["serial"] for e in shown["revoked"]}, revoked)
        self.assertLessEqual(max(e["time"] for e in shown["revoked"]), "2026-11-22T00:00:00Z")
        self.run_program("crl", "distribute", "--ca", "demo", *LATER)
        self.json("crl", "verify", "demo/listener", "--ca", "demo", *LATER)
        out = self.run_program("check", "demo/talker", "demo/listener", *LATER, exit=1).stdout
        self.assertIn("listener accepts talker: NO    talker accepts listener: ok", out)

    def test_later_lists_are_not_dated_in_the_future_again(self):
        self.run_program("crl", "new", "--ca", "demo", "--date-now", *LATER)
        self.run_program("crl", "new", "--ca", "demo", *LATER)  # the folders still have the list of the future
        self.assertEqual(self.shown()["this_update"], "2026-11-22T00:00:00Z")
        self.run_program("crl", "distribute", "--ca", "demo", *LATER)

    def test_a_list_that_names_less_takes_no_place(self):
        """The CA came back from a backup of before, and its folders are not known to its log."""
        log = self.at / "demo/ca/identity/issued.jsonl"
        log.write_text("".join(line for line in log.read_text().splitlines(True)
                               if "listener" in line and '"issued"' in line))
        shutil.copytree(self.at / "demo/listener", self.at / "away")
        for name in ("talker", "listener", "third"):
            (self.at / f"demo/{name}/crl.pem").unlink()
        (self.at / "demo/ca/identity/crl.pem").unlink()
        for _ in range(4):
            self.run_program("crl", "new", "--ca", "demo", "--date-now", *LATER)
        self.assertEqual((self.shown()["number"], self.shown()["revoked"]), (4, []))
        out = self.json("crl", "distribute", "away", "--ca", "demo", *LATER, exit=1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["crl_older"])
        self.assertEqual(self.shown("away")["number"], 2)

    def test_a_clock_that_is_behind_the_ca_dates_nothing(self):
        told = self.refused("certificate_not_yet_valid", 1, "crl", "new", "--ca", "demo", "--date-now", *BEFORE_CA)
        self.assertIn("set the clock", told["hint"])


class LargeNumbers(Transcript):
    """RFC 5280 5.2.3: a list's number has up to 20 octets."""

    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *NOW)
        identity = self.at / "demo/ca/identity"
        (self.at / "index.txt").touch()
        (self.at / "number").write_text("0674A1B2C3D4E5F60718\n")
        (self.at / "ca.cnf").write_text(
            "[ca]\ndefault_ca = it\n[it]\n"
            f"database = {self.at}/index.txt\ncrlnumber = {self.at}/number\ndefault_md = sha256\n"
            f"certificate = {identity}/ca.pem\nprivate_key = {identity}/ca.key.pem\ncrl_extensions = more\n"
            "[more]\nauthorityKeyIdentifier = keyid\n")
        self.openssl("ca", "-config", "ca.cnf", "-gencrl", "-crl_lastupdate", "20261121000000Z", "-crl_nextupdate",
                     "20271121000000Z", "-out", "former.pem")
        self.number = 0x0674A1B2C3D4E5F60718
        shutil.copy(self.at / "former.pem", self.at / "demo/listener/crl.pem")

    def test_the_next_list_follows_and_is_distributed(self):
        shown = self.json("crl", "show", "former.pem")["result"]
        self.assertEqual(shown["number"], str(self.number))
        self.assertIn(f"number   {self.number}\n", self.run_program("crl", "show", "former.pem").stdout)
        out = self.json("identity", "revoke", "demo/talker", "--ca", "demo", *LATER)["result"]
        self.assertEqual(out["crl"]["number"], str(self.number + 1))
        self.assertIn("674A1B2C3D4E5F60719".lower(),
                      self.openssl("crl", "-in", "demo/ca/identity/crl.pem", "-noout", "-crlnumber").lower())
        self.run_program("crl", "distribute", "--ca", "demo", *LATER)
        self.assertEqual(self.json("crl", "show", "demo/listener")["result"]["number"], str(self.number + 1))

    def test_a_lower_one_takes_no_place(self):
        shutil.move(self.at / "demo/listener", self.at / "away")
        out = self.json("crl", "distribute", "away", "--ca", "demo", *LATER, exit=1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["crl_older"])
        self.assertIn(str(self.number), out["diagnostics"][0]["message"])
        self.run_program("crl", "new", "--ca", "demo", "--from", "away/crl.pem", *LATER)
        self.run_program("crl", "distribute", "away", "--ca", "demo", *LATER)


class SameName(Transcript):
    """Two CAs of one name, as after a roll-over: a list is of the CA whose key signed it."""

    def test_each_keeps_its_list_in_the_folder(self):
        for at in ("old", "new"):
            self.run_program("ca", "create", at, "--role", "identity", "--subject", "CN=Plant CA", "--no-passphrase", *NOW)
        self.run_program("identity", "issue", "talker", "--ca", "old", "-o", "talker", *NOW)
        both = "".join((self.at / at / "ca.pem").read_text() for at in ("old", "new"))
        (self.at / "talker/identity_ca.pem").write_text(both)
        new = (self.at / "new/crl.pem").read_text()
        with (self.at / "talker/crl.pem").open("a") as file:
            file.write(new)
        self.run_program("crl", "new", "--ca", "old", *LATER)
        self.run_program("crl", "distribute", "talker", "--ca", "old", *LATER)
        old = (self.at / "old/crl.pem").read_text()
        self.assertEqual((self.at / "talker/crl.pem").read_text(), old + new)
        self.assertNotIn("several lists", self.run_program("crl", "show", "talker").stdout)
        told = self.run_program("doctor", "talker", *LATER, exit=None).stderr
        self.assertNotIn("lists of", told)


if __name__ == "__main__":
    main()

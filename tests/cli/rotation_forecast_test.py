#!/usr/bin/env python3
"""ca rotate --dry-run: which participants would part at the step, compared with what `check` says after it."""

import itertools

from transcript import NOW, Transcript, main

ROLES = ("identity", "permissions")
NAMES = ("talker", "listener", "radar")


class Forecast(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *(word for name in NAMES for word in ("--participant", name)), *NOW)
        for file in (self.at / "demo").glob("*/*.xml"):
            if "dds" in file.name:
                file.unlink()  # otherwise the environment says on which plugins they run

    def place(self, name):
        return str(self.at / "demo" / name)

    def rotate(self, role, *words, exit=0):
        return self.json("ca", "rotate", "demo", *words, "--role", role, *NOW, exit=exit)

    def forecast(self, role, *words, exit=0):
        before = {path: (self.at / path).read_bytes() for path in self.files()}
        out = self.rotate(role, *words, "--dry-run", exit=exit)["result"]
        self.assertEqual({path: (self.at / path).read_bytes() for path in self.files()}, before)
        return out["forecast"]

    def pairs(self, forecast):
        """{two names: only with stock plugins}"""
        return {frozenset(path.rsplit("/", 1)[1] for path in (one["a"], one["b"])): one["only_stock"]
                for one in forecast["pairs"]}

    def parted(self, *vendors):
        """By `check`, for each pair in both orders."""
        words = [word for vendor in vendors for word in ("--vendor", vendor)]
        return {frozenset(pair) for pair in itertools.permutations(NAMES, 2)
                if self.json("check", *map(self.place, pair), *words, *NOW, exit=None)["exit"] != 0}

    def test_step_separates_the_participants_that_the_forecast_named(self):
        """One participant alone moves, as in a fleet that moves bit by bit."""
        for role in ROLES:
            for words in (("--overlap", "30d"), (self.place("talker"), "--move"), ("--move",), ("--end",)):
                told = self.pairs(self.forecast(role, *words))
                self.rotate(role, *words)
                self.assertEqual({pair for pair, only_stock in told.items() if not only_stock},
                                 self.parted("ddssec"), f"{role} {words}")
                self.assertEqual(set(told), self.parted("A=ddssec", "B=cyclonedds"), f"{role} {words}")

    def test_move_of_one_parts_it_from_stock_peers_only(self):
        self.rotate("identity", "--overlap", "30d")
        told = self.forecast("identity", self.place("talker"), "--move")
        self.assertEqual((told["judged"], told["parted"], told["unread"]), (3, 2, []))
        self.assertEqual(self.pairs(told), {frozenset(("talker", "listener")): True, frozenset(("talker", "radar")): True})

    def test_end_of_one_parts_it_from_all_that_have_not_moved(self):
        self.rotate("identity", "--overlap", "30d")
        told = self.forecast("identity", self.place("talker"), "--end")
        self.assertEqual(self.pairs(told), {frozenset(("talker", "listener")): False,
                                            frozenset(("talker", "radar")): False})

    def test_rotation_at_once_of_some_parts_them_from_the_others(self):
        told = self.forecast("permissions", self.place("talker"), self.place("radar"))
        self.assertEqual(self.pairs(told), {frozenset(("talker", "listener")): False,
                                            frozenset(("radar", "listener")): False})

    def test_revoked_participant_is_not_judged(self):
        self.run_program("identity", "revoke", self.place("radar"), "--ca", "demo", *NOW)
        told = self.forecast("identity", "--overlap", "30d")
        self.assertEqual((told["judged"], told["parted"]), (2, 0))

    def test_folder_without_readable_files_is_named(self):
        self.rotate("identity", "--overlap", "30d")
        (self.at / "demo/radar/identity_ca.pem").write_text("nothing")
        told = self.forecast("identity", self.place("talker"), self.place("listener"), "--move")
        self.assertEqual((told["judged"], told["unread"]), (2, [self.place("radar")]))

    def test_participant_on_our_libraries_by_path_is_no_stock_peer(self):
        libraries = self.at / "dropin"
        libraries.mkdir()
        for part in ("auth", "ac", "crypto"):
            (libraries / f"libdds_security_{part}.so").write_bytes(self.library(part))
        for name in NAMES:
            text = "".join(f'<{element}><Library path="{libraries}/libdds_security_{part}.so"/></{element}>' for element, part in
                           (("Authentication", "auth"), ("AccessControl", "ac"), ("Cryptographic", "crypto")))
            (self.at / "demo" / name / "cyclonedds.xml").write_text(
                f'<CycloneDDS><Domain id="any"><Security>{text}</Security></Domain></CycloneDDS>')
        self.rotate("identity", "--overlap", "30d")
        self.assertEqual(self.forecast("identity", self.place("talker"), "--move")["parted"], 0)

    def library(self, part):
        from transcript import PROGRAM
        return (PROGRAM.parent.parent / f"dropin/libdds_security_{part}.so").read_bytes()

    def test_text_names_the_pairs_and_what_stock_plugins_need(self):
        self.rotate("identity", "--overlap", "30d")
        text = self.run_program("ca", "rotate", "demo", self.place("talker"), "--role", "identity", "--move", "--dry-run",
                                *NOW).stdout
        self.assertIn("2 pairs of 3 folders would part:\n", text)
        self.assertIn(f"  {self.place('talker')} - {self.place('listener')}  (if one of them runs on stock plugins)\n", text)
        self.assertIn("once it was started again", text)
        text = self.run_program("ca", "rotate", "demo", "--role", "identity", "--move", "--dry-run", *NOW).stdout
        self.assertIn("no two of 3 folders would part by their CAs\n", text)

    def test_step_that_is_made_has_no_forecast(self):
        self.assertNotIn("forecast", self.rotate("identity", "--overlap", "30d")["result"])


if __name__ == "__main__":
    main()

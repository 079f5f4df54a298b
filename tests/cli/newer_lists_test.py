#!/usr/bin/env python3
"""Revocation lists: a newer one is never lost, whichever command puts which list where."""

import fcntl
import os
import pathlib
import shutil
import subprocess
import time

from transcript import AT_THAT_TIME, NOW, PROGRAM, Transcript, main

LIBRARY = PROGRAM.parent.parent / "lib/kill_at.so"
LATER = ("--now", "2026-11-22T00:00:00Z")
EARLIER = ("--now", "2026-11-20T23:00:00Z")


class Lists(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *(w for n in ("talker", "listener", "third") for w in ("--participant", n)),
                         "--now", "2026-11-20T00:00:00Z")

    def shown(self, where):
        return self.json("crl", "show", where)["result"]

    def distribute(self, *folders, exit=0, ca="demo", now=NOW):
        return self.json("crl", "distribute", *folders, "--ca", ca, *now, exit=exit)

    def ids(self, out):
        return [d["id"] for d in out["diagnostics"]]

    def serial(self, name):
        return self.json("identity", "show", name, *NOW)["result"]["serial"]


class Restored(Lists):
    """The CA's folder came back from a backup."""

    def setUp(self):
        super().setUp()
        shutil.copytree(self.at / "demo/ca", self.at / "backup")

    def restore(self):
        shutil.rmtree(self.at / "demo/ca")
        shutil.copytree(self.at / "backup", self.at / "demo/ca")

    def revoke_and_restore(self):
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)
        self.distribute()
        self.restore()

    def test_a_newcomer_gets_the_newer_list(self):
        self.revoke_and_restore()
        revoked = self.serial("demo/talker")
        self.run_program("identity", "issue", "fourth", "--ca", "demo", "-o", "fourth", *LATER)
        self.assertEqual((self.at / "fourth/crl.pem").read_bytes(), (self.at / "demo/listener/crl.pem").read_bytes())
        self.assertIn(revoked, str(self.shown("fourth/crl.pem")))

    def test_an_old_list_takes_no_newer_ones_place(self):
        self.revoke_and_restore()
        before = (self.at / "demo/listener/crl.pem").read_bytes()
        out = self.distribute(exit=1)
        self.assertEqual(self.ids(out), ["crl_older"] * 2)
        self.assertIn("came back from a backup", out["diagnostics"][0]["message"])
        self.assertIn("ddssec crl new --ca demo --from", out["diagnostics"][0]["hint"])
        self.assertEqual(out["result"]["folders"], [str(self.at / "demo/talker")])
        self.assertEqual((self.at / "demo/listener/crl.pem").read_bytes(), before)
        self.assertEqual(self.ids(self.distribute("demo/listener", exit=1)), ["crl_older"])
        self.refused("crl_older", 1, "crl", "verify", "demo/listener", "--ca", "demo", *NOW)
        told = self.run_program("doctor", "demo/listener", *NOW).stderr
        self.assertRegex(told, r"DOC023.*the CA has list 1 only, .*crl.pem here is list 2")

    def test_the_next_list_takes_over_what_newer_ones_name(self):
        self.revoke_and_restore()
        talker = self.serial("demo/talker")
        self.run_program("identity", "revoke", "demo/third", "--ca", "demo", *LATER)
        shown = self.shown("demo")
        self.assertEqual((shown["number"], {e["serial"] for e in shown["revoked"]}),
                         (3, {talker, self.serial("demo/third")}))
        self.distribute(now=LATER)
        self.refused("certificate_revoked", 1, "identity", "renew", "demo/talker", "--ca", "demo", *LATER)
        self.assertEqual(self.shown("demo/listener")["number"], 3)

    def test_a_rotation_goes_by_newer_lists_as_well(self):
        self.revoke_and_restore()
        out = self.json("ca", "rotate", "demo", "--role", "identity", *LATER)["result"]
        self.assertEqual(out["revoked"], [str(self.at / "demo/talker")])

    def test_a_list_of_a_folder_that_the_log_does_not_know(self):
        self.run_program("identity", "issue", "fourth", "--ca", "demo", "-o", "demo/fourth", *NOW)
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)
        self.distribute("demo/fourth")
        talker = self.serial("demo/talker")
        self.restore()
        self.assertEqual(self.ids(self.distribute("demo/fourth", exit=1)), ["crl_older"])
        self.run_program("crl", "new", "--ca", "demo", *LATER)  # number 2 again, without talker
        self.assertEqual(self.ids(self.distribute("demo/fourth", exit=1, now=LATER)), ["crl_older"])
        self.run_program("crl", "new", "--ca", "demo", "--from", "demo/fourth", *LATER)
        self.distribute("demo/fourth", now=LATER)
        self.assertEqual([e["serial"] for e in self.shown("demo/fourth")["revoked"]], [talker])

    def test_issuing_anew_puts_no_older_list_into_the_folder(self):
        self.revoke_and_restore()
        before = (self.at / "demo/listener/crl.pem").read_bytes()
        self.run_program("identity", "issue", "listener", "--ca", "demo", "-o", "demo/listener", "--replace", *NOW)
        self.assertEqual((self.at / "demo/listener/crl.pem").read_bytes(), before)

    def test_a_foreign_list_is_not_taken_over(self):
        self.run_program("ca", "create", "other", "--role", "identity", "--no-passphrase", *NOW)
        self.refused("crl_signature_invalid", 1, "crl", "new", "--ca", "demo", "--from", "other/crl.pem", *NOW)


class Clock(Lists):
    def test_no_list_is_dated_before_the_one_that_it_follows(self):
        self.run_program("crl", "new", "--ca", "demo", *NOW)
        self.distribute()
        told = self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *EARLIER).stdout
        self.assertIn("Set the clock", told)
        shown = self.shown("demo")
        self.assertEqual((shown["number"], shown["this_update"]), (3, "2026-11-21T00:00:00Z"))
        self.refused("crl_not_yet_valid", 1, "crl", "distribute", "--ca", "demo", *EARLIER)
        self.distribute()
        self.assertEqual(self.shown("demo/listener")["number"], 3)

    def test_a_list_that_has_ended_is_made_anew_at_the_ca(self):
        self.run_program("crl", "new", "--ca", "demo", "--next-update", "1", *NOW)
        told = self.refused("crl_expired", 1, "crl", "distribute", "--ca", "demo", "--now", "2026-12-01T00:00:00Z")
        self.assertIn("ddssec crl new --ca demo", told["hint"])


class Waiting(Lists):
    """A command waits for the CA, which another command changes meanwhile."""

    def setUp(self):
        super().setUp()
        shutil.copytree(self.at / "demo", self.at / "changed/demo")

    def start(self, *words):
        file = os.open(self.at / "demo/ca/identity/ca.key.pem", os.O_RDONLY)
        fcntl.flock(file, fcntl.LOCK_EX)
        running = subprocess.Popen([PROGRAM, *words, *LATER], cwd=self.at, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        return file, running

    def has_key_open(self, process):
        links = pathlib.Path(f"/proc/{process.pid}/fd").glob("*")
        try:
            return any(os.readlink(link).endswith("ca.key.pem") for link in links)
        except OSError:
            return False

    def wait_until_it_waits(self, process):
        seen, end = 0, time.monotonic() + 15
        while seen < 5 and process.poll() is None and time.monotonic() < end:
            time.sleep(0.05)
            seen = seen + 1 if self.has_key_open(process) else 0

    def while_it_waits(self, change, *words):
        """What becomes of a command if `change` happens before it gets the CA."""
        file, running = self.start(*words)
        self.wait_until_it_waits(running)
        change()
        os.close(file)
        out, told = running.communicate(timeout=60)
        self.assertEqual((running.returncode, told), (0, ""), out)

    def take_over(self):
        """The files of a copy that was changed, in the order in which a rotation puts them."""
        at = self.at / "changed/demo"
        for name in ("ca/identity/ca.pem", "ca/identity/crl.pem", "ca/identity/issued.jsonl", "listener/cert.pem",
                     "listener/identity_ca.pem", "listener/crl.pem", "ca/identity/ca.key.pem"):
            (at / name).rename(self.at / "demo" / name)

    def rotated(self, *words):
        self.run_program("ca", "rotate", "changed/demo", "--role", "identity", *NOW)
        log = self.at / "changed/demo/ca/identity/issued.jsonl"
        log.write_text(log.read_text().replace(f"{self.at}/changed/", f"{self.at}/"))
        self.while_it_waits(self.take_over, *words)

    def test_a_list_is_of_the_key_that_the_ca_has_then(self):
        self.rotated("identity", "revoke", "demo/talker", "--ca", "demo")
        self.json("crl", "verify", "demo/ca/identity/crl.pem", "--ca", "demo", *LATER)
        self.assertEqual(self.ids(self.distribute("demo/listener", now=LATER)), [])

    def test_crl_new_is_of_the_key_that_the_ca_has_then(self):
        self.rotated("crl", "new", "--ca", "demo")
        self.json("crl", "verify", "demo/ca/identity/crl.pem", "--ca", "demo", *LATER)

    def test_a_certificate_is_of_the_key_that_the_ca_has_then(self):
        self.rotated("identity", "issue", "fourth", "--ca", "demo", "-o", "demo/fourth")
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "demo/ca/identity/ca.pem", "demo/fourth/cert.pem")

    def test_a_renewal_is_of_the_key_that_the_ca_has_then(self):
        self.rotated("identity", "renew", "demo/listener", "--ca", "demo")
        self.openssl("verify", *AT_THAT_TIME, "-CAfile", "demo/ca/identity/ca.pem", "demo/listener/cert.pem")

    def test_the_list_that_is_distributed_is_the_present_one(self):
        self.run_program("identity", "revoke", "changed/demo/talker", "--ca", "changed/demo", *NOW)
        newer = self.at / "changed/demo/ca/identity/crl.pem"
        self.while_it_waits(lambda: newer.rename(self.at / "demo/ca/identity/crl.pem"), "crl", "distribute", "--ca", "demo")
        self.assertEqual([self.shown(f"demo/{name}")["number"] for name in ("listener", "third")], [2, 2])

    def test_a_list_of_a_replaced_key_is_not_taken_for_the_cas(self):
        self.run_program("ca", "rotate", "changed/demo", "--role", "identity", *NOW)
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)
        shutil.copy(self.at / "demo/ca/identity/issued.jsonl", self.at / "changed/demo/ca/identity")
        shutil.copy(self.at / "demo/ca/identity/crl.pem", self.at / "changed/demo/ca/identity")
        told = self.refused("crl_signature_invalid", 1, "crl", "distribute", "--ca", "changed/demo", *NOW)
        self.assertIn("ddssec crl new --ca changed/demo", told["hint"])
        serial = self.serial("demo/talker")
        told = self.run_program("identity", "revoke", serial, "--ca", "changed/demo", *NOW).stdout
        self.assertIn("revoked already, but the list did not say so", told)
        self.json("crl", "verify", "changed/demo/ca/identity/crl.pem", "--ca", "changed/demo", *NOW)


class WithoutTheKey(Lists):
    """A user who cannot open the CA's key distributes without a lock."""

    # The key is away, which counts like one that may not be opened. Between the check of the folders and the
    # first rename another command distributes a newer list to them.
    def test_a_newer_list_that_came_in_between_is_distributed_again(self):
        shutil.copytree(self.at / "demo", self.at / "changed/demo")
        self.run_program("identity", "revoke", "changed/demo/talker", "--ca", "changed/demo", *NOW)
        log = self.at / "changed/demo/ca/identity/issued.jsonl"
        log.write_text(log.read_text().replace(f"{self.at}/changed/", f"{self.at}/"))
        (self.at / "demo/ca/identity/ca.key.pem").unlink()
        between = (f"mv changed/demo/ca/identity/crl.pem changed/demo/ca/identity/issued.jsonl demo/ca/identity && "
                   f"{PROGRAM} crl distribute --ca demo {' '.join(LATER)} > between.txt")
        environment = {**os.environ, "LD_PRELOAD": str(LIBRARY), "AT_RENAME": between}
        done = subprocess.run([PROGRAM, "crl", "distribute", "--ca", "demo", *LATER], cwd=self.at, env=environment,
                              capture_output=True, text=True, check=False, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("list 2 of", (self.at / "between.txt").read_text())
        self.assertIn("list 2 of", done.stdout)
        self.assertEqual([self.shown(f"demo/{name}")["number"] for name in ("talker", "listener", "third")], [2] * 3)


class Intermediate(Transcript):
    """Participants below two CAs of one root."""

    def setUp(self):
        super().setUp()
        self.run_program("ca", "create", "root", "--role", "identity", "--no-passphrase", *NOW)
        for name in ("plant", "plant2"):
            self.run_program("ca", "create", name, "--role", "identity", "--intermediate-of", "root", "--no-passphrase",
                             "--clamp", *NOW)
        for name in ("talker", "listener"):
            self.run_program("identity", "issue", name, "--ca", "plant", "-o", name, *NOW)

    def issuers(self, folder):
        shown = self.json("crl", "show", folder)["result"]
        return [one["issuer"] for one in (shown, *shown["others"])]

    def test_lists_of_both_lie_side_by_side(self):
        self.run_program("identity", "revoke", "talker", "--ca", "plant", *NOW)
        self.run_program("crl", "distribute", "--ca", "plant", *NOW)
        told = self.run_program("identity", "revoke", "plant2/ca.pem", "--ca", "root", *NOW).stdout
        self.assertIn("next: ddssec crl distribute DIR... --ca root", told)
        self.run_program("crl", "distribute", "listener", "--ca", "root", *NOW)
        both = ["CN=plant Identity CA", "CN=root Identity CA"]
        self.assertEqual(self.issuers("listener"), both)
        self.run_program("crl", "new", "--ca", "plant", *LATER)
        self.run_program("crl", "distribute", "--ca", "plant", *LATER)
        self.assertEqual(self.issuers("listener"), both)
        self.json("crl", "verify", "listener", "--ca", "root", *LATER)
        self.assertEqual(self.json("crl", "show", "listener")["result"]["number"], 3)
        self.run_program("ca", "rotate", "plant", "listener", "--role", "identity", "--issuer", "root", *LATER)
        self.assertEqual(self.issuers("listener"), both)

    def test_the_list_of_the_root_alone_would_shut_everybody_out(self):
        (self.at / "listener/crl.pem").unlink()
        out = self.json("crl", "distribute", "listener", "--ca", "root", *NOW, exit=1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["crl_missing"])
        self.assertFalse((self.at / "listener/crl.pem").exists())

    def test_a_folder_of_another_ca_takes_no_list(self):
        before = (self.at / "listener/crl.pem").read_bytes()
        out = self.json("crl", "distribute", "listener", "--ca", "plant2", *NOW, exit=1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["issuer_unknown"])
        self.assertEqual((self.at / "listener/crl.pem").read_bytes(), before)


class Several(Lists):
    """Two lists of one CA in one file."""

    def setUp(self):
        super().setUp()
        self.old = (self.at / "demo/listener/crl.pem").read_text()
        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo", *NOW)
        self.new = (self.at / "demo/ca/identity/crl.pem").read_text()

    def put(self, *lists):
        (self.at / "demo/listener/crl.pem").write_text("".join(lists))

    def accepts(self, product):
        (self.at / "away").mkdir(exist_ok=True)
        for name in ("talker", "listener"):  # away from the CA and its own list
            shutil.copytree(self.at / "demo" / name, self.at / "away" / name, dirs_exist_ok=True)
        (self.at / "away/talker/crl.pem").unlink(missing_ok=True)
        out = self.run_program("check", "away/talker", "away/listener", "--vendor", f"A={product}", "--vendor",
                               f"B={product}", *NOW, exit=None).stdout
        (line,) = [line for line in out.splitlines() if line.startswith("authentication ")]
        return "listener accepts talker: ok" in line

    def test_stock_products_read_the_first_and_ours_the_newest(self):
        self.put(self.old, self.new)
        self.assertEqual([self.accepts(p) for p in ("cyclonedds@0.10.2", "fastdds@2.9.1", "ddssec")], [True, True, False])
        self.put(self.new, self.old)
        self.assertEqual([self.accepts(p) for p in ("cyclonedds@0.10.2", "fastdds@2.9.1", "ddssec")], [False] * 3)

    # can judges as ddssec's plugins do, and says so; away from the CA, whose own list counts for it.
    def test_can_says_which_product_it_judges(self):
        shutil.copytree(self.at / "demo/talker", self.at / "away/talker")
        file = self.at / "away/talker/crl.pem"
        can = ("can", "away/talker", "publish", "x", *NOW)
        for lists, stock in (((self.old, self.new), "not revoked"), ((self.new, self.old), None)):
            file.write_text("".join(lists))
            out = self.json(*can, exit=1)
            self.assertEqual((out["result"]["allowed"], out["result"]["judge"]), (False, "ddssec"))
            self.assertIn("revoked by list 2 of the CA", out["result"]["because"])
            told = [d["message"] for d in out["diagnostics"] if d["id"] == "DOC023"]
            self.assertEqual(len(told), 1 if stock else 0)
            if stock:
                self.assertRegex(told[0], f"read the first only, by which CN=talker is {stock}; ddssec's plugins refuse it")
        self.assertIn("denied in domain 0 by ddssec's plugins: ", self.run_program(*can, exit=1).stdout)

    def test_can_leaves_out_a_list_whose_place_a_newer_one_takes(self):
        shutil.copytree(self.at / "demo/ca", self.at / "once")
        for file in ("crl.pem", "issued.jsonl"):  # a CA that forgot which certificates it revoked
            (self.at / "once/identity" / file).unlink()
        for _ in range(3):
            self.run_program("crl", "new", "--ca", "once/identity", *LATER)
        shutil.copytree(self.at / "demo/talker", self.at / "away/talker")
        (self.at / "away/talker/cyclonedds.xml").unlink()  # it names the files in demo
        newest = (self.at / "once/identity/crl.pem").read_text()
        (self.at / "away/talker/crl.pem").write_text(self.new + newest)
        out = self.json("can", "away/talker", "publish", "x", *LATER)
        self.assertRegex(str(out["diagnostics"]), "by which CN=talker is revoked; ddssec's plugins do not")

    def test_doctor_and_show_say_so(self):
        self.put(self.old, self.new)
        told = self.run_program("doctor", "demo/listener", *NOW).stderr
        self.assertRegex(told, 'DOC023.*crl.pem holds 2 lists of "CN=demo Identity CA"; Cyclone DDS and Fast DDS read the first')
        shown = self.shown("demo/listener")
        self.assertEqual((shown["number"], [(o["number"], len(o["revoked"])) for o in shown["others"]]), (1, [(2, 1)]))
        self.assertIn("several lists of", self.run_program("crl", "verify", "demo/listener", "--ca", "demo", *NOW).stdout)
        self.distribute("demo/listener")
        self.assertEqual((self.at / "demo/listener/crl.pem").read_text(), self.new)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""One participant's folder takes no files: all others get theirs, the folder is named, and the command can be repeated."""

import os
import pathlib
import shutil
import subprocess
import unittest

from transcript import AT_THAT_TIME, NOW, Transcript, library_path, main, PROGRAM

NAMES = ("alpha", "bravo", "charlie", "delta")
ADMINISTRATOR, OTHER = 1500, 1501
NEEDS_ROOT = unittest.skipUnless(os.geteuid() == 0, "only root can act as two users")
LIBRARY = PROGRAM.parent.parent / "lib/kill_at.so"


class Blocked(Transcript):
    """bravo's folder is another user's, to which the administrator's group may write."""

    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", *[word for name in NAMES for word in ("--participant", name)], *NOW)

    def share(self):
        """From here on commands run as an administrator who is not root."""
        self.at.chmod(0o755)
        for path in (self.at / "demo", *(self.at / "demo").rglob("*")):
            is_bravo = "bravo" in path.relative_to(self.at).parts
            os.chown(path, OTHER if is_bravo else ADMINISTRATOR, ADMINISTRATOR)
        (self.at / "demo/bravo").chmod(0o2775)
        shutil.copy(PROGRAM, self.at / "program")

    def as_user(self, user, *words, exit=0, **environment):
        done = subprocess.run(words, cwd=self.at, text=True, capture_output=True, timeout=60, check=False, user=user,
                              group=ADMINISTRATOR, extra_groups=[], stdin=subprocess.DEVNULL,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), **environment})
        self.assertEqual(done.returncode, exit, f"{words}: {done.stdout}{done.stderr}")
        return done

    def administrator(self, *words, exit=0, **environment):
        return self.as_user(ADMINISTRATOR, self.at / "program", *words, *NOW, exit=exit, **environment)

    def current(self, role):
        """Whose files are of the CA that is in place now."""
        out = []
        for name in NAMES:
            words = {"permissions": [PROGRAM, "permissions", "verify", f"demo/{name}", "--ca", "demo", *NOW],
                     "identity": ["openssl", "verify", *AT_THAT_TIME, "-CAfile", "demo/ca/identity/ca.pem", f"demo/{name}/cert.pem"]}
            if subprocess.run(words[role], cwd=self.at, capture_output=True, check=False).returncode == 0:
                out.append(name)
        return out

    def meet(self, a, b):
        self.json("check", f"demo/{a}", f"demo/{b}", *NOW)

    def numbers(self):
        return [self.json("crl", "show", f"demo/{name}", *NOW)["result"]["number"] for name in NAMES]

    def drafts(self):
        return [p.name for p in (self.at / "demo").rglob("*.new")]


@NEEDS_ROOT
class Sticky(Blocked):
    """Only bravo's owner may replace files in the folder, while drafts can still be made."""

    def setUp(self):
        super().setUp()
        self.share()
        (self.at / "demo/bravo").chmod(0o3775)

    def open_again(self):
        (self.at / "demo/bravo").chmod(0o2775)

    def test_a_revocation_list_gets_to_all_others(self):
        self.administrator("identity", "revoke", "demo/alpha", "--ca", "demo")
        done = self.administrator("crl", "distribute", "--ca", "demo", exit=5)
        self.assertIn("error[file_unwritable]", done.stderr)
        self.assertIn("demo/bravo/crl.pem", done.stderr)
        self.assertIn("is in 2 folders", done.stdout)
        self.assertEqual(self.numbers(), [1, 1, 2, 2])  # alpha gets none
        self.open_again()
        self.administrator("crl", "distribute", "--ca", "demo")
        self.assertEqual(self.numbers(), [1, 2, 2, 2])

    def rotate(self, role):
        self.assertEqual(self.current(role), list(NAMES))
        done = self.administrator("ca", "rotate", "demo", "--role", role, exit=5)
        self.assertIn("3 folders signed again", done.stdout)
        self.assertIn("demo/bravo/", done.stderr)
        self.assertIn("hint: the participant keeps its old files", done.stderr)
        self.assertEqual(self.current(role), ["alpha", "charlie", "delta"])
        self.meet("alpha", "delta")

    def test_a_rotation_reaches_all_others_and_the_next_command_finishes_it(self):
        for role in ("permissions", "identity"):
            self.rotate(role)
            self.assertNotEqual(self.drafts(), [])
            done = self.administrator("ca", "renew", "demo", "--role", role)  # another command is not stopped
            self.assertIn("warning[unfinished_left]", done.stderr)
            self.open_again()
            self.administrator("ca", "renew", "demo", "--role", role)
            self.assertEqual((self.current(role), self.drafts()), (list(NAMES), []))
            (self.at / "demo/bravo").chmod(0o3775)
        self.meet("alpha", "bravo")

    def test_a_rotation_can_be_repeated(self):
        for role in ("permissions", "identity"):
            self.rotate(role)
            for draft in (self.at / "demo/bravo").glob("*.new"):
                draft.unlink()  # and cannot be finished
            self.rotate_again(role)
        self.meet("alpha", "bravo")

    def rotate_again(self, role):
        self.open_again()
        done = self.administrator("ca", "rotate", "demo", "--role", role)
        self.assertIn("4 folders signed again", done.stdout)
        self.assertEqual((self.current(role), self.drafts()), (list(NAMES), []))
        (self.at / "demo/bravo").chmod(0o3775)

    def test_the_next_rotation_takes_the_place_of_what_waits(self):
        for role in ("permissions", "identity"):
            self.rotate(role)
            waiting = set(self.drafts())
            done = self.administrator("ca", "rotate", "demo", "--role", role, exit=5)
            self.assertIn("3 folders signed again", done.stdout)
            self.assertEqual(waiting & set(self.drafts()), set())
            self.open_again()
            self.administrator("ca", "renew", "demo", "--role", role)
            self.assertEqual((self.current(role), self.drafts()), (list(NAMES), []))
            (self.at / "demo/bravo").chmod(0o3775)

    def test_a_participant_that_was_left_behind_can_be_revoked(self):
        self.rotate("identity")
        self.open_again()
        for draft in (self.at / "demo/bravo").glob("*.new"):
            draft.unlink()
        done = self.administrator("identity", "revoke", "demo/bravo", "--ca", "demo")
        self.assertIn("CN=bravo  revoked (2 certificates)", done.stdout)

    def test_a_draft_that_another_user_made_is_not_taken(self):
        self.rotate("permissions")
        for draft in (self.at / "demo/bravo").glob("*.new"):
            draft.unlink()
            draft.write_text("bravo's")
            os.chown(draft, OTHER, ADMINISTRATOR)
        self.open_again()
        before = (self.at / "demo/bravo/permissions.p7s").read_bytes()
        self.administrator("ca", "renew", "demo", "--role", "permissions")
        self.assertEqual((self.at / "demo/bravo/permissions.p7s").read_bytes(), before)
        for draft in (self.at / "demo/bravo").glob("*.new"):
            draft.unlink()
        self.rotate_again("permissions")


@NEEDS_ROOT
class Unwritable(Blocked):
    """Only bravo's owner may write bravo's folder, so that not even a draft can be made there."""

    def setUp(self):
        super().setUp()
        self.share()

    def step(self, role, *words, exit=0):
        return self.administrator("ca", "rotate", "demo", "--role", role, *words, exit=exit)

    def left(self, role):
        rotation = self.json("ca", "show", "demo", "--role", role, *NOW)["result"]["rotation"]
        return rotation and [pathlib.Path(folder).name for folder in rotation["left"]]

    def trusted(self, role, name="bravo"):
        return (self.at / f"demo/{name}/{role}_ca.pem").read_text().count("BEGIN CERTIFICATE")

    def without_bravo(self, role, *words):
        (self.at / "demo/bravo").chmod(0o755)
        before = {p: p.read_bytes() for p in (self.at / "demo/bravo").iterdir()}
        done = self.step(role, *words, exit=5)
        self.assertIn("error[file_unwritable]", done.stderr)
        self.assertEqual({p: p.read_bytes() for p in (self.at / "demo/bravo").iterdir()}, before)
        (self.at / "demo/bravo").chmod(0o2775)
        return done.stderr

    def test_each_step_of_an_overlap_made_again_reaches_the_folder(self):
        for role in ("permissions", "identity"):
            key = (self.at / f"demo/ca/{role}/ca.key.pem").read_bytes()
            self.assertIn(f"ddssec ca rotate demo --role {role} --overlap TIME",
                          self.without_bravo(role, "--overlap", "30d"))
            self.assertEqual((self.trusted(role), self.trusted(role, "alpha")), (1, 2))
            key, before = (self.at / f"demo/ca/{role}/ca.key.pem").read_bytes(), key
            self.assertNotEqual(key, before)
            self.assertIn("both count in 1 folder", self.step(role, "--overlap", "30d").stdout)
            self.assertEqual(self.trusted(role), 2)
            self.assertIn(f"ddssec ca rotate demo --role {role} --move", self.without_bravo(role, "--move"))
            self.assertEqual(self.left(role), ["bravo"])
            self.step(role, "--move")
            self.assertEqual(self.left(role), [])
            told = self.without_bravo(role, "--end")
            self.assertIn("still trusts the former CA", told)
            self.assertIn(f"ddssec ca rotate demo --role {role} --end", told)
            self.assertEqual((self.trusted(role), self.left(role)), (2, ["bravo"]))
            self.assertIn("alone counts in 1 folder", self.step(role, "--end").stdout)
            self.assertEqual((self.trusted(role), self.left(role)), (1, None))
            self.assertIn("error[no_overlap]", self.step(role, "--end", exit=1).stderr)
            self.assertEqual((self.at / f"demo/ca/{role}/ca.key.pem").read_bytes(), key, "no further rotation")
            self.assertEqual(self.current(role), list(NAMES))
        self.meet("alpha", "bravo")

    def test_end_of_a_folder_that_had_not_moved_either_reaches_it(self):
        for role in ("permissions", "identity"):
            self.step(role, "--overlap", "30d")
            self.without_bravo(role, "--end")
            self.assertNotIn("bravo", self.current(role))
            self.step(role, "demo/bravo", "--end")
            self.assertEqual((self.current(role), self.left(role)), (list(NAMES), None))
        self.meet("alpha", "bravo")

    def test_rotation_at_once_is_completed_by_end(self):
        for role in ("permissions", "identity"):
            self.assertIn(f"then: ddssec ca rotate demo --role {role} --end", self.without_bravo(role))
            self.assertEqual(self.left(role), ["bravo"])
            key = (self.at / f"demo/ca/{role}/ca.key.pem").read_bytes()
            self.step(role, "--end")
            self.assertEqual((self.current(role), self.left(role)), (list(NAMES), None))
            self.assertEqual((self.at / f"demo/ca/{role}/ca.key.pem").read_bytes(), key)
        self.meet("alpha", "bravo")

    def test_end_with_files_that_wait_beside_their_places_puts_them_in_place(self):
        for role in ("permissions", "identity"):
            self.step(role, "--overlap", "30d")
            (self.at / "demo/bravo").chmod(0o3775)
            self.step(role, "--end", exit=5)
            self.assertNotEqual(self.drafts(), [])
            (self.at / "demo/bravo").chmod(0o2775)
            self.assertIn("alone counts in 1 folder", self.step(role, "--end").stdout)
            self.assertEqual((self.current(role), self.left(role), self.drafts()), (list(NAMES), None, []))


@NEEDS_ROOT
class Removed(Blocked):
    """bravo's owner removes drafts from the folder."""

    def setUp(self):
        super().setUp()
        self.share()
        shutil.copy(LIBRARY, self.at / "remove.so")

    def removing(self, *words):
        return self.administrator(*words, exit=5, LD_PRELOAD=str(self.at / "remove.so"),
                                  REMOVE_DRAFTS="demo/bravo/*.new")

    def test_a_revocation_list_gets_to_all_others(self):
        self.administrator("identity", "revoke", "demo/alpha", "--ca", "demo")
        self.assertIn("removed the new file", self.removing("crl", "distribute", "--ca", "demo").stderr)
        self.assertEqual(self.numbers(), [1, 1, 2, 2])

    def test_a_rotation_reaches_all_others_and_can_be_repeated(self):
        for role in ("permissions", "identity"):
            before = {p: p.read_bytes() for p in (self.at / "demo/bravo").iterdir()}
            done = self.removing("ca", "rotate", "demo", "--role", role)
            self.assertIn("removed the new file", done.stderr)
            self.assertEqual(self.current(role), ["alpha", "charlie", "delta"])
            self.assertEqual({p: p.read_bytes() for p in (self.at / "demo/bravo").iterdir()}, before)
            self.administrator("ca", "rotate", "demo", "--role", role)
            self.assertEqual(self.current(role), list(NAMES))
        self.meet("alpha", "bravo")


class InThePlace(Blocked):
    """There is a folder in the place of a file of bravo's, or a certificate that is none."""

    def block(self, file):
        path = self.at / "demo/bravo" / file
        path.unlink()
        path.mkdir()
        return path

    def test_a_revocation_list_gets_to_all_others(self):
        self.run_program("crl", "new", "--ca", "demo", *NOW)
        path = self.block("crl.pem")
        out = self.json("crl", "distribute", "--ca", "demo", *NOW, exit=3)  # the list that is there is read first
        self.assertEqual([pathlib.Path(f).name for f in out["result"]["folders"]], ["alpha", "charlie", "delta"])
        self.assertEqual([d["file"] for d in out["diagnostics"]], [str(path)])

    def rotated_without_bravo(self, role, exit):
        out = self.json("ca", "rotate", "demo", "--role", role, *NOW, exit=exit)
        self.assertEqual([pathlib.Path(f).name for f in out["result"]["folders"]], ["alpha", "charlie", "delta"])
        self.assertEqual([d["file"] for d in out["diagnostics"] if "bravo" in d["file"]],
                         [d["file"] for d in out["diagnostics"]])
        self.assertNotIn("bravo", self.current(role))
        self.meet("alpha", "delta")

    def test_a_rotation_reaches_all_others(self):
        for role in ("permissions", "identity"):
            path = self.block(f"{role}_ca.pem")
            before = {p: p.read_bytes() for p in (self.at / "demo/bravo").iterdir() if p.is_file()}
            self.rotated_without_bravo(role, 4)
            self.assertEqual({p: p.read_bytes() for p in before}, before)
            path.rmdir()
            shutil.copy(self.at / f"demo/alpha/{role}_ca.pem", path)
            self.json("ca", "rotate", "demo", "--role", role, *NOW)
            self.assertEqual(self.current(role), list(NAMES))
        self.meet("alpha", "bravo")

    def test_a_certificate_that_is_none_stops_no_rotation(self):
        certificate = self.at / "demo/bravo/cert.pem"
        text = certificate.read_text()
        certificate.write_text("garbage")
        self.rotated_without_bravo("identity", 1)
        certificate.write_text(text)
        self.json("ca", "rotate", "demo", "--role", "identity", *NOW)
        self.assertEqual(self.current("identity"), list(NAMES))


class Full(Blocked):
    """The disk is full from some write on, and has room again later."""

    def check_rotation(self, role):
        writes = 0
        while True:
            writes += 1
            done = subprocess.run([PROGRAM, "ca", "rotate", "demo", "--role", role, *NOW], cwd=self.at, check=False,
                                  capture_output=True, text=True,
                                  env={**os.environ, "LD_PRELOAD": str(LIBRARY), "FULL_AT": str(writes)})
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, 5, done.stderr)
            self.json("ca", "rotate", "demo", "--role", role, *NOW)
            self.assertEqual(self.current(role), list(NAMES), f"full at write {writes}, then again")
        self.assertGreater(writes, 10)
        self.meet("alpha", "delta")

    def test_a_rotation_that_found_no_room_can_be_repeated(self):
        self.check_rotation("permissions")
        self.check_rotation("identity")


if __name__ == "__main__":
    main()

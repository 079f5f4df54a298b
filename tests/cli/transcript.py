"""Runs the ddssec program and looks at everything it did: output, exit code, files."""

import atexit
import functools
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import jsonschema

PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
DATA = pathlib.Path(__file__).resolve().parent.parent / "data"
SCHEMA = json.loads((DATA.parent.parent / "cli/schema/ddssec-2.schema.json").read_text())
ANSWERS = jsonschema.Draft202012Validator(SCHEMA)
NOW = ("--now", "2026-11-21T00:00:00Z")
AT_THAT_TIME = ("-attime", "1795305600")  # a day after NOW, for openssl verify and smime
ENVELOPE = ["schema", "command", "ok", "exit", "result", "diagnostics", "files_written"]


LIBRARIES = tempfile.TemporaryDirectory(prefix="ddssec-libraries-")
atexit.register(LIBRARIES.cleanup)
for name in ("libddsc.so.0.10.2", "libfastrtps.so.2.9.1"):
    (pathlib.Path(LIBRARIES.name) / name).touch()


def library_path():
    """With libraries, empty ones, whose names say which versions are installed, whatever this machine has."""
    return ":".join(filter(None, (LIBRARIES.name, os.environ.get("LD_LIBRARY_PATH"))))


def shared_library(octets):
    """A file that the dynamic loader of this machine takes for a library, and that says what the octets say."""
    header = bytearray(PROGRAM.read_bytes()[:64])
    header[16:18] = (3).to_bytes(2, sys.byteorder)  # e_type: ET_DYN
    header[56:58] = bytes(2)  # e_phnum
    header[60:62] = bytes(2)  # e_shnum
    return bytes(header) + octets


@functools.cache
def severities_of(name):
    """What `explain` says of a rule; of a code, whose severity is that of logs, the word that diagnostics have."""
    done = subprocess.run([PROGRAM, "explain", name, "--format", "json"], text=True, capture_output=True, timeout=60,
                          check=True)
    told = json.loads(done.stdout)["result"]
    words = {"critical": "error", "informational": "note", "debug": "note"}
    return [words.get(one["severity"], one["severity"]) for one in (told, *told["other_severities"])]


@functools.cache
def answers_of(command):
    """The schema of this command's answers, without the conditions on those of others: they cannot apply, and looking
    at all fifty takes longer than the command."""
    parts = [part for part in SCHEMA["allOf"] if part["if"]["properties"].get("command") in (None, {"const": command})]
    return jsonschema.Draft202012Validator({**SCHEMA, "allOf": parts})


class Transcript(unittest.TestCase):
    """Each test works in a new folder and must leave no draft in it."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="ddssec-cli-")
        self.addCleanup(self.folder.cleanup)
        self.at = pathlib.Path(self.folder.name)
        self.old_umask = os.umask(0o022)
        self.addCleanup(os.umask, self.old_umask)

    def tearDown(self):
        drafts = [p for p in self.at.rglob("*") if p.name.endswith(".new") or ".ddssec" in p.name
                  or (p.name.startswith(".") and p.is_dir())]
        self.assertEqual(drafts, [], "a command left a draft behind")

    def run_program(self, *words, exit=0, stdin="", environment=None):
        """`exit`: None takes any answer, yes or no; a tuple any of these."""
        done = subprocess.run([PROGRAM, *map(str, words)], cwd=self.at, input=stdin, text=True,
                              capture_output=True, timeout=60, check=False,
                              env={**os.environ, "LD_LIBRARY_PATH": library_path(), **(environment or {})})
        expected = (0, 1) if exit is None else exit if isinstance(exit, tuple) else (exit,)
        self.assertIn(done.returncode, expected, f"{words}: {done.stdout}{done.stderr}")
        return done

    def json(self, *words, exit=0, **more):
        done = self.run_program(*words, "--format", "json", exit=exit, **more)
        # A slow machine makes a long command report its progress.
        said = [line for line in done.stderr.splitlines() if not re.fullmatch(r"\d+ of \d+ [a-z ]+", line)]
        self.assertEqual(said, [])
        out = json.loads(done.stdout)
        wrong = jsonschema.exceptions.best_match(answers_of(out.get("command")).iter_errors(out))
        self.assertIsNone(wrong, f"{words} against cli/schema: {wrong}")
        self.assertEqual([key for key in out if key != "dry_run"], ENVELOPE)
        for one in out["diagnostics"]:
            self.assertIn(one["severity"], severities_of(one["id"]), f"{words}: explain {one['id']} says otherwise")
        self.assertEqual((out["schema"], out["exit"], out["ok"]),
                         ("ddssec/2", done.returncode, done.returncode == 0))
        return out

    def json_as_nobody(self, *words, exit):
        """As a user who owns nothing, if this one is root; the program is copied to where all may go."""
        other = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
        copy = self.at / "ddssec"
        if not copy.exists():
            shutil.copy(PROGRAM, copy)
        done = subprocess.run([copy, *map(str, words), "--format", "json"], cwd=self.at, text=True, **other,
                              capture_output=True, timeout=60, check=False)
        self.assertEqual(done.returncode, exit, f"{words}: {done.stdout}{done.stderr}")
        return json.loads(done.stdout)

    def refused(self, code, exit, *words, **more):
        """The command fails with exactly this code, says so in both forms and writes nothing."""
        before = self.files()
        done = self.run_program(*words, exit=exit, **more)
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr, rf"^error\[{code}\]: .*\n(  --> .*\n)?  hint: .+\n$")
        out = self.json(*words, exit=exit, **more)
        self.assertEqual([d["id"] for d in out["diagnostics"]], [code])
        self.assertNotIn("invalid or missing argument", done.stderr, "it does not say what is wrong")
        self.assertEqual(self.files(), before)
        return out["diagnostics"][0]

    def files(self):
        return {str(p.relative_to(self.at)): (p.lstat().st_mode & 0o777)
                for p in self.at.rglob("*") if not p.is_dir()}

    def assertMeetsSchema(self, file, schema):
        done = subprocess.run(["xmllint", "--noout", "--nonet", "--schema",
                               DATA / "dds-security-xsd" / schema, self.at / file], text=True,
                              capture_output=True, timeout=60, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def openssl(self, *words):
        return subprocess.run(["openssl", *map(str, words)], cwd=self.at, text=True,
                              capture_output=True, timeout=60, check=True).stdout


class WithDocuments(Transcript):
    """Begins with a CA, a participant's certificate, g.xml, and p.xml, which allows publishing topic a."""

    def setUp(self):
        super().setUp()
        self.run_program("governance", "new", "-o", "g.xml")
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        self.run_program("identity", "issue", "talker", "--ca", "ca", "-o", "talker", *NOW)
        self.run_program("permissions", "new", "--cert", "talker/cert.pem", "-o", "p.xml", "--publish", "a", *NOW)


class WithoutLists(Transcript):
    """Tests on folders that have no revocation list where the test is about something else: the warning of that,
    which keystore_test.py tests, is left out."""

    def json(self, *words, **more):
        out = super().json(*words, **more)
        out["diagnostics"] = [d for d in out["diagnostics"] if not d["message"].startswith("there is no crl.pem")]
        return out


main = unittest.main

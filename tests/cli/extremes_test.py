#!/usr/bin/env python3
"""Very large documents, names that deceive, clocks at the ends of time, places that are no folders or may not be
written: each gets a sentence and an exit code of the contract, and nothing is lost."""

import os
import re
import shutil
import socket
import subprocess

from transcript import NOW, PROGRAM, Transcript, main

CODES = (0, 1, 2, 3, 4, 5)
LONG = 240  # seconds that nothing may take, on the slowest of machines
OCTETS = int(os.environ.get("DDSSEC_DOCUMENT_OCTETS", "10000000"))  # of the largest documents

HEAD = ('<dds><permissions><grant name="g"><subject_name>CN=a</subject_name><validity>'
        "<not_before>2020-01-01T00:00:00Z</not_before><not_after>2037-01-01T00:00:00Z</not_after></validity>")
TAIL = "<default>DENY</default></grant></permissions></dds>"
RULE = ("<allow_rule><domains><id>0</id></domains><publish><topics><topic>rt/topic{}</topic></topics></publish>"
        "</allow_rule>")
GOVERNED = ("<dds><domain_access_rules><domain_rule><domains><id>0</id></domains>"
            "<allow_unauthenticated_participants>false</allow_unauthenticated_participants>"
            "<enable_join_access_control>true</enable_join_access_control>"
            "<discovery_protection_kind>NONE</discovery_protection_kind>"
            "<liveliness_protection_kind>NONE</liveliness_protection_kind>"
            "<rtps_protection_kind>NONE</rtps_protection_kind><topic_access_rules>{}</topic_access_rules>"
            "</domain_rule></domain_access_rules></dds>")
TOPIC_RULE = ("<topic_rule><topic_expression>rt/topic{}</topic_expression>"
              "<enable_discovery_protection>false</enable_discovery_protection>"
              "<enable_liveliness_protection>false</enable_liveliness_protection>"
              "<enable_read_access_control>true</enable_read_access_control>"
              "<enable_write_access_control>true</enable_write_access_control>"
              "<metadata_protection_kind>NONE</metadata_protection_kind>"
              "<data_protection_kind>NONE</data_protection_kind></topic_rule>")
DECEIVING = {"control": "a\x1b[31mb", "bell": "a\x07", "line": "a\nerror[usage]: b", "tab": "a\tb",
             "right to left": "a\u202etxt.exe", "isolate": "a\u2066b\u2069", "mark": "\u200fa", "zero": "a\u200bb",
             "combining": "e\u0301" + "\u0334" * 200, "not UTF-8": b"a\xff\xfeb".decode("utf-8", "surrogateescape"),
             "c1": "a\x9bb", "separator": "a\u2028b", "emoji": "\U0001f916", "long": "x" * 5000}
MISLEADING = re.compile("[\x00-\x08\x0b-\x1f\x7f\x80-\x9f\u200b\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069\ufeff]")


class Extremes(Transcript):
    def answer(self, *words, now=NOW, codes=CODES, forms=((), ("--format", "json"))):
        """Of the contract, in both forms: a sentence with a hint if it is not done."""
        for form in forms:
            done = subprocess.run([PROGRAM, *words, *now, *form], cwd=self.at, capture_output=True, timeout=LONG,
                                  check=False, stdin=subprocess.DEVNULL)
            self.assertIn(done.returncode, codes, f"{words} {now}: {done.stderr[-500:]}")
            out, said = done.stdout.decode(), done.stderr.decode()  # UTF-8, or this fails
            self.assertIsNone(MISLEADING.search(out + said), f"{words}: {out + said!r:.500}")
            if not form and done.returncode > 1:
                self.assertRegex(said, r"(?m)^error\[\w+\]: .*\n(  --> .*\n)?(  concerns: .*\n)?  hint: .+$", f"{words}")
        return done.returncode

    # Documents

    def test_documents_of_many_octets(self):
        (self.at / "p.xml").write_text(HEAD + "".join(RULE.format(i) for i in range(OCTETS // len(RULE))) + TAIL)
        (self.at / "g.xml").write_text(
            GOVERNED.format("".join(TOPIC_RULE.format(i) for i in range(OCTETS // len(TOPIC_RULE)))))
        (self.at / "deep.xml").write_text("<dds>" * (OCTETS * 3 // 20))
        (self.at / "blank.xml").write_text(HEAD + " " * OCTETS + TAIL)
        (self.at / "name.xml").write_text(HEAD + RULE.format("x" * OCTETS) + TAIL)
        self.documents("p.xml", "g.xml", "deep.xml", "blank.xml", "name.xml")

    def test_documents_of_many_rules(self):
        count = OCTETS // 100
        (self.at / "p.xml").write_text(HEAD + "".join(RULE.format(i) for i in range(count)) + TAIL)
        (self.at / "g.xml").write_text(GOVERNED.format("".join(TOPIC_RULE.format(i) for i in range(count))))
        grant = (HEAD + RULE.format("") + TAIL)[len("<dds><permissions>"):-len("</permissions></dds>")]
        (self.at / "grants.xml").write_text("<dds><permissions>" + "".join(
            grant.replace("CN=a", f"CN=a{i}") for i in range(count)) + "</permissions></dds>")
        self.documents("p.xml", "g.xml", "grants.xml")

    def documents(self, *files):
        self.run_program("ca", "create", "ca", "--no-passphrase", *NOW)
        for file in files:
            group, other = ("governance", "permissions") if file.startswith("g.") else ("permissions", "governance")
            self.answer(other, "lint", file, codes=(1, 3), forms=((),))
            for words in (("lint", file), ("show", file), ("diff", file, file),
                          ("sign", file, "--ca", "ca", "-o", f"{file}.p7s"), ("verify", f"{file}.p7s", "--ca", "ca")):
                self.answer(group, *words, codes=(0, 1, 3), forms=((),))

    # Names

    def test_names_that_deceive(self):
        self.run_program("init", "demo", *NOW)
        for why, name in DECEIVING.items():
            before = self.files()
            self.assertEqual(self.answer("init", "x", "--participant", name), 2, why)
            self.assertEqual(self.answer("identity", "issue", name, "--ca", "demo", "-o", "x"), 2, why)
            self.assertEqual(self.answer("keystore", "enclave", "demo", name), 2, why)
            self.answer("explain", name, codes=(0, 2))
            self.assertEqual(self.answer(name), 2, why)
            self.assertEqual(self.answer("init", "--" + name), 2, why)
            self.assertIn(self.answer("doctor", name), (1, 3), why)
            self.assertEqual(self.answer("ca", "show", name), 3, why)
            self.assertEqual(self.answer("governance", "lint", name), 3, why)
            self.answer("can", "demo/talker", "publish", name)
            self.answer("can", "demo/talker", "publish", "a", "--partition", name)
            self.answer("check", "demo/talker", "demo/listener", "--topics", name, "--partition", name)
            self.answer("governance", "show", "demo/talker", "--topic", name)
            self.assertEqual(self.files(), before, why)

    def test_deceiving_names_in_what_is_made(self):
        self.run_program("init", "demo", *NOW)
        for number, (why, name) in enumerate(DECEIVING.items()):
            folder = f"new{number}"
            for words in (("--publish", name), ("--subscribe", "a", "--partition", name), ("--subject", "CN=" + name)):
                code = self.answer("identity", "issue", "b", "--ca", "demo", "-o", folder, *words, codes=(0, 1, 2, 3, 4))
                if (self.at / folder).exists():
                    for read in (("identity", "show", folder), ("permissions", "show", folder), ("doctor", folder),
                                 ("expiry", folder), ("ca", "show", "demo"), ("permissions", "lint", folder)):
                        self.answer(*read)
                    shutil.rmtree(self.at / folder)
                else:
                    self.assertNotEqual(code, 0, why)
            self.answer("governance", "new", "-o", f"{folder}.xml", "--topic", f"{name}:data=NONE", codes=(0, 1, 2, 3, 4))

    def test_folders_with_names_that_deceive(self):
        for number, (why, name) in enumerate(DECEIVING.items()):
            if why == "long":
                self.assertEqual(self.answer("init", name), 5)
                continue
            (self.at / str(number)).mkdir()
            folder = os.path.join(str(number), name)
            # Made by the first of the two answers; 5: longer than a name may be.
            self.assertIn(self.answer("init", folder, codes=(0, 2, 4, 5)), (2, 4, 5), why)
            if not os.path.isdir(os.path.join(self.at, folder)):
                continue
            talker = os.path.join(folder, "talker")
            for words in (("doctor", talker), ("expiry", folder), ("ca", "show", folder), ("identity", "show", talker),
                          ("crl", "new", "--ca", folder), ("crl", "distribute", "--ca", folder),
                          ("identity", "revoke", talker, "--ca", folder), ("can", talker, "publish", "a")):
                self.answer(*words, codes=(0, 1))

    # Clocks

    def test_clocks_at_the_ends_of_time(self):
        self.run_program("init", "demo", *NOW)
        for number, now in enumerate(("1970-01-01T00:00:00Z", "1970-01-01T00:00:01Z", "1999-12-31T23:59:59Z",
                                      "2037-12-31T00:00:00Z", "2038-01-19T03:14:08Z", "2049-12-31T23:59:59Z",
                                      "2050-01-01T00:00:00Z", "2106-02-07T06:28:16Z", "2262-04-11T23:47:17Z",
                                      "9999-01-01T00:00:00Z", "9999-12-31T23:59:59Z", "9999-12-31T24:00:00Z",
                                      "9999-12-31T23:59:59-14:00", "1970-01-01T00:00:00+14:00")):
            at = ("--now", now)
            made = f"made{number}"
            for words in (("doctor", "demo/talker"), ("check", "demo/talker", "demo/listener"),
                          ("can", "demo/talker", "publish", "a"), ("identity", "show", "demo/talker"),
                          ("expiry", "demo", "--within", "100000d"), ("crl", "verify", "demo", "--ca", "demo"),
                          ("permissions", "lint", "demo/talker"), ("governance", "verify", "demo/talker", "--ca", "demo"),
                          ("ca", "create", made + "ca", "--no-passphrase"), ("init", made),
                          ("identity", "issue", "b", "--ca", "demo", "-o", made + "b", "--publish", "x"),
                          ("identity", "issue", "b", "--ca", "demo", "-o", made + "c", "--days", "36500", "--clamp"),
                          ("crl", "new", "--ca", made), ("crl", "new", "--ca", made, "--next-update", "36500"),
                          ("identity", "renew", made + "/talker", "--ca", made, "--permissions"),
                          ("governance", "new", "-o", made + ".xml"), ("ca", "rotate", made, "--role", "identity")):
                self.answer(*words, now=at)
            if (self.at / made).is_dir():  # what was made then is good then
                self.assertEqual(self.answer("identity", "show", made + "/talker", now=at), 0, now)
                self.assertEqual(self.answer("check", made + "/talker", made + "/listener", now=at), 0, now)

    def test_times_that_are_none(self):
        for now in ("", "0", "now", "1969-12-31T23:59:59Z", "0000-01-01T00:00:00Z", "10000-01-01T00:00:00Z",
                    "-0001-01-01T00:00:00Z", "2026-02-30T00:00:00Z", "2026-02-30", "2026-11-2", "+", "+-1d", "-100000d", "--1d", "2026-11-21T25:00:00Z",
                    "2026-11-21T00:00:60Z", "99999999999999999999", "2026-11-21T00:00:00Z\n", "2026-11-21T00:00:00+15:00"):
            self.assertEqual(self.answer("version", now=(f"--now={now}",)), 2, now)

    def test_certificates_valid_from_1950_or_until_9999(self):
        (self.at / "ca.conf").write_text("[ca]\ndefault_ca=d\n[d]\ndatabase=index\nserial=serial\nnew_certs_dir=.\n"
                                         "default_md=sha256\npolicy=p\nunique_subject=no\n[p]\ncommonName=supplied\n"
                                         "[v]\nbasicConstraints=critical,CA:true\nkeyUsage=critical,keyCertSign,cRLSign\n")
        for number, (begin, end) in enumerate((("500101000000Z", "491231235959Z"), ("19500101000000Z", "99991231235959Z"),
                                               ("00010101000000Z", "00011231235959Z"), ("99991231235958Z", "99991231235959Z"))):
            made = self.at / f"c{number}"
            made.mkdir()
            (self.at / "index").write_text("")
            (self.at / "serial").write_text("01\n")
            self.openssl("req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", "/CN=x",
                         "-keyout", made / "ca.key.pem", "-out", made / "request.pem")
            self.openssl("ca", "-config", "ca.conf", "-batch", "-selfsign", "-keyfile", made / "ca.key.pem", "-extensions",
                         "v", "-in", made / "request.pem", "-startdate", begin, "-enddate", end, "-notext", "-out",
                         made / "ca.pem")
            (made / "ca.key.pem").chmod(0o600)
            for words in (("identity", "show", f"c{number}/ca.pem"), ("ca", "show", f"c{number}"), ("expiry", f"c{number}"),
                          ("identity", "issue", "b", "--ca", f"c{number}", "-o", f"b{number}", "--clamp"),
                          ("crl", "new", "--ca", f"c{number}"), ("crl", "new", "--ca", f"c{number}", "--next-update", "36500"),
                          ("ca", "renew", f"c{number}"), ("doctor", f"b{number}")):
                self.answer(*words)

    # Places

    def places(self):
        self.run_program("init", "demo", *NOW)
        (self.at / "file").write_text("mine")
        (self.at / "linked").symlink_to("demo")
        os.mkfifo(self.at / "pipe")
        listening = socket.socket(socket.AF_UNIX)
        self.addCleanup(listening.close)
        before = os.getcwd()
        os.chdir(self.at)  # a socket's path must be short
        listening.bind("socket")
        os.chdir(before)

    def test_sockets_pipes_files_and_links_where_folders_belong(self):
        self.places()
        before = self.files()
        for place in ("socket", "file", "pipe", "file/below", "socket/below", "linked", "/dev/null", "/proc/self/mem", "/"):
            for words in (("init", place), ("ca", "create", place, "--no-passphrase"), ("keystore", "create", place, "--no-passphrase"),
                          ("identity", "issue", "b", "--ca", "demo", "-o", place), ("identity", "csr", "b", "-o", place),
                          ("identity", "issue", "b", "--ca", "demo", "-o", place, "--replace"),
                          ("governance", "new", "-o", place), ("governance", "new", "-o", place, "--replace")):
                if place == "/" and words[0] == "identity":
                    continue
                if place == "file" and words[0] == "governance" and words[-1] == "--replace":
                    continue  # a plain file is what that is for
                self.assertIn(self.answer(*words), (4, 5), f"{words}")
        for place in ("socket", "file", "pipe", "file/below", "/dev/null", "nowhere"):
            for words in (("doctor", place), ("ca", "show", place), ("check", place, "demo/talker"), ("check", "demo/talker", place),
                          ("expiry", place), ("identity", "show", place), ("keystore", "list", place), ("crl", "new", "--ca", place),
                          ("identity", "issue", "b", "--ca", place, "-o", "x"), ("permissions", "show", place),
                          ("inspect", place), ("crl", "distribute", place, "--ca", "demo")):
                if place == "pipe" and words[0] in ("identity", "ca", "inspect", "permissions", "expiry"):
                    continue
                self.assertNotEqual(self.answer(*words), 0, f"{words}")
        self.assertEqual(self.files(), before)
        self.assertEqual((self.at / "file").read_text(), "mine")
        self.assertEqual(self.answer("doctor", "linked/talker"), 0)  # a link that leads somewhere is read

    def as_nobody(self, *words):
        other = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
        copy = self.at / "ddssec"
        if not copy.exists():
            shutil.copy(PROGRAM, copy)
        return subprocess.run([copy, *words, *NOW], cwd=self.at, text=True, **other, capture_output=True, timeout=LONG,
                              check=False, stdin=subprocess.DEVNULL)

    def test_places_that_may_not_be_written_or_read(self):
        self.run_program("init", "demo", *NOW)
        self.at.chmod(0o755)
        for path in (self.at / "demo").rglob("*.key.pem"):
            path.chmod(0o644)  # readable: what fails is the writing
        (self.at / "closed").mkdir(mode=0o700)
        for path in [self.at, *self.at.rglob("*")]:
            if path.is_dir() and path.name != "closed":
                path.chmod(0o555)
        self.addCleanup(self.at.chmod, 0o755)
        before = self.files()
        ca = ("--ca", "demo", "--insecure-key-mode")
        for words in (("init", "x"), ("ca", "create", "x", "--no-passphrase"), ("keystore", "create", "x", "--no-passphrase"),
                      ("identity", "issue", "b", *ca, "-o", "x"), ("identity", "csr", "b", "-o", "x"),
                      ("identity", "issue", "talker", *ca, "-o", "demo/talker", "--replace"),
                      ("governance", "new", "-o", "x.xml"), ("crl", "new", *ca), ("crl", "distribute", "--ca", "demo"),
                      ("identity", "revoke", "demo/talker", *ca), ("identity", "renew", "demo/talker", *ca)):
            done = self.as_nobody(*words)
            self.assertIn(done.returncode, (1, 4, 5), f"{words}: {done.stderr}")
            self.assertRegex(done.stderr, r"error\[\w+\]: .*\n(  --> .*\n)?  hint: .+", f"{words}")
        for words in (("doctor", "closed"), ("ca", "show", "closed"), ("expiry", "closed"), ("keystore", "list", "closed"),
                      ("identity", "show", "closed"), ("check", "closed", "demo/talker"),
                      ("identity", "issue", "b", "--ca", "closed", "-o", "closed/b"), ("init", "closed/x")):
            done = self.as_nobody(*words)
            self.assertIn(done.returncode, (1, 3, 5), f"{words}: {done.stderr}")
            self.assertRegex(done.stderr, r"error\[\w+\]: .*\n(  --> .*\n)?  hint: .+", f"{words}")
        copied = {name: mode for name, mode in self.files().items() if name != "ddssec"}
        self.assertEqual(copied, before)

    def test_a_draft_of_a_killed_process_with_the_same_number_is_passed_over(self):
        self.run_program("init", "demo", *NOW)
        script = 'echo old > "demo/talker/crl.pem.$$.$(stat -Lc %i /proc/self/ns/pid).new"; exec "$0" "$@"'
        done = subprocess.run(["sh", "-c", script, PROGRAM, "crl", "distribute", "--ca", "demo", *NOW], cwd=self.at,
                              text=True, capture_output=True, timeout=LONG, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        left = list((self.at / "demo/talker").glob("crl.pem.*.new"))
        self.assertEqual([p.read_text() for p in left], ["old\n"])
        for path in left:
            path.unlink()


if __name__ == "__main__":
    main()

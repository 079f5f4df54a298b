#!/usr/bin/env python3
"""trust status of real participants, embedded and of Cyclone DDS on our plugins: a renewal, a broken document, a good one.

Usage: trust_status_live_test.py DDSSEC DROPIN; ddssec-peer and cyclone_peer stand beside the program.
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time

DROPIN = pathlib.Path(sys.argv.pop(2)).resolve()

from products import FILES  # noqa: E402
from transcript import PROGRAM, Transcript, main  # noqa: E402

LONGEST = 60  # seconds until a change is seen: files are looked at every second, and a refusal takes two looks
KINDS = {"identity certificate", "identity CA", "revocation list", "permissions CA", "permissions", "governance"}
BESIDE = {"renewal list", "listed permissions", "OCSP response"}


class Running(Transcript):
    """A participant whose folder is demo/talker."""

    def setUp(self):
        super().setUp()
        self.run_program("init", "demo")
        self.folder, self.status = self.at / "demo/talker", self.at / "status"
        self.status.mkdir(mode=0o700)

    def start(self, **variables):
        log = open(self.at / "log", "ab")
        self.addCleanup(log.close)
        environment = {**os.environ, "DDSSEC_STATUS_DIR": str(self.status), **variables}
        environment.pop("CYCLONEDDS_URI", None)
        process = subprocess.Popen([str(word) for word in self.command], env=environment, stdout=log, stderr=log)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def ask(self, *words):
        """The answer, whatever its exit code is."""
        done = subprocess.run([PROGRAM, "trust", "status", *map(str, words), "--status-dir", "status", "--format", "json"],
                              cwd=self.at, text=True, capture_output=True, timeout=60, check=False)
        return json.loads(done.stdout)

    def until(self, what, holds, *words):
        end = time.monotonic() + LONGEST
        while True:
            told = self.ask(*words)
            found = [one for process in told["result"].get("processes", []) for one in process["participants"]]
            documents = {d["kind"]: d for one in found for d in one["documents"]}
            self.found = found
            if len(found) == 1 and holds(documents):
                return told, documents
            self.assertLess(time.monotonic(), end, f"{what}: {told}\n{(self.at / 'log').read_text()}")
            time.sleep(0.2)

    def story(self, process):
        begun, first = self.until("the first answer", lambda d: KINDS <= set(d), "demo/talker")
        self.assertEqual(begun["exit"], 0)
        self.assertEqual({one["state"] for one in first.values()}, {"current"})
        (shown,) = begun["result"]["processes"]
        self.assertEqual(shown["pid"], process.pid)
        self.assertEqual(shown["participants"][0]["subject"], "CN=talker")
        self.assertNotEqual(shown["participants"][0]["guid"], "")
        for kind, file in (("identity certificate", "cert.pem"), ("identity CA", "identity_ca.pem"),
                           ("permissions CA", "permissions_ca.pem"), ("permissions", "permissions.p7s"),
                           ("governance", "governance.p7s")):
            self.assertEqual(os.path.realpath(first[kind]["file"]), str(self.folder / file))
        identity = self.json("identity", "show", "demo/talker")["result"]
        certificate = first["identity certificate"]["in_force"][0]
        self.assertEqual([certificate[name] for name in ("number", "until")],
                         [identity["serial"], identity["not_after"]])

        serial = self.json("identity", "renew", "demo/talker", "--ca", "demo", "--permissions",
                           "--days", "700")["result"]["serial"]
        _, renewed = self.until("the renewal", lambda d: d["identity certificate"]["in_force"][0]["number"] == serial
                                and d["permissions"]["since"] > first["permissions"]["since"], "--pid", process.pid)
        self.assertGreater(renewed["identity certificate"]["since"], first["identity certificate"]["since"])

        self.run_program("identity", "renew", "demo/listener", "--ca", "demo", "--permissions", "--days", "700")
        self.run_program("crl", "distribute", "--ca", "demo")
        self.put("ocsp.der", self.ocsp_response())
        more, documents = self.until("the renewal list and the OCSP response", lambda d: BESIDE <= set(d), "demo/talker")
        self.assertEqual(more["exit"], 0)
        for kind, file in (("renewal list", "renewed.pem"), ("listed permissions", "renewed.pem"), ("OCSP response", "ocsp.der")):
            self.assertEqual(os.path.realpath(documents[kind]["file"]), str(self.folder / file))
            self.assertTrue(all(part["until"] for part in documents[kind]["in_force"]), documents[kind])
        for kind in ("renewal list", "listed permissions"):
            self.assertIn("CN=listener", {part["subject"] for part in documents[kind]["in_force"]})

        good = {name: (self.folder / name).read_bytes() for name in ("permissions.p7s", "identity_ca.pem")}
        self.put("permissions.p7s", b"broken")
        self.put("identity_ca.pem", (self.folder / "permissions_ca.pem").read_bytes())
        broken, documents = self.until("the refusals", lambda d: d["permissions"]["refused"] and
                                       d["identity CA"]["refused"], "demo/talker")
        self.assertEqual(broken["exit"], 1)
        for kind, file in (("permissions", "permissions.p7s"), ("identity CA", "identity_ca.pem")):
            refused = documents[kind]["refused"]
            self.assertTrue(refused["stands"])
            self.assertEqual(documents[kind]["state"], "refused")
            self.assertEqual(os.path.realpath(refused["file"]), str(self.folder / file))
            self.assertIn(f"[{refused['name']} {refused['code']}]", refused["sentence"])
            self.assertEqual(documents[kind]["in_force"], renewed[kind]["in_force"])
        self.assertEqual({documents[kind]["refused"]["name"] for kind in ("permissions", "identity CA")},
                         {"permissions_renewal_refused", "identity_ca_renewal_refused"})
        told = self.run_program("trust", "status", "--pid", process.pid, "--status-dir", "status", exit=1).stdout
        self.assertIn("REFUSED at", told)

        for name, octets in good.items():
            self.put(name, octets)
        after, documents = self.until("the good ones", lambda d: not d["permissions"]["refused"]["stands"] and
                                      not d["identity CA"]["refused"]["stands"], "demo/talker")
        self.assertEqual(after["exit"], 0)
        self.assertEqual({one["state"] for one in documents.values()}, {"current"})
        for secret in ("PRIVATE", "key.pem"):
            self.assertNotIn(secret, str(after))

        self.run_program("identity", "revoke", "demo/talker", "--ca", "demo")
        self.put("crl.pem", (self.at / "demo/ca/identity/crl.pem").read_bytes())
        ended, _ = self.until("the revocation", lambda d: self.found[0]["cut_off"], "demo/talker")
        self.assertEqual((ended["exit"], self.found[0]["cut_off"]["name"]), (1, "certificate_revoked"))

        self.assertIsNone(process.poll(), (self.at / "log").read_text())
        process.send_signal(signal.SIGTERM)
        process.wait(timeout=30)
        self.assertEqual(list(self.status.iterdir()), [], "it left its socket")
        self.refused_now("status_process_ended", process.pid)

    def ocsp_response(self):
        """Of the identity CA, about the talker's certificate."""
        serial = self.json("identity", "show", "demo/talker")["result"]["serial"]
        (self.at / "index").write_text(f"V\t400101000000Z\t\t{serial.replace(':', '')}\tunknown\t/CN=talker\n")
        ca = self.at / "demo/ca/identity"
        issuer = ca / "ca.pem"
        subprocess.run(["openssl", "ocsp", "-index", "index", "-CA", issuer, "-rsigner", issuer, "-rkey", ca / "ca.key.pem",
                        "-issuer", issuer, "-cert", self.folder / "cert.pem", "-no_nonce", "-rmd", "sha256", "-ndays", "1",
                        "-respout", "ocsp.der"], cwd=self.at, check=True, capture_output=True)
        return (self.at / "ocsp.der").read_bytes()

    def refused_now(self, code, pid):
        told = self.run_program("trust", "status", "--pid", pid, "--status-dir", "status", exit=3).stderr
        self.assertIn(f"error[{code}]", told)

    def put(self, name, octets):
        (self.folder / "part").write_bytes(octets)
        os.replace(self.folder / "part", self.folder / name)


class Embedded(Running):
    @property
    def command(self):
        (self.folder / "security.properties").write_text("org.ddssec.files_poll_interval = 1\n")
        return [PROGRAM.parent / "ddssec-peer", "--role", "sub", "--domain", "0", "--timeout", "200", "--security",
                self.folder]

    def test_documents_are_followed(self):
        self.story(self.start())

    def test_without_the_variable_there_is_no_socket(self):
        process = self.start(DDSSEC_STATUS_DIR="")
        time.sleep(2)
        self.assertIsNone(process.poll())
        self.assertEqual(list(self.status.iterdir()), [])
        self.refused_now("status_not_shown", process.pid)

    def test_folder_that_others_can_write_to_stops_only_the_socket(self):
        self.status.chmod(0o777)
        process = self.start()
        log = self.at / "log"
        end = time.monotonic() + LONGEST
        while "status_not_served 1627" not in log.read_text():
            self.assertLess(time.monotonic(), end, log.read_text())
            time.sleep(0.2)
        self.assertIsNone(process.poll())
        self.assertEqual(list(self.status.iterdir()), [])


class CycloneDds(Running):
    @property
    def command(self):
        files = [part for option, file in FILES.items() if (self.folder / file).exists()
                 for part in ("--" + option, self.folder / file)]
        return [PROGRAM.parent / "cyclone_peer", "--subscribe", "--topic", "Square", "--timeout", "200", *files]

    def test_documents_are_followed(self):
        properties = self.at / "properties"
        properties.write_text("org.ddssec.files_poll_interval = 1\n")
        self.story(self.start(LD_LIBRARY_PATH=str(DROPIN), DDSSEC_PROPERTIES=str(properties)))

    def test_killed_process_leaves_a_socket_that_says_it_ended(self):
        process = self.start(LD_LIBRARY_PATH=str(DROPIN))
        self.until("the first answer", lambda d: "permissions" in d, "demo/talker")
        self.assertEqual(len(list(self.status.iterdir())), 2, "one of each library")
        process.kill()
        process.wait()
        self.assertNotEqual(list(self.status.iterdir()), [])
        self.refused_now("status_process_ended", process.pid)


if __name__ == "__main__":
    main()

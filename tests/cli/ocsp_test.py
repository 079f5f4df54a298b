#!/usr/bin/env python3
"""identity ocsp against `openssl ocsp` on the loopback, and what doctor and check say of responses."""

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import threading
import time

from agent_daemon_test import workers_of
from agent_folders import checked_events
from ocsp_responder import index_line, responder
from transcript import PROGRAM, Transcript, library_path, main

CONTENT_TYPE = "Content-type: application/ocsp-response"


ASK = ("identity", "ocsp", "demo/talker", "--url")


class Ocsp(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "--participant", "talker", "--participant", "listener")
        self.ca = self.at / "demo/ca/identity"

    def serial(self, name):
        return self.openssl("x509", "-in", f"demo/{name}/cert.pem", "-noout", "-serial").strip().split("=")[1]

    def index(self, **states):
        """The responder's list of certificates; others are unknown to it."""
        (self.at / "index").write_text(
            "".join(index_line(state, self.serial(name), name) for name, state in states.items()))

    def responder(self, *more):
        return responder(self.at / "index", self.ca, *more)

    @contextlib.contextmanager
    def server(self, answer):
        """A server that answers every request with these octets, or not at all (None)."""
        done = threading.Event()

        def serve(listener):
            while not done.is_set():
                with contextlib.suppress(OSError):
                    peer, _ = listener.accept()
                    with peer:
                        peer.settimeout(20)
                        peer.recv(65536)
                        if answer is not None:
                            peer.sendall(answer)
                            peer.shutdown(socket.SHUT_WR)
                        peer.recv(65536)  # until the other side gives up

        with socket.create_server(("127.0.0.1", 0)) as listener:
            listener.settimeout(0.2)
            thread = threading.Thread(target=serve, args=(listener,))
            thread.start()
            try:
                yield f"http://127.0.0.1:{listener.getsockname()[1]}/"
            finally:
                done.set()
                thread.join()

    def fetch(self, url):
        return self.json(*ASK, url)

    def not_good(self, code, url):
        """The responder's answer is judged so, and no file changes."""
        before = self.files()
        (told,) = self.json(*ASK, url, exit=1)["diagnostics"]
        self.assertEqual((told["id"], told["severity"], self.files()), (code, "error", before))
        self.assertTrue(self.run_program(*ASK, url, exit=1).stderr.startswith(f"error[{code}]: "))
        explained = self.json("explain", code)["result"]
        self.assertIn("error", [explained["severity"], *(one["severity"] for one in explained["other_severities"])])
        return told["message"]

    def set_property(self, name, text):
        (self.at / f"demo/{name}/security.properties").write_text(text)

    def test_a_good_answer_lies_beside_the_certificate(self):
        self.index(talker="V")
        with self.responder() as url:
            answer = self.fetch(url)
            self.assertEqual(self.fetch(url)["result"]["url"], url)  # once more, in place of the first
        file = self.at / "demo/talker/ocsp.der"
        self.assertEqual(answer["files_written"][0]["path"], "demo/talker/ocsp.der")
        told = self.openssl("ocsp", "-respin", file, "-CAfile", self.ca / "ca.pem", "-issuer", self.ca / "ca.pem",
                            "-cert", "demo/talker/cert.pem", "-no_nonce")
        self.assertIn("demo/talker/cert.pem: good", told)
        doctor = self.json("doctor", "demo/talker", exit=None)
        self.assertFalse([one for one in doctor["diagnostics"] if one["id"] == "DOC112"])

    def test_a_revoked_or_unknown_certificate_gets_no_file(self):
        self.index(talker="R")
        with self.responder() as url:
            self.assertRegex(self.not_good("ocsp_revoked", url), "keyCompromise")
        self.index(listener="V")
        with self.responder() as url:
            self.not_good("ocsp_unknown", url)
        self.assertNotIn("demo/talker/ocsp.der", self.files())

    def test_a_responder_of_another_ca_is_not_believed(self):
        self.run_program("init", "other", "--participant", "x")
        self.index(talker="V")
        stranger = self.at / "other/ca/identity"
        with self.responder("-rsigner", stranger / "ca.pem", "-rkey", stranger / "ca.key.pem") as url:
            self.not_good("ocsp_signer_wrong", url)
        self.assertNotIn("demo/talker/ocsp.der", self.files())

    def test_what_is_no_answer_is_refused_in_time(self):
        with self.server(b"HTTP/1.0 404 Not Found\r\n\r\n") as url:
            self.refused("ocsp_fetch_failed", 1, *ASK, url)
        with self.server(b"HTTP/1.0 200 OK\r\nContent-type: text/html\r\n\r\n<html>") as url:
            self.refused("ocsp_fetch_failed", 1, *ASK, url)
        with self.server(f"HTTP/1.0 200 OK\r\n{CONTENT_TYPE}\r\n\r\n".encode() + b"\x30\x03\x0a\x01\x03") as url:
            self.not_good("ocsp_not_successful", url)
        with self.server(f"HTTP/1.0 200 OK\r\n{CONTENT_TYPE}\r\n\r\n".encode() + b"\x30\x82\xff\xff" + bytes(70000)) as url:
            self.refused("ocsp_fetch_failed", 1, *ASK, url)
        with self.server(b"HTTP/1.0 302 Found\r\nLocation: http://127.0.0.1:1/\r\n\r\n") as url:
            self.refused("ocsp_fetch_failed", 1, *ASK, url)
        with self.server(None) as url:
            self.refused("ocsp_fetch_failed", 1, *ASK, url, "--timeout", "1")
        with socket.create_server(("127.0.0.1", 0)) as gone:
            url = f"http://127.0.0.1:{gone.getsockname()[1]}/"
        self.refused("ocsp_fetch_failed", 1, *ASK, url, "--timeout", "1")
        for url in ("https://127.0.0.1/", "ftp://127.0.0.1/", "nonsense", "http://"):
            self.refused("ocsp_fetch_failed", 1, *ASK, url)

    def test_a_recorded_answer_does_not_replace_a_later_one(self):
        self.index(talker="V")
        with self.responder() as url:
            self.fetch(url)
            first = (self.at / "demo/talker/ocsp.der").read_bytes()
            time.sleep(1.1)  # it counts in seconds
            self.fetch(url)
        head = f"HTTP/1.0 200 OK\r\n{CONTENT_TYPE}\r\n\r\n".encode()
        with self.server(head + first) as url:
            self.assertRegex(self.not_good("ocsp_expired", url), "not before .*recorded")
            (self.at / "demo/talker/ocsp.der").unlink()
            self.json(*ASK, url, "--now", "+49h", exit=1)  # at its end
            self.assertNotIn("demo/talker/ocsp.der", self.files())
            self.fetch(url)

    def test_a_line_break_in_a_url_is_refused(self):
        with self.server(None) as url:
            for path in ("x HTTP/1.1\r\nHost: inner", "a b", "\x1b"):
                told = self.refused("ocsp_fetch_failed", 1, *ASK, url + path)
                self.assertIn("printable", told["message"])

    def test_a_certificate_that_names_no_responder_needs_a_url(self):
        self.refused("ocsp_no_responder", 1, "identity", "ocsp", "demo/talker")

    def name_responder(self, url, name="talker", ca=None):
        """A certificate that names this responder, with the serial number of the former one."""
        ca = ca or self.ca
        extensions = self.at / "extensions"
        extensions.write_text(f"keyUsage=critical,digitalSignature\nauthorityInfoAccess=OCSP;URI:{url}\n")
        self.openssl("req", "-new", "-key", f"demo/{name}/key.pem", "-subj", f"/CN={name}", "-out", "request.pem")
        self.openssl("x509", "-req", "-sha256", "-in", "request.pem", "-CA", ca / "ca.pem", "-CAkey", ca / "ca.key.pem",
                     "-set_serial", "0x" + self.serial(name), "-days", "30", "-extfile", extensions,
                     "-out", f"demo/{name}/cert.pem")

    def test_a_certificate_that_names_a_responder_needs_no_url(self):
        self.index(talker="V")
        with self.responder() as url:
            self.name_responder(url)
            self.assertEqual(self.json("identity", "ocsp", "demo/talker")["result"]["url"], url)

    def agent(self, *more, exit=0):
        answer = self.json("agent", "demo/talker", "--ca", "demo", "--once", *more, exit=exit)
        (event,) = answer["result"]["events"]
        return answer, event

    def test_the_agent_fetches_at_half_of_the_life_of_the_response(self):
        _, event = self.agent()
        self.assertNotIn("ocsp_until", event)  # the certificate names no responder
        self.index(talker="V")
        with self.responder() as url:
            self.name_responder(url)
            self.assertNotIn("ocsp_until", self.agent("--dry-run")[1])
            answer, event = self.agent()
            self.assertEqual(event["event"], "ocsp_renewed")
            self.assertEqual([file["path"] for file in answer["files_written"]], ["demo/talker/ocsp.der"])
            self.assertLess(event["next"], event["ocsp_until"])
            first = (self.at / "demo/talker/ocsp.der").read_bytes()
            self.assertEqual(self.agent("--now", "+20h")[1]["event"], "current")
            self.assertEqual((self.at / "demo/talker/ocsp.der").read_bytes(), first)
            self.assertEqual(self.agent("--now", "+25h")[1]["event"], "ocsp_renewed")
        answer, event = self.agent("--now", "+30h", exit=1)
        self.assertEqual((event["event"], event["problem"]["code"]), ("current", "ocsp_fetch_failed"))
        self.assertIn("ocsp_fetch_failed", [one["id"] for one in answer["diagnostics"]])

    def test_the_agent_fetches_a_response_though_the_ca_refuses_the_renewal(self):
        """Peers that demand a response would refuse the participant, although its certificate is valid."""
        self.index(talker="V")
        with self.responder() as url:
            self.name_responder(url)
            self.run_program("permissions", "new", "--cert", "demo/talker/cert.pem", "--publish", "x", "--days", "2", "--sign",
                             "--ca", "demo", "-o", "demo/talker/permissions.xml", "--replace")  # so a renewal is due
            (self.ca / "issued.jsonl").write_text("")
            answer, event = self.agent("--permissions", exit=1)
        self.assertEqual((event["event"], event["code"]), ("failed", "certificate_unlogged"))
        self.assertEqual([file["path"] for file in answer["files_written"]], ["demo/talker/ocsp.der"])

    def events_if_killed_at_the_look_up(self, prepare):
        """The events of an agent whose process for the folder is killed while it asks the responder."""
        with socket.create_server(("127.0.0.1", 0)) as listener:
            self.run_program("identity", "issue", "third", "--ca", "demo", "-o", "demo/third", "--ocsp-responder",
                             f"http://127.0.0.1:{listener.getsockname()[1]}/")
            prepare(self.at / "demo/third")
            agent = subprocess.Popen([PROGRAM, "agent", "demo/third", "--ca", "demo", "--once", "--now", "+300d"], cwd=self.at,
                                     env={**os.environ, "LD_LIBRARY_PATH": library_path()}, text=True, stdout=subprocess.PIPE,
                                     stderr=subprocess.DEVNULL)
            self.addCleanup(agent.kill)
            listener.settimeout(30)
            with listener.accept()[0]:
                worker, = workers_of(agent)
                os.kill(worker, signal.SIGKILL)
                return checked_events(agent.communicate(timeout=30)[0])

    def test_the_agent_reports_a_renewal_whose_process_is_killed_after_it(self):
        event, = self.events_if_killed_at_the_look_up(lambda folder: None)
        self.assertEqual((event["event"], event["problem"]["code"]), ("renewed", "internal"))
        self.assertIn("it has ended", event["problem"]["message"])

    def test_the_agent_reports_the_error_of_a_renewal_though_its_process_is_killed_after_it(self):
        key = self.at / "demo/talker/key.pem"
        event, = self.events_if_killed_at_the_look_up(lambda folder: shutil.copy(key, folder / "key.pem"))
        self.assertEqual((event["event"], event["code"]), ("failed", "key_mismatch"))

    def test_the_agent_asks_no_responder_for_a_certificate_of_another_ca(self):
        self.run_program("init", "other", "--participant", "x")
        stranger = self.at / "other/ca/identity"
        shutil.copy(stranger / "ca.pem", self.at / "demo/talker/identity_ca.pem")
        (self.at / "demo/talker/crl.pem").unlink()  # it is of the former CA
        with socket.create_server(("127.0.0.1", 0)) as listener:
            self.name_responder(f"http://127.0.0.1:{listener.getsockname()[1]}/", ca=stranger)
            answer, event = self.agent(exit=1)
            self.assertEqual(event["problem"]["code"], "issuer_unknown")
            self.assertRegex(event["problem"]["message"], "a CA of --ca.*is not asked")
            listener.settimeout(0.2)
            with self.assertRaises(TimeoutError):
                listener.accept()
        self.assertNotIn("demo/talker/ocsp.der", self.files())

    def test_the_agent_waits_once_for_a_responder_that_does_not_answer(self):
        with self.server(None) as url:
            for name in ("talker", "listener"):
                self.name_responder(url, name)
            begin = time.monotonic()
            answer = self.json("agent", "demo/talker", "demo/listener", "--ca", "demo", "--once", exit=1)
            self.assertLess(time.monotonic() - begin, 18)  # a request takes 10 s
        first, second = (event["problem"] for event in answer["result"]["events"])
        self.assertEqual((first["code"], second["code"]), ("ocsp_fetch_failed", "ocsp_fetch_failed"))
        self.assertRegex(second["message"], "another folder's request")
        self.assertNotIn("ocsp_silent", str(answer))

    def test_a_certificate_names_the_responder_that_was_asked_for_and_so_do_those_that_follow(self):
        url = "http://ocsp.example:8888/a,b?c=d"

        def named(folder):
            return self.openssl("x509", "-in", f"{folder}/cert.pem", "-noout", "-ocsp_uri").strip()
        self.run_program("identity", "issue", "third", "--ca", "demo", "-o", "demo/third", "--ocsp-responder", url)
        self.assertEqual(named("demo/third"), url)
        self.run_program("identity", "renew", "demo/third", "--ca", "demo", "--rekey")
        self.assertEqual(named("demo/third"), url)
        self.json("agent", "demo/third", "--ca", "demo", "--once", "--days", "500", "--now", "+300d", exit=None)
        self.assertEqual(named("demo/third"), url)
        self.assertEqual(named("demo/talker"), "")
        self.run_program("identity", "csr", "fourth", "-o", "fourth")
        self.run_program("identity", "sign-csr", "fourth", "--ca", "demo", "--yes", "--ocsp-responder", url)
        self.assertEqual(named("fourth"), url)
        for wrong in ("https://ocsp.example/", "ocsp.example", "http://a b/", "http://" + 600 * "a"):
            self.refused("usage", 2, "identity", "issue", "x", "--ca", "demo", "-o", "x", "--ocsp-responder", wrong)

    def test_expiry_lists_the_response(self):
        def told(*more, exit=0):
            entries = self.json("expiry", "demo/talker", *more, exit=exit)["result"]["entries"]
            (one,) = [one for one in entries if one["kind"] == "OCSP response"]
            return one
        self.index(talker="V")
        with self.responder() as url:
            self.fetch(url)
        self.assertEqual([told()[name] for name in ("state", "subject", "places")], ["ok", "CN=talker", 1])
        self.assertEqual(told("--now", "+20h")["state"], "ok")  # it lasts for two days
        self.assertEqual(told("--now", "+25h", exit=1)["state"], "soon")
        self.assertEqual(told("--now", "+25h", "--within", "12h")["state"], "ok")
        self.assertEqual(told("--now", "+49h", exit=1)["state"], "expired")
        (self.at / "demo/talker/ocsp.der").write_bytes(b"nothing")
        answer = self.json("expiry", "demo/talker", exit=3)
        self.assertEqual([one["id"] for one in answer["diagnostics"]], ["ocsp_malformed"])

    def test_doctor_says_what_is_wrong_with_the_response(self):
        self.index(talker="V", listener="V")
        with self.responder() as url:
            self.run_program("identity", "ocsp", "demo/listener", "--url", url)
        listener = (self.at / "demo/listener/ocsp.der").read_bytes()
        (self.at / "demo/talker/ocsp.der").write_bytes(listener)
        (told,) = self.about("talker", "DOC112")
        self.assertEqual(told["severity"], "warning")
        self.assertRegex(told["message"], "^ocsp.der: the OCSP response is about another certificate")
        self.assertFalse(self.about("listener", "DOC112"))
        (told,) = self.about("listener", "DOC112", "--now", "2099-01-01T00:00:00Z")[:1]
        self.assertRegex(told["message"], "is out of date")
        (self.at / "demo/talker/ocsp.der").unlink()
        self.set_property("talker", "org.ddssec.auth.ocsp = strict\n")
        (told,) = self.about("talker", "DOC112")
        self.assertEqual(told["severity"], "error")
        self.assertRegex(told["message"], "ignore, soft or hard")

    def about(self, name, rule, *more):
        answer = self.json("doctor", f"demo/{name}", *more, exit=None)
        return [one for one in answer["diagnostics"] if one["id"] == rule]

    def test_check_knows_that_a_side_demands_a_response(self):
        talk = ("check", "demo/talker", "demo/listener")
        self.assertTrue(self.json(*talk)["result"]["talk"])
        self.set_property("listener", "org.ddssec.auth.ocsp = hard\n")
        answer = self.json(*talk, exit=1)
        self.assertFalse(answer["result"]["talk"])
        (told,) = [one for one in answer["diagnostics"] if one["id"] == "DOC113"]
        self.assertRegex(told["message"], "listener demands an OCSP response .*, and talker has none .*: there is no ocsp.der$")
        self.index(talker="V")
        with self.responder() as url:
            self.fetch(url)
        self.assertTrue(self.json(*talk)["result"]["talk"])
        # The side that demands it judges with its own lists.
        self.openssl("req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", "/CN=delegate",
                     "-keyout", "delegate.key", "-out", "delegate.csr")
        (self.at / "delegate.ext").write_text("keyUsage=critical,digitalSignature\nextendedKeyUsage=OCSPSigning\n")
        self.openssl("x509", "-req", "-sha256", "-in", "delegate.csr", "-CA", self.ca / "ca.pem", "-CAkey", self.ca / "ca.key.pem",
                     "-set_serial", "77", "-days", "30", "-extfile", "delegate.ext", "-out", "delegate.pem")
        with responder(self.at / "index", self.ca, "-rsigner", self.at / "delegate.pem", "-rkey", self.at / "delegate.key") as url:
            self.fetch(url)
        self.assertTrue(self.json(*talk)["result"]["talk"])
        self.run_program("identity", "revoke", "delegate.pem", "--ca", "demo", "--subject", "CN=delegate")
        shutil.copy(self.ca / "crl.pem", self.at / "demo/listener/crl.pem")
        answer = self.json(*talk, exit=1)
        self.assertIn("DOC113", [one["id"] for one in answer["diagnostics"]])
        self.index(talker="V")
        with self.responder() as url:
            self.fetch(url)
        answer = self.json(*talk, "--vendor", "A=cyclonedds", exit=1)
        (told,) = [one for one in answer["diagnostics"] if one["id"] == "DOC113"]
        self.assertRegex(told["message"], "Cyclone DDS 0.10.2 sends none")


if __name__ == "__main__":
    main()

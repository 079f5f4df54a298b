#!/usr/bin/env python3
"""trust status: what it shows of processes that answer, and what it says of those that do not."""

import contextlib
import os
import socket
import stat
import subprocess
import time

from shown_process import answer, certificate, document, participant, refusal, running_participant
from transcript import NOW, Transcript, main

WHERE = ("--status-dir", "status", *NOW)
ASK = ("trust", "status", *WHERE)


class TrustStatus(Transcript):
    def setUp(self):
        super().setUp()
        self.status, self.folder = self.at / "status", self.at / "talker"
        self.status.mkdir(mode=0o700)
        self.folder.mkdir()
        self.pid = os.getpid()

    def files(self):
        """Without sockets: the test's own come and go."""
        return {name: mode for name, mode in super().files().items() if not name.endswith(".sock")}

    def shown(self, *words, exit=0, **more):
        return self.json(*ASK, *words, exit=exit, **more)["result"]["processes"]

    def test_refused_document_is_shown_with_its_sentence(self):
        with running_participant(self.status, self.folder):
            told = self.run_program(*ASK, "--pid", self.pid, exit=1).stdout
            self.assertIn(f"process {self.pid}: CN=talker  guid 0110\n", told)
            self.assertIn(f"identity certificate  {self.folder}/cert.pem  (current)\n", told)
            self.assertIn(f"permissions           {self.folder}/permissions.p7s  (refused)\n", told)
            self.assertIn("in force since 2026-11-21T00:00:00Z\n      until 2027-11-21T00:00:00Z  CN=talker", told)
            self.assertIn("REFUSED at 2026-11-21T01:00:00Z: the sentence of the event", told)
            self.assertEqual(self.shown("--pid", self.pid, exit=1),
                             [{"pid": self.pid, "participants": [participant(self.folder)]}])

    def test_document_that_waits_is_shown(self):
        waits = participant(self.folder)
        waits["documents"][0]["waiting"] = {"subject": "revision 7", "number": "", "until": None, "sha256": "cd" * 32}
        del waits["documents"][1]["waiting"]  # a process with ddssec 0.2.0 does not say it
        with running_participant(self.status, self.folder, answer(waits)):
            self.assertIn("    waits for peers, to come into force: no end  revision 7  sha256 cdcdcdcd",
                          self.run_program(*ASK, "--pid", self.pid, exit=1).stdout)
            documents = self.shown("--pid", self.pid, exit=1)[0]["participants"][0]["documents"]
            self.assertEqual([document["waiting"] and document["waiting"]["subject"] for document in documents], ["revision 7", None])

    def test_state_that_is_not_known_is_not_shown(self):
        for state in (None, "something\nelse", ""):  # None: a process with ddssec 0.3.0 does not say it
            shown = participant(self.folder, certificate(self.folder), document(self.folder))
            shown["documents"][1]["state"] = state
            if state is None:
                del shown["documents"][1]["state"]
            with running_participant(self.status, self.folder, answer(shown)):
                self.assertIn(f"{self.folder}/permissions.p7s\n", self.run_program(*ASK).stdout)
                documents = self.shown()[0]["participants"][0]["documents"]
            self.assertEqual([one["state"] for one in documents], ["current", None])

    def test_document_that_begins_later_is_not_shown_as_refused(self):
        later = participant(self.folder, certificate(self.folder, refused=refusal(waits=True)), document(self.folder))
        with running_participant(self.status, self.folder, answer(later)):
            told = self.run_program(*ASK, "--pid", self.pid, exit=0).stdout
            self.assertIn("    waits until it begins, since 2026-11-21T01:00:00Z: the sentence of the event", told)
            self.assertNotIn("REFUSED", told)
        del later["documents"][0]["refused"]["waits"]  # a process with ddssec 0.2.0 does not say it
        with running_participant(self.status, self.folder, answer(later)):
            self.assertIn("REFUSED at", self.run_program(*ASK, "--pid", self.pid, exit=1).stdout)

    def test_renewal_list_is_explained_and_an_entry_that_has_ended_is_no_fault(self):
        entries = document(self.folder, "renewal list", "renewed.pem")
        listed = document(self.folder, "listed permissions", "renewed.pem", until="2026-11-20T00:00:00Z")
        for until, shown in (("2027-11-21T00:00:00Z", "until 2027-11-21T00:00:00Z  CN=talker"), (None, "CN=talker")):
            entries["in_force"][0]["until"] = until  # a process with ddssec 0.3.0 does not say it
            well = answer(participant(self.folder, certificate(self.folder), document(self.folder), entries, listed))
            with running_participant(self.status, self.folder, well):
                told = self.run_program(*ASK).stdout
            self.assertIn("    a session goes on after a peer's certificate ends if its successor is here\n"
                          f"      {shown}  number 1A\n", told)
            self.assertIn("    a session goes on after a peer's permissions end if its successor is here\n"
                          "      ended 2026-11-20T00:00:00Z  CN=talker  number 1A\n", told)
            self.assertNotIn("no end", told)
        entries["in_force"] = []
        well = answer(participant(self.folder, certificate(self.folder), document(self.folder), entries))
        with running_participant(self.status, self.folder, well):
            self.assertIn("is here\n      none\n", self.run_program(*ASK).stdout)

    def test_exit_is_0_while_all_is_well(self):
        well = answer(participant(self.folder, certificate(self.folder),
                                  document(self.folder, refused=refusal(stands=False))))
        with running_participant(self.status, self.folder, well):
            self.assertIn("refused before, at", self.run_program(*ASK).stdout)
            ended = self.run_program("trust", "status", "--status-dir", "status", "--now", "2028-01-01", exit=1).stdout
            self.assertIn("ENDED 2027-11-21T00:00:00Z", ended)

    def test_folder_of_a_participant_finds_its_processes(self):
        two = answer(participant(self.folder), participant(self.at / "other", identity=2))
        (self.at / "link").symlink_to("talker")
        with running_participant(self.status, self.folder, two):
            for name in ("talker", "talker/", "./talker", "link", self.folder):
                (process,) = self.shown(name, exit=1)
                self.assertEqual([one["identity"] for one in process["participants"]], [1], name)
            self.refused("status_not_shown", 3, *ASK, "elsewhere")
            self.refused("status_not_shown", 3, *ASK, "elsewhere", "--pid", self.pid)

    def test_variable_names_the_folder(self):
        with running_participant(self.status, self.folder):
            self.json("trust", "status", *NOW, environment={"DDSSEC_STATUS_DIR": str(self.status)}, exit=1)
        told = self.refused("usage", 2, "trust", "status", environment={"DDSSEC_STATUS_DIR": ""})
        self.assertIn("DDSSEC_STATUS_DIR", told["message"])

    def test_two_libraries_of_one_process_are_one_participant(self):
        mine = answer(participant(self.folder, certificate(self.folder)))
        also = answer(participant(self.folder, document(self.folder), guid=""))
        with running_participant(self.status, self.folder, mine), \
                running_participant(self.status, self.folder, also, more="-2"):
            (process,) = self.shown("--pid", self.pid)
            (one,) = process["participants"]
            self.assertEqual(one["guid"], "0110")
            self.assertEqual([d["kind"] for d in one["documents"]], ["identity certificate", "permissions"])

    def test_two_embedded_participants_stay_two(self):
        mine = answer(participant(self.folder, certificate(self.folder), document(self.folder)))
        with running_participant(self.status, self.folder, mine), \
                running_participant(self.status, self.folder, mine, more="-2"):
            (process,) = self.shown()
            self.assertEqual(len(process["participants"]), 2)

    def test_what_a_terminal_would_obey_is_escaped(self):
        bad = participant(self.folder)
        bad["subject"] = "CN=\x1b[2J\u202e"
        with running_participant(self.status, self.folder, answer(bad)):
            told = self.run_program(*ASK, exit=1).stdout
            self.assertNotIn("\x1b", told)
            self.assertNotIn("\u202e", told)

    def test_line_of_a_subject_is_no_line_of_the_command(self):
        bad = participant(self.folder)
        bad["subject"] = "CN=a\nprocess 1: CN=forged"
        with running_participant(self.status, self.folder, answer(bad)):
            self.assertNotIn("\nprocess 1:", self.run_program(*ASK, exit=1).stdout)

    def test_one_part_that_has_ended_is_an_end(self):
        lists = document(self.folder)
        lists["in_force"].append({**lists["in_force"][0], "until": "2026-11-20T00:00:00Z"})
        with running_participant(self.status, self.folder, answer(participant(self.folder, certificate(self.folder), lists))):
            self.assertIn("ENDED 2026-11-20", self.run_program(*ASK, exit=1).stdout)

    def test_participants_that_the_answer_has_no_room_for_are_named(self):
        with running_participant(self.status, self.folder, answer(participant(self.folder), left_out=7)):
            done = self.run_program(*ASK, exit=3)
            self.assertIn("CN=talker", done.stdout)
            self.assertIn("no room for 7 participants", done.stderr)

    def test_participant_that_is_cut_off_is_not_well(self):
        gone = participant(self.folder, certificate(self.folder), document(self.folder))
        self.assertIsNone(gone["cut_off"])
        with running_participant(self.status, self.folder, answer(gone)):
            self.run_program(*ASK)
        gone["cut_off"] = refusal()
        with running_participant(self.status, self.folder, answer(gone)):
            self.assertIn("  CUT OFF since 2026-11-21T01:00:00Z, until", self.run_program(*ASK, exit=1).stdout)

    def test_library_that_shows_nothing_is_named(self):
        for shown, missing in ((certificate, "access control"), (document, "authentication")):
            with running_participant(self.status, self.folder, answer(participant(self.folder, shown(self.folder)))):
                done = self.run_program(*ASK, exit=3)
                self.assertIn("CN=talker", done.stdout)
                self.assertIn(f"{missing} shows no documents of CN=talker", done.stderr)

    # ---- processes that do not answer

    def test_process_without_the_variable_is_not_shown(self):
        told = self.refused("status_not_shown", 3, *ASK, "--pid", self.pid)
        self.assertIn("DDSSEC_STATUS_DIR", told["hint"])
        self.refused("status_not_shown", 3, *ASK)
        self.refused("file_not_found", 3, "trust", "status", "--status-dir", "missing")
        self.refused("usage", 2, *ASK, "--pid", "0")

    def test_process_that_has_ended_is_told_from_one_that_does_not_show(self):
        ended = subprocess.Popen(["true"])
        ended.wait()
        self.refused("status_process_ended", 3, *ASK, "--pid", ended.pid)
        left = socket.socket(socket.AF_UNIX)
        left.bind(str(self.status / f"ddssec-{ended.pid}.sock"))
        left.close()
        self.refused("status_process_ended", 3, *ASK, "--pid", ended.pid)
        self.refused("status_not_shown", 3, *ASK)

    def test_socket_of_a_former_process_with_this_number_says_so(self):
        left = socket.socket(socket.AF_UNIX)
        left.bind(str(self.status / f"ddssec-{self.pid}.sock"))
        left.close()
        told = self.refused("status_process_ended", 3, *ASK, "--pid", self.pid)
        self.assertIn("former process", told["message"])

    def test_answers_that_are_none_are_refused(self):
        no_time = participant(self.folder)
        no_time["documents"][-1]["since"] = "yesterday"
        for text in ("", "{", "[]", "[" * 100_000, "{}", '{"schema": "ddssec-status/2", "participants": []}',
                     answer({"identity": 1}), answer(no_time), "x" * 3_000_000):
            with running_participant(self.status, self.folder, text):
                self.refused("status_unanswered", 3, *ASK)

    def test_answer_that_is_cut_says_so(self):
        whole = answer(participant(self.folder))
        with running_participant(self.status, self.folder, whole[:len(whole) // 2]):
            self.assertIn("cut off", self.refused("status_unanswered", 3, *ASK)["message"])

    def test_more_sockets_than_are_asked_are_counted(self):
        for pid in range(5000000, 5001100):
            os.mknod(self.status / f"ddssec-{pid}.sock", 0o600 | stat.S_IFSOCK)
        self.assertIn("76 of its sockets", self.refused("status_unanswered", 3, *ASK)["message"])

    def test_name_that_no_process_writes_is_passed_over(self):
        with running_participant(self.status, self.folder, pid=f"00{self.pid}"):
            self.refused("status_not_shown", 3, *ASK)

    def test_participants_with_one_handle_cost_no_more_than_others(self):
        many = answer(*[participant(self.folder, certificate(self.folder)) for _ in range(4000)])
        with contextlib.ExitStack() as stack:
            for more in ("", "-2", "-3", "-4"):
                stack.enter_context(running_participant(self.status, self.folder, many, more=more))
            begin = time.monotonic()
            self.run_program(*ASK, exit=3)
            self.assertLess(time.monotonic() - begin, 10)

    def test_process_that_never_answers_is_left_after_seconds(self):
        mute = socket.socket(socket.AF_UNIX)
        mute.bind(str(self.status / f"ddssec-{self.pid}.sock"))
        mute.listen()
        with mute:
            told = self.run_program(*ASK, "--pid", self.pid, exit=3).stderr
        self.assertIn("error[status_unanswered]", told)

    def test_many_that_never_answer_cost_no_more_than_one(self):
        with contextlib.ExitStack() as stack:
            for pid in range(os.getppid() + 1000, os.getppid() + 1005):
                mute = stack.enter_context(socket.socket(socket.AF_UNIX))
                mute.bind(str(self.status / f"ddssec-{pid}.sock"))
                mute.listen()
            begin = time.monotonic()
            self.run_program(*ASK, exit=3)
            self.assertLess(time.monotonic() - begin, 30)

    def test_file_in_place_of_a_socket_is_not_opened(self):
        (self.status / f"ddssec-{self.pid}.sock").write_text("no socket")
        (self.status / "ddssec-x.sock").write_text("no number")
        self.refused("status_unanswered", 3, *ASK)

    # ---- other users

    def test_folder_that_others_can_write_to_is_not_believed(self):
        self.status.chmod(0o777)
        told = self.refused("status_folder_untrusted", 4, *ASK)
        self.assertIn("0777", told["message"])

    def test_process_of_another_user_is_told_from_one_that_does_not_answer(self):
        if os.geteuid() != 0:
            self.skipTest("only root can become another user")
        self.at.chmod(0o755)
        with running_participant(self.status, self.folder):
            told = self.json_as_nobody("trust", "status", *WHERE, exit=3)
            self.assertEqual([d["id"] for d in told["diagnostics"]], ["status_of_another_user"])
            self.status.chmod(0o755)
            told = self.json_as_nobody("trust", "status", *WHERE, exit=3)
            self.assertEqual([d["id"] for d in told["diagnostics"]], ["status_of_another_user"])
            self.assertIn("user 0", told["diagnostics"][0]["message"])

    def test_root_does_not_believe_another_user_in_the_folder_of_one(self):
        if os.geteuid() != 0:
            self.skipTest("only root can become another user")
        os.chown(self.status, 65533, 65533)
        child = os.fork()
        if child == 0:
            # The socket is made as root; who listens is another user.
            server = socket.socket(socket.AF_UNIX)
            server.bind(str(self.status / f"ddssec-{os.getpid()}.sock"))
            os.setgid(65534)
            os.setuid(65534)
            server.listen()
            os.write(1, b"")
            server.settimeout(20)
            with server.accept()[0] as client:
                client.sendall(answer(participant(self.folder)).encode())
            os._exit(0)
        try:
            for _ in range(100):
                done = self.run_program("trust", "status", *WHERE, "--pid", child, exit=3)
                if "status_of_another_user" in done.stderr:
                    break
            self.assertIn("error[status_of_another_user]", done.stderr)
            self.assertIn("user 65534", done.stderr)
        finally:
            os.kill(child, 9)
            os.waitpid(child, 0)


if __name__ == "__main__":
    main()

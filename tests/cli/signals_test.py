#!/usr/bin/env python3
"""SIGINT, SIGTERM and SIGHUP end a command that only computes. A job in CI that sends one does not wait for minutes."""

import os
import signal
import subprocess
import time

from transcript import PROGRAM, Transcript, library_path, main

LIBRARY = PROGRAM.parent.parent / "lib/spin_at.so"


class Signals(Transcript):
    def computing(self):
        """A command that computes without an end."""
        command = subprocess.Popen([PROGRAM, "permissions", "lint", "endless"], cwd=self.at, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL,
                                   env={**os.environ, "LD_LIBRARY_PATH": library_path(), "LD_PRELOAD": str(LIBRARY)})
        self.addCleanup(command.wait)
        self.addCleanup(command.kill)
        until = time.monotonic() + 20
        while not (self.at / "computing").exists():
            self.assertIsNone(command.poll(), "it ended before it computed")
            self.assertLess(time.monotonic(), until, "it does not compute")
            time.sleep(0.01)
        return command

    def test_they_end_a_command_that_computes(self):
        (self.at / "endless").touch()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(signal=number.name):
                command = self.computing()
                command.send_signal(number)
                self.assertEqual(command.wait(20), -number)
            (self.at / "computing").unlink(missing_ok=True)


if __name__ == "__main__":
    main()

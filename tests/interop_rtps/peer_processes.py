"""Runs ddssec-peer in a network of its own and reads the lines that it writes."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
from pair import Namespace  # noqa: E402


class PeerProcesses(unittest.TestCase):
    """Ends what it has started."""

    def setUp(self):
        self.space = Namespace()
        self.running = []

    def tearDown(self):
        for process in self.running:
            if process.poll() is None:
                process.kill()
            process.wait()
            process.output.close()
        self.space.close()

    def launch(self, command, seconds, **options):
        """A process in domain 3. `seconds` is its time limit unless the command has one."""
        timeout = [] if "--timeout" in command else ["--timeout", str(seconds)]
        output = tempfile.TemporaryFile()
        process = subprocess.Popen(self.space.enter([*command, "--domain", "3", *timeout]), stdout=output,
                                   stderr=subprocess.DEVNULL, **options)
        process.output = output
        self.running.append(process)
        return process

    @staticmethod
    def lines(process):
        """What it has written so far, without a line that is not complete."""
        written = os.pread(process.output.fileno(), 1 << 26, 0)
        return [json.loads(line) for line in written[:written.rfind(b"\n") + 1].splitlines()]

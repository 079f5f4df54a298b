#!/usr/bin/env python3
"""SIGINT, SIGTERM and SIGHUP end a command that only computes. A job in CI that sends one does not wait for minutes."""

import os
import signal
import subprocess
import time
from pathlib import Path

from transcript import NOW, PROGRAM, Transcript, main

PERMISSIONS = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><permissions><grant name="a"><subject_name>CN=a</subject_name>
<validity><not_before>2020-01-01T00:00:00</not_before><not_after>2030-01-01T00:00:00</not_after></validity>
{rules}<default>DENY</default></grant></permissions></dds>
"""
RULE = """<allow_rule><domains><id>0</id></domains><publish><topics>{topics}</topics></publish></allow_rule>
"""


def computed_seconds(pid):
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return int(fields[11]) / os.sysconf("SC_CLK_TCK")


class Signals(Transcript):
    def setUp(self):
        super().setUp()
        for name, letters in (("old.xml", "abc"), ("new.xml", "bca")):
            topics = "".join(f"<topic>{''.join(f'*{letters[(i + j) % 3]}' for j in range(60))}{i}</topic>" for i in range(3000))
            (self.at / name).write_text(PERMISSIONS.format(rules=RULE.format(topics=topics)))

    def test_they_end_a_command_that_computes(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(signal=number.name):
                command = subprocess.Popen([PROGRAM, "permissions", "diff", "old.xml", "new.xml", *NOW], cwd=self.at,
                                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                while computed_seconds(command.pid) < 0.2:
                    self.assertIsNone(command.poll(), "it ended before the signal: it needs more to compute")
                    time.sleep(0.01)
                command.send_signal(number)
                self.assertEqual(command.wait(20), -number)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""A short run of latency.py: its table, its figures and its plot have the form that they should have."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

BUILD = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release").resolve()
PROGRAM = pathlib.Path(__file__).resolve().parent / "latency.py"
KEYS = ["median_us", "p90_us", "p99_us", "p999_us", "p9999_us"]


class Report(unittest.TestCase):
    def test_short_run_prints_and_draws_every_variant(self):
        with tempfile.TemporaryDirectory() as folder:
            base = pathlib.Path(folder)
            ran = subprocess.run([sys.executable, PROGRAM, "--build", BUILD, "--rounds", "1", "--count", "200", "--only",
                                  "^(UDP|ddssec|Cyclone, best effort, wait)", "--json", base / "json", "--svg", base / "svg"],
                                 text=True, capture_output=True, timeout=55)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            rows = [line for line in ran.stdout.splitlines() if line.startswith("| ")]
            results = json.loads((base / "json").read_text())["results"]
            lines = xml.etree.ElementTree.parse(base / "svg").getroot().iter("{http://www.w3.org/2000/svg}polyline")
            drawn = len(list(lines))
        self.assertEqual(len(results), 10)  # UDP, eight of ours, one of Cyclone DDS
        self.assertEqual(len(rows), 1 + len(results))
        self.assertEqual(len({row.count("|") for row in rows}), 1)
        self.assertEqual(drawn, 9 + 4)  # the floor is in each of the four panels
        for result in results:
            values = [result[key] for key in KEYS]
            self.assertEqual(values, sorted(values))
            self.assertGreater(values[0], 1)
            self.assertGreater(result["cpu_us"], 0)
            self.assertGreater(result["jitter_us"], 0)
            self.assertEqual(result["lost"], 0)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""Certificates are revoked with `ddssec` while their participants run: one whose folder has no list as
yet, then one more, with old lists put back and broken ones in between. Usage: revocation_test.py BUILD [FILTER]"""

import pathlib
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
from shapes_process import check, run  # noqa: E402

DOMAIN = 9
PATIENCE = 40   # seconds; nothing that comes takes so long
INTERVAL = 1    # seconds between two looks; the pairs of ../interop have the default
PROMISED = 2.0  # seconds from the new list to the cut
SLOW = 8.0      # what a loaded machine may add
NAMES = ("alice", "bob", "carol", "dave")


def ddssec(case, *arguments):
    done = subprocess.run([str(case.program.parent / "ddssec"), *arguments], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    check(f"ddssec {arguments}: {done.stdout}", done.returncode == 0)


def revoke(case, base, name):
    """Revokes the certificate. Returns the time at which each participant has the list in its folder."""
    ddssec(case, "identity", "revoke", f"{base}/{name}", "--ca", base)
    ddssec(case, "crl", "distribute", "--ca", base)
    return time.monotonic()


def cut_off(process, since):
    """The process hears nothing more soon after it was revoked."""
    while process.sizes_for(0.5):
        check("hears on", time.monotonic() < since + PROMISED + SLOW + 1)


def revoked_while_running(case):
    with tempfile.TemporaryDirectory() as folder:
        base = f"{folder}/demo"
        ddssec(case, "init", base, "--domain", str(DOMAIN), "--profile", "balanced",
               *(word for name in NAMES for word in ("--participant", name)))
        lists = [pathlib.Path(base, name, "crl.pem") for name in NAMES]
        for name in NAMES:
            pathlib.Path(base, name, "security.properties").write_text(
                f"org.ddssec.files_poll_interval = {INTERVAL}\n")
        for path in lists:  # as in folders that an earlier version made
            path.unlink()
        bob, carol, dave = (case.start(f"-S -k 0 --security {base}/{name}") for name in NAMES[1:])
        alice = case.start(f"-P -k 0 -z 0 --write-period 20 -v d --security {base}/alice")
        for process in (bob, carol, dave):
            process.hears(10, PATIENCE)

        cut_off(carol, revoke(case, base, "carol"))
        alice.says("a certificate was revoked", PATIENCE)
        first = lists[0].read_text()
        cut_off(dave, revoke(case, base, "dave"))
        alice.says("a certificate was revoked", PATIENCE)

        # A list of before does not bring dave back, nor does none, nor half of one.
        for text, said in ((first, "is older than"), (first[:len(first) // 2], "is not a certificate revocation list"),
                           (None, "does not exist")):
            lists[0].unlink() if text is None else lists[0].write_text(text)
            alice.says(said, PATIENCE)
        check("dave is back", not dave.sizes_for(1))
        dave.interrupt()
        again = case.start(f"-S -k 0 --security {base}/dave")
        alice.says("a certificate was revoked", PATIENCE)
        check("dave is back, made anew", not again.sizes_for(1))
        bob.hears(100, PATIENCE)
        for process in (alice, bob, carol):
            check("codes", process.interrupt() == 0)


if __name__ == "__main__":
    sys.exit(run([revoked_while_running], [DOMAIN], 1))

"""OpenSSL's own OCSP responder for a CA that ddssec made."""

import contextlib
import re
import subprocess
import threading


def index_line(state, serial, name):
    """A certificate in the responder's list: V is valid, R is revoked."""
    dates = {"V": "V\t400101000000Z\t", "R": "R\t400101000000Z\t250101000000Z,keyCompromise"}
    return f"{dates[state]}\t{serial}\tunknown\t/CN={name}\n"


@contextlib.contextmanager
def responder(index, ca, *more):
    """It picks a port, and says which: the address. `ca`: a folder; `more` overrides its options."""
    process = subprocess.Popen(
        ["openssl", "ocsp", "-port", "0", "-index", index, "-CA", ca / "ca.pem", "-rsigner", ca / "ca.pem",
         "-rkey", ca / "ca.key.pem", "-rmd", "sha256", "-ndays", "2", *more],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    end = threading.Timer(20, process.kill)
    end.start()
    try:
        lines, found = [], None
        while not found:
            lines.append(process.stdout.readline())
            assert lines[-1], f"openssl ocsp has ended: {lines}"
            found = re.search(r"ACCEPT .*:(\d+)", lines[-1])
        end.cancel()
        yield f"http://127.0.0.1:{found[1]}/"
    finally:
        end.cancel()
        process.kill()
        process.wait()
        process.stdout.close()

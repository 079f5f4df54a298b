"""Starts a peer of tests/interop on what ddssec made; the peers stand beside the program."""

import os
import subprocess

from transcript import PROGRAM

FILES = {"identity_ca": "identity_ca.pem", "identity_certificate": "cert.pem", "private_key": "key.pem",
         "permissions_ca": "permissions_ca.pem", "governance": "governance.p7s",
         "permissions": "permissions.p7s", "crl": "crl.pem"}
PROGRAMS = {"cyclonedds": "cyclone_peer", "ddssec": "cyclone_peer", "fastdds": "fastdds_peer",
            "embedded": "embedded_peer"}


def start(namespace, product, folder, role, seconds, dropin=None):
    """`ddssec`: Cyclone DDS on the plugins of ddssec, which lie in `dropin`."""
    files = [part for option, file in FILES.items() if (folder / file).exists()
             for part in ("--" + option, str(folder / file))]
    environment = {**os.environ, "TZ": "UTC"}
    environment.pop("LD_LIBRARY_PATH", None)
    if product == "ddssec":
        environment["LD_LIBRARY_PATH"] = str(dropin)
    command = [str(PROGRAM.parent / PROGRAMS[product]), role, "--topic", "Square", "--timeout", str(seconds), *files]
    return subprocess.Popen(namespace.enter(command), env=environment, text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT)

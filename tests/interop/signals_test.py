#!/usr/bin/env python3
"""ddsperf, which waits for its signals in sigwait, on our plugins: SIGINT and SIGTERM stop it cleanly, since no
thread of the plugins takes them first.

Usage: signals_test.py BUILD      in a network of its own
"""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile

BUILD = pathlib.Path(sys.argv[1]).resolve()
PATIENCE = 30  # seconds
CONFIGURATION = """<CycloneDDS><Domain Id="any"><Security>
  <Authentication>
    <Library path="dds_security_auth" initFunction="init_authentication" finalizeFunction="finalize_authentication"/>
    <IdentityCA>file:{0}/identity_ca.pem</IdentityCA>
    <IdentityCertificate>file:{0}/cert.pem</IdentityCertificate>
    <PrivateKey>file:{0}/key.pem</PrivateKey>
  </Authentication>
  <Cryptographic>
    <Library path="dds_security_crypto" initFunction="init_crypto" finalizeFunction="finalize_crypto"/>
  </Cryptographic>
  <AccessControl>
    <Library path="dds_security_ac" initFunction="init_access_control" finalizeFunction="finalize_access_control"/>
    <PermissionsCA>file:{0}/permissions_ca.pem</PermissionsCA>
    <Governance>file:{0}/governance.p7s</Governance>
    <Permissions>file:{0}/permissions.p7s</Permissions>
  </AccessControl>
</Security></Domain></CycloneDDS>"""


def stopped_by(which, environment, folder):
    """Why ddsperf did not end cleanly; None if it did."""
    log = pathlib.Path(folder) / f"{which.name}.log"
    with open(log, "w", encoding="utf-8") as output:
        process = subprocess.Popen(["ddsperf", "-D", str(PATIENCE), "sub"], env=environment, text=True,
                                   stdout=subprocess.PIPE, stderr=output)
        try:
            # It prints a line a second once its entities are made, so once the plugins' threads run.
            line = process.stdout.readline()
            maps = pathlib.Path(f"/proc/{process.pid}/maps").read_text(encoding="utf-8")
            process.send_signal(which)
            process.communicate(timeout=PATIENCE)
        finally:
            process.kill()
            process.wait()
    if "libddssec_authentication.so" not in maps:
        return "our plugins were not loaded"
    if not line or process.returncode != 0:
        return f"exit status {process.returncode}, first line '{line.strip()}'\n{log.read_text(encoding='utf-8')}"
    return None


def main():
    with tempfile.TemporaryDirectory(prefix="ddssec-signals-") as folder:
        demo = os.path.join(folder, "demo")
        subprocess.run([BUILD / "bin" / "ddssec", "init", demo, "--participant", "talker"], check=True,
                       stdout=subprocess.DEVNULL)
        environment = {**os.environ, "CYCLONEDDS_URI": CONFIGURATION.format(demo + "/talker"),
                       "LD_LIBRARY_PATH": str(BUILD / "dropin")}
        faults = 0
        for which in (signal.SIGINT, signal.SIGTERM):
            fault = stopped_by(which, environment, folder)
            faults += fault is not None
            print(f"{'FAILED' if fault else 'ok':8}{which.name}" + (f": {fault}" if fault else ""), flush=True)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Stock Cyclone DDS and Fast DDS take the documents that the command line tool writes.

Usage: written_by_cli_test.py BUILD_FOLDER     pairs of stock peers, each in a network of its own
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import types

import pair
from documents import DOMAIN, TOPIC

BUILD = pathlib.Path(sys.argv[1]).resolve()

# Name, what `governance new` gets, what the publisher's and the subscriber's `permissions new` get.
DOCUMENTS = (
    ("strict", (), ("--publish", TOPIC), ("--subscribe", TOPIC)),
    ("balanced", ("--profile", "balanced", "--topic", f"{TOPIC}:metadata=SIGN"),
     ("--publish", "Squ*"), ("--subscribe", "?quare")),
    ("denials", ("--topic", "Other*:data=NONE"),
     ("--publish", "*", "--deny-publish", "Other", "--deny-subscribe", "Other"),
     ("--subscribe", "*", "--deny-publish", "Other", "--deny-subscribe", "Other")),
)


class Workshop:
    """A folder with a CA and two participants, all made by the tool."""

    def __init__(self, folder):
        self.at = pathlib.Path(folder)
        self.run("ca", "create", "ca", "--no-passphrase")
        for name in ("publisher", "subscriber"):
            self.run("identity", "issue", name, "--ca", "ca", "-o", name)

    def run(self, *words):
        subprocess.run([BUILD / "bin/ddssec", *words], cwd=self.at, check=True, stdout=subprocess.DEVNULL)

    def arguments(self, name, governance, rights):
        """Writes both documents and gives the peer's options."""
        document = f"{name}-governance.xml"
        if not (self.at / document).exists():
            self.run("governance", "new", "--domain", str(DOMAIN), *governance, "-o", document,
                     "--sign", "--ca", "ca")
            # With a revision, which stock products must read over.
            self.run("governance", "sign", document, "--ca", "ca", "--replace")
            assert b'<?ddssec revision="' in (self.at / document).with_suffix(".p7s").read_bytes()
        role = "publisher" if "--publish" in rights else "subscriber"
        permissions = f"{name}-{role}.xml"
        if not (self.at / permissions).exists():
            self.run("permissions", "new", "--cert", f"{role}/cert.pem", "--domain", str(DOMAIN),
                     *rights, "-o", permissions, "--sign", "--ca", "ca")
        files = {"identity_ca": "ca/identity/ca.pem", "identity_certificate": f"{role}/cert.pem",
                 "private_key": f"{role}/key.pem", "permissions_ca": "ca/permissions/ca.pem",
                 "governance": f"{name}-governance.p7s", "permissions": f"{name}-{role}.p7s"}
        return [word for key, file in files.items()
                for word in (f"--{key}", f"file://{self.at / file}")]


def outcome(kind, publish, subscribe, logs):
    case = types.SimpleNamespace(allowed=(pair.DATA,), expires=False)
    programs = pair.Programs(str(BUILD / "bin"), "", str(logs))
    namespace = pair.Namespace()
    peers = []
    try:
        for role, words in (("--subscribe", subscribe), ("--publish", publish)):
            peers.append(pair.start(programs, namespace, kind, [role, *words],
                                    os.path.join(logs, role.strip("-") + ".log")))
        watch = pair._Watch(peers[1], peers[0], case)
        watch.follow()
        watch.stop()
        return pair.judge(peers[1], peers[0], False)[0]
    finally:
        for peer in peers:
            peer.kill()
        namespace.close()


def main():
    failed = 0
    with tempfile.TemporaryDirectory(prefix="ddssec-written-") as folder:
        shop = Workshop(folder)
        for name, governance, publisher, subscriber in DOCUMENTS:
            words = (shop.arguments(name, governance, publisher),
                     shop.arguments(name, governance, subscriber))
            for kind in ("cyclone", "fast"):
                got = outcome(kind, *words, folder)
                failed += got != pair.DATA
                print(f"{name:<10} {kind:<8} {got}")
                if got != pair.DATA:
                    for log in ("publish.log", "subscribe.log"):
                        print((pathlib.Path(folder) / log).read_text(errors="replace")[-2000:])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

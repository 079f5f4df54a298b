#!/usr/bin/env python3
"""ddssec agent --hook with a CA that is not ours: cfssl (Debian: golang-cfssl). It writes names with Go's crypto/x509, as
step-ca and Vault do: what fits into a PrintableString becomes one."""

import json
import re
import secrets
import shutil
import socket
import subprocess
import sys
import time

from agent_folders import AgentTest, ShortLived
from transcript import DATA, main

PAGE = DATA.parent.parent / "docs/agent.md"
YEAR = "8760h"


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def is_open(port):
    with socket.socket() as one:
        return one.connect_ex(("127.0.0.1", port)) == 0


class Cfssl(AgentTest):
    def setUp(self):
        super().setUp()
        self.key = secrets.token_hex(16)

    def write(self, name, value):
        (self.at / name).write_text(json.dumps(value))
        return self.at / name

    def serve(self, expiry="43800h", ca=None):
        """Starts a server that signs with the CA of `init` or another one. Returns what a client must know."""
        ca = ca or self.ca
        profile = {"expiry": expiry, "usages": ["digital signature"], "auth_key": "agent"}
        keys = {"agent": {"type": "standard", "key": self.key}}
        port = free_port()
        config = self.write("server.json", {"signing": {"default": profile}, "auth_keys": keys})
        log = open(self.at / "server.log", "w")
        self.addCleanup(log.close)
        server = subprocess.Popen(["cfssl", "serve", "-address", "127.0.0.1", "-port", str(port), "-config", config,
                                   "-ca", ca / "ca.pem", "-ca-key", ca / "ca.key.pem"], cwd=self.at, stdout=log, stderr=log)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        end = time.monotonic() + 30
        while not is_open(port):
            self.assertLess(time.monotonic(), end, (self.at / "server.log").read_text())
            time.sleep(0.05)
        return {"signing": {"default": {"auth_remote": {"auth_key": "agent", "remote": "ca"}}}, "auth_keys": keys,
                "remotes": {"ca": f"http://127.0.0.1:{port}"}}

    def hook_of_page(self, client):
        """The line of docs/agent.md."""
        line, variable = re.findall(r"(?m)^\| cfssl \| `(.*?)`, where `(.*)` \|$", PAGE.read_text())[0]
        line = line.replace(r"\|", "|").replace("/etc/ddssec/cfssl.json", str(self.write("client.json", client)))
        return self.hook("export no_proxy=127.0.0.1\n" + variable + "\n" + line)

    def first_certificate(self, hook, folder="demo/talker"):
        """As docs/agent.md says: one time by hand."""
        line, = re.findall(r"`(openssl x509 -x509toreq .*?)`", PAGE.read_text().replace("\n", " "))
        line = line.replace("FOLDER", folder).replace("HOOK", hook)
        subprocess.run(["sh", "-ec", line], cwd=self.at, check=True, timeout=60, capture_output=True)

    def types(self, folder="demo/talker"):
        return self.openssl("x509", "-in", f"{folder}/cert.pem", "-noout", "-subject", "-nameopt", "RFC2253,show_type").strip()

    def expect_renewed(self, hook, types):
        """The certificate in place is for a year, and the server's next one for five."""
        self.assertEqual(self.once("--hook", hook)[0]["event"], "current")
        key, before = self.public_key(), self.dates()
        event, = self.once("--hook", hook, *self.LATER)
        self.assertEqual((event["event"], self.public_key(), self.types()), ("renewed", key, "subject=" + types))
        self.assertGreater(self.dates()[1], before[1])
        self.run_program("doctor", "demo/talker", "--now", "+301d")

    def test_a_folder_of_init_is_refused_with_what_to_do(self):
        hook = self.hook_of_page(self.serve(YEAR))
        event = self.refused("renewal_unfit", "--hook", hook, *self.LATER)
        self.assertIn("expected CN=UTF8STRING:talker, found CN=PRINTABLESTRING:talker", event["message"])
        self.assertIn("stop the participant, put a certificate of this CA in place of cert.pem once", event["hint"])
        self.first_certificate(hook)
        self.run_program("doctor", "demo/talker")
        self.expect_renewed(self.hook_of_page(self.serve()), "CN=PRINTABLESTRING:talker")

    def test_a_folder_that_cfssl_certified_is_renewed(self):
        """Its CA is cfssl's own, too."""
        ca = self.at / "other"
        ca.mkdir()
        request = self.write("ca.json", {"CN": "Plant CA", "key": {"algo": "ecdsa", "size": 256}, "names": [{"O": "Example"}],
                                         "ca": {"expiry": "87600h"}})
        made = json.loads(subprocess.run(["cfssl", "genkey", "-loglevel", "3", "-initca", request], check=True, timeout=60,
                                         capture_output=True, text=True).stdout)
        (ca / "ca.pem").write_text(made["cert"])
        (ca / "ca.key.pem").write_text(made["key"])
        (self.talker / "identity_ca.pem").write_text(made["cert"])
        ShortLived(self.at, ca)
        (self.talker / "crl.pem").write_text(self.openssl("ca", "-gencrl", "-config", "short/openssl.cnf", "-crldays", "400"))
        self.first_certificate(self.hook_of_page(self.serve(YEAR, ca)))
        self.run_program("doctor", "demo/talker")
        self.expect_renewed(self.hook_of_page(self.serve(ca=ca)), "CN=PRINTABLESTRING:talker")

    def test_a_name_that_is_no_printable_string_is_renewed_at_once(self):
        self.run_program("identity", "issue", "arm_7", "--ca", "demo", "-o", "demo/talker", "--replace", "--publish", "x",
                         "--days", "365")
        self.expect_renewed(self.hook_of_page(self.serve()), "CN=UTF8STRING:arm_7")

    def test_a_wrong_key_or_no_server_is_a_failure_of_the_hook(self):
        client = self.serve()
        for name, wrong in (("key", {"auth_keys": {"agent": {"type": "standard", "key": secrets.token_hex(16)}}}),
                            ("server", {"remotes": {"ca": f"http://127.0.0.1:{free_port()}"}})):
            with self.subTest(name):
                self.refused("hook_failed", "--hook", self.hook_of_page({**client, **wrong}), *self.LATER)


if __name__ == "__main__":
    if not (shutil.which("cfssl") and shutil.which("cfssljson")):
        print("NOT TESTED: a CA that is not ours. There is no cfssl (apt-get install golang-cfssl)")
        sys.exit(77)
    main()

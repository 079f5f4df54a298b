"""Keystores for the tests of `ddssec keystore`, and the policies that they take."""

import os

from sros2_keystore import DATA, make_keystore
from transcript import NOW, Transcript

POLICY = DATA.parent.parent / "upstream/policies/talker_listener.policy.xml"
NEEDED = ("public/permissions_ca.cert.pem", "public/identity_ca.cert.pem",
          "private/permissions_ca.key.pem", "private/identity_ca.key.pem", "enclaves/governance.p7s")
TALKER = "ks/enclaves/talker_listener/talker"
SHORT = """<policy version="0.2.0"><enclaves>
<enclave path="/demo/talker"><profiles><profile ns="/" node="talker">
<topics publish="ALLOW"><topic>chatter</topic></topics></profile></profiles></enclave>
<enclave path="/demo/listener"><profiles><profile ns="/" node="listener">
<topics subscribe="ALLOW"><topic>chatter</topic></topics></profile></profiles></enclave>
</enclaves></policy>
"""


class KeystoreTest(Transcript):
    def create(self, *more):
        return self.json("keystore", "create", "ks", "--no-passphrase", *more, *NOW)

    def golden(self):
        make_keystore(self.at / "ks")

    def links(self, folder):
        return {p.name: os.readlink(p) for p in (self.at / folder).iterdir() if p.is_symlink()}

    def healthy(self, *enclaves):
        out = self.json("keystore", "verify", "ks", *NOW)["result"]
        self.assertEqual([e["name"] for e in out["enclaves"]], sorted(enclaves))

"""Governance and permissions in the form both stock implementations read, and what one participant
is given on its command line."""

import os
import uuid
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta, timezone

from pki import STARTER, WAITER, subject

DOMAIN = 7
OTHER_DOMAIN = 8
TOPIC = "Square"
PASSWORD = "interop"
COMPANION = "companion"


def _boolean(value):
    return "true" if value else "false"


@dataclass(frozen=True)
class Governance:
    """One governance document; the names are those of its elements, shortened."""
    discovery: str = "NONE"
    liveliness: str = "NONE"
    rtps: str = "NONE"
    metadata: str = "NONE"
    data: str = "NONE"
    topic_discovery: bool = True  # counts only where discovery is protected
    allow_unauthenticated: bool = False
    join: bool = True
    read: bool = True
    write: bool = True
    domains: tuple = (0, 230)
    psk: str = "NONE"  # rtps_psk_protection_kind, of DDS-Security 1.2
    revises_keys: bool = False  # enable_key_revision, of DDS-Security 1.2

    def xml(self):
        low, high = self.domains
        psk = ("" if self.psk == "NONE" else
               f"\n      <rtps_psk_protection_kind>{self.psk}</rtps_psk_protection_kind>")
        revision = "\n      <enable_key_revision>true</enable_key_revision>" if self.revises_keys else ""
        topic_discovery = self.topic_discovery and self.discovery != "NONE"
        return f"""<?xml version="1.0" encoding="utf-8"?>
<dds>
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>{low}</min><max>{high}</max></id_range></domains>
      <allow_unauthenticated_participants>{_boolean(self.allow_unauthenticated)}</allow_unauthenticated_participants>
      <enable_join_access_control>{_boolean(self.join)}</enable_join_access_control>{revision}
      <discovery_protection_kind>{self.discovery}</discovery_protection_kind>
      <liveliness_protection_kind>{self.liveliness}</liveliness_protection_kind>
      <rtps_protection_kind>{self.rtps}</rtps_protection_kind>{psk}
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>{_boolean(topic_discovery)}</enable_discovery_protection>
          <enable_liveliness_protection>{_boolean(self.liveliness != "NONE")}</enable_liveliness_protection>
          <enable_read_access_control>{_boolean(self.read)}</enable_read_access_control>
          <enable_write_access_control>{_boolean(self.write)}</enable_write_access_control>
          <metadata_protection_kind>{self.metadata}</metadata_protection_kind>
          <data_protection_kind>{self.data}</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
"""


@dataclass(frozen=True)
class Permissions:
    """One permissions document with one grant and one allow rule."""
    publish: tuple = (TOPIC,)
    subscribe: tuple = (TOPIC,)
    partition: str = ""
    domain: int = DOMAIN
    not_before: str = "2020-01-01T00:00:00"
    not_after: str = "2037-01-01T00:00:00"
    other_subject: bool = False

    def xml(self, common_name):
        name = subject("somebody-else" if self.other_subject else common_name)
        return f"""<?xml version="1.0" encoding="utf-8"?>
<dds>
  <permissions>
    <grant name="participant">
      <subject_name>{name}</subject_name>
      <validity>
        <not_before>{self.not_before}</not_before>
        <not_after>{self.not_after}</not_after>
      </validity>
      <allow_rule>
        <domains><id>{self.domain}</id></domains>
{self._section("publish", self.publish)}{self._section("subscribe", self.subscribe)}\
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
"""

    def _section(self, kind, topics):
        if not topics:
            return ""
        names = "".join(f"<topic>{name}</topic>" for name in topics)
        partitions = (f"<partitions><partition>{self.partition}</partition></partitions>"
                      if self.partition else "")
        return f"        <{kind}><topics>{names}</topics>{partitions}</{kind}>\n"


@dataclass(frozen=True)
class Keys:
    """Key kinds (pki.KEY_KINDS) of participants, the identity CA and the permissions CA."""
    leaf: str = "ec"
    identity_ca: str = "ec"
    permissions_ca: str = "ec"


def _soon(seconds):
    return datetime.now(timezone.utc) + timedelta(seconds=seconds) if seconds else None


@dataclass(frozen=True)
class Side:
    """What one participant of a pair is given. The CA names "main", "other" and "second" are
    different CAs, "intermediate" is one under "main"; "identity" as permissions CA means that the
    identity CA serves as both."""
    governance: Governance = field(default_factory=Governance)
    permissions: Permissions = field(default_factory=Permissions)
    plain: bool = False
    signed_by: str = "main"             # identity CA that issued the certificate
    trusts: str = "main"                # identity CA file configured
    expired: bool = False
    foreign_key: bool = False           # the private key of another certificate
    crl: str = ""                       # "peer", "stranger" or "companion": the one in the configured CRL;
                                        # "later": a stranger, and the peer once data flows
    permissions_by: str = "main"        # signer: a permissions CA, or "leaf" for itself
    permissions_ca: str = "main"        # permissions CA file configured
    governance_by: str = ""             # signer, if not the configured permissions CA
    tamper: str = ""                    # "permissions" or "governance"
    password: bool = False
    partition: str = ""
    keysize: int = 0
    cipher: str = ""                    # of the endpoint (Cyclone DDS), of the participant (embedded)
    process_cipher: str = ""            # by an environment variable, which only ours in Cyclone has
    data_uris: bool = False             # certificates and documents as data:, URIs
    identity_seconds: int = 0           # the certificate expires so soon after it was made
    permissions_seconds: int = 0        # so do the permissions

    def arguments(self, pki, keys, starts):
        """The peer's command line options, after making every file they name."""
        shared = ["--partition", self.partition] if self.partition else []
        if self.plain:
            return shared + ["--plain"]
        me, peer = (STARTER, WAITER) if starts else (WAITER, STARTER)
        return shared + self._of(me, peer, pki, keys)

    def of(self, me, pki, keys):
        """The options of a participant with another subject name than the two of a pair."""
        return self._of(me, "", pki, keys)

    def _of(self, me, peer, pki, keys):
        shared = []
        issuer = self._identity_ca(pki, keys, self.signed_by)
        certificate = pki.leaf(me, keys.leaf, issuer, self.expired, _soon(self.identity_seconds))
        documents = {
            "identity_ca": self._trusted(pki, keys, issuer),
            "identity_certificate": certificate,
            "private_key": self._private_key(pki, keys, me),
            "permissions_ca": self._permissions_ca(pki, keys, self.permissions_ca) + "/cert.pem",
            "governance": self._signed_governance(pki, keys),
            "permissions": self._signed_permissions(pki, keys, me, certificate),
        }
        if self.crl:
            named = {"peer": peer, COMPANION: COMPANION}.get(self.crl, "stranger")
            own = f"list-{uuid.uuid4()}" if self.crl == "later" else None
            documents["crl"] = pki.crl(issuer, pki.leaf(named, keys.leaf, issuer), own)
        if self.password:
            shared += ["--password", PASSWORD]
        if self.keysize:
            shared += ["--keysize", str(self.keysize)]
        if self.cipher:
            shared += ["--cipher", self.cipher]
        return shared + [part for name, path in documents.items()
                         for part in ("--" + name, self._value(path))]

    def companion(self, pki, keys, samples):
        """The peer's value of --companion: another participant of the process under this governance,
        which leaves after so many samples."""
        certificate = pki.leaf(COMPANION, keys.leaf, self._identity_ca(pki, keys, self.signed_by),
                               until=_soon(self.identity_seconds))
        permissions = self._signed_permissions(pki, keys, COMPANION, certificate)
        return ",".join((certificate, pki.key(COMPANION, keys.leaf), permissions, str(samples)))

    def revoke_peer(self, pki, keys, starts, path):
        """Puts a CRL that names the peer in the place of the one configured."""
        issuer = self._identity_ca(pki, keys, self.signed_by)
        peer = pki.leaf(WAITER if starts else STARTER, keys.leaf, issuer)
        os.replace(pki.crl(issuer, peer, f"list-{uuid.uuid4()}"), path)

    def _value(self, path):
        if not self.data_uris:
            return path
        with open(path, newline="") as file:
            return "data:," + file.read()

    @staticmethod
    def _identity_ca(pki, keys, name):
        root = pki.ca("identity-main", keys.identity_ca) if name == "intermediate" else None
        return pki.ca(f"identity-{name}", keys.identity_ca, root)

    def _trusted(self, pki, keys, issuer):
        trusted = self._identity_ca(pki, keys, self.trusts)
        if self.signed_by == "intermediate":
            return pki.bundle(trusted, issuer)
        return trusted + "/cert.pem"

    def _permissions_ca(self, pki, keys, name):
        if name == "identity":
            return self._identity_ca(pki, keys, self.trusts)
        return pki.ca(f"permissions-{name}", keys.permissions_ca)

    def _private_key(self, pki, keys, me):
        if self.foreign_key:
            return pki.key("stranger", keys.leaf)
        return (pki.encrypted_key(me, keys.leaf, PASSWORD) if self.password
                else pki.key(me, keys.leaf))

    def _signed_governance(self, pki, keys):
        ca = self._permissions_ca(pki, keys, self.governance_by or self.permissions_ca)
        tamper = ("<max>230</max>", "<max>229</max>") if self.tamper == "governance" else None
        return pki.sign(self.governance.xml(), ca + "/cert.pem", ca + "/key.pem", tamper)

    def _signed_permissions(self, pki, keys, me, certificate):
        end = _soon(self.permissions_seconds)
        grants = self.permissions
        if end:
            grants = replace(grants, not_after=f"{end:%Y-%m-%dT%H:%M:%S}")
        document = grants.xml(me)
        if self.permissions_by == "leaf":
            return pki.sign(document, certificate, pki.key(me, keys.leaf))
        ca = self._permissions_ca(pki, keys, self.permissions_by)
        tamper = ("2037-", "2036-") if self.tamper == "permissions" else None
        return pki.sign(document, ca + "/cert.pem", ca + "/key.pem", tamper)

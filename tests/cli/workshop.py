"""Keys, certificates, documents and participants' folders for tests of the program, made with the openssl
program. Nothing of ddssec takes part in making them. Test keys, worthless outside a test."""

import datetime
import functools
import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
from pki import CA_CONFIGURATION, CA_EXTENSIONS  # noqa: E402
from pki import KEY_KINDS as USUAL_KINDS  # noqa: E402

KEY_KINDS = {**USUAL_KINDS, "rsa1024": ("RSA", "rsa_keygen_bits:1024"),
             "rsa3072": ("RSA", "rsa_keygen_bits:3072"), "ed25519": ("ED25519", None)}
LONG = ("20200101000000Z", "20361231000000Z")
# Tests name days about this one, on which the usual CAs end.
DAYS_OF_A_CA = str((datetime.date(2036, 11, 25) - datetime.date.today()).days)
PAST, FUTURE, END = ("2020-01-01T00:00:00Z", "2036-01-01T00:00:00Z", "2037-01-01T00:00:00Z")
GOVERNANCE = """<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <domain_access_rules>
    <domain_rule>
      <domains><id>0</id></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
"""
ALLOW = """<allow_rule>
        <domains><id>{domain}</id></domains>
        <publish><topics><topic>{topic}</topic></topics></publish>
        <subscribe><topics><topic>{topic}</topic></topics></subscribe>
      </allow_rule>"""


def allow(topic="Square", domain=0):
    return ALLOW.format(topic=topic, domain=domain)


def grant(subject, rules=None, begin=PAST, end=END, default="DENY", name=' name="participant"'):
    return f"""    <grant{name}>
      <subject_name>{subject}</subject_name>
      <validity><not_before>{begin}</not_before><not_after>{end}</not_after></validity>
      {rules or allow()}
      <default>{default}</default>
    </grant>
"""


def permissions(*grants):
    return ('<?xml version="1.0" encoding="UTF-8"?>\n<dds>\n  <permissions>\n' + "".join(grants) +
            "  </permissions>\n</dds>\n")


def openssl(*words, text=None):
    """`text`: what it reads, as text or as octets."""
    octets = text.encode() if isinstance(text, str) else text
    done = subprocess.run(["openssl", *map(str, words)], input=octets, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"openssl {' '.join(map(str, words))}: {done.stderr.decode(errors='replace')}")
    return done.stdout.decode(errors="replace")


NO_EXTENSIONS = "[req]\ndistinguished_name = none\n[none]\n"


@functools.cache
def has_x509v1():
    """Whether `openssl req` has the option -x509v1: from OpenSSL 3.2 on it adds key identifiers without it,
    and a certificate with extensions is of version 3."""
    done = subprocess.run(["openssl", "req", "-help"], capture_output=True, text=True, check=False)
    return "-x509v1" in done.stdout + done.stderr


class Workshop:
    """Keys, certificates and CAs, each made once."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)

    def key(self, name, kind="ec"):
        path = self.folder / f"{name}.{kind}.key"
        algorithm, option = KEY_KINDS[kind]
        if not path.exists():
            openssl("genpkey", "-algorithm", algorithm,
                    *(("-pkeyopt", option) if option else ()), "-out", path)
        return path

    def ca(self, label, subject=None, extensions=CA_EXTENSIONS, dates=None, kind="ec", root=None,
           digest="sha256"):
        """A CA's folder with cert.pem, key.pem and what `openssl ca` needs; self-signed, or below
        the CA folder `root`. Without extensions it is X.509 version 1."""
        folder = self.folder / f"ca-{label}"
        if folder.exists():
            return folder
        folder.mkdir()
        (folder / "openssl.cnf").write_text(CA_CONFIGURATION.format(folder=folder))
        (folder / "index.txt").touch()
        (folder / "serial").write_text("1000\n")
        os.link(self.key("ca-" + label, kind), folder / "key.pem")
        request = ("-key", folder / "key.pem", "-subj", subject or f"/CN={label} CA")
        is_usual = "basicConstraints=" in "".join(extensions) and digest == "sha256"
        if not extensions:
            self.version_1(*request, "-days", DAYS_OF_A_CA, "-out", folder / "cert.pem")
        elif dates is None and root is None and is_usual:
            openssl("req", "-x509", "-new", "-sha256", "-days", DAYS_OF_A_CA, *request,
                    *[part for text in extensions for part in ("-addext", text)],
                    "-out", folder / "cert.pem")
        else:
            openssl("req", "-new", *request, "-out", folder / "request.csr")
            (folder / "extensions").write_text("\n".join(extensions) + "\n")
            begin, end = dates or LONG
            openssl("ca", "-batch", "-notext", *(() if root else ("-selfsign",)), "-config",
                    (root or folder) / "openssl.cnf", "-md", digest, "-startdate", begin, "-enddate", end,
                    "-extfile", folder / "extensions", "-in", folder / "request.csr", "-out", folder / "cert.pem")
        return folder

    def version_1(self, *words):
        """A certificate of X.509 version 1, which has no extension."""
        configuration = self.folder / "no-extensions.cnf"
        configuration.write_text(NO_EXTENSIONS)
        openssl("req", "-x509", *(["-x509v1"] if has_x509v1() else []), "-new", "-sha256",
                "-config", configuration, *words)

    def leaf(self, label, ca, subject="/CN=talker", kind="ec", dates=None, extensions=None,
             digest="sha256"):
        """A certificate under `ca`, and its key."""
        path, key = self.folder / f"{label}.pem", self.key(label, kind)
        if path.exists():
            return path, key
        if dates is None and extensions is None:
            self.version_1("-key", key, "-subj", subject, "-CA", ca / "cert.pem", "-CAkey", ca / "key.pem",
                           "-days", "365", "-out", path)
            return path, key
        request = self.folder / f"{label}.csr"
        openssl("req", "-new", "-key", key, "-subj", subject, "-out", request)
        (self.folder / f"{label}.ext").write_text(extensions or "basicConstraints=CA:FALSE\n")
        begin, end = dates or LONG
        openssl("ca", "-batch", "-notext", "-config", ca / "openssl.cnf", "-md", digest, "-startdate", begin,
                "-enddate", end, "-preserveDN", "-extfile", self.folder / f"{label}.ext",
                "-in", request, "-out", path)
        return path, key

    def crl(self, label, ca, revoked=None, days=("-crldays", "365")):
        path = self.folder / f"{label}.crl"
        if path.exists():
            return path
        before = (ca / "index.txt").read_text()
        if revoked:
            openssl("ca", "-config", ca / "openssl.cnf", "-revoke", revoked)
        openssl("ca", "-config", ca / "openssl.cnf", "-gencrl", *days, "-out", path)
        (ca / "index.txt").write_text(before)
        return path


class Folder:
    """One participant's folder, correct until something is changed."""

    def __init__(self, shop, path, subject="/CN=talker", label="talker", **leaf):
        self.shop, self.path = shop, pathlib.Path(path)
        self.path.mkdir(parents=True)
        self.identity_ca, self.permissions_ca = shop.ca("identity"), shop.ca("permissions")
        leaf.setdefault("extensions", "basicConstraints=CA:FALSE\n")
        self.certificate, self.key = shop.leaf(label, leaf.pop("ca", self.identity_ca), subject,
                                               **leaf)
        self.subject = openssl("x509", "-in", self.certificate, "-noout", "-subject", "-nameopt",
                               "RFC2253").strip().removeprefix("subject=")
        self.put("identity_ca.pem", self.identity_ca / "cert.pem")
        self.put("permissions_ca.pem", self.permissions_ca / "cert.pem")
        self.put("cert.pem", self.certificate)
        self.put("key.pem", self.key, 0o600)
        self.sign("governance", GOVERNANCE)
        self.sign("permissions", permissions(grant(self.subject)))

    def put(self, name, source, mode=0o644):
        shutil.copyfile(source, self.path / name)
        os.chmod(self.path / name, mode)

    def sign(self, what, xml, *options, signer=None, form=("-text",), command="smime"):
        """Signs `xml` as the document `what`, the way `openssl smime -sign -text` does unless told."""
        certificate, key = signer or (self.permissions_ca / "cert.pem", self.permissions_ca / "key.pem")
        openssl(command, "-sign", *form, "-signer", certificate, "-inkey", key, *options,
                "-out", self.path / f"{what}.p7s", text=xml)
        os.chmod(self.path / f"{what}.p7s", 0o644)

    def own_permissions(self, *options, **more):
        self.sign("permissions", permissions(grant(self.subject)), *options, **more)

    def replace(self, name, old, new):
        path = self.path / name
        text = path.read_bytes()
        assert old.encode() in text, f"{name} has no {old}"
        path.write_bytes(text.replace(old.encode(), new.encode()))

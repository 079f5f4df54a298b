"""Keys, certificates and signed documents for the interop pairs, made by the openssl program.

Everything is made once per run and kept in one folder; asking again for the same thing returns the
same file. The class is the only place that knows how a document is made, so another tool can take
openssl's place here. Test keys: worthless outside a test.
"""

import base64
import hashlib
import os
import ssl
import subprocess
import threading

ORGANIZATION = "interop"
CA_EXTENSIONS = ("basicConstraints=critical,CA:TRUE",
                 "keyUsage=critical,keyCertSign,cRLSign,digitalSignature")
KEY_KINDS = {"ec": ("EC", "ec_paramgen_curve:prime256v1"),
             "ec384": ("EC", "ec_paramgen_curve:secp384r1"),
             "rsa": ("RSA", "rsa_keygen_bits:2048")}
CA_CONFIGURATION = """[ca]
default_ca = one
[one]
database = {folder}/index.txt
serial = {folder}/serial
new_certs_dir = {folder}
certificate = {folder}/cert.pem
private_key = {folder}/key.pem
default_md = sha256
default_crl_days = 365
policy = any
unique_subject = no
[any]
countryName = optional
organizationName = optional
commonName = supplied
"""


def der_name(common_name):
    """DER of the subject O=interop, CN=common_name with UTF-8 strings, as openssl writes it."""
    def block(tag, content):
        return bytes([tag, len(content)]) + content  # every length here is below 128

    def attribute(oid, text):
        return block(0x31, block(0x30, block(0x06, oid) + block(0x0C, text.encode())))
    return block(0x30, attribute(b"\x55\x04\x0a", ORGANIZATION) +
                 attribute(b"\x55\x04\x03", common_name))


def _name_where(prefix, wanted):
    for number in range(10000):
        name = f"{prefix}-{number}"
        if wanted(hashlib.sha256(der_name(name)).digest()[0]):
            return name
    raise AssertionError("no such name")


# A participant's GUID begins with one set bit and 47 bits of the SHA-256 of its subject name, and
# the lower GUID starts the handshake (DDS-Security 1.2, clause 10.3.3): the name decides who starts.
STARTER = _name_where("starter", lambda octet: octet < 0x40)
WAITER = _name_where("waiter", lambda octet: octet >= 0xC0)


def subject(common_name):
    """The subject as grants need it (RFC 2253 order)."""
    return f"CN={common_name},O={ORGANIZATION}"


class Pki:
    """A folder of keys, certificates and signed documents; safe to use from several threads."""

    def __init__(self, folder):
        self.folder = folder
        self._lock = threading.RLock()

    def _path(self, *parts):
        return os.path.join(self.folder, *parts)

    def _once(self, path, make):
        """Returns path, calling make() first if it is not there yet."""
        with self._lock:
            if not os.path.exists(path):
                make()
        return path

    @staticmethod
    def _openssl(*arguments, text=None):
        done = subprocess.run(["openssl", *arguments], input=text, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"openssl {' '.join(arguments)}: {done.stderr.strip()}")

    def key(self, name, kind):
        """A private key file; kind is one of KEY_KINDS."""
        path = self._path(f"{name}.{kind}.key")
        algorithm, option = KEY_KINDS[kind]
        return self._once(path, lambda: self._openssl("genpkey", "-algorithm", algorithm,
                                                      "-pkeyopt", option, "-out", path))

    def encrypted_key(self, name, kind, password):
        """The same key as key(name, kind), in a file that needs the password."""
        path = self._path(f"{name}.{kind}.encrypted.key")
        return self._once(path, lambda: self._openssl(
            "pkey", "-in", self.key(name, kind), "-aes256", "-passout", f"pass:{password}",
            "-out", path))

    def ca(self, name, kind, root=None):
        """A CA: the folder with cert.pem, key.pem and what `openssl ca` needs. Self-signed, or an
        intermediate under the CA folder `root`."""
        folder = self._path(f"ca-{name}-{kind}")
        certificate, key = f"{folder}/cert.pem", f"{folder}/key.pem"

        def make():
            os.mkdir(folder)
            with open(f"{folder}/openssl.cnf", "w") as file:
                file.write(CA_CONFIGURATION.format(folder=folder))
            open(f"{folder}/index.txt", "w").close()
            with open(f"{folder}/serial", "w") as file:
                file.write("1000\n")
            os.link(self.key(f"ca-{name}", kind), key)
            request = ["-new", "-key", key, "-sha256", "-subj", f"/O={ORGANIZATION}/CN={name}-ca"]
            if root is None:
                extensions = [part for text in CA_EXTENSIONS for part in ("-addext", text)]
                self._openssl("req", "-x509", "-days", "3650", *request, *extensions,
                              "-out", certificate)
                return
            self._openssl("req", *request, "-out", f"{folder}/request.csr")
            with open(f"{folder}/extensions", "w") as file:
                file.write("\n".join(CA_EXTENSIONS) + "\n")
            self._openssl("ca", "-batch", "-notext", "-config", f"{root}/openssl.cnf", "-days",
                          "3000", "-extfile", f"{folder}/extensions",
                          "-in", f"{folder}/request.csr", "-out", certificate)
        return self._once(folder, make)

    def bundle(self, *folders):
        """One file with the certificates of several CA folders."""
        path = self._path("+".join(os.path.basename(folder) for folder in folders) + ".pem")

        def make():
            texts = []
            for folder in folders:
                with open(f"{folder}/cert.pem") as file:
                    texts.append(file.read())
            with open(path, "w") as file:
                file.write("".join(texts))
        return self._once(path, make)

    def leaf(self, common_name, kind, ca, expired=False, until=None, key=None):
        """A participant certificate signed by the CA folder `ca`; `until` is a UTC datetime, and `key` the file of
        another key than key(common_name, kind)."""
        label = f"{common_name}-{kind}-under-{os.path.basename(ca)}"
        label += "-expired" if expired else f"-{until:%H%M%S%f}" if until else ""
        label += f"-{os.path.basename(key)}" if key else ""
        path = self._path(f"{label}.pem")

        def make():
            request = self._path(f"{label}.csr")
            self._openssl("req", "-new", "-key", key or self.key(common_name, kind), "-subj",
                          f"/O={ORGANIZATION}/CN={common_name}", "-out", request)
            dates = (["-startdate", "20200101000000Z", "-enddate", "20210101000000Z"] if expired
                     else ["-enddate", f"{until:%Y%m%d%H%M%SZ}"] if until else ["-days", "365"])
            self._openssl("ca", "-batch", "-notext", "-config", f"{ca}/openssl.cnf", *dates,
                          "-in", request, "-out", path)
            with open(path) as file:
                assert der_name(common_name) in ssl.PEM_cert_to_DER_cert(file.read())
        return self._once(path, make)

    def crl(self, ca, revoked, name=None):
        """A CRL of `ca` that names the certificate file `revoked` (a CA may have several CRLs), in a
        file of its own if it is given a name."""
        path = self._path(f"{name or os.path.basename(revoked)}.crl")

        def make():
            configuration = f"{ca}/openssl.cnf"
            index = f"{ca}/index.txt"
            with open(index) as file:
                before = file.read()
            self._openssl("ca", "-config", configuration, "-revoke", revoked)
            self._openssl("ca", "-config", configuration, "-gencrl", "-out", path)
            with open(index, "w") as file:
                file.write(before)
        return self._once(path, make)

    def sign(self, document, certificate, key, tamper=None):
        """The S/MIME file of a document's text; tamper=(old, new) changes it after signing."""
        stamp = hashlib.sha256(repr((document, certificate, key, tamper)).encode()).digest()
        path = self._path(base64.b32encode(stamp[:10]).decode().lower() + ".p7s")

        def make():
            self._openssl("smime", "-sign", "-text", "-signer", certificate, "-inkey", key,
                          "-out", path + ".new", text=document)
            if tamper:
                with open(path + ".new", newline="") as file:
                    signed = file.read()
                assert tamper[0] in signed
                with open(path + ".new", "w", newline="") as file:
                    file.write(signed.replace(*tamper))
            os.rename(path + ".new", path)
        return self._once(path, make)

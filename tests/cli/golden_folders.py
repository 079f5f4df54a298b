"""Participants' folders, each with one fault: what `ddssec doctor` is held to."""

import os
import pathlib
import shutil

import golden_texts
from workshop import CA_EXTENSIONS, GOVERNANCE, Folder, Workshop, grant, openssl, permissions

DATA = pathlib.Path(__file__).resolve().parent.parent / "data"
LONG_AGO = ("20200101000000Z", "20210101000000Z")
NOT_YET = ("20360101000000Z", "20361201000000Z")
FOLDERS = {}


def folder(maker):
    """Enters a maker into the table; its name is the folder's."""
    FOLDERS[maker.__name__.replace("_", "-")] = maker
    return maker


@folder
def correct(shop, path):
    Folder(shop, path)


@folder
def sros2_keystore(shop, path):
    """The keystore that sros2 made, with its links."""
    keystore = DATA / "sros2/generated/keystore"
    shutil.copytree(keystore, path.parent / "keystore", dirs_exist_ok=True)
    root = path.parent / "keystore"
    for role in ("identity_ca", "permissions_ca"):
        link(root / f"public/{role}.cert.pem", "ca.cert.pem")
    enclave = root / "enclaves/talker_listener/talker"
    for role in ("identity_ca", "permissions_ca"):
        link(enclave / f"{role}.cert.pem", f"../../../public/{role}.cert.pem")
    link(enclave / "governance.p7s", "../../governance.p7s")
    os.chmod(enclave / "key.pem", 0o600)
    link(path, enclave.relative_to(path.parent))


def link(path, target):
    if not path.is_symlink():
        path.symlink_to(target)


# ---- files

@folder
def permissions_missing(shop, path):
    Folder(shop, path)
    (path / "permissions.p7s").unlink()


@folder
def governance_link_broken(shop, path):
    Folder(shop, path)
    (path / "governance.p7s").unlink()
    (path / "governance.p7s").symlink_to("../nowhere/governance.p7s")


@folder
def certificate_garbage(shop, path):
    Folder(shop, path)
    (path / "cert.pem").write_text("-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n")


@folder
def key_readable_by_all(shop, path):
    Folder(shop, path)
    os.chmod(path / "key.pem", 0o644)


@folder
def ca_key_beside(shop, path):
    made = Folder(shop, path)
    made.put("ca.key.pem", made.identity_ca / "key.pem", 0o600)


# ---- keys and certificates

@folder
def key_encrypted(shop, path):
    made = Folder(shop, path)
    openssl("pkey", "-in", made.key, "-aes256", "-passout", "pass:golden", "-out", path / "key.pem")
    os.chmod(path / "key.pem", 0o600)


@folder
def key_of_another(shop, path):
    Folder(shop, path).put("key.pem", shop.key("stranger"), 0o600)


@folder
def p384(shop, path):
    Folder(shop, path, label="p384", kind="ec384")


@folder
def rsa_2048(shop, path):
    Folder(shop, path, label="rsa2048", kind="rsa")


@folder
def rsa_3072(shop, path):
    Folder(shop, path, label="rsa3072", kind="rsa3072")


@folder
def rsa_1024(shop, path):
    Folder(shop, path, label="rsa1024", kind="rsa1024")


@folder
def ed25519(shop, path):
    Folder(shop, path, label="ed25519", kind="ed25519", digest="default")


@folder
def ca_p384(shop, path):
    ca = shop.ca("p384", kind="ec384")
    Folder(shop, path, label="under-p384", ca=ca).put("identity_ca.pem", ca / "cert.pem")


@folder
def x509_v1(shop, path):
    Folder(shop, path, label="v1", extensions=None)


def identity_under(name, label, **ca):
    """A participant whose identity CA is made in another way."""
    def make(shop, path):
        made = shop.ca(label, **ca)
        Folder(shop, path, label="under-" + label, ca=made).put("identity_ca.pem", made / "cert.pem")
    FOLDERS[name] = make


def permissions_under(name, label, **ca):
    """Both documents signed by a permissions CA that is made in another way."""
    def make(shop, path):
        made = Folder(shop, path)
        made.permissions_ca = shop.ca(label, **ca)
        made.put("permissions_ca.pem", made.permissions_ca / "cert.pem")
        made.sign("governance", GOVERNANCE)
        made.own_permissions()
    FOLDERS[name] = make


# Version 3 whose keyUsage alone says that it is a CA.
KEY_USAGE_ONLY = ("keyUsage=critical,keyCertSign,cRLSign,digitalSignature",)
identity_under("x509-v1-ca", "version-1", extensions=())
permissions_under("x509-v1-permissions-ca", "version-1-permissions", extensions=())
identity_under("identity-ca-no-constraints", "no-constraints", extensions=KEY_USAGE_ONLY)
permissions_under("permissions-ca-no-constraints", "no-constraints-permissions", extensions=KEY_USAGE_ONLY)
identity_under("identity-ca-sha512", "sha512-ca", digest="sha512")
permissions_under("permissions-ca-sha512", "sha512-permissions", digest="sha512")


@folder
def identity_other_ca_same_name(shop, path):
    Folder(shop, path, label="impostor", ca=shop.ca("impostor", "/CN=identity CA"))


@folder
def identity_unknown_ca(shop, path):
    Folder(shop, path, label="foreigner", ca=shop.ca("foreign"))


@folder
def identity_expired(shop, path):
    Folder(shop, path, label="expired", dates=LONG_AGO)


@folder
def identity_not_yet_valid(shop, path):
    Folder(shop, path, label="future", dates=NOT_YET)


@folder
def identity_ca_expired(shop, path):
    ca = shop.ca("old", dates=LONG_AGO)
    Folder(shop, path, label="under-old", ca=ca).put("identity_ca.pem", ca / "cert.pem")


@folder
def identity_ca_is_none(shop, path):
    """The participant's own certificate in the place of the CA's."""
    made = Folder(shop, path)
    made.put("identity_ca.pem", made.certificate)


@folder
def identity_below_intermediate(shop, path):
    root = shop.ca("identity")
    middle = shop.ca("middle", root=root)
    made = Folder(shop, path, label="below-middle", ca=middle)
    text = (root / "cert.pem").read_text() + (middle / "cert.pem").read_text()
    (made.path / "identity_ca.pem").write_text(text)


@folder
def identity_below_intermediate_only(shop, path):
    """The CA file holds the intermediate without its root."""
    middle = shop.ca("middle", root=shop.ca("identity"))
    Folder(shop, path, label="below-middle", ca=middle).put("identity_ca.pem", middle / "cert.pem")


@folder
def identity_ca_file_of_two(shop, path):
    """The issuing CA comes second in its file."""
    made = Folder(shop, path)
    text = (shop.ca("foreign") / "cert.pem").read_text() + made.identity_ca.joinpath(
        "cert.pem").read_text()
    (made.path / "identity_ca.pem").write_text(text)


def permissions_middle(name, *files):
    def make(shop, path):
        made = Folder(shop, path)
        middle = shop.ca("permissions-middle", root=shop.ca("permissions"))
        folders = {"root": made.permissions_ca, "middle": middle}
        (path / "permissions_ca.pem").write_text(
            "".join((folders[file] / "cert.pem").read_text() for file in files))
        signer = (middle / "cert.pem", middle / "key.pem")
        made.sign("governance", GOVERNANCE, signer=signer)
        made.own_permissions(signer=signer)
    FOLDERS[name] = make


permissions_middle("permissions-by-intermediate", "root", "middle")
permissions_middle("permissions-by-intermediate-first", "middle", "root")
permissions_middle("permissions-by-intermediate-only", "middle")
permissions_middle("permissions-by-unlisted-intermediate", "root")


@folder
def identity_below_missing_intermediate(shop, path):
    Folder(shop, path, label="below-middle", ca=shop.ca("middle", root=shop.ca("identity")))


@folder
def identity_key_usage(shop, path):
    Folder(shop, path, label="encipher", extensions="keyUsage=critical,keyEncipherment\n")


@folder
def identity_sha1(shop, path):
    Folder(shop, path, label="sha1", digest="sha1")


@folder
def identity_sha384(shop, path):
    Folder(shop, path, label="sha384", digest="sha384")


@folder
def identity_sha512(shop, path):
    Folder(shop, path, label="sha512", digest="sha512")


permissions_under("permissions-ca-expired", "old", dates=LONG_AGO)
permissions_under("permissions-ca-may-not-sign", "nosign",
                  extensions=(CA_EXTENSIONS[0], "keyUsage=critical,keyCertSign,cRLSign"))


@folder
def crl_empty(shop, path):
    made = Folder(shop, path)
    made.put("crl.pem", shop.crl("empty", made.identity_ca))


@folder
def crl_der(shop, path):
    made = Folder(shop, path)
    made.put("crl.pem", shop.crl("empty", made.identity_ca))
    openssl("crl", "-in", path / "crl.pem", "-outform", "DER", "-out", path / "crl.der")
    (path / "crl.der").replace(path / "crl.pem")


@folder
def crl_names_own(shop, path):
    made = Folder(shop, path)
    made.put("crl.pem", shop.crl("own", made.identity_ca, made.certificate))


@folder
def crl_expired(shop, path):
    made = Folder(shop, path)
    made.put("crl.pem", shop.crl("old", made.identity_ca, days=(
        "-crl_lastupdate", "20200101000000Z", "-crl_nextupdate", "20210101000000Z")))


@folder
def crl_of_other_ca(shop, path):
    Folder(shop, path).put("crl.pem", shop.crl("foreign", shop.ca("foreign")))


# ---- signed documents

@folder
def permissions_changed(shop, path):
    Folder(shop, path).replace("permissions.p7s", "Square", "Circle")


@folder
def governance_changed(shop, path):
    Folder(shop, path).replace("governance.p7s", "<id>0</id>", "<id>1</id>")


@folder
def permissions_unsigned(shop, path):
    made = Folder(shop, path)
    (path / "permissions.p7s").write_text(permissions(grant(made.subject)))


@folder
def governance_unsigned(shop, path):
    Folder(shop, path)
    (path / "governance.p7s").write_text(GOVERNANCE)


@folder
def permissions_by_itself(shop, path):
    """One CA for both roles; the participant signed its permissions with its own key."""
    made = Folder(shop, path)
    made.permissions_ca = made.identity_ca
    made.put("permissions_ca.pem", made.identity_ca / "cert.pem")
    made.sign("governance", GOVERNANCE)
    made.own_permissions(signer=(made.certificate, made.key))


@folder
def permissions_by_foreign_ca(shop, path):
    ca = shop.ca("foreign")
    Folder(shop, path).own_permissions(signer=(ca / "cert.pem", ca / "key.pem"))


@folder
def permissions_by_ca_of_same_name(shop, path):
    ca = shop.ca("impostor-permissions", "/CN=permissions CA")
    Folder(shop, path).own_permissions(signer=(ca / "cert.pem", ca / "key.pem"))


@folder
def governance_by_foreign_ca(shop, path):
    ca = shop.ca("foreign")
    Folder(shop, path).sign("governance", GOVERNANCE, signer=(ca / "cert.pem", ca / "key.pem"))


def form(name, *options, form=("-text",), command="smime"):
    def make(shop, path):
        made = Folder(shop, path)
        made.own_permissions(*options, form=form, command=command)
    FOLDERS[name] = make


form("form-cms", command="cms")
form("form-no-text", form=())
form("form-text-binary", form=("-text", "-binary"))
form("form-opaque-text", form=("-text", "-nodetach"))
form("form-opaque", form=("-nodetach",))
form("form-nocerts", "-nocerts")
form("form-pem", "-outform", "PEM")
form("form-der", "-outform", "DER")
form("form-sha512", "-md", "sha512")
form("form-sha1", "-md", "sha1")
form("form-noattr", "-noattr")


@folder
def form_crlf(shop, path):
    Folder(shop, path)
    text = (path / "permissions.p7s").read_bytes()
    (path / "permissions.p7s").write_bytes(text.replace(b"\r\n", b"\n").replace(b"\n", b"\r\n"))


@folder
def form_lf(shop, path):
    Folder(shop, path)
    text = (path / "permissions.p7s").read_bytes()
    (path / "permissions.p7s").write_bytes(text.replace(b"\r\n", b"\n"))


@folder
def form_crcrlf(shop, path):
    """As OpenSSL's S/MIME comes from Windows: one more CR before each CRLF of the text."""
    Folder(shop, path)
    for name in ("governance.p7s", "permissions.p7s"):
        text = (path / name).read_bytes()
        (path / name).write_bytes(text.replace(b"\n", b"\r\n"))
        assert b"\r\r\n" in (path / name).read_bytes()


FOLDERS.update(golden_texts.FOLDERS)


def make_all(where, names=None):
    """Every folder below `where`/golden; the path of each by its name."""
    shop = Workshop(pathlib.Path(where) / "workshop")
    golden = pathlib.Path(where) / "golden"
    golden.mkdir(parents=True)
    for name in names or FOLDERS:
        FOLDERS[name](shop, golden / name)
    return {name: golden / name for name in names or FOLDERS}

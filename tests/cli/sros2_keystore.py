"""A keystore as sros2 makes it: one CA, keys that every user can read."""

import pathlib
import shutil

DATA = pathlib.Path(__file__).resolve().parent.parent / "data/sros2/generated/keystore"
ENCLAVES = ("wildcard", "talker_listener/talker", "talker_listener/listener")


def links_of(enclave):
    """The links that sros2 makes in an enclave."""
    up = "/".join([".."] * len(enclave.split("/")))
    return {"identity_ca.cert.pem": f"{up}/../public/identity_ca.cert.pem",
            "permissions_ca.cert.pem": f"{up}/../public/permissions_ca.cert.pem",
            "governance.p7s": f"{up}/governance.p7s"}


def make_keystore(keystore):
    shutil.copytree(DATA, keystore)
    for role in ("identity_ca", "permissions_ca"):  # the data come without their links
        (keystore / f"public/{role}.cert.pem").symlink_to("ca.cert.pem")
        (keystore / f"private/{role}.key.pem").symlink_to("ca.key.pem")
    for enclave in ENCLAVES:
        for name, to in links_of(enclave).items():
            (keystore / "enclaves" / enclave / name).symlink_to(to)
    for key in keystore.rglob("*key.pem"):
        if not key.is_symlink():
            key.chmod(0o644)

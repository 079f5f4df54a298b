"""What the benchmarks of processes share: a network of their own, documents, and what they ran on."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "interop"))
from documents import DOMAIN, Governance, Permissions  # noqa: E402
from pki import Pki  # noqa: E402

SROS2 = Governance(discovery="ENCRYPT", liveliness="ENCRYPT", rtps="SIGN", metadata="ENCRYPT",
                   data="ENCRYPT")
ENCRYPT = Governance(discovery="ENCRYPT", liveliness="ENCRYPT", rtps="ENCRYPT", metadata="ENCRYPT",
                     data="ENCRYPT")


def many_topics(count):
    """All topics, and names of others that make the document as long as a system of so many has it."""
    return ("*", *(f"unused/by/this/participant/{i:04}" for i in range(count)))


def make_folders(base, names=("one", "other"), governance=SROS2, topics=("*",), partition=""):
    """A folder as --security wants it for each of the participants."""
    pki, permissions = Pki(base), Permissions(topics, topics[:1], partition, DOMAIN)
    return [make_folder(pki, name, governance, permissions) for name in names]


def make_folder(pki, name, governance, permissions):
    """The folder of one participant of the keystore."""
    identity, authority = pki.ca("identity", "ec"), pki.ca("permissions", "ec")
    signer = f"{authority}/cert.pem", f"{authority}/key.pem"
    folder = os.path.join(pki.folder, "participant-" + name)
    os.makedirs(folder, exist_ok=True)
    documents = {"identity_ca.pem": f"{identity}/cert.pem", "cert.pem": pki.leaf(name, "ec", identity),
                 "key.pem": pki.key(name, "ec"), "permissions_ca.pem": signer[0],
                 "governance.p7s": pki.sign(governance.xml(), *signer),
                 "permissions.p7s": pki.sign(permissions.xml(name), *signer)}
    for document, source in documents.items():
        shutil.copy(source, os.path.join(folder, document))
    return folder


def in_own_namespace():
    """Runs this program again where only its own processes are on the loopback interface."""
    if os.environ.get("DDSSEC_BENCH_NAMESPACE") == "1":
        subprocess.run("ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo", shell=True, check=True)
        return
    unshare = ["unshare", "--net"] if os.geteuid() == 0 else ["unshare", "--net", "--map-root-user"]
    os.environ["DDSSEC_BENCH_NAMESPACE"] = "1"
    os.execvp("unshare", unshare + [sys.executable, *sys.argv])


def machine():
    model = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{model.group(1) if model else 'unknown CPU'}, {os.cpu_count()} cores, {time.strftime('%Y-%m-%d')}"

"""Runs the ROS 2 nodes of ../shared/ros2 (beside the source tree) in networks of their own, secured by a keystore
that `ddssec` made, on stock plugins or on ours.

Usage: nodes.py ROS2      exit 77 with the reason if the nodes cannot run here
"""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

sys.dont_write_bytecode = True
TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS / "interop"), str(TESTS / "cli")]
from pair import Namespace  # noqa: E402
from sros2_keystore import make_keystore as copy_of_sros2_keystore  # noqa: E402

PATIENCE = 20.0  # seconds
NOT_RUN = 77     # what ctest shows as skipped
ROLES = ("authentication", "access_control", "cryptography")
STOCK, OURS = "stock", "ours"
PLUGINS = {STOCK: {f"libdds_security_{name}.so" for name in ("auth", "ac", "crypto")},
           OURS: {f"libddssec_{name}.so" for name in ROLES}, None: set()}
PLUGIN = re.compile(r"(libdds_security_(?:auth|ac|crypto)\.so|libddssec_(?:authentication|access_control|cryptography)\.so)")
CLOSED = "passphrase.txt"


class Fault(AssertionError):
    """What a row found wrong."""


def check(is_so, what):
    if not is_so:
        raise Fault(what)


def reason_not_to_run(ros2):
    """Why the nodes cannot run here; None if they can."""
    if not (ros2 / "run.sh").exists():
        return f"there is no {ros2}"
    libraries = [ros2 / "lib" / "librmw_cyclonedds_cpp.so", ros2 / "bin" / "talker", ros2 / "lib" / "libclass_loader.so"]
    linked = subprocess.run(["ldd", *libraries], text=True, capture_output=True, check=False,
                            env={**os.environ, "LD_LIBRARY_PATH": str(ros2 / "lib")}).stdout
    missing = sorted({line.split()[0] for line in linked.splitlines() if "not found" in line})
    return f"the nodes need {', '.join(missing)} (scripts/bootstrap.sh --dev installs them on Debian 12)" if missing else None


def refuse_to_run(ros2):
    """The exit status: 77 with a line that says why, where the nodes cannot run; 0 where they can."""
    reason = reason_not_to_run(ros2)
    if reason:
        print(f"NOT RUN: no ROS 2 node was tried on the plugins, since {reason}", flush=True)
    return NOT_RUN if reason else 0


class Keystore:
    """A keystore of sros2's layout. `ddssec`: the program; `ros2`: the folder with the policies."""

    def __init__(self, folder, ddssec, ros2):
        self.path, self._ddssec = pathlib.Path(folder) / "keystore", ddssec
        self._closed = pathlib.Path(folder) / CLOSED
        self._closed.write_text("a passphrase of a test\n", encoding="utf-8")
        self._closed.chmod(0o600)
        self.run("keystore", "create", self.path)
        for policy, nodes in (("talker_listener", ("talker", "listener")),
                              ("add_two_ints", ("add_two_ints_server", "add_two_ints_client"))):
            for node in nodes:
                self.run("keystore", "enclave", self.path, f"/{policy}/{node}", "--policy",
                         ros2 / "policies" / f"{policy}.policy.xml")

    def run(self, *command):
        done = subprocess.run([self._ddssec, *command, "--passphrase-file", self._closed], text=True,
                              capture_output=True, check=False)
        if done.returncode != 0:
            raise Fault(f"ddssec {' '.join(map(str, command))}: {done.stdout}{done.stderr}")

    def distribute(self):
        done = subprocess.run([self._ddssec, "crl", "distribute", "--ca", self.path], text=True, capture_output=True,
                              check=False)
        check(done.returncode == 0, f"ddssec crl distribute: {done.stdout}{done.stderr}")

    def enclave(self, node):
        return next(self.path.glob(f"enclaves/**/{node}"))

    def copy(self, folder):
        """For a row that changes something that belongs to no CA. Its revocation lists are not its own."""
        copied = Keystore.__new__(Keystore)
        copied.path = pathlib.Path(folder) / "keystore"
        shutil.copytree(self.path, copied.path, symlinks=True)
        return copied


def keystore_of_sros2(folder):
    """A copy of tests/data/sros2, which sros2 made, with keys that every user can read, as sros2 leaves them."""
    copied = Keystore.__new__(Keystore)
    copied.path = pathlib.Path(folder) / "keystore"
    copy_of_sros2_keystore(copied.path)
    return copied


class Node:
    """One running node."""

    def __init__(self, setting, node, kind, keystore, *arguments, strategy="Enforce"):
        self.name, self.kind = node, kind
        self._log = pathlib.Path(setting.folder) / f"{node}-{kind}.log"
        environment = {name: value for name, value in os.environ.items()
                       if not name.startswith(("ROS_", "CYCLONEDDS_", "DDSSEC_"))}
        environment |= {"ROS_SECURITY_KEYSTORE": str(keystore.path), "ROS_SECURITY_ENABLE": "true",
                        "ROS_SECURITY_STRATEGY": strategy, "RCUTILS_COLORIZED_OUTPUT": "0"}
        environment.pop("LD_LIBRARY_PATH", None)
        if kind == OURS:
            environment["DROPIN"] = str(setting.dropin)
        enclave = "/" + str(keystore.enclave(node).relative_to(keystore.path / "enclaves"))
        command = [setting.ros2 / "run.sh", node, "--ros-args", "--enclave", enclave, *arguments]
        with open(self._log, "wb") as output:
            self.process = subprocess.Popen(setting.namespace.enter(command), env=environment, stdout=output,
                                            stderr=subprocess.STDOUT)

    @property
    def log(self):
        return self._log.read_text(encoding="utf-8", errors="replace")

    def count(self, pattern):
        return len(re.findall(pattern, self.log))

    def until(self, pattern, times=1):
        """Waits until the log holds the pattern that often."""
        end = time.monotonic() + PATIENCE
        while self.count(pattern) < times:
            ended = self.process.poll()
            if (ended is not None or time.monotonic() > end) and self.count(pattern) < times:
                raise Fault(f"{self.name} on {self.kind} plugins did not say '{pattern}' {times} times; it "
                            f"{'runs' if ended is None else f'ended with {ended}'}:\n{self.log}")
            time.sleep(0.02)

    def ends(self):
        """Waits until it ends by itself; its status."""
        try:
            return self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            raise Fault(f"{self.name} on {self.kind} plugins runs on:\n{self.log}") from None

    def uses(self, kind):
        """The plugins meant are the ones in use, and no others."""
        maps = pathlib.Path(f"/proc/{self.process.pid}/maps").read_text(encoding="utf-8")
        found = set(PLUGIN.findall(maps))
        check(found == PLUGINS[kind], f"{self.name} uses {sorted(found)}, not {sorted(PLUGINS[kind])}")

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(5)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()


class Setting:
    """A network and a folder of a row's own, with the nodes that it starts; leaving it ends them."""

    def __init__(self, folder, build, ros2):
        self.folder, self.dropin, self.ros2 = folder, build / "dropin", ros2
        self.namespace, self._nodes = None, []

    def __enter__(self):
        os.makedirs(self.folder)
        self.namespace = Namespace()
        return self

    def __exit__(self, *_):
        for node in self._nodes:
            node.stop()
        self.namespace.close()

    def start(self, node, kind, keystore, *arguments, **words):
        self._nodes.append(Node(self, node, kind, keystore, *arguments, **words))
        return self._nodes[-1]


if __name__ == "__main__":
    sys.exit(refuse_to_run(pathlib.Path(sys.argv[1]).resolve()))

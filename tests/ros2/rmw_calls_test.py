#!/usr/bin/env python3
"""The calls of rmw_cyclonedds on stock and on our plugins, under permissions that allow the least: everything that
a ROS 2 node needs is created, also Cyclone's builtin topics, which no policy names, and nothing else is. The same with
a keystore that sros2 made.

Usage: rmw_calls_test.py BUILD      in a network of its own
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True

from nodes import OURS, PATIENCE, PLUGIN, PLUGINS, STOCK, Fault, check, keystore_of_sros2  # noqa: E402

BUILD = pathlib.Path(sys.argv[1]).resolve()
POLICY = pathlib.Path(__file__).resolve().parent / "node.policy.xml"


def make_keystore(folder):
    """The folder of its one enclave."""
    closed = folder / "passphrase.txt"
    closed.write_text("a passphrase of a test\n", encoding="utf-8")
    closed.chmod(0o600)
    for command in (["create", folder / "keystore"],
                    ["enclave", folder / "keystore", "/least", "--policy", POLICY]):
        subprocess.run([BUILD / "bin" / "ddssec", "keystore", *command, "--passphrase-file", closed], check=True,
                       stdout=subprocess.DEVNULL)
    enclave = folder / "keystore" / "enclaves" / "least"
    permissions = (enclave / "permissions.xml").read_text(encoding="utf-8")
    check("<default>DENY</default>" in permissions, f"the permissions do not deny by default:\n{permissions}")
    return enclave


class Calls:
    """One running program; the enclave's last name is the node's."""

    def __init__(self, kind, enclave, *topic):
        environment = {name: value for name, value in os.environ.items()
                       if not name.startswith(("CYCLONEDDS_", "DDSSEC_")) and name != "LD_LIBRARY_PATH"}
        if kind == OURS:
            environment["LD_LIBRARY_PATH"] = str(BUILD / "dropin")
        self.kind = kind
        self._log = tempfile.TemporaryFile("w+", encoding="utf-8")
        self.process = subprocess.Popen([BUILD / "bin" / "rmw_calls", enclave, enclave.name, *topic], env=environment,
                                        stdin=subprocess.PIPE, stdout=self._log, stderr=subprocess.STDOUT)

    def log(self):
        return os.pread(self._log.fileno(), 1 << 20, 0).decode(errors="replace")

    def until(self, line):
        """Waits until it said that."""
        end = time.monotonic() + PATIENCE
        while line not in self.log().splitlines():
            ended = self.process.poll() is not None
            if (ended or time.monotonic() > end) and line not in self.log().splitlines():
                raise Fault(f"'{line}' was not said on {self.kind} plugins:\n{self.log()}")
            time.sleep(0.02)

    def uses_what_is_meant(self):
        found = set(PLUGIN.findall(pathlib.Path(f"/proc/{self.process.pid}/maps").read_text(encoding="utf-8")))
        check(found == PLUGINS[self.kind], f"{sorted(found)} are in use, not the {self.kind} plugins")

    def ends(self):
        self.process.stdin.close()
        return self.process.wait(PATIENCE)


def end_well(both):
    for one in both:
        status, log = one.ends(), one.log()
        check(status == 0, f"exit status {status} on {one.kind} plugins:\n{log}")
        # About this machine's OpenSSL there may be a warning.
        other = "".join(line for line in log.splitlines(True) if "[openssl_known_unsafe 1624]" not in line)
        check("ddssec error" not in other and "ddssec warning" not in other, f"complaints:\n{log}")
        check(log.count("[plugins_in_use 1620]") == (one.kind == OURS), f"whose plugins are these?\n{log}")


def meet(enclave, kinds):
    both = [Calls(kind, enclave, "chatter") for kind in kinds]
    for one in both:
        one.until("created")
        one.uses_what_is_meant()
    for one in both:
        one.until("met")
    end_well(both)


def hear(enclaves, kinds):
    """The first of the two enclaves publishes, the second hears it."""
    both = [Calls(kind, enclave, "chatter", direction)
            for kind, enclave, direction in zip(kinds, enclaves, ("publish", "subscribe"))]
    for one in both:
        one.until("created")
        one.uses_what_is_meant()
    both[1].until("heard")
    end_well(both)


REFUSALS = {"dds_create_topic": "topic_not_allowed 1423]", "dds_create_reader": "subscribe_not_allowed 1422]"}


def refused(call, kind, enclave, *topic):
    one = Calls(kind, enclave, *topic)
    one.until(f"failed: {call} rt/{topic[0]}: Not Allowed By Security")
    status, log = one.ends(), one.log()
    check(status == 1, f"exit status {status}")
    check(kind == STOCK or log.count(REFUSALS[call]) == 1, f"the reason is not said once:\n{log}")


def rows(folder):
    (folder / "sros2").mkdir()
    enclave, sros2 = make_keystore(folder), keystore_of_sros2(folder / "sros2")
    talker, listener, wildcard = map(sros2.enclave, ("talker", "listener", "wildcard"))
    for a, b in ((OURS, OURS), (OURS, STOCK), (STOCK, STOCK)):
        yield f"{a} and {b}", meet, (enclave, (a, b))
    for kind in (OURS, STOCK):
        yield f"a topic outside the policy, {kind}", refused, ("dds_create_topic", kind, enclave, "forbidden")
    for kinds in ((OURS, OURS), (OURS, STOCK), (STOCK, OURS), (STOCK, STOCK)):
        named = f"sros2's keystore, {kinds[0]} to {kinds[1]}"
        yield named, hear, ((talker, listener), kinds)
        yield f"{named}, policy that allows all", hear, ((wildcard, wildcard), kinds)
    for kind in (OURS, STOCK):
        yield (f"sros2's keystore, the talker subscribes, {kind}", refused,
               ("dds_create_reader", kind, talker, "chatter", "subscribe"))
        yield (f"sros2's keystore, a topic outside the policy, {kind}", refused,
               ("dds_create_topic", kind, talker, "forbidden", "publish"))


def main():
    failed = 0
    with tempfile.TemporaryDirectory(prefix="ddssec-rmw-") as folder:
        for name, row, arguments in rows(pathlib.Path(folder)):
            begin, fault = time.monotonic(), None
            try:
                row(*arguments)
            except (Fault, subprocess.TimeoutExpired) as one:
                fault, failed = one, failed + 1
            print(f"{'FAILED' if fault else 'ok':8}{name} ({time.monotonic() - begin:.1f} s)"
                  + (f": {fault}" if fault else ""), flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

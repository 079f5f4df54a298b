#!/usr/bin/env python3
"""The seven tasks of securing a DDS system, each in as few commands as we promise, counted here; then
Cyclone DDS, Fast DDS and our plugins run on what came of them.

Usage: seven_tasks_test.py DDSSEC [DROPIN]; the peers of tests/interop stand beside DDSSEC.
"""

import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
DROPIN = pathlib.Path(sys.argv.pop(2)).resolve()

import forecast  # noqa: E402
from pair import Namespace  # noqa: E402
from products import start  # noqa: E402
from transcript import PROGRAM, Transcript, main  # noqa: E402

# As `check` names them: with the versions that are installed.
VENDORS = {name.split("@")[0]: name for name in forecast.installed(PROGRAM.resolve().parent.parent)}
VENDORS["embedded"] = "ddssec"
# Since 2.10 Fast DDS discovers nothing of Cyclone DDS 0.10 when secured, with any plugins.
MEETS_CYCLONE_DDS = tuple(map(int, VENDORS["fastdds"].split("@")[1].split(".")[:2])) < (2, 10)

FLEET = "\n".join(f"""[[participant]]
name = "p{i}"
{"publish" if i % 2 == 0 else "subscribe"} = ["Square"]
""" for i in range(10))
PASSPHRASE = ("--passphrase-file", "passphrase")
SECONDS = 8


class SevenTasks(Transcript):
    @classmethod
    def setUpClass(cls):
        cls.namespace = Namespace()
        cls.addClassCleanup(cls.namespace.close)

    def setUp(self):
        super().setUp()
        self.count = 0
        (self.at / "passphrase").write_text("seven tasks\n")

    def user(self, *words, exit=0):
        """What a person types: it counts."""
        self.count += 1
        return self.json(*words, exit=exit)

    def took(self, commands):
        self.assertEqual(self.count, commands)
        self.count = 0

    def peer(self, product, folder, role):
        return start(self.namespace, product, self.at / folder, role, SECONDS, DROPIN)

    def run_both(self, writer, reader, a, b, works):
        """Either all samples arrive, or the two do not match."""
        both = [self.peer(a, writer, "--publish"), self.peer(b, reader, "--subscribe")]
        said = [one.communicate(timeout=60)[0] for one in both]
        ended = [one.returncode for one in both]
        self.assertEqual(ended == [0, 0], works, f"{a} -> {b}: {ended}\n{said}")

    def check(self, writer, reader, a, b, works):
        return self.json("check", writer, reader, "--topics", "Square", "--require", "writer=A", "--vendor",
                         f"A={VENDORS[a]}", "--vendor", f"B={VENDORS[b]}", exit=0 if works else 1)

    def exchange(self, writer, reader, products=(("cyclonedds",) * 2, ("fastdds",) * 2), works=True):
        """The products do what `check` says."""
        for a, b in products:
            self.run_both(writer, reader, a, b, works)
            self.check(writer, reader, a, b, works)

    def meet_fastdds(self, writer, reader):
        """ddssec and Fast DDS: the embedded participant with every version, the plugins in Cyclone DDS up to 2.9."""
        self.exchange(writer, reader, (("embedded", "fastdds"), ("fastdds", "embedded")))
        plugins = (("ddssec", "fastdds"), ("fastdds", "ddssec"))
        if MEETS_CYCLONE_DDS:
            return self.exchange(writer, reader, plugins)
        print(f"{VENDORS['fastdds']} must discover nothing of {VENDORS['cyclonedds']} with ddssec's plugins")
        for a, b in plugins:
            self.run_both(writer, reader, a, b, works=False)
            told = self.check(writer, reader, a, b, works=True)  # of the embedded participant, and says so
            self.assertIn("only of ddssec's embedded participant", " ".join(d["message"] for d in told["diagnostics"]))
        return None

    def production(self):
        self.user("ca", "create", "ca", *PASSPHRASE)
        self.user("governance", "new", "--sign", "--ca", "ca", *PASSPHRASE, "-o", "governance.xml")
        (self.at / "participants.toml").write_text(FLEET)
        self.user("identity", "issue", "--from", "participants.toml", "--ca", "ca", *PASSPHRASE,
                  "--governance", "governance.p7s", "-o", "fleet")

    def test_1_a_demo_in_one_command(self):
        self.user("init", "demo")
        self.took(1)
        self.exchange("demo/talker", "demo/listener")
        self.meet_fastdds("demo/talker", "demo/listener")

    def test_2_production_with_distinct_rights_in_three(self):
        self.production()
        self.took(3)
        for i in range(10):
            self.json("doctor", f"fleet/p{i}")
        self.exchange("fleet/p0", "fleet/p1")
        self.exchange("fleet/p1", "fleet/p2", (("cyclonedds",) * 2,), works=False)

    def test_3_one_more_participant_in_one(self):
        self.production()
        self.count = 0
        self.user("identity", "issue", "late", "--ca", "ca", *PASSPHRASE, "--governance",
                  "governance.p7s", "--subscribe", "Square", "-o", "fleet/late")
        self.took(1)
        self.exchange("fleet/p0", "fleet/late")

    def test_4_other_rights_in_one_after_a_look_at_the_difference(self):
        self.production()
        self.count = 0
        self.user("permissions", "new", "--cert", "fleet/p2/cert.pem", "--subscribe", "Square", "--sign",
                  "--ca", "ca", *PASSPHRASE, "-o", "new.xml")
        self.took(1)
        self.user("permissions", "diff", "fleet/p2/permissions.p7s", "new.p7s", "--fail-on", "wider", exit=1)
        shutil.copy(self.at / "new.p7s", self.at / "fleet/p2/permissions.p7s")  # to the device
        self.exchange("fleet/p0", "fleet/p2")

    def test_5_a_renewed_certificate_in_one(self):
        self.production()
        self.count = 0
        before = self.json("identity", "show", "fleet/p0")["result"]
        self.user("identity", "renew", "fleet/p0", "--ca", "ca", *PASSPHRASE, "--days", "400",
                  "--permissions")
        self.took(1)
        after = self.json("identity", "show", "fleet/p0")["result"]
        self.assertLess(before["not_after"], after["not_after"])
        self.json("doctor", "fleet/p0")
        self.exchange("fleet/p0", "fleet/p1")

    def test_6_a_revocation_in_one_and_its_distribution_in_one(self):
        self.production()
        self.count = 0
        self.user("identity", "revoke", "fleet/p0", "--ca", "ca", *PASSPHRASE)
        self.took(1)
        self.user("crl", "distribute", "--ca", "ca")
        self.took(1)
        self.exchange("fleet/p2", "fleet/p1")
        self.exchange("fleet/p0", "fleet/p1", works=False)

    def test_7_why_two_do_not_talk_in_one(self):
        self.production()
        self.count = 0
        other = self.at / "fleet/p1/governance.p7s"
        self.run_program("governance", "new", "--profile", "balanced", "--sign", "--ca", "ca",
                         *PASSPHRASE, "-o", "other.xml")
        shutil.copy(self.at / "other.p7s", other)
        told = self.user("check", "fleet/p0", "fleet/p1", exit=1)
        self.took(1)
        self.assertIn("<metadata_protection_kind> is ENCRYPT at p0 (governance.p7s:",
                      " ".join(d["message"] for d in told["diagnostics"]))
        self.exchange("fleet/p0", "fleet/p1", works=False)


if __name__ == "__main__":
    main()

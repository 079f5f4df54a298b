#!/usr/bin/env python3
"""A participant's folder that is for another machine, or comes from one: check and can judge the files of the folder
itself, and warn of paths that lead out of it. doctor is about this machine."""

import shutil

from transcript import NOW, Transcript, main

IF_ELSEWHERE = ("if this folder is for another machine, that is as it should be, and ddssec doctor judges it there")
MISSING = "/opt/nowhere/dropin"


class Elsewhere(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "-q", *NOW)
        self.listener = self.at / "demo/listener"

    def told(self, *words, exit, severity="error", **more):
        out = self.json(*words, *NOW, exit=exit, **more)
        return [(one["id"], one["message"]) for one in out["diagnostics"] if one["severity"] == severity]

    def name_libraries(self):
        self.run_program("identity", "issue", "listener", "--ca", "demo", "-o", "demo/listener", "--dropin", MISSING, "-q", *NOW)

    def foreign_governance(self, folder):
        self.run_program("ca", "create", "other", "--no-passphrase", "-q", *NOW)
        self.run_program("governance", "new", "-o", "other.xml", "--sign", "--ca", "other", "-q", *NOW)
        shutil.copy(self.at / "other.p7s", self.at / folder / "governance.p7s")

    def test_libraries_that_are_not_on_this_machine(self):
        self.name_libraries()
        self.assertEqual(self.told("check", "demo/talker", "demo/listener", exit=0), [])
        (rule, message), = self.told("check", "demo/talker", "demo/listener", exit=0, severity="warning")
        self.assertEqual(rule, "DOC007")
        self.assertEqual(message, f"listener: cyclonedds.xml names the library {MISSING}/libdds_security_auth.so in "
                                  f"<Authentication>, which is not on this machine; {IF_ELSEWHERE}")
        for product, count in (("cyclonedds", 1), ("fastdds", 0)):
            told = self.told("check", "demo/talker", "demo/listener", "--vendor", product, exit=0, severity="warning")
            self.assertEqual([rule for rule, _ in told].count("DOC007"), count)
        self.assertIn("result: they match\n", self.run_program("check", "demo/talker", "demo/listener", *NOW).stdout)
        can = self.json("can", "demo/listener", "subscribe", "Square", *NOW)
        self.assertEqual([one["id"] for one in can["diagnostics"]], ["DOC007"])

    def test_doctor_is_about_this_machine(self):
        self.name_libraries()
        out = self.json("doctor", "demo/listener", *NOW, exit=1)
        told, = [one for one in out["diagnostics"] if one["severity"] == "error"]
        self.assertEqual(told["id"], "DOC102")
        self.assertIn("which is not on this machine: Cyclone DDS does not start", told["message"])
        self.assertTrue(told["hint"].startswith(f"{IF_ELSEWHERE}; otherwise copy ddssec's drop-in folder"), told["hint"])

    def test_doctor_has_each_check_once(self):
        environment = {"CYCLONEDDS_URI": f"file://{self.at}/demo/talker/cyclonedds.xml"}
        for words in ((), ("--peer", "demo/talker")):
            result = self.json("doctor", "demo/listener", *words, *NOW, exit=None, environment=environment)["result"]
            for checks in (result["checks"], result.get("peer", {}).get("checks", [])):
                titles = [one["title"] for one in checks]
                self.assertEqual(sorted(titles), sorted(set(titles)))
        self.name_libraries()
        for folder, exit, bad in (("demo/talker", 0, []), ("demo/listener", 1, ["configurations that the products start with"])):
            rows = self.run_program("doctor", folder, *NOW, exit=exit).stdout.split("\nin all")[0].splitlines()[1:]
            count = len(self.json("doctor", folder, *NOW, exit=exit)["result"]["checks"])
            self.assertEqual([row.split("  ")[0] for row in rows], [*bad, f"{count - len(bad)} checks"])

    def test_a_shell_of_this_machine_names_the_configuration(self):
        self.name_libraries()
        told = self.told("check", "demo/talker", "demo/listener", exit=1,
                         environment={"CYCLONEDDS_URI": f"file://{self.listener}/cyclonedds.xml"})
        self.assertEqual([rule for rule, _ in told], ["DOC102"])

    def test_a_copied_folder_shows_the_real_reason(self):
        shutil.copytree(self.listener, self.at / "back/listener")
        self.foreign_governance("back/listener")
        for moved in (False, True):
            if moved:  # Its paths lead nowhere then.
                self.listener.rename(self.at / "demo/gone")
            (rule, message), = self.told("check", "demo/talker", "back/listener", exit=1)
            self.assertEqual(rule, "DOC090")
            self.assertIn("DOC032: governance.p7s was signed by", message)
            (rule, message), = self.told("check", "demo/talker", "back/listener", exit=1, severity="warning")
            self.assertEqual(rule, "DOC007")
            self.assertIn(f"listener: cyclonedds.xml names {self.listener}/", message)
            self.assertIn("which is not " + ("on this machine" if moved else "the file of this folder"), message)
            self.assertTrue(message.endswith(IF_ELSEWHERE), message)

    def test_a_copied_folder_that_is_good(self):
        shutil.copytree(self.listener, self.at / "back/listener")
        self.assertEqual(self.json("check", "demo/talker", "back/listener", *NOW)["diagnostics"], [])
        self.listener.rename(self.at / "demo/gone")
        self.assertEqual([rule for rule, _ in self.told("check", "demo/talker", "back/listener", exit=0, severity="warning")],
                         ["DOC007"])
        told = self.json("doctor", "back/listener", *NOW, exit=1)["diagnostics"]
        hints = {one["hint"] for one in told if one["id"] == "DOC008"}
        self.assertEqual(len(hints), 1)
        self.assertTrue(hints.pop().startswith(f"{IF_ELSEWHERE}; otherwise correct the path"))

    # A configuration that names one file of the folder belongs to it: the others are what its process reads.
    def test_a_folder_that_names_one_file_elsewhere(self):
        self.foreign_governance(".")
        file = self.listener / "cyclonedds.xml"
        text = file.read_text()
        for named in (f"{self.at}/governance.p7s", "/opt/nowhere/governance.p7s"):
            file.write_text(text.replace(f"{self.listener}/governance.p7s", named))
            (rule, message), = self.told("check", "demo/talker", "demo/listener", exit=1)
            self.assertEqual(rule, "DOC090")
            self.assertIn(f"DOC008: cyclonedds.xml names file:{named} as governance", message)


if __name__ == "__main__":
    main()

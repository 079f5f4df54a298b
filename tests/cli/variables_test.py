#!/usr/bin/env python3
"""Variables in cyclonedds.xml: doctor replaces them as Cyclone DDS 0.10.2 does. Measured with ddsrt_expand_envvars and
with participants that did not start."""

from transcript import NOW, Transcript, main


class Variables(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "-q", *NOW)
        self.configuration = self.at / "demo/talker/cyclonedds.xml"
        self.correct = self.configuration.read_text()

    def told(self, old, new, exit, **environment):
        self.assertIn(old, self.correct)
        self.configuration.write_text(self.correct.replace(old, new))
        answer = self.json("doctor", "demo/talker", "--vendor", "cyclonedds", *NOW, exit=exit,
                           environment={"CYCLONEDDS_URI": f"file://{self.configuration}", **environment})
        return [one["message"] for one in answer["diagnostics"] if one["severity"] == "error"]

    def test_files_behind_variables(self):
        here = f"file:{self.at}/demo"
        for new in ("file:${HERE}/demo", "file:${GONE:-${HERE}}/demo", "file:${HERE:+${HERE}}/demo", "file:${HERE:?}/demo"):
            with self.subTest(new=new):
                self.assertEqual(self.told(here, new, exit=0, HERE=str(self.at)), [])
        for new in ("file:$HERE/demo", "file:${GONE}/demo", "file:${HERE:+}/demo"):
            with self.subTest(new=new):
                self.assertTrue(self.told(here, new, exit=1, HERE=str(self.at)))
        for new in ("file:${HERE", "file:${GONE:?no}/demo", "file:${HERE:x}/demo", "file:${CYCLONEDDS_PID}/demo"):
            with self.subTest(new=new):
                self.assertIn("whose variables", self.told(here, new, exit=1, HERE=str(self.at))[-1])

    def test_a_library_behind_a_variable(self):
        told = self.told('path="dds_security_auth"', 'path="${HERE}/nolib.so"', exit=1, HERE=str(self.at))
        self.assertIn(f"{self.at}/nolib.so", told[0])
        self.assertEqual(self.told('path="dds_security_auth"', 'path="${GONE:-dds_security_auth}"', exit=0), [])

    def errors(self, folder, exit):
        environment = {"CYCLONEDDS_URI": f"file://{self.at}/{folder}/cyclonedds.xml", "HERE": "somewhere"}
        told = self.json("doctor", folder, "--vendor", "cyclonedds", *NOW, exit=exit, environment=environment)["diagnostics"]
        return [(one["id"], one["message"]) for one in told if one["severity"] in ("error", "warning")]

    def test_a_folder_with_the_name_of_a_variable(self):
        for name in ("a${HERE}b", "${HERE:-etc}", "$HERE"):
            with self.subTest(name=name):
                self.run_program("init", name, "-q", *NOW)
                self.assertEqual(self.errors(f"{name}/talker", 0), [])
        self.assertIn("${:-$}{HERE}", (self.at / "a${HERE}b/talker/cyclonedds.xml").read_text())

    # Measured: Cyclone DDS's own access control looks for the permissions at another path.
    def test_folders_whose_names_cyclone_dds_does_not_keep(self):
        for name in ('a"b', "a\\b"):
            with self.subTest(name=name):
                self.run_program("init", name, "-q", *NOW)
                self.assertIn("DOC008", [rule for rule, _ in self.errors(f"{name}/talker", 1)])


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""doctor: the plugin libraries and the configuration that Cyclone DDS would load."""

import pathlib
import shutil

from doctor_folders import VENDORS, DoctorTest
from transcript import library_path, main, shared_library


class Plugins(DoctorTest):
    NAMES = ("correct",)

    def test_shared_memory_that_cyclone_dds_would_use(self):
        def told(configuration, exit):
            return self.json("doctor", self.paths["correct"], exit=exit,
                             environment={"CYCLONEDDS_URI": configuration})
        out = told("<SharedMemory><Enable>true</Enable></SharedMemory>", 1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC100"])
        self.assertEqual(out["result"]["verdicts"], dict(zip(VENDORS, ["unsafe", "ok", "late"])))
        for part in ("<SharedMemory><Enable>true", "CYCLONEDDS_URI", "governance.p7s"):
            self.assertIn(part, out["diagnostics"][0]["message"])
        self.assertEqual(told("<General/>", 0)["diagnostics"], [])

    def test_properties_that_take_protection_away(self):
        file = self.at / "plugins.properties"
        weak = {"org.ddssec.access.allow_shared_memory": "true", "org.ddssec.crypto.trust_type_information": "true",
                "org.ddssec.files_poll_interval": "0", "org.ddssec.clock_step_grace": "3600"}
        file.write_text("".join(f"{name} = {value}\n" for name, value in weak.items()))
        out = self.json("doctor", self.paths["correct"], environment={"DDSSEC_PROPERTIES": str(file)})
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC116"] * len(weak))
        for diagnostic, (name, value) in zip(out["diagnostics"], weak.items()):
            self.assertTrue(diagnostic["message"].startswith(f"{name} = {value}: "), diagnostic["message"])
            self.assertEqual(diagnostic["file"], str(file))
            self.assertEqual(diagnostic["severity"], "warning")
        file.write_text("org.ddssec.files_poll_interval = 5\norg.ddssec.clock_step_grace = 60\n"
                        "org.ddssec.access.allow_shared_memory = false\n")
        out = self.json("doctor", self.paths["correct"], environment={"DDSSEC_PROPERTIES": str(file)})
        self.assertEqual(out["diagnostics"], [])
        own = self.at / self.paths["correct"] / "security.properties"
        own.write_text("org.ddssec.shm = on\norg.ddssec.shm.trust_kernel = true\n")
        out = self.json("doctor", self.paths["correct"])
        own.unlink()
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC116"])
        self.assertIn("org.ddssec.shm.trust_kernel = true", out["diagnostics"][0]["message"])

    def test_plugin_files_that_others_can_change(self):
        properties = self.at / "plugins.properties"
        properties.write_text("org.ddssec.files_poll_interval = 5\n")
        properties.chmod(0o666)
        out = self.json("doctor", self.paths["correct"], exit=1, environment={"DDSSEC_PROPERTIES": str(properties)})
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC104"])
        self.assertIn(f"{properties} can be written by every user", out["diagnostics"][0]["message"])
        ours = self.libraries("writable", b"ddssec_\0ddssec plugin version 1.2.3\0")
        self.run_program("init", "demo-writable", "--dropin", "writable")
        (self.at / "writable/libdds_security_ac.so").chmod(0o666)
        out = self.json("doctor", "demo-writable/talker", exit=1, environment={"LD_LIBRARY_PATH": library_path()})
        told = [d["message"] for d in out["diagnostics"] if d["id"] == "DOC104"]
        self.assertEqual(len(told), 1)
        self.assertIn(f"{ours}/libdds_security_ac.so can be written by every user", told[0])

    def test_configuration_and_what_it_names_elsewhere(self):
        self.run_program("init", "demo-elsewhere")
        folder = "demo-elsewhere/talker"
        elsewhere = self.at / "elsewhere"
        elsewhere.mkdir()
        ca = elsewhere / "permissions.crt"
        shutil.copy(self.at / folder / "permissions_ca.pem", ca)
        own = (self.at / folder / "cyclonedds.xml").read_text()
        configuration = elsewhere / "cyclonedds.xml"
        configuration.write_text(own.replace(str(self.at / folder / "permissions_ca.pem"), str(ca)))
        self.assertIn(str(ca), configuration.read_text())
        for changed in (ca, configuration):
            changed.chmod(0o666)
            out = self.json("doctor", folder, exit=1, environment={"CYCLONEDDS_URI": f"file://{configuration}"})
            changed.chmod(0o644)
            told = [d["message"] for d in out["diagnostics"] if d["id"] == "DOC104"]
            self.assertEqual(len(told), 1, out["diagnostics"])
            self.assertIn(f"{changed} can be written by every user", told[0])

    def test_known_file_beside_many_others(self):
        shutil.copytree(self.at / self.paths["correct"], self.at / "crowded")
        for number in range(200):
            (self.at / "crowded" / f"note{number}.txt").touch()
        for name in ("identity_ca.pem", "permissions_ca.pem", "cert.pem", "governance.p7s"):
            (self.at / "crowded" / name).chmod(0o666)
            out = self.json("doctor", "crowded", exit=1)
            (self.at / "crowded" / name).chmod(0o644)
            self.assertTrue(any(d["id"] == "DOC104" and name in d["message"] for d in out["diagnostics"]), name)

    def libraries(self, folder, octets, names=("auth", "ac", "crypto")):
        (self.at / folder).mkdir(exist_ok=True)
        for name in names:
            (self.at / folder / f"libdds_security_{name}.so").write_bytes(shared_library(octets))
        return str(self.at / folder)

    def test_libraries_with_whole_paths_are_no_question_of_the_shell(self):
        ours = self.libraries("ours", b"ddssec_\0ddssec plugin version 1.2.3\0")
        self.run_program("init", "demo", "--dropin", "ours")
        out = self.json("doctor", "demo/talker", environment={"LD_LIBRARY_PATH": library_path()})
        self.assertEqual([p["file"] for p in out["result"]["plugins"]],
                         [f"{ours}/libdds_security_{name}.so" for name in ("auth", "ac", "crypto")])
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC101"])  # CYCLONEDDS_URI is not set
        shutil.rmtree(ours)
        environment = {"LD_LIBRARY_PATH": self.libraries("others", b"ddssec_") + ":" + library_path()}
        out = self.json("doctor", "demo/talker", exit=1, environment=environment)
        told = [d for d in out["diagnostics"] if d["id"] != "DOC101"]
        self.assertEqual([d["id"] for d in told], ["DOC102"])
        self.assertIn(f"names the library {ours}/libdds_security_auth.so in <Authentication>, which is not on this "
                      "machine: Cyclone DDS does not start", told[0]["message"])
        self.assertIn("--dropin DROPIN", told[0]["hint"])
        self.assertEqual(out["result"]["verdicts"], dict(zip(VENDORS, ["fail", "ok", "fail"])))
        text = self.run_program("doctor", "demo/talker", exit=1, environment=environment).stdout
        self.assertIn("  authentication  not found\n", text)
        self.libraries("ours", b"ddssec_")
        file = self.at / "demo/talker/cyclonedds.xml"
        file.write_text(file.read_text().replace("init_crypto", "init_cryptography"))
        told = self.json("doctor", "demo/talker", exit=1)["diagnostics"]
        self.assertIn('initFunction="init_cryptography"', [d["message"] for d in told if d["id"] == "DOC102"][0])

    def test_the_plugins_that_cyclone_dds_would_load_are_named(self):
        ours = self.libraries("ours", b"ddssec_\0ddssec plugin version 1.2.3\0")
        self.run_program("init", "demo")
        def plugins(path, exit, folder="demo/talker", **more):
            out = self.json("doctor", folder, exit=exit, environment={"LD_LIBRARY_PATH": path, **more})
            return ([(p["role"], p["maker"], p["version"], p["file"]) for p in out["result"]["plugins"]],
                    [d for d in out["diagnostics"] if d["id"] == "DOC068"])
        found, told = plugins(ours, 0)
        self.assertEqual(told, [])
        self.assertEqual(found[1], ("access control", "ddssec", "1.2.3", f"{ours}/libdds_security_ac.so"))
        text = self.run_program("doctor", "demo/talker", environment={"LD_LIBRARY_PATH": ours}).stdout
        self.assertIn("with this LD_LIBRARY_PATH, and CYCLONEDDS_URI set to the folder's cyclonedds.xml, Cyclone DDS would load\n"
                      f"  authentication  ddssec 1.2.3: {ours}/libdds_security_auth.so\n", text)
        stock = self.libraries("stock", b"init_crypto")
        found, told = plugins(stock, 0)
        self.assertEqual([p[1] for p in found], ["other"] * 3)
        self.assertIn("runs the stock plugins, not ddssec's: authentication: stock", told[0]["message"])
        self.assertIn("export LD_LIBRARY_PATH=", told[0]["hint"])
        text = self.run_program("doctor", "demo/talker", environment={"LD_LIBRARY_PATH": stock}).stdout
        self.assertNotIn("nothing found", text)
        named = f"file://{self.at}/demo/talker/cyclonedds.xml"
        self.assertEqual(plugins(stock, 0, self.paths["correct"], CYCLONEDDS_URI=named)[1], [])
        told = plugins(f"{stock}:{ours}", 1)[1]
        self.assertIn("ours/libdds_security_auth.so is ddssec's, and", told[0]["message"])
        mixed = self.libraries("mixed", b"ddssec_", ["crypto"])
        told = plugins(f"{mixed}:{stock}", 1)[1]
        self.assertEqual(told[0]["severity"], "warning")
        self.assertIn("of two products: authentication: stock, not ddssec's", told[0]["message"])
        self.assertIn("export LD_LIBRARY_PATH=", told[0]["hint"])
        # Without a configuration the names are not known. CYCLONEDDS_URI comes first.
        self.assertEqual(plugins(ours, 0, self.paths["correct"]), ([], []))
        named = f"file://{self.at}/demo/talker/cyclonedds.xml"
        self.assertEqual(len(plugins(ours, 0, self.paths["correct"], CYCLONEDDS_URI=named)[0]), 3)
        self.assertEqual(plugins(ours, 0, CYCLONEDDS_URI="<General/>"), ([], []))

    def test_plugin_libraries_are_loaded_apart(self):
        plugins = self.at / "plugins"
        plugins.mkdir()
        (plugins / "libdds_security_auth.so").write_text("not a library")
        out = self.json("doctor", self.paths["correct"], "--plugins", "plugins", exit=1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC070"] * 3)
        self.assertEqual(out["result"]["verdicts"], dict(zip(VENDORS, ["ok", "ok", "fail"])))
        self.assertIn("libdds_security_ac.so (access_control)", out["diagnostics"][1]["message"])
        system = next(path for path in ("/lib/x86_64-linux-gnu/libm.so.6", "/lib64/libm.so.6",
                                        "/lib/aarch64-linux-gnu/libm.so.6") if pathlib.Path(path).exists())
        for name in ("auth", "ac", "crypto"):
            (plugins / f"libdds_security_{name}.so").unlink(missing_ok=True)
            (plugins / f"libdds_security_{name}.so").symlink_to(system)
        out = self.json("doctor", self.paths["correct"], "--plugins", "plugins", exit=1)
        self.assertEqual([d["id"] for d in out["diagnostics"]], ["DOC071"] * 3)
        self.assertIn("init_authentication", out["diagnostics"][0]["message"])
        (told,) = self.json("doctor", self.paths["correct"], "--plugins", "nowhere", exit=1)["diagnostics"]
        self.assertEqual((told["id"], pathlib.Path(told["file"]).name), ("DOC070", "nowhere"))
        self.assertIn("does not exist", told["message"])
        self.assertIn("copy the folder again (cp -rLT)", told["hint"])

    def test_configurations_of_a_folder_that_was_moved(self):
        self.run_program("init", "demo")
        self.json("doctor", "demo/talker")
        (self.at / "demo").rename(self.at / "moved & kept")
        told = self.json("doctor", "moved & kept/talker", exit=1)["diagnostics"]  # no product finds its files
        self.assertEqual([(d["id"], d["severity"], pathlib.Path(d["file"]).name) for d in told if d["id"] == "DOC007"],
                         [("DOC007", "warning", "cyclonedds.xml"), ("DOC007", "warning", "fastdds.xml")])
        message = next(d["message"] for d in told if d["id"] == "DOC007")
        self.assertEqual(message, f"cyclonedds.xml names files in {self.at}/demo/talker, and the participant's are in "
                                  f"{self.at}/moved & kept/talker")
        # As the hint says.
        for name in ("cyclonedds.xml", "fastdds.xml"):
            (self.at / "moved & kept/talker" / name).unlink()
        self.run_program("identity", "issue", "talker", "--ca", "moved & kept", "-o", "moved & kept/talker")
        told = self.json("doctor", "moved & kept/talker")["diagnostics"]
        self.assertNotIn("DOC007", [d["id"] for d in told])
        # By another path, the folder is the same.
        (self.at / "link").symlink_to("moved & kept")
        told = self.json("doctor", "link/talker")["diagnostics"]
        self.assertNotIn("DOC007", [d["id"] for d in told])


if __name__ == "__main__":
    main()

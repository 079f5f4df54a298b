#!/usr/bin/env python3
"""doctor --ros: the environment, the domain and the enclave of a ROS 2 node."""

import shutil

import golden_folders
from doctor_folders import DoctorTest
from transcript import main, shared_library
from workshop import allow


class Ros(DoctorTest):
    NAMES = ("correct", "sros2-keystore")

    def ros(self, *words, exit, **variables):
        keystore = self.paths["sros2-keystore"].parent / "keystore"
        out = self.json("doctor", *(words or [self.paths["sros2-keystore"]]), "--ros", exit=exit,
                        environment={**self.environment(), "ROS_SECURITY_KEYSTORE": str(keystore), **variables})
        return {d["id"]: d["message"] for d in out["diagnostics"]}

    def environment(self):
        """As a node needs it; the libraries are read, not loaded."""
        self.make_dropin()
        return self.environment_without_files()

    def make_dropin(self):
        (self.at / "dropin").mkdir(exist_ok=True)
        for name in ("auth", "ac", "crypto"):
            library = self.at / f"dropin/libdds_security_{name}.so"
            library.write_bytes(shared_library(b"\0ddssec_authentication_version\0"))

    def environment_without_files(self):
        return {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce", "ROS_DOMAIN_ID": "",
                "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp", "LD_LIBRARY_PATH": f"/nowhere:{self.at}/dropin"}

    def test_the_plugins_that_a_node_would_run(self):
        for rmw, words in (("", "is not set"), ("rmw_fastrtps_cpp", '"rmw_fastrtps_cpp"')):
            told = self.ros(exit=1, RMW_IMPLEMENTATION=rmw)
            self.assertEqual(list(told), ["DOC067"])
            self.assertIn(words, told["DOC067"])
        self.ros(self.paths["sros2-keystore"], "--vendor", "fastdds", exit=0, RMW_IMPLEMENTATION="rmw_fastrtps_cpp")
        for path in ("", "/nonexistent", ":"):
            told = self.ros(exit=1, LD_LIBRARY_PATH=path)
            self.assertEqual(list(told), ["DOC068"])
            self.assertIn(f'no folder of LD_LIBRARY_PATH ("{path}") holds libdds_security_auth.so', told["DOC068"])
        self.make_dropin()
        for name in ("auth", "ac", "crypto"):  # as cp -a of a drop-in leaves it
            library = self.at / f"dropin/libdds_security_{name}.so"
            octets = library.read_bytes()
            library.unlink()
            library.symlink_to("../lib/gone.so")
            self.assertIn(library.name, self.run_ros_with_dropin(exit=1)["DOC068"])
            library.unlink()
            library.write_bytes(shared_library(b"stock"))
            self.assertIn("is not of ddssec", self.run_ros_with_dropin(exit=1)["DOC068"])
            library.write_bytes(octets)
        self.assertEqual(self.run_ros_with_dropin(exit=0), {})

    def run_ros_with_dropin(self, exit):
        made = {**self.environment_without_files(), "ROS_SECURITY_KEYSTORE":
                str(self.paths["sros2-keystore"].parent / "keystore")}
        out = self.json("doctor", self.paths["sros2-keystore"], "--ros", exit=exit, environment=made)
        return {d["id"]: d["message"] for d in out["diagnostics"]}

    def test_the_environment_of_ros(self):
        self.assertEqual(self.ros(exit=0), {})
        self.assertEqual(self.ros(exit=0, ROS_SECURITY_ENCLAVE_OVERRIDE="/talker_listener/talker"), {})
        told = self.ros(exit=1, ROS_SECURITY_ENABLE="True", ROS_SECURITY_STRATEGY="enforce")
        self.assertEqual(list(told), ["DOC060", "DOC061"])
        self.assertIn('is "True"; it must be exactly "true"', told["DOC060"])
        self.assertIn('is "enforce"; it must be exactly "Enforce"', told["DOC061"])
        told = self.ros(exit=1, ROS_SECURITY_ENCLAVE_OVERRIDE="/talker_listener/listener")
        self.assertIn('this is the enclave "/talker_listener/talker"', told["DOC062"])
        # Measured with a node of ROS 2 Humble: rcl leaves out the first character, and the node aborts.
        told = self.ros(exit=1, ROS_SECURITY_ENCLAVE_OVERRIDE="talker_listener/talker")
        self.assertIn('begins with "/"', told["DOC062"])
        self.assertIn("is not below", self.ros(exit=1, ROS_SECURITY_KEYSTORE="/nowhere")["DOC062"])
        self.assertIn("not set", self.ros(exit=1, ROS_SECURITY_KEYSTORE="")["DOC062"])
        told = self.ros(exit=1, ROS_DOMAIN_ID="5")
        self.assertEqual(list(told), ["DOC096"])  # and not once more for each piece of the documents
        self.assertEqual(told["DOC096"], 'ROS_DOMAIN_ID is "5", so a node runs in domain 5; the documents are for 0')

    def test_a_node_runs_in_the_domain_of_its_environment(self):
        self.run_program("init", "ks", "--layout", "sros2", "--domain", "7")
        own = {"ROS_SECURITY_KEYSTORE": str(self.at / "ks")}
        told = self.ros("ks/enclaves/talker", exit=1, **own)
        self.assertEqual(told["DOC096"],
                         "ROS_DOMAIN_ID is not set, so a node runs in domain 0; the documents are for 7")
        self.assertEqual(self.ros("ks/enclaves/talker", exit=0, ROS_DOMAIN_ID="7", **own), {})
        out = self.json("doctor", "ks/enclaves/talker", "--ros", exit=1,
                        environment={**self.environment(), **own})
        hint = next(d["hint"] for d in out["diagnostics"] if d["id"] == "DOC096")
        self.assertIn("export ROS_DOMAIN_ID=7", hint)

    # Measured with a node of ROS 2 Humble, by its ports: rcl reads the variable as strtoul(value, &end, 0) does.
    def test_the_domain_is_read_as_a_node_reads_it(self):
        for value, domain in (("010", 8), ("0x10", 16), (" 7", 7), ("+5", 5), ("5abc", 5), ("7 ", 7)):
            self.assertEqual(self.ros(exit=1, ROS_DOMAIN_ID=value)["DOC096"],
                             f'ROS_DOMAIN_ID is "{value}", so a node runs in domain {domain}; the documents are for 0')

    def test_names_that_ros_needs(self):
        told = self.ros(self.paths["correct"], exit=1)
        self.assertEqual(list(told), ["DOC062", "DOC063", "DOC064", "DOC065", "PERM040"])
        self.assertIn("identity_ca.pem", told["DOC063"])
        self.assertIn("ros_discovery_info", told["DOC064"])
        self.assertIn('is "rt/Square"', told["DOC065"])
        shop = golden_folders.Workshop(self.at / "shop")
        made = golden_folders.Folder(shop, self.at / "node")
        rules = allow("rt/robot1/rosout") + allow("ros_discovery_info")
        made.sign("permissions", golden_folders.permissions(golden_folders.grant("CN=talker", rules)))
        self.assertIn("rt/robot1/rosout", self.ros("node", exit=1)["DOC066"])

    def test_hardware_keys_are_not_for_cyclone_dds(self):
        folder = self.at / "keystore"
        shutil.copytree(self.paths["sros2-keystore"].parent / "keystore", folder, symlinks=True)
        enclave = folder / "enclaves/talker_listener/talker"
        (enclave / "key.p11").write_text("pkcs11:object=talker")
        variables = {"ROS_SECURITY_KEYSTORE": str(folder), "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}
        self.assertIn("key.p11", self.ros(enclave, exit=1, **variables)["DOC063"])
        variables["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp"
        self.assertNotIn("DOC063", self.ros(enclave, exit=1, **variables))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The lines with which a ROS 2 node is started: with them and nothing else, it runs on ddssec's plugins."""

import os
import shutil
import subprocess

from transcript import NOW, PROGRAM, Transcript, main, shared_library

KEYSTORE = ("keystore", "create", "my keystore", "--no-passphrase", *NOW)


class StartLines(Transcript):
    def install(self, with_plugins=True):
        """The program alone or with plugins, which are read and not loaded."""
        prefix = self.at / "installed here"
        (prefix / "bin").mkdir(parents=True)
        shutil.copy(PROGRAM, prefix / "bin/ddssec")
        if with_plugins:
            (prefix / "lib/ddssec/dropin").mkdir(parents=True)
            for name in ("auth", "ac", "crypto"):
                (prefix / f"lib/ddssec/dropin/libdds_security_{name}.so").write_bytes(
                    shared_library(b"\0ddssec_authentication_version\0"))
        return prefix

    def shell(self, text, exit=0):
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_", "RMW_", "LD_"))}
        kept["PATH"] = f"{self.at}/installed here/bin:{kept['PATH']}"
        done = subprocess.run(["bash", "-euc", text], cwd=self.at, env=kept, text=True, capture_output=True, timeout=60,
                              check=False)
        self.assertEqual(done.returncode, exit, f"{text}\n{done.stdout}{done.stderr}")
        return done.stdout

    def commands(self, printed):
        """The commands that a user copies, without that of the node."""
        lines = printed[printed.index("# after sourcing"):].splitlines()
        self.assertIn("ros2 run PACKAGE NODE --ros-args --enclave /talker", lines)
        return "\n".join(line for line in lines if line.startswith("export "))

    def test_keystore_enclave_prints_lines_with_which_doctor_finds_nothing(self):
        self.install()
        self.run_program(*KEYSTORE, "--domain", "7")
        printed = self.shell(f"ddssec keystore enclave 'my keystore' /talker --allow-all {' '.join(NOW)}")
        doctor = "ddssec doctor 'my keystore/enclaves/talker' --ros"
        self.assertIn(f"# in the same terminal, {doctor} checks these variables\n", printed)
        lines = self.commands(printed)
        self.shell(f"{lines}\n{doctor} {' '.join(NOW)}")
        for needed in ("ROS_SECURITY_ENABLE", "ROS_SECURITY_KEYSTORE", "RMW_IMPLEMENTATION", "LD_LIBRARY_PATH", "ROS_DOMAIN_ID"):
            self.assertIn(needed, lines)
            self.shell(f"{lines}\nunset {needed}\n{doctor} {' '.join(NOW)}", exit=1)

    def test_keystore_enclave_in_domain_zero_leaves_the_domain_out(self):
        self.run_program(*KEYSTORE)
        printed = self.run_program("keystore", "enclave", "my keystore", "/talker", "--allow-all", *NOW).stdout
        self.assertNotIn("ROS_DOMAIN_ID", printed)

    def test_init_of_a_keystore_prints_the_same_lines(self):
        prefix = self.install()
        printed = self.shell(f"ddssec init demo --layout sros2 --participant /talker {' '.join(NOW)}")
        self.assertIn(f"export LD_LIBRARY_PATH='{prefix}/lib/ddssec/dropin'${{LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}}\n",
                      printed)
        self.shell(f"{self.commands(printed)}\nddssec doctor demo/enclaves/talker --ros {' '.join(NOW)}")

    def test_keystore_enclave_without_plugins_beside_the_program_says_what_to_write_for_their_folder(self):
        self.install(with_plugins=False)
        self.run_program(*KEYSTORE)
        printed = self.shell(f"ddssec keystore enclave 'my keystore' /talker --allow-all {' '.join(NOW)}")
        self.assertIn("DROPIN is the folder with ddssec's libdds_security_*.so:\n", printed)
        self.assertIn("export LD_LIBRARY_PATH=DROPIN${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}\n", printed)

    def test_doctors_rules_name_the_same_lines(self):
        for rule, line in (("DOC067", "export RMW_IMPLEMENTATION=rmw_cyclonedds_cpp"),
                           ("DOC068", "export LD_LIBRARY_PATH=DROPIN${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"),
                           ("DOC060", "export ROS_SECURITY_ENABLE=true")):
            self.assertIn(line, self.json("explain", rule)["result"]["hint"])


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The pod of docs/agent.md: its YAML is read, and its two commands are run as they stand there, on folders of this
machine in place of the mounted ones. The systemd unit is checked by systemd-analyze, if there is one."""

import pathlib
import re
import shlex
import shutil
import subprocess
import unittest

from agent_folders import AgentTest
from transcript import DATA, PROGRAM, main

SOURCE = DATA.parent.parent
UNIT = SOURCE / "packaging/agent/ddssec-agent.service"


class Page(AgentTest):
    def pod(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("no module yaml")
        text, = re.findall(r"```yaml\n(.*?)```", (SOURCE / "docs/agent.md").read_text(), re.S)
        return yaml.safe_load(text)

    def here(self, text):
        """The mounted folders as folders of this test."""
        return re.sub(r"/(secret|identity|hook)\b(?=/| |$)", rf"{self.at}/\1", text)

    def make_another_list(self):
        self.run_program("identity", "revoke", "demo/listener", "--ca", "demo")
        self.run_program("crl", "new", "--ca", "demo", "--next-update", "400")

    def test_the_pod_renews_a_mounted_secret(self):
        spec = self.pod()["spec"]
        volumes = {volume["name"] for volume in spec["volumes"]}
        for container in spec["initContainers"] + spec["containers"]:
            self.assertLessEqual({mount["name"] for mount in container["volumeMounts"]}, volumes)
        inside = self.at / "secret/..1"  # as kubelet makes it
        inside.parent.mkdir()
        shutil.copytree(self.talker, inside)
        (self.at / "secret/..data").symlink_to("..1")
        for file in inside.iterdir():
            (self.at / "secret" / file.name).symlink_to(f"..data/{file.name}")
        (self.at / "identity").mkdir()
        shell, option, script = spec["initContainers"][0]["command"]
        subprocess.run([shell, option, self.here(script)], check=True, timeout=60)
        agent, = [one for one in spec["containers"] if one["name"] == "agent"]
        mounted = [one for one in agent["volumeMounts"] if one["name"] == "hook"]
        for one in mounted:
            self.assertEqual(one["mountPath"], f"/hook/{one['subPath']}")  # the folder is the container runtime's
        self.assertEqual([one["subPath"] for one in mounted], ["ask-the-ca", "ask-for-documents"])
        hook = self.at / "hook/ask-the-ca"
        signing = pathlib.Path(self.signing_hook())
        (self.at / "dir").mkdir(mode=0o755)
        signing.rename(self.at / "dir/ask-the-ca")
        documents = self.at / "dir/ask-for-documents"
        documents.write_text(f"#!/bin/sh\n[ $DDSSEC_WANTED != crl ] || cat {self.ca}/crl.pem\n")
        documents.chmod(0o755)
        (self.at / "dir").rename(hook.parent)
        program, command, folder, *words = map(self.here, agent["command"])
        self.assertEqual((program, command), ("ddssec", "agent"))
        self.assertEqual(words, ["--hook", str(hook), "--documents-hook", str(hook.parent / "ask-for-documents")])
        hook.parent.chmod(0o777)  # as kubelet makes the folder of a volume
        refused = self.once(*words, *self.LATER, folder=folder, exit=4)
        self.assertEqual([(event.get("problem") or event)["code"] for event in refused], ["hook_unsafe", "hook_unsafe"])
        hook.parent.chmod(0o755)
        self.make_another_list()
        fetched, event = self.once(*words, *self.LATER, folder=folder, exit=1)
        self.assertEqual(fetched["problem"]["code"], "no_new_permissions")  # they are due, and the hook has none
        self.assertEqual((fetched["event"], [pathlib.Path(file["path"]).name for file in fetched["files"]], event["event"]),
                         ("documents_fetched", ["crl.pem"], "renewed"))
        shutil.rmtree(self.at / "secret")

    @unittest.skipUnless(shutil.which("systemd-analyze"), "there is no systemd-analyze")
    def test_the_unit_is_sound_and_sandboxed(self):
        unit = self.at / UNIT.name
        unit.write_text(UNIT.read_text().replace("/usr/bin/ddssec", str(PROGRAM)))
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], text=True, capture_output=True, timeout=60,
                              check=False)
        self.assertNotIn(UNIT.name, done.stderr)
        self.assertEqual(done.returncode, 0, done.stderr)
        done = subprocess.run(["systemd-analyze", "security", "--offline=true", "--threshold=30", "--no-pager", unit], text=True,
                              capture_output=True, timeout=60, check=False)
        self.assertEqual(done.returncode, 0, done.stdout[-300:])

    def test_the_units_command_works_with_its_settings(self):
        settings = (SOURCE / "packaging/agent/ddssec-agent.default").read_text()
        given = dict(re.findall(r"(?m)^#(DDSSEC_\w+)=(.*)$", settings))
        self.assertEqual(set(given), {"DDSSEC_AGENT_FOLDERS", "DDSSEC_AGENT_SOURCE", "DDSSEC_AGENT_OPTIONS"})
        line, = re.findall(r"(?m)^ExecStart=/usr/bin/ddssec agent (.*)$", UNIT.read_text())
        self.assertEqual(line, "$DDSSEC_AGENT_FOLDERS $DDSSEC_AGENT_SOURCE $DDSSEC_AGENT_OPTIONS")
        for value in re.findall(r"(?m)^#DDSSEC_AGENT_SOURCE=(.*)$", settings):
            words = shlex.split(shlex.split(value)[0])
            done = self.run_program("agent", "nothing", *words, "--once", exit=3)
            self.assertIn("file_not_found", done.stdout)


if __name__ == "__main__":
    main()

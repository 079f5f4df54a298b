#!/usr/bin/env python3
"""doctor finds the plugin libraries that the dynamic loader of this machine finds: a process loads each of them, too."""

import os
import pathlib
import shutil
import subprocess
import sys

from transcript import NOW, Transcript, library_path, main, shared_library

NAMES = ("auth", "ac", "crypto")
LIBRARIES = [f"libdds_security_{name}.so" for name in NAMES]
FIRST = LIBRARIES[0]
REAL = next(path for path in map(pathlib.Path, ("/lib/x86_64-linux-gnu/libm.so.6", "/lib64/libm.so.6",
                                                "/lib/aarch64-linux-gnu/libm.so.6")) if path.exists())
# Loads the library by its name, and says which file that was.
LOAD = f"""import ctypes
ctypes.CDLL("{FIRST}")
print({{line.split()[-1] for line in open("/proc/self/maps") if "{FIRST}" in line}}.pop())"""
# Of glibc 2.36 for x86-64, and some that no machine has at the same time.
SUBFOLDERS = ("glibc-hwcaps/x86-64-v4", "glibc-hwcaps/x86-64-v3", "glibc-hwcaps/x86-64-v2", "glibc-hwcaps/power10",
              "tls", "tls/haswell", "tls/x86_64", "tls/haswell/x86_64", "haswell", "x86_64", "x86_64/haswell",
              "haswell/tls", "other")


class Loader(Transcript):
    def setUp(self):
        super().setUp()
        self.run_program("init", "demo", "-q", *NOW)
        self.ours = self.put("ours", REAL.read_bytes() + b"ddssec_")
        self.stock = REAL.read_bytes() + b"stock"

    def put(self, folder, octets):
        (self.at / folder).mkdir(parents=True, exist_ok=True)
        for library in LIBRARIES:
            (self.at / folder / library).write_bytes(octets)
        return self.at / folder

    def put_patched(self, folder, at, *octets):
        library = bytearray(self.stock)
        library[at:at + len(octets)] = bytes(octets)
        return self.put(folder, bytes(library))

    def loaded(self, path):
        """The file; None: the loader refuses; a negative number: the signal that ended the process."""
        done = subprocess.run([sys.executable, "-c", LOAD], text=True, capture_output=True, timeout=60,
                              env={**os.environ, "LD_LIBRARY_PATH": path})
        return done.stdout.strip() or (done.returncode if done.returncode < 0 else None)

    def doctor(self, *folders, exit=None):
        path = ":".join(map(str, folders))
        out = self.json("doctor", "demo/talker", *NOW, exit=exit, environment={"LD_LIBRARY_PATH": path})
        files = [one["file"] for one in out["result"]["plugins"] if one["role"] == "authentication"]
        return (files or [None])[0], [one["message"] for one in out["diagnostics"] if one["id"] == "DOC068"]

    def test_subfolders_that_the_loader_searches_come_first(self):
        searched = 0
        for number, subfolder in enumerate(SUBFOLDERS):
            for before in (self.at / f"before{number}", self.at / f"within{number}"):
                shutil.copytree(self.ours, before) if "within" in before.name else before.mkdir()
                self.put(before / subfolder, self.stock)
                real = self.loaded(f"{before}:{self.ours}")
                is_stock = subfolder in real
                searched += is_stock
                with self.subTest(before=before.name, subfolder=subfolder):
                    file, told = self.doctor(before, self.ours, exit=1 if is_stock else 0)
                    self.assertEqual(file, real)
                    self.assertEqual(len(told), is_stock)
        if os.uname().machine == "x86_64":
            self.assertGreater(searched, 0)

    def test_of_several_subfolders_the_loaders_order_counts(self):
        for subfolder in SUBFOLDERS:
            self.put(f"all/{subfolder}", self.stock)
        for _ in SUBFOLDERS:
            real = self.loaded(f"{self.at}/all:{self.ours}")
            self.assertEqual(self.doctor(self.at / "all", self.ours)[0], real)
            shutil.rmtree(pathlib.Path(real).parent)
            if not (self.at / "all").is_dir() or str(self.ours) in real:
                break

    def test_what_is_no_library_is_passed_over_or_ends_the_search(self):
        def folder(name):
            for library in LIBRARIES:
                (self.at / name / library).mkdir(parents=True)
            return self.at / name

        def link(name, target):
            (self.at / name).mkdir()
            for library in LIBRARIES:
                (self.at / name / library).symlink_to(target or library)
            return self.at / name
        cases = [self.put_patched("class32", 4, 1), self.put_patched("machine", 18, 0xF3, 0), folder("folder"),
                 self.put_patched("encoding", 5, 2), self.put("text", b"hello"), self.put("empty", b""),
                 self.put_patched("relocatable", 16, 1, 0), self.put_patched("padding", 12, 1),
                 self.put_patched("abi", 7, 9), self.put_patched("linux", 7, 3), self.put("cut", self.stock[:5000]),
                 self.put("header", self.stock[:64]), link("nowhere", "/nowhere"), link("loop", None)]
        for case in cases:
            real = self.loaded(f"{case}:{self.ours}")
            with self.subTest(case=case.name, real=real):
                # Found or not elsewhere: Cyclone DDS looks in a folder of its own then.
                file, told = self.doctor(case, self.ours, exit=None)
                if isinstance(real, str):
                    self.assertEqual(file, real)
                    self.assertEqual(bool(told), str(case) in real)
                elif real is None:
                    self.assertNotIn(str(self.at), str(file))
                    self.assertIn(f"{case}/{FIRST} is no library of this machine", told[0])
                else:
                    self.assertIn(f"{case}/{FIRST} is cut off", told[0])

    def test_a_node_of_ros_finds_them_in_the_same_way(self):
        for subfolder in SUBFOLDERS:
            self.put(f"all/{subfolder}", self.stock)
        environment = {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp", "LD_LIBRARY_PATH": f"{self.at}/all:{self.ours}"}
        out = self.json("doctor", "demo/talker", "--ros", *NOW, exit=1, environment=environment)
        told = [one["message"] for one in out["diagnostics"] if one["id"] == "DOC068"]
        real = self.loaded(environment["LD_LIBRARY_PATH"])
        self.assertEqual(bool(told), str(self.ours) not in real)
        self.put("text", b"hello")
        environment["LD_LIBRARY_PATH"] = f"{self.at}/text:{self.ours}"
        out = self.json("doctor", "demo/talker", "--ros", *NOW, exit=1, environment=environment)
        told = [one["message"] for one in out["diagnostics"] if one["id"] == "DOC068"]
        self.assertIn(f"{self.at}/text/{FIRST} is no library of this machine, and the loader looks no further", told[0])

    def test_a_relative_folder_counts_for_nodes_that_start_here(self):
        environment = {"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp", "LD_LIBRARY_PATH": "ours"}
        for path, severities in (("ours", ["warning"]), (str(self.ours), [])):
            environment["LD_LIBRARY_PATH"] = path
            out = self.json("doctor", "demo/talker", "--ros", *NOW, exit=1, environment=environment)
            told = [one for one in out["diagnostics"] if one["id"] == "DOC068"]
            self.assertEqual([one["severity"] for one in told], severities)
            self.assertTrue(all("that starts in another folder runs on the stock plugins" in one["message"] for one in told))

    def test_a_whole_path_to_what_is_no_library(self):
        self.put("paths", shared_library(b"ddssec_"))
        self.run_program("identity", "issue", "third", "--ca", "demo", "-o", "demo/third", "--governance",
                         "demo/governance.p7s", "--publish", "Square", "--dropin", "paths", "-q", *NOW)
        self.json("doctor", "demo/third", *NOW, environment={"LD_LIBRARY_PATH": library_path()})
        self.put("paths", b"")
        told = self.json("doctor", "demo/third", *NOW, exit=1)["diagnostics"]
        self.assertIn(f"names the library {self.at}/paths/{FIRST} in <Authentication>, which is no library of this machine",
                      [one["message"] for one in told if one["id"] == "DOC102"][0])

    def judge_library(self, path, exit):
        """Verdicts and what DOC102 says of a configuration with another <Library path=...> in <Authentication>."""
        file = self.at / "demo/talker/cyclonedds.xml"
        text = file.read_text()
        file.write_text(text.replace('path="dds_security_auth"', f'path="{path}"'))
        functions = b"".join(b"%s_%s\0" % (verb, role) for verb in (b"init", b"finalize")
                             for role in (b"authentication", b"access_control", b"crypto"))
        self.put("ours", shared_library(b"ddssec_\0" + functions))
        (self.at / "ours" / LIBRARIES[1]).write_bytes(shared_library(b"ddssec_\0init_access_control\0"))
        environment = {"LD_LIBRARY_PATH": f"{self.ours}:{library_path()}"}
        out = self.json("doctor", "demo/talker", *NOW, exit=exit, environment=environment)
        file.write_text(text)
        return ([out["result"]["verdicts"][name] for name in ("cyclonedds@0.10.2", "ddssec")],
                [one["message"] for one in out["diagnostics"] if one["id"] == "DOC102"])

    def test_other_names_of_a_library(self):
        self.assertEqual(self.judge_library("dds_security_auth", 0), (["ok", "ok"], []))
        self.assertEqual(self.judge_library(f"file://{self.ours}/{FIRST}", 0), (["ok", "ok"], []))
        verdicts, told = self.judge_library(FIRST, 1)  # Debian's folder has it by its usual name only
        self.assertEqual(verdicts, ["fail", "ok"])
        self.assertIn(f'names the library "{FIRST}" in <Authentication>: Cyclone DDS finds its own by the name '
                      '"dds_security_auth"', told[0])
        for path in ("dds_security_ac", f"{self.ours}/{LIBRARIES[1]}"):
            verdicts, told = self.judge_library(path, 1)
            self.assertEqual(verdicts, ["fail", "fail"])
            self.assertIn(f"names the library {path} in <Authentication>, which has no function init_authentication",
                          told[0])
        verdicts, told = self.judge_library("libdds_security_auth", 1)
        self.assertEqual(verdicts, ["fail", "fail"])
        self.assertIn("which is not found", told[0])


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Shared memory between two secured processes: its use, a search of memory for plaintext, kill -9, strangers.
Usage: shared_memory_test.py BUILD"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "interop"))
from documents import Governance, Keys, Permissions, Side  # noqa: E402
from peer_processes import PeerProcesses  # noqa: E402
from pki import Pki  # noqa: E402

PEER = pathlib.Path(sys.argv.pop(1)).resolve() / "bin" / "ddssec-peer"
FILES = {"--identity_ca": "identity_ca.pem", "--identity_certificate": "cert.pem",
         "--private_key": "key.pem", "--permissions_ca": "permissions_ca.pem",
         "--governance": "governance.p7s", "--permissions": "permissions.p7s", "--crl": "crl.pem"}
ENCRYPT = Governance(discovery="ENCRYPT", liveliness="ENCRYPT", rtps="SIGN", metadata="ENCRYPT", data="ENCRYPT")
SIGN = Governance(rtps="SIGN", metadata="SIGN")
MESSAGES = Governance(rtps="ENCRYPT")
ALLOWED = Permissions(domain=3, publish=("*",), subscribe=("*",), partition="*")
LARGE = 200_000
NEEDLE = b"\x5a" * 256  # what ddssec-peer writes
OTHER = ("setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups")

# A process that tries tokens at local sockets, which it is told after the id of a process.
TOKENS = """
for name in sys.argv[2:]:
    for say in (b'', bytes(32), bytes(33), b'x'):
        s = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        s.settimeout(5)
        s.connect('\\0' + name)
        data, fds = b'', []
        try:
            if say:
                s.send(say)
            data, fds, flags, _ = socket.recv_fds(s, 64, 4)
        except (ConnectionResetError, BrokenPipeError):
            pass
        if data or fds:
            print('LEAK', data, fds)
"""
# A process that looks into the segments of that process.
LOOK = """
opened = plain = 0
for fd in range(256):
    path = f'/proc/{sys.argv[1]}/fd/{fd}'
    try:
        if 'memfd:ddssec' not in os.readlink(path):
            continue
        memory = os.open(path, os.O_RDONLY)
        opened += 1
        plain += bytes([0x5a] * 256) in os.pread(memory, os.fstat(memory).st_size, 0)
        os.pwrite(os.open(path, os.O_RDWR), b'x', 0)
        print('WROTE')
    except OSError:
        pass
print(opened > 0, plain > 0)
"""
# A process that sends each local socket TCP sockets that linger. The process that closes the last copy waits.
SLOW = """
import threading
kept = []
for name in sys.argv[1:] * 10:
    listener = socket.socket()
    listener.bind(("127.0.0.1", 0))
    listener.listen(1)
    slow = socket.socket()  # create_connection would load more of Python than another user can read
    slow.connect(listener.getsockname())
    kept.append((listener, listener.accept()))
    slow.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 600))
    slow.setblocking(False)
    for _ in range(10):
        try:
            while True:
                slow.send(bytes(1 << 16))
        except BlockingIOError:
            time.sleep(.001)
    local = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    local.settimeout(1)
    try:
        local.connect("\\0" + name)
        socket.send_fds(local, [b"x"], [slow.fileno()])
    except OSError:
        pass
    threading.Thread(target=os.close, args=(slow.detach(),), daemon=True).start()
    local.close()
print("sent", flush=True)
sys.stdin.readline()
"""


class SharedMemory(PeerProcesses):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.pki = Pki(cls.folder.name)
        cls.made = 0

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def start(self, role, governance=ENCRYPT, *arguments, shm="on", prefix=(), owner=None):
        type(self).made += 1
        folder = pathlib.Path(self.folder.name) / f"participant{self.made}"
        folder.mkdir()
        options = Side(governance, ALLOWED).arguments(self.pki, Keys(), role in ("pub", "tput-pub", "ping"))
        for option, path in zip(options[::2], options[1::2]):
            shutil.copy(path, folder / FILES[option])
        if shm:
            (folder / "security.properties").write_text(f"org.ddssec.shm = {shm}\n")
        if owner:
            for path in (folder, *folder.iterdir()):
                os.chown(path, owner, owner)
        log = folder / "events"
        process = self.launch([*prefix, str(PEER), "--role", role, "--security", str(folder), *arguments], 40,
                              env={**os.environ, "DDSSEC_EVENT_LOG": str(log)})
        process.log = log
        return process

    def said(self, process, name):
        return [line for line in self.lines(process) if line["event"] == name]

    def has_event(self, process, code):
        return process.log.exists() and code in process.log.read_text()

    def until(self, condition, what, seconds=25):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.02)

    @staticmethod
    def uses(process):
        """How many events said that memory is used."""
        return sum("rtps_memory_used" in line for line in process.log.read_text().splitlines())

    def uses_memory(self, process):
        self.until(lambda: self.has_event(process, "rtps_memory_used"), "no shared memory is used")

    @staticmethod
    def real_pid(process):
        """Of the program, not of what enters the namespace."""
        pid = process.pid
        while True:
            if os.path.basename(os.readlink(f"/proc/{pid}/exe")) == "ddssec-peer":
                return pid
            children = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
            if not children:
                return pid
            pid = int(children[0])

    @staticmethod
    def segments(pid):
        found = []
        for line in pathlib.Path(f"/proc/{pid}/maps").read_text().splitlines():
            if "/memfd:" in line:
                begin, end = (int(x, 16) for x in line.split()[0].split("-"))
                found.append((begin, end, line.split()[1]))
        return found

    def plaintext(self, pid):
        """The mapped segments that contain what was written."""
        found = 0
        with open(f"/proc/{pid}/mem", "rb") as memory:
            for begin, end, _ in self.segments(pid):
                memory.seek(begin)
                found += NEEDLE in memory.read(end - begin)
        return found

    def stream(self, governance=ENCRYPT, duration="30", **more):
        sub = self.start("tput-sub", governance, "--size", str(LARGE))
        pub = self.start("tput-pub", governance, "--size", str(LARGE), "--duration", duration, **more)
        return pub, sub

    def test_all_samples_arrive(self):
        for governance in (ENCRYPT, SIGN, Governance(rtps="SIGN", data="ENCRYPT"), Governance(data="SIGN")):
            pub, sub = self.stream(governance, "1.5")
            self.assertEqual((pub.wait(60), sub.wait(60)), (0, 0), governance)
            self.assertTrue(self.has_event(pub, "rtps_memory_used"), governance)
            (tput,) = self.said(sub, "tput")
            self.assertEqual(tput["samples"], tput["sent"])
            self.assertGreater(tput["samples"], 10)

    def test_round_trips(self):
        pong = self.start("pong")
        ping = self.start("ping", ENCRYPT, "--count", "300", "--size", str(LARGE))
        self.assertEqual((ping.wait(60), pong.wait(60)), (0, 0))
        self.assertTrue(self.has_event(ping, "rtps_memory_used") and self.has_event(pong, "rtps_memory_used"))

    def test_search_finds_plaintext_only_where_nothing_encrypts(self):
        for governance, expected in ((ENCRYPT, 0), (Governance(data="ENCRYPT"), 0), (SIGN, 1)):
            pub, sub = self.stream(governance)
            self.uses_memory(pub)
            time.sleep(0.5)
            for process in (pub, sub):
                pid = self.real_pid(process)
                self.assertTrue(self.segments(pid))
                self.assertEqual(self.plaintext(pid) > 0, expected > 0, governance)
            self.assertFalse([s for s in self.segments(self.real_pid(sub)) if "w" in s[2]])
            self.tearDown()
            self.setUp()

    def test_messages_encrypted_only_go_by_network(self):
        pub, sub = self.stream(MESSAGES, "1")
        self.assertEqual((pub.wait(60), sub.wait(60)), (0, 0))
        self.assertTrue(self.has_event(pub, "rtps_memory_unused"))
        self.assertIn("org.ddssec.shm.trust_kernel", pub.log.read_text())
        self.assertFalse(self.has_event(pub, "rtps_memory_used"))

    def test_off_by_default_nothing_is_mapped(self):
        for shm in ("", "off"):
            pub, sub = self.stream(ENCRYPT, "3", shm=shm)
            self.until(lambda: self.said(pub, "matched"), "no match")
            time.sleep(1)
            self.assertFalse(self.segments(self.real_pid(pub)) or self.segments(self.real_pid(sub)))
            self.assertEqual((pub.wait(60), sub.wait(60)), (0, 0))

    def test_on_one_side_only_that_side_says_so(self):
        for of_sub, of_pub in (("on", "off"), ("off", "on")):
            sub = self.start("tput-sub", ENCRYPT, "--size", str(LARGE), shm=of_sub)
            pub = self.start("tput-pub", ENCRYPT, "--size", str(LARGE), "--duration", "5", shm=of_pub)
            self.assertEqual((pub.wait(60), sub.wait(60)), (0, 0))
            said = {process: self.has_event(process, "rtps_memory_unused") for process in (pub, sub)}
            self.assertEqual(said, {pub: of_pub == "on", sub: of_sub == "on"})
            self.assertIn("org.ddssec.shm is off there", (pub if of_pub == "on" else sub).log.read_text())

    def test_misspelled_is_refused(self):
        pub = self.start("pub", shm="yes")
        self.assertEqual(pub.wait(20), 3)
        self.assertIn("org.ddssec.shm", self.said(pub, "error")[0]["what"])

    def test_killed_reader_is_replaced(self):
        pub, sub = self.stream(duration="30")
        self.uses_memory(pub)
        before = self.uses(pub)
        os.kill(self.real_pid(sub), 9)
        second = self.start("tput-sub", ENCRYPT, "--size", str(LARGE))
        self.until(lambda: self.uses(pub) == before + 1, "the second reader gets no memory", 30)
        self.assertIsNone(pub.poll())
        self.assertTrue(self.segments(self.real_pid(second)))

    def test_killed_writer_leaves_nothing(self):
        pub, sub = self.stream(duration="20")
        self.uses_memory(pub)
        pid = self.real_pid(pub)
        os.kill(pid, 9)
        other = self.start("tput-pub", ENCRYPT, "--size", str(LARGE), "--duration", "20")
        self.uses_memory(other)
        self.assertIsNone(sub.poll())
        # The lease of the killed one: 10 s.
        self.until(lambda: len(self.segments(self.real_pid(sub))) == 1, "the former memory stays mapped", 30)
        self.assertFalse([one.name for one in os.scandir("/dev/shm") if "ddssec" in one.name and one.is_file()])

    def test_other_pid_namespace_goes_by_network(self):
        sub = self.start("tput-sub", ENCRYPT, "--size", str(LARGE))
        pub = self.start("tput-pub", ENCRYPT, "--size", str(LARGE), "--duration", "2",
                         prefix=("unshare", "--pid", "--fork", "--kill-child"))
        self.assertEqual((pub.wait(60), sub.wait(60)), (0, 0))
        self.assertTrue(self.has_event(pub, "rtps_memory_unused") and self.has_event(sub, "rtps_memory_unused"))
        self.assertFalse(self.has_event(pub, "rtps_memory_used"))

    def expect_all_arrive(self, prefix, through_memory, why=""):
        """`prefix` is that of the writer. One event says whether its samples go through memory."""
        sub = self.start("tput-sub", ENCRYPT, "--size", str(LARGE))
        pub = self.start("tput-pub", ENCRYPT, "--size", str(LARGE), "--duration", "2", prefix=prefix)
        self.assertEqual((pub.wait(60), sub.wait(60)), (0, 0))
        (tput,) = self.said(sub, "tput")
        self.assertEqual(tput["samples"], tput["sent"])
        self.assertGreater(tput["samples"], 10)
        lines = pub.log.read_text().splitlines()
        said = [sum(name in line for line in lines) for name in ("rtps_memory_used", "rtps_memory_unused")]
        self.assertEqual(said, [1, 0] if through_memory else [0, 1], pub.log.read_text())
        self.assertIn(why, pub.log.read_text())

    def test_system_gives_no_memory_all_goes_by_network(self):
        """The largest file that the writer may make is smaller than a segment."""
        self.expect_all_arrive(("prlimit", "--fsize=1000000"), False, "the system gave no memory")

    def test_no_descriptor_is_left_all_goes_by_network(self):
        """The writer has descriptors for all but the memory."""
        pub, _ = self.stream()
        self.uses_memory(pub)
        pid = self.real_pid(pub)
        numbers = [int(one) for one in os.listdir(f"/proc/{pid}/fd")]
        memory = [n for n in numbers if "memfd:ddssec" in os.readlink(f"/proc/{pid}/fd/{n}")]
        self.assertTrue(memory)
        self.tearDown()
        self.setUp()
        self.expect_all_arrive(("prlimit", f"--nofile={min(memory)}"), False, "the system gave no memory")

    def test_folder_of_shared_memory_is_full_or_another_one_memory_is_used(self):
        """The writer is in a mount namespace of its own, whose /dev/shm has no room: segments need no file there."""
        if os.geteuid() != 0:
            self.skipTest("cannot mount")
        fill = "mount -t tmpfs -o size=4k none /dev/shm && ! cat /dev/zero 2>/dev/null >/dev/shm/full && exec \"$@\""
        self.expect_all_arrive(("unshare", "--mount", "sh", "-c", fill, "sh"), True)

    def names_of(self, pid):
        """The local sockets in the namespace of the process."""
        return sorted(set(re.findall(r"@(ddssec-[0-9a-f]{32})", pathlib.Path(f"/proc/{pid}/net/unix").read_text())))

    def stranger(self, program, *arguments):
        """A process of another user in this namespace of the network."""
        if os.geteuid() != 0:
            self.skipTest("cannot become another user")
        program = "import os, socket, struct, sys, time\nos.setgid(65534); os.setuid(65534)\n" + program
        return subprocess.Popen(self.space.enter([sys.executable, "-c", program, *arguments]), text=True,
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def test_stranger_learns_nothing(self):
        probe = TOKENS + ("for fd in range(256):\n"
                          "    for what in (f'fd/{fd}', 'mem'):\n"
                          "        try:\n"
                          "            open(f'/proc/{sys.argv[1]}/{what}', 'rb').close(); print('OPENED', what)\n"
                          "        except OSError: pass\n"
                          "print('done')\n")
        for more in ("", "\norg.ddssec.shm.other_users = true"):
            pub, _ = self.stream(shm="on" + more)
            self.uses_memory(pub)
            pid = self.real_pid(pub)
            names = self.names_of(pid)
            self.assertTrue(names)
            out, _ = self.stranger(probe, str(pid), *names).communicate(timeout=60)
            self.assertEqual(out, "done\n")
            self.assertIsNone(pub.poll())
            self.tearDown()
            self.setUp()

    def test_stranger_with_slow_descriptors_holds_nobody_up(self):
        """TCP sockets that linger, sent to all local sockets of both processes."""
        pub, sub = self.stream()
        self.uses_memory(pub)
        stranger = self.stranger(SLOW, *self.names_of(self.real_pid(pub)))
        try:
            said = stranger.stdout.readline()
            self.assertEqual(said, "sent\n", said if said == "sent\n" else stranger.stdout.read())
            # Discovery, keys and samples need the threads of both participants.
            third = self.start("tput-sub", ENCRYPT, "--size", str(LARGE))
            self.until(lambda: self.said(third, "matched"), "a new reader does not match", 10)
            self.assertIsNone(pub.poll())
            pub.terminate()
            self.assertIsNotNone(pub.wait(15))
        finally:
            stranger.kill()
            stranger.communicate(timeout=20)

    def test_same_user_opens_ciphertext_only(self):
        """A process of the user of both peers, without their keys. It can also read what the governance does not
        encrypt (docs/shared-memory.md), but write nothing."""
        if os.geteuid() != 0:
            self.skipTest("cannot become another user")
        os.chmod(self.folder.name, 0o755)
        for governance, expected in ((ENCRYPT, "True False"), (SIGN, "True True")):
            sub, pub = [self.start(role, governance, "--size", str(LARGE), *more, prefix=OTHER, owner=65534)
                        for role, more in (("tput-sub", ()), ("tput-pub", ("--duration", "30")))]
            self.uses_memory(pub)
            time.sleep(0.5)
            for process in (pub, sub):
                pid = self.real_pid(process)
                out, _ = self.stranger(TOKENS + LOOK, str(pid), *self.names_of(pid)).communicate(timeout=60)
                # A reader keeps no descriptor of what it has mapped.
                self.assertEqual(out.strip(), expected if process is pub else "False False", governance)
                self.assertIsNone(process.poll())
            self.tearDown()
            self.setUp()

    def test_other_users(self):
        """Two processes of different users share memory if both say so."""
        if os.geteuid() != 0:
            self.skipTest("cannot become another user")
        os.chmod(self.folder.name, 0o755)
        for more, expected in (("", False), ("\norg.ddssec.shm.other_users = true", True)):
            self.start("tput-sub", ENCRYPT, "--size", str(LARGE), shm="on" + more, prefix=OTHER, owner=65534)
            pub = self.start("tput-pub", ENCRYPT, "--size", str(LARGE), "--duration", "8", shm="on" + more)
            self.assertEqual(pub.wait(60), 0)
            self.assertEqual(self.has_event(pub, "rtps_memory_used"), expected, pub.log.read_text())
            if not expected:
                self.assertIn("org.ddssec.shm.other_users", pub.log.read_text())
            self.tearDown()
            self.setUp()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "--verbose", *sys.argv[1:]])

"""Runs shapes programs in a network namespace and reads what they say, line by line as it comes."""

import concurrent.futures
import pathlib
import queue
import re
import signal
import subprocess
import sys
import threading
import time

TESTS = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TESTS / "interop"), str(TESTS / "bench")]
from pair import Namespace  # noqa: E402

PATIENCE = 10.0  # seconds until what must be said has been said
SAMPLE = re.compile(r"^(\S+) +(\S+) +(\d{3}) (\d{3}) \[(\d+)\](?: \{(\d+)\})?$")


class Shapes:
    """One running program."""

    def __init__(self, space, program, arguments, preexec=None):
        self.arguments = arguments
        self.lines = []
        self._new = queue.Queue()
        self.process = subprocess.Popen(space.enter([str(program), *arguments.split()]), text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, preexec_fn=preexec)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            self._new.put(line.rstrip("\n"))
        self._new.put(None)

    def next_line(self, seconds=PATIENCE):
        """The next line; None at the end of the output, or if none comes."""
        try:
            line = self._new.get(timeout=max(seconds, 0.001))
        except queue.Empty:
            return None
        if line is not None:
            self.lines.append(line)
        return line

    def says(self, pattern, seconds=PATIENCE):
        """The match of the next line that the pattern fits; whatever comes before is passed over."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            line = self.next_line(end - time.monotonic())
            found = re.search(pattern, line) if line is not None else None
            if found:
                return found
            if line is None and self.process.poll() is not None:
                break
        raise AssertionError(f"{self.arguments}: never said /{pattern}/, but {self.lines[-5:]}")

    def has_said(self, pattern, seconds=PATIENCE):
        """The same, but a line that was passed over counts too."""
        return next(filter(None, (re.search(pattern, line) for line in self.lines)), None) or self.says(pattern, seconds)

    def hears(self, count, seconds=PATIENCE):
        """So many samples: (topic, color, size, last octet)."""
        out = []
        while len(out) < count:
            topic, color, _, _, size, octet = self.says(SAMPLE.pattern, seconds).groups()
            out.append((topic, color, int(size), octet))
        return out

    def samples(self):
        """The sizes of all samples that it has said."""
        return [int(found[5]) for found in map(SAMPLE.match, self.lines) if found]

    def sizes_for(self, seconds):
        """The sizes of the samples that come in that time."""
        end, out = time.monotonic() + seconds, []
        while (left := end - time.monotonic()) > 0:
            line = self.next_line(left)
            found = SAMPLE.match(line) if line is not None else None
            if found:
                out.append(int(found[5]))
        return out

    def says_within(self, pattern, seconds):
        """Whether it says so in that time."""
        try:
            self.says(pattern, seconds)
        except AssertionError:
            return False
        return True

    def tell(self, line):
        """Writes a line to its standard input."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def interrupt(self):
        """SIGINT; the exit code, which must come at once."""
        self.process.send_signal(signal.SIGINT)
        return self.end(5)

    def end(self, seconds=PATIENCE):
        """Waits for its end; the exit code."""
        try:
            code = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"{self.arguments}: did not end") from None
        while self.next_line(1) is not None:
            pass
        return code

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self._reader.join()
        self.process.stdin.close()
        self.process.stdout.close()


class Case:
    """A case's processes, all in one domain of its own; what tests are written in."""

    def __init__(self, space, program, domain):
        self.space, self.program, self.domain = space, program, domain
        self.running = []

    def start(self, arguments, program=None, domain=None, space=None, preexec=None):
        words = f"{arguments} -d {self.domain if domain is None else domain}"
        process = Shapes(space or self.space, program or self.program, words, preexec)
        self.running.append(process)
        return process

    def vendor(self, arguments, program, space):
        """Another vendor's program, which takes its domain as one of the words."""
        process = Shapes(space, program, arguments)
        self.running.append(process)
        return process

    def tool(self, arguments):
        """scenario_publisher, beside the program."""
        process = Shapes(self.space, self.program.parent / "scenario_publisher", f"{self.domain} {arguments}")
        self.running.append(process)
        return process

    def pair(self, publisher, subscriber):
        """Both, in the order of a careful person: the subscriber is there first."""
        sub = self.start("-S " + subscriber)
        sub.says("Create reader")
        return self.start("-P " + publisher), sub

    def close(self):
        for process in self.running:
            process.close()


def check(what, is_so):
    if not is_so:
        raise AssertionError(what)


def tried(space, program, domain, scenario):
    """The scenario's name, and what went wrong or None."""
    case = Case(space, program, domain)
    try:
        scenario(case)
        return scenario.__name__, None
    except AssertionError as fault:
        return scenario.__name__, str(fault)
    finally:
        case.close()


def run(scenarios, domains, workers):
    """The main program of a file of scenarios: BUILD [FILTER]; its exit code. Each scenario has one of
    the domains, and they mostly wait."""
    program = pathlib.Path(sys.argv[1]).resolve() / "bin" / "ddssec-shapes"
    wanted = (sys.argv[2:] or [""])[0]
    chosen = [(domains[i % len(domains)], scenario) for i, scenario in enumerate(scenarios)
              if wanted in scenario.__name__]
    space, failed = Namespace(), 0
    with concurrent.futures.ThreadPoolExecutor(max_workers=workers) as pool:
        for name, fault in pool.map(lambda c: tried(space, program, *c), chosen):
            print(f"{'FAILED' if fault else 'ok':8}{name.replace('_', ' ')}" + (f": {fault}" if fault else ""),
                  flush=True)
            failed += fault is not None
    space.close()
    return 1 if failed or not chosen else 0


__all__ = ["Case", "Namespace", "PATIENCE", "SAMPLE", "Shapes", "check", "run"]

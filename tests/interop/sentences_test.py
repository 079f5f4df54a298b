#!/usr/bin/env python3
"""What docs/sentences-of-cyclone-dds.md lists is what a real Cyclone DDS says, with its own plugins and
with ours. Usage: sentences_test.py SOURCE BUILD [FILTER]"""

import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile
from dataclasses import replace

sys.dont_write_bytecode = True
from documents import DOMAIN, TOPIC, Keys, Permissions, Side
from pair import Namespace
from pki import Pki
from scenarios import GOVERNANCES

TIMEOUT = 5  # seconds until two that cannot meet are believed not to
GOVERNANCE = GOVERNANCES["sros2"]
GOOD = Side(governance=GOVERNANCE)
STOCK, OURS = "stock", "ddssec"
BOTH = (STOCK, OURS)


def governed(**changes):
    return replace(GOOD, governance=replace(GOVERNANCE, **changes))


# what is wrong: publisher, subscriber, {sentence as the page has it up to "...": plugins that say it}
CASES = {
    "another identity CA": (GOOD, replace(GOOD, signed_by="other", trusts="other"),
                            {"Begin handshake reply failed: ": BOTH}),
    "a revoked certificate": (replace(GOOD, crl="peer"), GOOD, {"Process handshake failed: ": BOTH}),
    "another's key": (GOOD, replace(GOOD, foreign_key=True),
                      {"Failed to finalize digest context": (STOCK,),
                       "Error occurred while validating local permission: ": (OURS,)}),
    "another permissions CA": (GOOD, replace(GOOD, permissions_by="other", permissions_ca="other"),
                               {"Could not get remote participant ": BOTH, " permissions from plugin: ": BOTH}),
    "other protection of the domain": (GOOD, governed(rtps="NONE"),
                                       {"match remote_participant ": BOTH, " security_attributes mismatch: ": BOTH,
                                        "0x80000007.0x80000006 - 0x80000006.0x80000006": BOTH,
                                        "Remote secure participant ": BOTH, " not allowed": BOTH}),
    "other protection of the topic": (GOOD, governed(metadata="NONE", data="ENCRYPT"),
                                      {"match_remote_writer ": BOTH, "match_remote_reader ": BOTH,
                                       " security_attributes mismatch: ": BOTH,
                                       "0x80000077.0x80000002 - 0x8000007f.0x80000003": BOTH}),
    "an expired certificate": (GOOD, replace(GOOD, expired=True),
                               {"Error occurred while validating local permission: ": BOTH}),
    "changed permissions": (GOOD, replace(GOOD, tamper="permissions"),
                            {"Error occurred while validating local permissions: ": BOTH}),
    "another domain": (GOOD, governed(domains=(100, 101)),
                       {"It is not allowed to create participant: Could not find domain ": (STOCK,),
                        "Error occurred while validating local permissions: ": (OURS,)}),
    "a topic that is not allowed": (GOOD, replace(GOOD, permissions=Permissions(subscribe=("Other",))),
                                    {"Not Allowed By Security": BOTH,
                                     "ddssec informational: ddssec's security plugins are in use; ": (OURS,)}),
    "no such library": (GOOD, GOOD, {"Could not load Authentication library: ": BOTH,
                                     ": cannot open shared object file": BOTH}),
}


def said(build, folder, plugins, what):
    """All that both say."""
    publisher, subscriber, _ = CASES[what]
    pki, space, logs = Pki(folder), Namespace(), []
    environment = {name: value for name, value in os.environ.items() if name != "CYCLONEDDS_URI"}
    environment["LD_LIBRARY_PATH"] = str(build / "dropin") if plugins == OURS else ""
    try:
        for role, side, starts in (("--subscribe", subscriber, False), ("--publish", publisher, True)):
            command = [build / "bin/cyclone_peer", role, "--topic", TOPIC, "--domain", DOMAIN, "--samples", 5,
                       "--timeout", TIMEOUT, *side.arguments(pki, Keys(), starts)]
            if what == "no such library" and starts:
                command += ["--plugins", "auth=no_such_library"]
            logs.append(subprocess.Popen(space.enter([*map(str, command)]), env=environment, text=True,
                                         errors="replace", stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                         stderr=subprocess.STDOUT))
        return "".join(log.communicate(timeout=4 * TIMEOUT)[0] for log in logs)
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"{what}, {plugins}: a peer did not end within {4 * TIMEOUT} s") from None
    finally:
        for log in logs:
            if log.poll() is None:
                log.kill()
        space.close()


def missing(build, plugins, what):
    """The sentences that were not said."""
    with tempfile.TemporaryDirectory() as folder:
        text = said(build, folder, plugins, what)
    lacks = [sentence for sentence, who in CASES[what][2].items() if plugins in who and sentence not in text]
    return [f"{what}, {plugins}: never said {sentence!r}\n{text[-1500:]}" for sentence in lacks]


def not_on_the_page(source):
    page = (source / "docs/sentences-of-cyclone-dds.md").read_text(encoding="utf-8")
    sentences = {sentence.strip(" :") for _, _, said in CASES.values() for sentence in said
                 if not sentence.startswith("0x80000007")}
    return [f"the page has no {sentence!r}" for sentence in sorted(sentences) if sentence not in page]


def main():
    source, build = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    wanted = (sys.argv[3:] or [""])[0]
    faults = not_on_the_page(source)
    runs = [(plugins, what) for what in CASES for plugins in BOTH if wanted in what]
    with concurrent.futures.ThreadPoolExecutor(max_workers=4) as pool:  # they mostly wait
        for found in pool.map(lambda run: missing(build, *run), runs):
            faults += found
    print("\n".join(faults) or f"{len(runs)} runs, and the page has what was said")
    return 1 if faults or not runs else 0


if __name__ == "__main__":
    sys.exit(main())

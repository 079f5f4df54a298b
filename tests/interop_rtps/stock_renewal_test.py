#!/usr/bin/env python3
"""What a pair of Cyclone DDS processes does when its documents are renewed or end while data flows: on stock plugins,
and on ours. Each pair has a network of its own. Prints rows for docs/renew-without-restart.md.
Usage: stock_renewal_test.py BUILD"""

import concurrent.futures
import os
import pathlib
import sys
import tempfile
import time

sys.dont_write_bytecode = True
from renewal_test import Process, Story, check, command, gaps
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "bench"))
from surroundings import machine

LONG = 3600
ENDS = 30      # seconds that the document lasts that ends
RENEWED = 15   # seconds after which both participants get the next one
WATCHED = 62   # seconds; a Cyclone DDS may need some 8 s to authenticate again
STOPPED = 10   # seconds without a sample at the end: it does not come back
RESTART = 30.0  # seconds until a pair that was started again must talk
# The first certificate and permissions, and whether the next ones come in time.
SITUATIONS = {"certificate renewed": (ENDS, LONG, True), "permissions renewed": (LONG, ENDS, True),
              "permissions not renewed": (LONG, ENDS, False)}
PLUGINS = {"stock": "stock plugins", "ddssec": "ddssec's plugins"}


def talks_after_restart(build, story, kind):
    """Whether the pair talks again with the documents that are in place by now."""
    for process in story.processes:
        process.close()
    story.processes[:] = [Process(story.space, command(build, documents, kind, publishes, True), story.began)
                          for documents, publishes in zip(story.documents, (True, False))]
    end = time.monotonic() + RESTART
    while not story.processes[1].samples() and time.monotonic() < end:
        time.sleep(0.1)
    return bool(story.processes[1].samples())


def measured(build, kind, situation):
    """(last sample at, samples, interruptions, whether it talks after a restart: None if it went on)"""
    certificate, permissions, is_renewed = SITUATIONS[situation]
    with tempfile.TemporaryDirectory(prefix="ddssec-stock-") as folder:
        story = None
        try:
            story = Story(build, folder, kind, kind, True, (), (certificate, permissions))
            story.talks_before(RENEWED)
            story.wait_until(RENEWED)
            if is_renewed:
                for documents in story.documents:
                    documents.put(0, LONG, LONG)
            story.wait_until(WATCHED)
            samples = story.subscriber.samples()
            last = samples[-1][0]
            again = talks_after_restart(build, story, kind) if last < WATCHED - STOPPED else None
            return last, len(samples), gaps(samples), again
        finally:
            if story:
                story.close()


def row(kind, situation, found):
    last, count, interruptions, again = found
    lost = sum(one[2] for one in interruptions)
    if last < WATCHED - STOPPED:
        note = (f"stopped at {last:.0f} s, and nothing came in the next {WATCHED - last:.0f} s; "
                f"{'talked' if again else 'did not talk'} after a restart of both")
    else:
        longest = max((seconds for _, seconds, _ in interruptions), default=0)
        note = f"went on; longest pause {longest:.1f} s" if interruptions else "went on without a pause"
    return f"| {situation} | {PLUGINS[kind]} | {count} | {lost} | {note} |"


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    cases = [(kind, situation) for situation in SITUATIONS for kind in PLUGINS]
    load = os.getloadavg()[0]
    with concurrent.futures.ThreadPoolExecutor(max_workers=len(cases)) as pool:
        found = dict(zip(cases, pool.map(lambda case: measured(build, *case), cases)))
    print(f"Two Cyclone DDS 0.10 processes, 30 samples a second, reliable and VOLATILE, watched for {WATCHED} s; a document "
          f"ends after {ENDS} s. {machine()}, load {load:.1f}")
    print("| both participants | on | samples | lost in pauses | what happened |\n|---|---|---|---|---|")
    for case in cases:
        print(row(*case, found[case]))
    for kind in PLUGINS:
        last = found[kind, "permissions not renewed"][0]
        check(f"{kind}: ended permissions still count at {last:.1f} s", last < WATCHED - STOPPED)
    for situation in ("certificate renewed", "permissions renewed"):
        last = found["ddssec", situation][0]
        check(f"ddssec, {situation}: nothing since {last:.1f} s", last >= WATCHED - STOPPED)


if __name__ == "__main__":
    main()

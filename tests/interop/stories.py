"""Runs the cases of a test that drives real processes: a line for each, some at a time.

A case is a tuple that begins with its name. `attempt(case)` plays it; it returns what went wrong (None: nothing)
and what else the line shall say.
"""

import concurrent.futures
import sys
import tempfile
import time


def attempt_in(world_class, name):
    """The attempt() of cases that end with a story, for which the words between make the world: `story(world)`."""
    def attempt(case):
        _, *setting, story = case
        with tempfile.TemporaryDirectory(prefix=f"ddssec-{name}-") as folder, world_class(folder, *setting) as world:
            try:
                story(world)
            except AssertionError as one:
                return f"{one}{world.logs()}", ""
        return None, ""
    return attempt


def tell(case, attempt):
    start = time.monotonic()
    fault, remark = attempt(case)
    said = f"{time.monotonic() - start:.1f} s" + (f"; {remark}" if remark else "")
    print(f"{'FAILED' if fault else 'ok':8}{case[0]} ({said})" + (f": {fault}" if fault else ""), flush=True)
    return fault is None


def run(cases, attempt, at_once=3):
    """The exit status. An argument after the build folder selects the cases whose name contains it."""
    wanted = (sys.argv[2:] or [""])[0]
    chosen = [case for case in cases if wanted in case[0]]
    with concurrent.futures.ThreadPoolExecutor(max_workers=at_once) as pool:  # they mostly wait
        outcomes = list(pool.map(lambda case: tell(case, attempt), chosen))
    return 0 if outcomes and all(outcomes) else 1

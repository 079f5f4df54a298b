"""How idle the processors are: promised times hold on a machine that does nothing else."""

import pathlib
import time

IDLE = 0.8    # share of the processors' time that is idle before a run whose times count
LOOKED = 5.0  # seconds in which that is measured


def processor_time():
    """(idle, all) of all processors since the machine started, in ticks."""
    words = pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]  # guests are part of user
    ticks = [int(word) for word in words]
    return ticks[3] + ticks[4], sum(ticks)


def idle_share(before):
    """The share of the processors' time since then that they were idle."""
    idle, total = (now - then for now, then in zip(processor_time(), before))
    return idle / max(total, 1)


def idle_now():
    before = processor_time()
    time.sleep(LOOKED)
    return idle_share(before)

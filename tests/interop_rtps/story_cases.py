"""Cases of a Story (renewal_test.py): ../interop/stories.py runs them, and each ends with the tail of the programs' lines."""

import pathlib
import sys
import tempfile

from shapes_process import SAMPLE  # puts the folder of what follows in place
import stories

LAST_LINES = 60  # of all programs


def last_lines(story):
    """What the programs said at last, without their samples."""
    lines = [line for process in story.processes for line in process.lines[-400:] if not SAMPLE.match(line[1])]
    return "\n".join(f"{at:.1f} {line}" for at, line in lines[-LAST_LINES:])


def run(cases, begin, play, at_once):
    """The exit status. A case is a tuple that begins with its name: `begin(build, folder, case)` gives the Story on
    which `play(story, case)` plays it, and what that returns is printed."""
    build = pathlib.Path(sys.argv[1]).resolve()

    def attempt(case):
        with tempfile.TemporaryDirectory(prefix="ddssec-story-") as folder:
            story = None
            try:
                story = begin(build, folder, case)
                return None, play(story, case)
            except AssertionError as fault:
                return f"{fault}\n{last_lines(story) if story else ''}", ""
            finally:
                if story:
                    story.close()
    return stories.run(cases, attempt, at_once)

#!/usr/bin/env python3
"""Nobody waits for the program itself."""

import time

from transcript import Transcript, main


class Speed(Transcript):
    def test_help_is_there_at_once(self):
        def seconds():
            began = time.monotonic()
            self.run_program("--help")
            return time.monotonic() - began
        self.assertLess(min(seconds() for _ in range(20)), 0.020)


if __name__ == "__main__":
    main()

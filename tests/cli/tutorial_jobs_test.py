#!/usr/bin/env python3
"""The lines of docs/secure-a-ros2-robot.md that start and end nodes work however a user gives them to bash. Nodes that
only sleep stand for those of ROS 2."""

import os
import pty
import re

from transcript import DATA, Transcript, main

PAGE = DATA.parent.parent / "docs/secure-a-ros2-robot.md"
NODE = """#!/bin/sh
echo $$ >> "$NODES"
printf '%s\\n' 'I heard' 'authentication, access control and cryptography of ddssec' certificate_revoked
exec sleep 40
"""


def is_alive(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


class Jobs(Transcript):
    def run_in_terminal(self, *options):
        """The output, and the exit code, of bash with the page's lines in a terminal of its own."""
        child, terminal = pty.fork()
        if child == 0:
            os.chdir(self.at)
            os.environ |= {"PATH": f"{self.at}:{os.environ['PATH']}", "NODES": str(self.at / "nodes"), "HOME": str(self.at)}
            os.execvp("timeout", ["timeout", "--foreground", "30", "bash", *options, "page.sh"])
        output = b""
        try:
            while octets := os.read(terminal, 4096):
                output += octets
        except OSError:  # the other end of the terminal is closed
            pass
        os.close(terminal)
        return output.decode(errors="replace"), os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

    def test_the_nodes_end_where_the_page_ends_them(self):
        (self.at / "ros2").write_text(NODE)
        (self.at / "ros2").chmod(0o755)
        blocks = re.findall(r"^```bash\n(.*?)^```$", PAGE.read_text(), re.M | re.S)
        (self.at / "page.sh").write_text("".join(blocks) + "echo the page has ended\n")
        for options in (("-i",), ("-m",), ("-euo", "pipefail")):
            (self.at / "nodes").write_text("")
            output, exit_code = self.run_in_terminal(*options)
            nodes = [int(line) for line in (self.at / "nodes").read_text().split()]
            alive = [node for node in nodes if is_alive(node)]
            for node in alive:
                os.kill(node, 9)
            self.assertEqual((exit_code, len(nodes), alive), (0, 2, []), (options, output))
            self.assertIn("the page has ended", output)
            self.assertNotIn("ambiguous", output)


if __name__ == "__main__":
    main()

"""Run a command that the kernel ends as soon as the process that asked for it is gone, even by SIGKILL (on Linux).

``python kept.py PARENT COMMAND...`` becomes the command: it keeps its process id. Elsewhere it runs it, no more.
"""

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1  # <linux/prctl.h>


def main() -> None:
    """Bind this process's life to the parent's, and become the command."""
    parent, command = int(sys.argv[1]), sys.argv[2:]
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it went before it could be watched
            sys.exit(1)
    os.execv(command[0], command)


if __name__ == "__main__":
    main()

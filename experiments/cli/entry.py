"""Begin and end of every command. Needs the standard library alone until Ctrl-C is seen to."""

import atexit
import errno
import gc
import os
import re
import sys

from experiments.base import interrupts

EXIT_USAGE = 2
EXIT_CLOSED = 141
"""The status of a program that SIGPIPE ends: nobody reads its output on."""
ERROR = "error:"


def begin() -> None:
    """See to Ctrl-C and threads, before anything is imported that minds them."""
    interrupts.open_streams()
    interrupts.begin()
    atexit.register(interrupts.end)  # the first registered, so the last to run
    # The interpreter would look through all the libraries for garbage, twice, before it ends: 0.2 s of every command.
    atexit.register(gc.freeze)
    # All of this runs BLAS on one thread.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def main() -> None:
    """Entry point of ``colias``."""
    begin()
    run()


def run() -> None:
    """Do what ``sys.argv`` asks for. A wrong use or a missing library ends in one line on stderr, and status 2."""
    status, message = _outcome()
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # or Python would try once more, and complain
        status = status or EXIT_CLOSED
    if message:
        text = _with_tip(message)
        if sys.stderr.isatty() and "NO_COLOR" not in os.environ:
            text = text.replace(ERROR, f"\x1b[31m{ERROR}\x1b[0m", 1)
        print(text, file=sys.stderr, flush=True)
    sys.exit(status)


def _with_tip(message: str) -> str:
    """Return a message with the known name that was meant in a line of its own."""
    if not message.startswith(ERROR) or not (meant := re.search(r"nearest: ([^;)]+)", message)):
        return message
    rest = re.sub(r" \(nearest: [^;)]+\)|nearest: [^;)]+; ", "", message)
    return f"{rest}\ntip: did you mean '{meant[1]}'?"


def _outcome() -> tuple[int, str]:
    """Do what the command line asks for: the exit status, and a last text for stderr. A defect shows its traceback."""
    try:
        from experiments.cli import main as cli_main

        status = cli_main.command()
        return status, interrupts.MESSAGE if status == interrupts.STATUS else ""
    except BrokenPipeError:
        return EXIT_CLOSED, ""
    except SystemExit as error:  # Rich and Typer end the process so where nobody reads on
        if isinstance(error.__context__, BrokenPipeError):
            return EXIT_CLOSED, ""
        if trace := _users(error):
            return EXIT_USAGE, trace
        raise
    except Exception as error:
        if trace := _users(error):
            return EXIT_USAGE, trace
        if line := _line(error):
            return EXIT_USAGE, f"{ERROR} {line}"
        raise


def _users(error: BaseException) -> str:
    """Return the traceback of what a user's own file raised; empty for anything else."""
    from experiments.base import user_code

    return user_code.traced(error) if user_code.of_users(error) else ""


def _line(error: Exception) -> str:
    """Return an error in one line where that tells a user what to do; empty for a defect."""
    if isinstance(error, ImportError):  # a missing OpenGL too
        return f"a library does not load: {error}; colias doctor names what is missing"
    if isinstance(error, OSError):
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        way_out = "; make room and repeat the command: with the same --out a run goes on" if full else ""
        return f"{error.filename}: {error.strerror}{way_out}" if error.filename else str(error)
    from experiments.base.errors import TrialError, UsageError

    return str(error) if isinstance(error, UsageError | TrialError) else ""

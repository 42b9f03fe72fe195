"""Begin and end of every command. Needs the standard library alone until Ctrl-C is seen to."""

from __future__ import annotations

import atexit
import gc
import os
import re
import sys

from experiments.bench.run import interrupts

TYPE_CHECKING = False  # that of typing, whose import takes longer than all else here
if TYPE_CHECKING:
    from typing import NoReturn

EXIT_USAGE = 2
EXIT_CLOSED = 141
"""The status of a program that SIGPIPE ends: nobody reads its output on."""
ERROR = "error:"


def begin() -> None:
    """See to Ctrl-C and threads, before anything is imported that minds them."""
    interrupts.begin()
    atexit.register(interrupts.end)  # the first registered, so the last to run
    # The interpreter would look through all the libraries for garbage, twice, before it ends: 0.2 s of every command.
    atexit.register(gc.freeze)
    # All of this runs BLAS on one thread.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def main() -> NoReturn:
    """Entry point of ``colias``."""
    begin()
    run()


def run() -> NoReturn:
    """Do what ``sys.argv`` asks for. A wrong use or a missing library ends in one line on stderr, and status 2."""
    status, message = _outcome()
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # or Python would try once more, and complain
        status = status or EXIT_CLOSED
    if message:
        print(_with_tip(message), file=sys.stderr, flush=True)
    sys.exit(status)


def _with_tip(message: str) -> str:
    """Return a message with the known name that was meant in a line of its own, and in colour on a terminal."""
    if message.startswith(ERROR) and (meant := re.search(r"nearest: ([^;)]+)", message)):
        told = re.sub(r" \(nearest: [^;)]+\)|nearest: [^;)]+; ", "", message)
        message = f"{told}\ntip: did you mean '{meant[1]}'?"
    if sys.stderr.isatty() and "NO_COLOR" not in os.environ:
        message = message.replace(ERROR, f"\x1b[31m{ERROR}\x1b[0m", 1).replace("\ntip:", "\n\x1b[36mtip:\x1b[0m", 1)
    return message


def run_file(path: str) -> NoReturn:
    """Do what ``python experiments/NAME.py [OPTIONS]`` asks for: ``colias run`` on that file."""
    sys.argv[1:1] = ["run", path]
    main()


def _outcome() -> tuple[int, str]:
    """Do what the command line asks for: the exit status, and a last text for stderr. A defect shows its traceback."""
    status, message = 0, ""
    try:
        from experiments.bench.cli import main as cli_main

        status = cli_main.command(sys.argv[1:] or ["--help"])
    except KeyboardInterrupt:
        status, message = interrupts.STATUS, interrupts.SAID
    except BrokenPipeError:
        status = EXIT_CLOSED
    except SystemExit as error:  # Rich and Typer end the process so where nobody reads on
        if not isinstance(error.__context__, BrokenPipeError):
            raise
        status = EXIT_CLOSED
    except Exception as error:
        user_code = sys.modules.get("experiments.bench.run.user_code")  # without it no user's file was run
        if user_code and user_code.of_users(error):
            status, message = EXIT_USAGE, user_code.traced(error)
        elif _is_plain(error):
            status, message = EXIT_USAGE, f"{ERROR} {_words(error)}"
        else:
            raise
    return status, message


def _is_plain(error: Exception) -> bool:
    """Return whether the message alone tells a user what to do; anything else is a defect and shows its traceback."""
    if isinstance(error, OSError | ImportError):  # a missing OpenGL is the second
        return True
    # Looked up, not imported: their modules may be what could not be loaded.
    errors = sys.modules.get("experiments.bench.run.errors")
    return errors is not None and isinstance(error, errors.UsageError | errors.TrialError)


def _words(error: Exception) -> str:
    """Return an error in one line."""
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    return f"a library does not load: {error}" if isinstance(error, ImportError) else str(error)

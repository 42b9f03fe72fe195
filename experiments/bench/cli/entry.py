"""Begin and end of every command. Needs the standard library alone until Ctrl-C and the streams are seen to."""

from __future__ import annotations

import atexit
import gc
import os
import sys

from experiments.bench.doctor import memory
from experiments.bench.run import interrupts

TYPE_CHECKING = False  # that of typing, whose import takes longer than all else here
if TYPE_CHECKING:
    from typing import NoReturn

EXIT_USAGE = 2
EXIT_CLOSED = 141
"""The status of a program that SIGPIPE ends: nobody reads its output on."""


def begin() -> None:
    """See to Ctrl-C, closed streams and threads, before anything is imported that minds them."""
    interrupts.begin()
    atexit.register(interrupts.end)  # the first registered, so the last to run
    # The interpreter would look through all the libraries for garbage, twice, before it ends: 0.2 s of every command.
    atexit.register(gc.freeze)
    _open_streams()
    # All of this runs BLAS on one thread. Its start of others is what fails first where memory is limited, and it
    # then sends this process a SIGINT.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def main() -> NoReturn:
    """Entry point of ``colias``."""
    begin()
    run()


def run() -> NoReturn:
    """Do what ``sys.argv`` asks for. A wrong use or a missing library ends in one line on stderr, and status 2."""
    status, message = _outcome()
    if message:
        _tell(message)
    sys.exit(status)


def run_file(path: str) -> NoReturn:
    """Do what ``python experiments/NAME.py [OPTIONS]`` asks for: ``colias run`` on that file."""
    sys.argv[1:1] = ["run", path]
    main()


def _outcome() -> tuple[int, str]:
    """Do what the command line asks for: the exit status, and a last text for stderr. A defect shows its traceback."""
    status, message = 0, ""
    limit = memory.limit_mb()
    if limit is not None and limit < memory.LEAST_MB:
        allowed = f"this process may have {limit:,.0f} MB of address space (ulimit -v)"
        return EXIT_USAGE, f"colias: {allowed}: it needs {memory.LEAST_MB:,} MB"
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
            status, message = EXIT_USAGE, f"colias: {_words(error)}"
        else:
            raise
    trouble = _flush()
    if trouble is None:
        return status, message
    if isinstance(trouble, BrokenPipeError):  # nobody reads on
        return status or EXIT_CLOSED, message
    return EXIT_USAGE, f"colias: standard output: {getattr(trouble, 'strerror', None) or trouble}"


def _is_plain(error: Exception) -> bool:
    """Return whether the message alone tells a user what to do; anything else is a defect and shows its traceback."""
    if isinstance(error, OSError | ImportError | MemoryError):  # a missing OpenGL is the first
        return True
    if isinstance(error, RuntimeError) and "can't start new thread" in str(error):
        return True
    # Looked up, not imported: their modules may be what could not be loaded.
    known = (("experiments.bench.run.errors", "UsageError"), ("experiments.bench.run.errors", "TrialError"),
             ("experiments.bench.firmware.emulator", "EmulatorError"))  # fmt: skip
    kinds = tuple(getattr(sys.modules[module], name) for module, name in known if module in sys.modules)
    return isinstance(error, kinds)


def _words(error: Exception) -> str:
    """Return an error in one line; of what limited memory may be the reason, the limit too."""
    text = str(error)
    if isinstance(error, OSError) and error.filename:
        return f"{error.filename}: {error.strerror}"
    if isinstance(error, OSError | ValueError) and _in_printing(error):
        return f"standard output: {getattr(error, 'strerror', None) or text}"
    if isinstance(error, OSError) or not isinstance(error, ImportError | MemoryError | RuntimeError):
        return text
    if isinstance(error, ImportError):
        text = f"a library does not load: {text}"
    elif isinstance(error, MemoryError):
        text = f"out of memory: {text}" if text else "out of memory"
    limit = memory.limit_mb()
    return text if limit is None else f"{text} (this process may have {limit:,.0f} MB of address space: ulimit -v)"


def _in_printing(error: BaseException) -> bool:
    """Return whether it came of printing: such an error names no file."""
    step = error.__traceback__
    while step is not None:
        if step.tb_frame.f_globals.get("__name__") == "rich.console":
            return True
        step = step.tb_next
    return False


def _open_streams() -> None:
    """Give closed standard streams the null device: the next file opened would get their number, and their text."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
            ours = False
        except OSError:
            place = os.open(os.devnull, os.O_RDWR)
            if place != number:
                os.dup2(place, number)
                os.close(place)
            os.set_inheritable(number, True)  # for the worker processes
            ours = True
        if getattr(sys, name) is None:
            mode = "r" if number == 0 else "w"
            stream = open(number if ours else os.devnull, mode, encoding="utf-8", closefd=not ours)  # noqa: SIM115
            setattr(sys, name, stream)
            setattr(sys, f"__{name}__", stream)


def _flush() -> OSError | ValueError | None:
    """Write out what was printed. What cannot be is dropped, and why is returned: Python would complain once more."""
    try:
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return error
    except ValueError as error:  # somebody's model has closed it
        return error
    return None


def _tell(text: str) -> None:
    try:
        print(text, file=sys.stderr, flush=True)
    except ValueError:  # somebody's model has closed it
        pass
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)

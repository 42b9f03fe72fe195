"""The command ``colias doctor``. Heavy imports happen when it runs."""

from __future__ import annotations

from experiments.bench.cli.options import EXIT_FAILED

COLOURS = {"ok": "green", "optional": "yellow", "missing": "red"}


def doctor() -> int:
    """Say whether this machine has what the bench needs: Python, packages, what draws, the network, tools, extras.

    A reference frame is drawn and compared with those that are known. If its hash is another, pixels differ a little,
    and so may numbers. What is optional, only some commands need. The exit status is 1 if anything is missing.
    """
    from rich.text import Text

    from experiments.bench.doctor import examine
    from experiments.bench.report.terminal import show_line

    states = []
    for state, name, message in examine():
        states.append(state)
        show_line(Text.assemble((f"{state:<10}", COLOURS[state]), f"{name:<20}{message}"), 30)
    return EXIT_FAILED if "missing" in states else 0

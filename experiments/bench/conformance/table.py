"""Output of ``colias check``."""

from __future__ import annotations

from collections.abc import Sequence

from experiments.bench.conformance.laws import Finding
from experiments.bench.report.terminal import count, out_console, show_line

MOST_US = 1000.0
"""Largest cost of a model for a frame of 99x72, us, without a word about it: the robot's camera gives 30 frames a
second.
"""


def show(label: str, findings: Sequence[Finding], us: float | None, notes: Sequence[str] = ()) -> None:
    """Print a line for each law, and what is broken; the ``notes``; what a frame costs, ``us``, if it is known.

    Of several rounds ``us`` is that of the fastest: what else runs on the machine only adds.
    """
    for finding in findings:
        *_, trouble = finding.trouble.split("\n")  # of a traceback what was raised
        line = f"broken: {trouble}" if trouble else f"kept: {finding.asks}"
        show_line(f"{finding.law:<13}{line}", 13)
    for traceback in dict.fromkeys(finding.trouble for finding in findings if "\n" in finding.trouble):
        out_console.print(traceback, soft_wrap=True, markup=False, highlight=False)
    for note in notes:
        show_line(f"note: {note}", 4)
    if us is not None:
        more = "; more than 1 ms: say why in its docstring" if us > MOST_US else ""
        out_console.print(f"{'cost':<13}{us:.0f} us a frame at 99x72, in its fastest round{more}", markup=False)
    broken = sum(bool(finding.trouble) for finding in findings)
    summary = f"breaks {count(broken, 'law')} of {len(findings)}" if broken else f"keeps all {len(findings)} laws"
    out_console.print(f"{label} {summary}", markup=False)

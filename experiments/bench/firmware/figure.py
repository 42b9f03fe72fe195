"""Figure of what fits the chip: RAM by purpose and the worst frame's time, a row for each program."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.bench.firmware.budget import MOST_WAITS, Budget, label
from experiments.bench.report.palette import HUES
from experiments.bench.report.style import LOOK, WIDTH

LIMIT = "#383838"
BAD = "#c0392b"
KB = 1024.0
INCHES_A_ROW = 0.34


def draw(budgets: Sequence[Budget]) -> Figure:
    """Draw RAM and time of each program.

    Parameters
    ----------
    budgets
        Measured programs, the first on top.

    Returns
    -------
    matplotlib.figure.Figure
        Left: RAM by purpose, kB; a line at the chip's two regions together. A program may be below that line and still
        not fit, as neither region alone may have room for the states; the words beside the row say so. Right: time of
        the frame of the most instructions, from the least to the most cycles an instruction, and the frame's time;
        dotted, what it would wait more if the tables were in flash.
    """
    height = max(INCHES_A_ROW * len(budgets), 0.7) + 1.3
    with mpl.rc_context(LOOK):
        drawn = Figure(figsize=(WIDTH, height), layout="constrained")
        memory, time = drawn.subplots(1, 2, sharey=True, width_ratios=(3, 2))
        _memory(memory, budgets)
        _time(time, budgets)
        memory.set_yticks(range(len(budgets)), [label(budget) for budget in budgets])
        memory.set_ylim(len(budgets) - 0.5, -0.5)
        memory.tick_params(axis="y", length=0)
        time.tick_params(axis="y", length=0)
        drawn.legend(loc="outside lower center", ncols=5, frameon=False, fontsize=8)
    return drawn


def _memory(axes: Axes, budgets: Sequence[Budget]) -> None:
    purposes = [name for name in budgets[0].purposes if name != "test program"]
    for place, budget in enumerate(budgets):
        left = 0.0
        if place % 2 == 0:
            axes.axhspan(place - 0.5, place + 0.5, color="black", alpha=0.04, lw=0)
        for hue, name in enumerate(purposes):
            size = budget.purposes[name] / KB
            axes.barh(place, size, left=left, height=0.62, color=HUES[hue], label=name if place == 0 else None)
            left += size
        caption = f"over by {budget.over:,} B" if budget.over else budget.memory
        colour = LIMIT if budget.fits_memory else BAD
        axes.annotate(caption, (1.0, place), xycoords=("axes fraction", "data"), ha="right", va="center",
                      fontsize=8, color=colour)  # fmt: skip
    chip = budgets[0].firmware.chip
    limit = (chip.ram_main + chip.ram_core) / KB
    axes.axvline(limit, color=LIMIT, ls="--", lw=1.0)
    top = max(limit, *(sum(budget.purposes.values()) / KB for budget in budgets))
    axes.set_xlim(0.0, 2.0 * top)  # room for the words beside the longest bar
    axes.set_title(f"RAM (kB); the chip has {chip.ram_main / KB:g} + {chip.ram_core / KB:g}", fontsize=8, loc="left")


def _time(axes: Axes, budgets: Sequence[Budget]) -> None:
    chip = budgets[0].firmware.chip
    for place, budget in enumerate(budgets):
        low, high = budget.milliseconds
        colour = BAD if budget.too_slow else HUES[0]
        axes.barh(place, high - low, left=low, height=0.3, color=colour)
        waiting = budget.waiting_ms(MOST_WAITS)
        axes.barh(place, waiting, left=high, height=0.3, fill=False, edgecolor=LIMIT, lw=0.6, ls=":",
                  label=f"tables in flash, {MOST_WAITS} wait states" if place == 0 else None)  # fmt: skip
        axes.annotate(f"{low:.2f} to {high:.2f}", (1.02, place), xycoords=("axes fraction", "data"), va="center",
                      fontsize=8, color=colour, annotation_clip=False)  # fmt: skip
    axes.axvline(chip.frame_ms, color=LIMIT, ls="--", lw=1.0)
    top = max(chip.frame_ms, *(budget.milliseconds[1] + budget.waiting_ms(MOST_WAITS) for budget in budgets))
    axes.set_xlim(0.0, 1.08 * top)
    cycles = f"at {chip.cpi_least:g} to {chip.cpi_most:g} cycles an instruction"
    caption = f"worst frame (ms), limit {chip.frame_ms:g}: undetermined\n{cycles}"
    axes.set_title(caption, fontsize=8, loc="left")

"""Several training seeds as a picture: their interquartile mean, each of them, and what they are held against."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from colias_sim.envs import ENVS
from experiments.bench.figures import plotting
from experiments.bench.figures.palette import GREYS, HUES
from experiments.bench.figures.plotting import WIDTH, Panel, headline, rows_inches, scoreboard
from experiments.bench.training.scores import of_runs
from experiments.bench.training.study import Studied
from experiments.bench.training.table import described

LEARNT, OTHERS = HUES[0], GREYS[0]
BELOW = 0.3
"""Offset of the points of the training seeds, from the middle of their row."""
LEGEND = "small points: training seeds; their large point: interquartile mean, 95 % interval over training seeds\n" \
         "grey: mean and 95 % interval over episodes"  # fmt: skip


def write(studied: Studied) -> Path | None:
    """Draw ``policies.svg`` and ``policies.png`` into the study's folder; ``None`` where no episode was played."""
    return plotting.save(draw(studied), studied.folder, "policies") if studied.runs else None


def draw(studied: Studied) -> Figure:
    """Return a panel for each of the env's measures; the policies above, their opponents below."""
    panels = [Panel(measure.name, measure.name) for measure in ENVS[studied.env].all_measures]
    standings = studied.standings
    tints = {standing.name: LEARNT if place == 0 else OTHERS for place, standing in enumerate(standings)}
    with mpl.rc_context(plotting.STYLE):
        drawn = Figure(figsize=(WIDTH, 1.35 + rows_inches(len(standings))), layout="constrained")
        axes = np.atleast_1d(drawn.subplots(1, len(panels), sharey=True))
        scoreboard(list(axes), panels, standings, tints)
        for place, panel in zip(axes, panels, strict=True):
            scores = of_runs(studied.runs, panel.title)
            place.plot(scores, [BELOW] * len(scores), "o", ms=3, mfc=LEARNT, mec="none", alpha=0.6, clip_on=False)
        headline(drawn, described(studied))
        drawn.supxlabel(LEGEND, fontsize=8, x=0.01, ha="left")
    return drawn

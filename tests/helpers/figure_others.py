"""Figures of the study of sensitivity and videos, from fixed rows."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, get_args

import numpy as np
import polars as pl
from matplotlib.figure import Figure

from experiments.bench import sweep, sweep_plan
from experiments.bench.box import Range, setting_at
from experiments.bench.fit import RESULTS, Fit, FitPlan, conclude
from experiments.bench.report import fit as fit_figure
from experiments.bench.report import sweep as sweep_figure
from experiments.bench.report.video import Canvas, Reel
from experiments.bench.stats.verdict import Judged, Outcome
from experiments.bench.study import Study, shipped
from tests.helpers.figure_rows import wave

# --- the study of sensitivity -----------------------------------------------------------------------------------------


def sensitivity(models: Sequence[str]) -> Figure:
    """Every move that the report shows; every word that there is."""
    return sweep_figure.draw(studied("sensitivity"))


def eyes_and_wheels(models: Sequence[str]) -> Figure:
    return sweep_figure.draw(studied("fidelity"))


def range_of_eyes(models: Sequence[str]) -> Figure:
    """Points with names that are too many for rows: a map for each claim."""
    return sweep_figure.draw(studied("eye-range"))


def studied(name: str) -> sweep.Sweep:
    """A study whose claims come to every verdict in turn."""
    words = get_args(Judged)
    plan = sweep_plan.planned(dataclasses.replace(shipped(name), repeats=1))

    class Turns(sweep.Sweep):
        @cached_property
        def outcomes(self) -> dict[Any, tuple[Outcome, ...]]:
            return {
                (point, model, claim.id): tuple(
                    Outcome(words[(row + column + i) % len(words)], "") for i in range(plan.study.replicates)
                )
                for row, (point, model) in enumerate(plan.judged)
                for column, (claim, _) in enumerate(plan.claims)
            }

    return Turns(plan, {})


# --- videos -----------------------------------------------------------------------------------------------------------


def video(models: Sequence[str]) -> Figure:
    """A short recording: the plan from above, potentials and spikes."""
    time_s = np.arange(len(wave(models[0]))) / 30.0
    reel = Reel(Path("trial.rrd"), "speed")
    for place, model in enumerate(models):
        potential = wave(model, phase=0.2 * place)
        reel.values[model] = {"hs": np.vstack([time_s, potential]), "spikes/hs": np.vstack([time_s, potential > 0.1])}
        reel.levels[model] = [0.16, -0.16]
    reel.tracks = {name: np.vstack([time_s, np.zeros((3, len(time_s)))]) for name in ("observer", "mover1")}
    return Canvas(reel, (1280, 720), "speed: trial 0, rightward at 6 cm/s").figure


def fit(models: Sequence[str]) -> Figure:
    """A fit of three parameters in which two claims exclude each other."""
    ranges = (
        Range("dsnn.t_sp", 0.05, 0.3, title="Spike threshold"),
        Range("dsnn.n_con", 2, 8, whole=True, title="Connections"),
        Range("camera.ae_target", 60, 220, title="Mean grey that the loop aims at (grey levels)"),
    )

    def results(count: int, seed: int, replicates: int = 1) -> tuple[tuple[dict[str, str], ...], pl.DataFrame]:
        settings, rows = [], []
        for number, shares in enumerate(np.random.default_rng(seed).random((count, len(ranges)))):
            settings.append(setting_at(ranges, list(shares)))
            for claim, value in {"C13": shares[0] - 0.6, "C14": 0.4 - shares[0], "C18": shares[2] - 0.3}.items():
                verdict = "holds" if value > 0 else "fails"
                rows += [(number, claim, place, verdict, value) for place in range(replicates)]
        return tuple(settings), pl.DataFrame(rows, RESULTS, orient="row")

    keys = [part.key for part in ranges]
    importance = {name: dict(zip(keys, (0.6, 0.1, 0.3), strict=True)) for name in ("all", "C13", "C14", "C18")}
    asked = Fit(Study("fit", "made-up slack", claims=("C13", "C14", "C18")), over=tuple(map(str, ranges)))
    anew = results(1, 2, 20)[1]
    plan = FitPlan(asked, ranges, 0, 2, 10)
    return fit_figure.draw(conclude(plan, *results(60, 0), [7], anew, *results(32, 1), 1, importance, []))

"""The atlas: what every model answers to a dozen clips, on one page and in one figure."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from experiments.bench.clips import plan as clips_plan
from experiments.bench.clips import run as clips_run
from experiments.bench.clips.experiment import Clip, OfflineExperiment
from experiments.bench.clips.plan import OfflinePlan
from experiments.bench.engine.batch import Resources
from experiments.bench.engine.templates import render
from experiments.bench.figures import plotting
from experiments.bench.leaderboard import atlas_figure
from experiments.bench.leaderboard.looming_stimuli import BEHIND, FRAME, SHADES, SQUARE
from experiments.bench.store.files import Files
from experiments.bench.store.kinds import LEADERBOARD
from experiments.bench.store.places import inside
from experiments.bench.store.record import begin_whole
from experiments.bench.store.rows import Failure

NAME = "atlas"
L_OVER_V = ("l_over_v_s", 0.16)
DARK, LIGHT = SHADES["dark"], SHADES["light"]
GROUND = ("background_speed", -8.0)


def _square(name: str, motion: str, *changes: tuple[str, object]) -> Clip:
    return Clip(name, "plain", (*FRAME, *SQUARE, ("motion", motion), ("speed", 60.0), *changes))


CLIPS = (
    _square("dark square rightward", "rightward", *DARK),
    _square("dark square downward", "downward", *DARK),
    _square("light square leftward", "leftward", *LIGHT),
    Clip("grating rightward", "grating", (*FRAME, ("period_px", 16.0), ("temporal_hz", 2.0))),
    Clip("dark looming", "looming", (L_OVER_V, *DARK)),
    Clip("light looming", "looming", (L_OVER_V, *LIGHT)),
    Clip("looming 20° to the right", "looming", (L_OVER_V, ("azimuth_deg", 20.0), *DARK)),
    Clip("near miss", "looming", (L_OVER_V, ("miss", 2.0), *DARK)),
    Clip("dark receding", "looming", (L_OVER_V, ("motion", "receding"), *DARK)),
    Clip("looming before a grating", "looming", (L_OVER_V, *BEHIND)),
    Clip("photograph shifts left", "cluttered", (*FRAME, ("object", "absent"), ("motion", "looming"), GROUND)),
    Clip("leaves in the wind", "foliage", (*FRAME, ("duration_s", 2.0))),
)
"""The columns, from left to right: 99x72 px, 30 frames/s."""


@dataclass(frozen=True, slots=True)
class Atlas:
    """Files of the atlas, and what failed."""

    page: Path
    figure: Path
    failures: list[Failure]


def experiment(models: Sequence[str]) -> OfflineExperiment:
    """Return the clips of the atlas for ``models``."""
    return OfflineExperiment(NAME, "every model's answers to a dozen clips", CLIPS, tuple(models))


def run(folder: Path, models: Sequence[str], seed: int, resources: Resources) -> Atlas:
    """Show what has not been shown, and write ``atlas.html``, ``atlas.svg`` and ``atlas.png``.

    Parameters
    ----------
    folder
        A new one, or one that holds a leaderboard or a part of this atlas.
    models
        Names, or paths of files; the rows from top to bottom.
    seed
        Of the clips.
    resources
        Workers, or a cluster.

    Raises
    ------
    UsageError
        Something cannot be run, or the folder holds another atlas.
    """
    plan = clips_plan.plan(experiment(models), (), (), None, seed)
    batch = clips_run.batch(plan)
    with resources.pool(rendering=False) as pool:
        begin_whole(folder, LEADERBOARD)
        with closing(batch.open(inside(folder, NAME), resources)) as opened:
            failures = batch.fill(opened, pool, resources)
            drawn = atlas_figure.draw(plan, opened.frames())
    figure = plotting.save(drawn, folder, NAME)
    return Atlas(_write_page(plan, folder), figure, failures)


def _write_page(plan: OfflinePlan, folder: Path) -> Path:
    """Return one self-contained page around the figure."""
    picture = base64.b64encode((folder / f"{NAME}.svg").read_bytes()).decode()
    entries = [(model.label, model.declared) for model in plan.showings[0].models]
    page = render(
        "leaderboard/atlas.html.j2",
        picture=f"data:image/svg+xml;base64,{picture}",
        seed=plan.seed,
        models=[(label, entry.summary, ", ".join(entry.channels), entry.source) for label, entry in entries],
        clips=[
            (clip.name, clip.entry.name, ", ".join(f"{name} {value}" for name, value in clip.changes if name not in
                                                 ("rows", "columns")))
            for clip in CLIPS
        ],
    )  # fmt: skip
    Files(folder).write_text(f"{NAME}.html", page)
    return folder / f"{NAME}.html"

"""Benchmark of shared frames in a fit: the best slack at seeds never searched, of searches of equal wall time.

``python -m benchmarks.fitting`` runs it alone. It needs the extra ``[fit]``.
"""

from __future__ import annotations

import importlib.util
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments import Fit, Study

SECONDS = 30.0
"""Wall time of each search."""
HELD_OUT = 5
"""Replicates in which each winner is judged anew."""
STUDY = Study(
    "bench", "the peak of spikes over speeds under the robot's eye", claims=("C15",), experiments=("speed",),
    assignments=("camera.preset=ov7670",), repeats=None, replicates=1, every_trial=False,
)  # fmt: skip
"""C15 has slack on both sides of its bound; C13 has none above 0, so that every search would end there."""
OVER = ("dsnn.t_sp=0.02..0.3", "dsnn.n_con=4,6,8", "dsnn.d=1..4", "camera.ae_target=60..220", "scene.light=0.5..2")
SEARCHES = {
    "frames shared by 10 settings": Fit(STUDY, OVER, share=10, search_repeats=5),
    "a rendering for each setting": Fit(STUDY, OVER, share=1, search_repeats=5),
    "random, frames shared by 10": Fit(STUDY, OVER, share=10, search_repeats=5, sampler="random"),
}


def table() -> Table:
    """Return settings searched, and the winner's least slack in the search and anew, in smallest differences."""
    result = Table(f"a fit of {SECONDS:.0f} s", "settings", "slack, search", f"slack, {HELD_OUT} replicates anew")
    if importlib.util.find_spec("optuna") is None:
        result.add_row("optuna is not installed", "", "", "")
        return result
    for name, fit in SEARCHES.items():
        result.add_row(name, *_searched(fit))
    return result


def _searched(fit: Fit) -> tuple[str, str, str]:
    """Search for the wall time, in batches as a fit has them, and judge the winner anew."""
    from experiments.bench.run.runs import Resources
    from experiments.bench.studies.fitting.players import Player
    from experiments.bench.studies.fitting.run import TEST, planned
    from experiments.bench.studies.fitting.search import Search

    plan, resources = planned(fit), Resources(0, None, True, False)
    search = Search(plan.box, 0, plan.renderings, plan.share, fit.sampler, fit.goals)
    with tempfile.TemporaryDirectory() as folder, resources.pool() as pool:
        player = Player(fit, Path(folder), resources, [])
        searched = []
        began = time.perf_counter()
        while time.perf_counter() - began < SECONDS:
            played = player.play(f"search-{len(searched)}", search.ask(), 0, 1, pool)
            search.tell(played)
            searched += played
        best = max(searched, key=lambda score: score.rank(fit.goals[0]))
        (anew,) = player.play("held-out", [best.setting], TEST, HELD_OUT, pool, anew=True)
    return str(len(searched)), f"{best.value:+.1f}", f"{np.mean(anew.least):+.1f}"


if __name__ == "__main__":
    Console().print(table())

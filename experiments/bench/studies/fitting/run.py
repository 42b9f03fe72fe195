"""Run a fit: search the box, judge the best at seeds that the search never saw, and sample the whole box evenly.

Each batch of settings is a study of its own, with one axis whose levels are the settings: what plays, counts and goes
on is the engine of studies.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from experiments.bench import registry
from experiments.bench.engine.batch import Resources
from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.pool import Pool
from experiments.bench.engine.settings import check_counts
from experiments.bench.engine.terminal import error_console
from experiments.bench.store.description import KIND, begun, reconciled, write_new
from experiments.bench.store.kinds import FIT
from experiments.bench.store.places import inside
from experiments.bench.store.rows import Failure
from experiments.bench.streams import stream
from experiments.bench.studies import run as study_run
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.fitting.box import Box, Setting, box_of
from experiments.bench.studies.fitting.fit import NEXT_BEST, TOGETHER, Fit
from experiments.bench.studies.fitting.fitted import Fitted
from experiments.bench.studies.fitting.scores import Score, scores
from experiments.bench.studies.study import Axis, Level

if TYPE_CHECKING:
    from experiments.bench.studies.fitting.search import Search

AXIS = "setting"
TEST, SAMPLE = 1_000_000, 2_000_000
"""What is added to the seed of the search for the seeds of the judging anew, and of the sample."""


@dataclass(frozen=True, slots=True)
class FitPlan:
    """A fit, checked.

    Parameters
    ----------
    fit, box, seed
        What was asked for.
    renderings, share
        What a batch has: settings of the renderings, and settings of the network that share each.
    """

    fit: Fit
    box: Box
    seed: int
    renderings: int
    share: int

    @property
    def batches(self) -> int:
        """The number of batches."""
        return -(-self.fit.trials // (self.renderings * self.share))


def planned(fit: Fit, seed: int = 0) -> FitPlan:
    """Check a fit, with everything that its first batch, the sample and the judging anew would refuse.

    Parameters
    ----------
    fit
        The fit.
    seed
        Of the search.

    Raises
    ------
    UsageError
        Something is not legal, or the extra is not installed.
    """
    require_optuna()
    check_counts(seed, fit.held_out, "--held-out")
    experiments = [registry.find(name) for name in fit.study.experiments or study_run.answering(fit.study.claims)]
    if not experiments:
        raise UsageError("--claims: a fit without experiments needs some, for example C13,C15")
    box = box_of(fit.over, fit.study, experiments)
    middle = study_run.planned(replace(fit.study, axes=(_axis([box.at([0.5] * len(box.ranges))]),)), seed)
    if not middle.claims:
        raise UsageError(f"{', '.join(middle.experiments)}: no claim there can be fitted to")
    for (claim, _), repeats in ((pair, repeats) for pair in middle.claims for repeats in middle.repeats):
        if middle.things == "trials" and repeats < getattr(claim, "least", 0):
            raise UsageError(f"--repeats {repeats}: {claim.id} needs at least {getattr(claim, 'least', 0)}"
                             " trials of each condition")  # fmt: skip
    outside = len(box.outside)
    size = TOGETHER * fit.share
    renderings = 1 if not outside else size if outside == len(box.ranges) else TOGETHER
    return FitPlan(fit, box, seed, renderings, size // renderings)


def require_optuna() -> None:
    """Raise `UsageError` where the extra is not installed."""
    if importlib.util.find_spec("optuna") is None:
        raise UsageError("a fit needs optuna, which is not installed: run 'sh tools/setup.sh --fit', or install"
                         " colias-sim[fit]")  # fmt: skip


def run(plan: FitPlan, out: Path, resources: Resources) -> Fitted:
    """Run what a fit's folder lacks.

    Parameters
    ----------
    plan
        From `planned`.
    out
        The fit's folder: a new one, or one that holds a part of this fit. More settings may be searched than before.
    resources
        Workers, or a cluster.

    Returns
    -------
    Fitted
        What it comes to; the caller writes it.

    Raises
    ------
    UsageError
        There is another run.
    """
    from experiments.bench.studies.fitting.search import Search

    fit, failures = plan.fit, list[Failure]()
    _begin(plan, out, resources)
    player = _Player(plan, out, resources, failures)
    search = Search(plan.box, plan.seed, plan.renderings, plan.share, fit.sampler)
    searched: list[Score] = []
    with resources.pool() as pool:
        for number in range(plan.batches):
            played = player.play(f"search-{number:04d}", search.ask(), plan.seed, fit.study.replicates, pool)
            search.tell(played)
            searched += played
            if not resources.quiet:
                error_console.print(_so_far(searched), soft_wrap=True, markup=False)
        order = sorted(range(len(searched)), key=lambda place: searched[place].rank, reverse=True)
        best = _different(order, searched)[: NEXT_BEST + 1]
        name = f"held-out-{len(searched)}"
        anew = player.play(name, [searched[place].setting for place in best], plan.seed + TEST, fit.held_out, pool)
        sample = player.play(f"sample-{fit.sample}", spread(plan.box, fit.sample, plan.seed), plan.seed + SAMPLE,
                             fit.study.replicates, pool)  # fmt: skip
    looks = sum(1 for folder in out.glob("held-out-*") if begun(folder))
    return Fitted(fit, plan.box, plan.seed, tuple(searched), tuple(best), tuple(anew), tuple(sample), looks,
                  _importance(search, searched), tuple(failures))  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Player:
    """Plays settings as a study, each batch in a folder of its own."""

    plan: FitPlan
    out: Path
    resources: Resources
    failures: list[Failure]

    def play(self, name: str, settings: Sequence[Setting], seed: int, replicates: int, pool: Pool) -> list[Score]:
        axis = _axis(settings)
        study = replace(self.plan.fit.study, axes=(axis,), replicates=replicates)
        plan = study_run.planned(study, seed)
        batch = study_run.batch(plan, name)
        with closing(batch.open(inside(self.out, name), self.resources)) as folder:
            failed = batch.fill(folder, pool, self.resources)
            self.failures.extend(failed)
            return scores(Counts(plan, folder.rows(), failed), dict(zip(axis.labels, settings, strict=True)))


def _axis(settings: Sequence[Setting]) -> Axis:
    levels = (Level(str(n), tuple(f"{key}={value}" for key, value in setting.items()))
              for n, setting in enumerate(settings))  # fmt: skip
    return Axis(AXIS, tuple(levels))


def spread(box: Box, number: int, seed: int) -> list[dict[str, str]]:
    """Return settings that fill a box evenly: the first points of a scrambled Sobol sequence.

    Parameters
    ----------
    box
        The box.
    number
        How many.
    seed
        Of the scrambling.

    References
    ----------
    Owen 1998, Scrambling Sobol' and Niederreiter-Xing points.
    """
    from scipy.stats import qmc

    sequence = qmc.Sobol(len(box.ranges), scramble=True, rng=stream("fit.sample", seed))
    points = sequence.random_base2((number - 1).bit_length())[:number]
    return [box.at([min(float(share), np.nextafter(1.0, 0.0)) for share in point]) for point in points]


def _begin(plan: FitPlan, out: Path, resources: Resources) -> None:
    """Make the folder, or hold it against this fit; its batches say themselves what computes."""
    from experiments.bench.studies.fitting.search import version

    fit = plan.fit
    description: dict[str, Any] = {
        KIND: FIT.name, "experiment": FIT.name, "over": [str(part) for part in plan.box.ranges],
        "box": [asdict(part) for part in plan.box.ranges], "share": fit.share, "seed": plan.seed,
        "replicates per setting": fit.study.replicates, "held_out": fit.held_out, "sampler": fit.sampler,
        "optuna": version(), "study": fit.study.name,
    }  # fmt: skip
    out.mkdir(parents=True, exist_ok=True)
    if begun(out):
        reconciled(out, description, resources.other_code)
    else:
        write_new(out, description)


def _different(order: Sequence[int], searched: Sequence[Score]) -> list[int]:
    """Return the first place of each setting, in this order: a box of names alone has settings twice."""
    first: dict[tuple[tuple[str, str], ...], int] = {}
    for place in order:
        first.setdefault(tuple(searched[place].setting.items()), place)
    return list(first.values())


def _importance(search: Search, searched: Sequence[Score]) -> dict[str, dict[str, float]]:
    return {claim: dict(search.importance(claim)) for claim in ("", *searched[0].outcomes)}


def _so_far(searched: Sequence[Score]) -> str:
    best = max(searched, key=lambda score: score.rank)
    held = sum(map(best.holds_claim, best.outcomes))
    return (f"best of {len(searched)} settings: {held} of {len(best.outcomes)} claims kept, least slack"
            f" {best.value:+.3g} smallest differences")  # fmt: skip

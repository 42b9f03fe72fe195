"""Run a fit: search the box, judge the best at seeds that the search never saw, and sample the whole box evenly.

Each batch of settings is a study of its own, with one axis whose levels are the settings: the engine of studies plays,
counts and continues it.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.bench import registry, sweep_plan
from experiments.bench.engine.terminal import error_console
from experiments.bench.run.errors import UsageError
from experiments.bench.run.runs import Resources
from experiments.bench.run.settings import check_counts
from experiments.bench.run.streams import stream
from experiments.bench.store.description import KIND, begun, reconciled, write_new
from experiments.bench.store.kinds import FIT
from experiments.bench.store.rows import Failure
from experiments.bench.studies.fitting.box import Box, box_of
from experiments.bench.studies.fitting.fit import NEXT_BEST, SLACK, TOGETHER, Fit, Goal
from experiments.bench.studies.fitting.fitted import Fitted
from experiments.bench.studies.fitting.optimum import Optimum, front
from experiments.bench.studies.fitting.players import Player, axis_of, check_board, study_of
from experiments.bench.studies.fitting.scores import Reading, Score
from experiments.bench.sweep_plan import Plan

TEST, SAMPLE = 1_000_000, 2_000_000
"""Numbers added to the seed of the search for the seeds of the judging anew, and of the sample."""


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
    names = () if fit.board else fit.study.experiments or sweep_plan.answering(fit.study.claims)
    experiments = [registry.find(name) for name in names]
    if not experiments and not fit.board:
        raise UsageError("--claims: a fit without experiments needs some, for example C13,C15")
    box = box_of(fit.over, fit.study, experiments)
    if fit.board:
        check_board(fit, box)
        return FitPlan(fit, box, seed, 1, TOGETHER * fit.share)
    middle = _middle(fit, box, seed)
    if fit.of_claims and not middle.claims:
        raise UsageError(f"{', '.join(middle.experiments)}: no claim there can be fitted to")
    measures = [measure.name for measure, _ in middle.measures]
    for goal in fit.goals:
        if not goal.of_claims and goal.name not in measures:
            raise UsageError(f"--maximise {goal.name}: not measured there; measured are {', '.join(measures)}")
    for (claim, _), repeats in ((pair, repeats) for pair in middle.claims for repeats in middle.repeats):
        if middle.things == "trials" and repeats < getattr(claim, "least", 0):
            raise UsageError(f"--repeats {repeats}: {claim.id} needs at least {getattr(claim, 'least', 0)}"
                             " trials of each condition")  # fmt: skip
    outside = len(box.outside)
    size = TOGETHER * fit.share
    renderings = 1 if not outside else size if outside == len(box.ranges) else TOGETHER
    return FitPlan(fit, box, seed, renderings, size // renderings)


def _middle(fit: Fit, box: Box, seed: int) -> Plan:
    """Return the plan of the setting in the middle of the box; a refusal of a measure names the fit's own option."""
    try:
        return sweep_plan.planned(replace(study_of(fit), axes=(axis_of([box.at([0.5] * len(box.ranges))]),)), seed)
    except UsageError as error:
        raise UsageError(
            str(error).replace("--measure ", "--minimise " if fit.minimise else "--maximise ", 1)
        ) from error


def require_optuna() -> None:
    """Raise `UsageError` where the extra is not installed."""
    if importlib.util.find_spec("optuna") is None:
        raise UsageError("a fit needs optuna, which is not installed: run 'sh tools/setup.sh --fit', or install"
                         " colias-sim[fit]")  # fmt: skip


def run(plan: FitPlan, out: Path, resources: Resources) -> Fitted | Optimum:
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
    Fitted or Optimum
        The result, in claims or in measures; the caller writes it.

    Raises
    ------
    UsageError
        There is another run.
    """
    from experiments.bench.studies.fitting.search import Search

    fit, failures = plan.fit, list[Failure]()
    _begin(plan, out, resources)
    player = Player(fit, out, resources, failures)
    search = Search(plan.box, plan.seed, plan.renderings, plan.share, fit.sampler, fit.goals)
    searched: list[Any] = []
    with resources.pool() as pool:
        for number in range(plan.batches):
            played = player.play(f"search-{number:04d}", search.ask(), plan.seed, fit.study.replicates, pool)
            search.tell(played)
            searched += played
            if not resources.quiet:
                line = _so_far(searched, fit.goals[0]) if fit.of_claims else _best_so_far(searched, fit.goals)
                error_console.print(line, soft_wrap=True, markup=False)
        best = _best(searched, fit)
        settings = [searched[place].setting for place in best] + ([] if fit.of_claims else [{}])
        anew = player.play(f"held-out-{len(searched)}", settings, plan.seed + TEST, fit.held_out, pool, anew=True)
        sample = player.play(f"sample-{fit.sample}", spread(plan.box, fit.sample, plan.seed), plan.seed + SAMPLE,
                             fit.study.replicates, pool)  # fmt: skip
    looks = len({folder.name.split("-")[2] for folder in out.glob("held-out-*") if begun(folder)})
    shares = {name: dict(search.importance(name)) for name in ("", *searched[0].numbers)}
    scores: tuple[Any, ...] = (tuple(searched), tuple(best), tuple(anew), tuple(sample))
    values = (fit, plan.box, plan.seed, *scores, looks, shares, tuple(failures))
    return Fitted(*values) if fit.of_claims else Optimum(*values)


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
        **({} if fit.search_repeats is None else {"repeats of the search": fit.search_repeats}),
        **({} if fit.maximise == (SLACK,) else {"maximise": fit.maximise, "minimise": fit.minimise}),
    }  # fmt: skip
    out.mkdir(parents=True, exist_ok=True)
    if begun(out):
        reconciled(out, description, resources.other_code)
    else:
        write_new(out, description)


def _best(searched: Sequence[Any], fit: Fit) -> list[int]:
    """Return the places of the settings to judge anew: the winner and the next best, or the front of several goals."""
    if len(fit.goals) > 1:
        return front(searched, fit.goals)[: NEXT_BEST + 1]
    goal = fit.goals[0]
    rank = (lambda score: score.rank(goal)) if fit.of_claims else lambda score: _known(score.searched((goal,))[0])
    order = sorted(range(len(searched)), key=lambda place: rank(searched[place]), reverse=True)
    return _different(order, searched)[: NEXT_BEST + 1]


def _known(value: float) -> float:
    """Return a value, the least there is where it is none."""
    return value if np.isfinite(value) else -np.inf


def _different(order: Sequence[int], searched: Sequence[Any]) -> list[int]:
    """Return the first place of each setting, in this order: a box of names alone has settings twice."""
    first: dict[tuple[tuple[str, str], ...], int] = {}
    for place in order:
        first.setdefault(tuple(searched[place].setting.items()), place)
    return list(first.values())


def _so_far(searched: Sequence[Score], goal: Goal) -> str:
    best = max(searched, key=lambda score: score.rank(goal))
    return (f"best of {len(searched)} settings: {best.kept} of {len(best.outcomes)} claims kept, least slack"
            f" {best.value:+.3g} smallest differences")  # fmt: skip


def _best_so_far(searched: Sequence[Reading], goals: Sequence[Goal]) -> str:
    parts = []
    for goal in goals:
        best = max(searched, key=lambda reading: _known(reading.searched((goal,))[0]))
        parts.append(f"{goal.name} {best.numbers[goal.name]:.4g}")
    return f"best of {len(searched)} settings: {', '.join(parts)}"

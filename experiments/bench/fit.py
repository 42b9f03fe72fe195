"""Fits: a search for parameters under which claims hold together or measures are largest, judged on fresh seeds.

Each batch of settings is a sweep of one axis, a leaderboard or tuning curves, and is continued as any other.
"""

from __future__ import annotations

import importlib.util
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from experiments.bench import leaderboard, registry, sweep, sweep_plan, tune
from experiments.bench.box import Box, box_of, setting_at, spread
from experiments.bench.grid import apart, keys_of
from experiments.bench.measures import SPIKES
from experiments.bench.run.description import begin_whole, begun
from experiments.bench.run.errors import UsageError
from experiments.bench.run.files import Files
from experiments.bench.run.models import ask, look_up
from experiments.bench.run.rows import Failure
from experiments.bench.run.runs import Resources
from experiments.bench.run.settings import check_counts
from experiments.bench.run.workers import Workers
from experiments.bench.stats.count import LEAST_JUDGED, Count, count
from experiments.bench.stats.tests import summarise
from experiments.bench.stats.verdict import together
from experiments.bench.study import BOARDS, KEPT, LEADERBOARD, SLACK, TOGETHER, Fit, Study
from experiments.bench.sweep import MOST_SLACK

Setting = Mapping[str, str]
"""Key of each range of the box -> its value as ``--set`` takes it."""
PAIR = 2
"""Settings of the renderings in a batch, where both they and the network are searched."""
NEXT_BEST = 10
"""Settings that are judged anew beside the winner."""
TEST, SAMPLE, APART = 1_000_000, 2_000_000, 1000
"""Added to the seed of the search for the judging anew and for the sample; distance of a board's replicates."""
AS_IS = "as it is"
"""Name of the model without a setting."""

# The search: Optuna asks for settings batch by batch.


def ask_for(search: Any, plan: FitPlan, number: int) -> list[Any]:
    """Return Optuna's trials of a batch; those that share a rendering one after another.

    The sampler is made anew for each batch, seeded by the seed of the fit and the batch's number. So equal seeds give
    equal settings, whatever plays them; and a fit that was cut short asks again for what it had, and finds it played.
    """
    from optuna import distributions as kinds
    from optuna.samplers import TPESampler

    state = int(np.random.SeedSequence(plan.seed, spawn_key=(number,)).generate_state(1)[0])
    search.sampler = TPESampler(seed=state, constant_liar=True)
    free: dict[str, Any] = {
        part.key: kinds.CategoricalDistribution(part.choices) if part.choices
        else kinds.IntDistribution(int(part.low), int(part.high), log=part.log) if part.whole
        else kinds.FloatDistribution(part.low, part.high, log=part.log)
        for part in plan.box
    }  # fmt: skip
    asked = []
    for _ in range(plan.renderings):
        first = search.ask(free)
        asked.append(first)
        outside = {part.key: first.params[part.key] for part in plan.box if not part.network}
        for _ in range(plan.share - 1):
            if outside:
                search.enqueue_trial(outside)
            asked.append(search.ask(free))
    return asked


def tell(search: Any, asked: Sequence[Any], scores: pl.DataFrame, fit: Fit) -> None:
    """Tell Optuna the `scored` values of a batch; a setting without a value counts as failed."""
    from optuna.trial import TrialState

    for trial, row in zip(asked, scores.iter_rows(named=True), strict=True):
        for name in names_of(row):
            trial.set_user_attr(name, row[name])
        values = worth(row, fit)
        known = all(map(math.isfinite, values))
        search.tell(trial, values if known else None, state=None if known else TrialState.FAIL)


def importance(search: Any, plan: FitPlan, name: str = "") -> dict[str, float]:
    """Return the share of each parameter in whether the first goal, a claim or a measure is among the best tenth.

    By PED-ANOVA (Watanabe, Bansal and Hutter 2023); all 0 where every setting came to the same.
    """
    from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances

    sign = plan.fit.goals.get(name, 1)

    def less(trial: Any) -> float:
        return -sign * float(trial.user_attrs[name] if name else trial.values[0])

    known = [trial for trial in search.get_trials(deepcopy=False) if trial.values]
    if len(set(map(less, known))) < 2:
        return {part.key: 0.0 for part in plan.box}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "PedAnova.*low `target`", UserWarning)  # it is given the slack below 0
        shares = get_param_importances(search, evaluator=PedAnovaImportanceEvaluator(), target=less)
    return {part.key: float(shares.get(part.key, 0.0)) for part in plan.box}


# Results of settings: a table with a row for each setting, claim or measure, and replicate.

RESULTS = pl.Schema(
    {"setting": pl.Int64, "name": pl.String, "replicate": pl.Int64, "verdict": pl.String, "value": pl.Float64}
)
"""``value`` is the slack of a claim, or a measure, NaN where it has none; ``verdict`` is of claims alone."""


def names_of(columns: Any) -> list[str]:
    """Return the claims or measures among the columns of a table of `scored`."""
    return [name for name in columns if name not in ("setting", "kept", "least", "mean")]


def scored(results: pl.DataFrame) -> pl.DataFrame:
    """Sum up the results of settings over their replicates.

    Returns
    -------
    polars.DataFrame
        A row for each setting: the least slack of each claim, ``kept`` (the claims that hold in every replicate),
        ``least`` and ``mean`` slack of all; or the mean of each measure, NaN where a replicate has none.
    """
    on_claims = results["verdict"].null_count() == 0
    by_name = results.group_by("setting", "name", maintain_order=True)
    value = pl.col("value")
    sums = by_name.agg(value.min() if on_claims else value.mean(), holds=(pl.col("verdict") == "holds").all())
    table = sums.pivot("name", index="setting", values="value", maintain_order=True)
    if not on_claims:
        return table
    totals = sums.group_by("setting").agg(kept=pl.col("holds").sum(), least=value.min())
    means = results.group_by("setting").agg(mean=value.mean())
    return table.join(totals, "setting", maintain_order="left").join(means, "setting", maintain_order="left")


def worth(row: Mapping[str, Any], fit: Fit) -> list[float]:
    """Return what the search makes large, for each goal, of a row of `scored`; NaN where there is no value."""
    if fit.of_claims:
        return [float(row["kept"] if KEPT in fit.goals else row["least"])]
    return [sign * row[name] for name, sign in fit.goals.items()]


def front(values: Sequence[Sequence[float]]) -> list[int]:
    """Return the places of the rows that none betters: in no goal smaller, and in one larger; the first goal's first.

    Of equal rows the first is returned, and none with a NaN.
    """
    whole = [place for place, row in enumerate(values) if not np.isnan(row).any()]
    chosen: list[int] = []
    for place in sorted(whole, key=lambda place: (*(-value for value in values[place]), place)):
        if not any((np.asarray(values[other]) >= values[place]).all() for other in chosen):
            chosen.append(place)
    return chosen


def best_of(scores: pl.DataFrame, settings: Sequence[Setting], fit: Fit) -> list[int]:
    """Return the places of the winner and the next best, or of the front of several goals.

    Of claims those that keep all come first, then the goal decides, then the mean slack.
    """
    rows = scores.to_dicts()
    if len(fit.goals) > 1:
        return front([worth(row, fit) for row in rows])[: NEXT_BEST + 1]

    def rank(place: int) -> tuple[float, ...]:
        row, (value,) = rows[place], worth(rows[place], fit)
        if not fit.of_claims:
            return (value if math.isfinite(value) else -math.inf,)
        return float(row["kept"] == len(names_of(row))), value, row["mean"]

    first: dict[tuple[tuple[str, str], ...], int] = {}  # a box of names alone has settings twice
    for place in sorted(range(len(rows)), key=rank, reverse=True):
        first.setdefault(tuple(settings[place].items()), place)
    return list(first.values())[: NEXT_BEST + 1]


# Playing settings.


def assigned(setting: Setting) -> tuple[str, ...]:
    """Return a setting as ``KEY=VALUE`` texts, one for each parameter of those that move together."""
    return tuple(f"{key}={value}" for name, value in setting.items() for key in keys_of(name))


def study_of(fit: Fit, settings: Sequence[Setting], *, anew: bool = False) -> Study:
    """Return the study whose points are settings, by their numbers; the search may have fewer trials."""
    names = [SPIKES if name.partition(":")[0] == SPIKES else name for name in fit.goals]
    measures = () if fit.of_claims else tuple(dict.fromkeys(sorted(names, key=SPIKES.__eq__)))
    repeats = fit.study.repeats if anew or fit.search_repeats is None else fit.search_repeats
    axes = {"setting": {str(number): assigned(setting) for number, setting in enumerate(settings)}}
    return replace(fit.study, measures=measures, repeats=repeats, axes=axes)


def text_of(fit: Fit, setting: Setting) -> str:
    """Return the model of a fit with a setting, as ``--model`` takes it."""
    (model,) = fit.study.models
    parts = ",".join(text.partition(".")[2] for text in assigned(setting))
    return model if not parts else f"{model},{parts}" if ask(model)[1] else f"{model}:{parts}"


@dataclass(frozen=True, slots=True)
class FitPlan:
    """A fit, checked; a batch has ``renderings`` settings of these, and ``share`` of the network for each."""

    fit: Fit
    box: Box
    seed: int
    renderings: int
    share: int

    @property
    def batches(self) -> int:
        """The number of batches."""
        return -(-self.fit.trials // (self.renderings * self.share))


def _of_sweep(result: sweep.Sweep, fit: Fit) -> Iterator[tuple[Any, ...]]:
    """Yield the rows of `RESULTS` of a sweep whose points are settings."""
    for row in result.table.iter_rows(named=True) if fit.of_claims else ():
        slack = -MOST_SLACK if row["slack"] is None else row["slack"]  # so that silence gains nothing
        yield int(row["setting"]), row["claim"], row["replicate"], row["verdict"], slack
    for row in result.numbers.iter_rows(named=True):
        for number, value in enumerate(row["each"] if row["measure"] in fit.goals else ()):
            yield int(row["setting"]), row["measure"], number, None, math.nan if value is None else value


def _on_board(
    fit: Fit, texts: Sequence[str], seed: int, folder: Path, pool: Workers, resources: Resources
) -> tuple[dict[str, dict[str, Any]], list[Failure]]:
    """Play what a folder lacks of a leaderboard or of tuning curves; return the numbers of each model, and failures."""
    shown = list(dict.fromkeys(texts))
    if fit.board == LEADERBOARD:
        planned = leaderboard.plan(shown, None, seed)
        responses, failures = leaderboard.play(planned, folder, pool, resources)
        rows = [row for board in leaderboard.rank(planned, responses).values() for row in board.to_dicts()]
    else:
        _, rows, failures = tune.run(tune.plan(shown, (), (), seed), folder, pool, resources)
    found: dict[str, dict[str, Any]] = {}
    for row in rows:
        found.setdefault(row["model"], {}).update(row)
    return {text: found.get(look_up([text])[0].label, {}) for text in shown}, failures


# The result.


@dataclass(frozen=True)
class Fitted:
    """The result of a fit.

    Parameters
    ----------
    plan
        The fit that was asked for, its box and its seed.
    settings
        The settings searched and those of the even sample, a row each: ``of``, ``number``, their values, ``kept`` and
        the slacks of claims, or the means of measures.
    anew
        The settings judged anew, a row for each and each claim or goal, the winner's first: the count or the mean, the
        ends of its 95 % interval, and the value in the search. Of measures the model as it is comes last.
    word
        The verdict on the winner: ``fitted``; ``not fitted``; or ``no word``, of too few replicates judged anew. Empty
        of measures.
    share
        The count of the sample's settings in which every claim is kept: the share of the box. ``None`` of measures.
    luck
        Claims together (``all``) or goal -> by how much the search promised too much of its winner: its mean there less
        that at fresh seeds; ``None`` where it is not known.
    gain
        Goal -> by how much the winner is better than the model as it is, both at fresh seeds.
    importance
        Claim or measure -> parameter -> its share of what varies; ``all`` is all claims together.
    looks
        Number of times that settings were judged at those seeds, this one included.
    sentences
        The answer in sentences: the winner judged anew, how much of it was luck, the even sample, what was searched.
    failures
        Everything that failed.
    """

    plan: FitPlan
    settings: pl.DataFrame
    anew: pl.DataFrame
    word: str
    share: Count | None
    luck: Mapping[str, float | None]
    gain: Mapping[str, float | None]
    importance: Mapping[str, Mapping[str, float]]
    looks: int
    sentences: Sequence[str]
    failures: Sequence[Failure] = ()

    @property
    def winner(self) -> Setting:
        """The best setting as the search saw it; of several goals the best in the first."""
        return self.anew.select(part.key for part in self.plan.box).row(0, named=True)


def settings_table(fit: Fit, of: str, settings: Sequence[Setting], scores: pl.DataFrame) -> pl.DataFrame:
    """Return the rows of ``fit.csv`` of the settings of search or sample, from their `scored` table."""
    names = names_of(scores.columns)
    if fit.of_claims:
        slacks = [pl.col(name).alias(f"slack {name}") for name in names]
        scores = scores.select(
            "kept", pl.lit(len(names)).alias("claims"), pl.col("least").alias("least slack"), *slacks
        )
    own = pl.DataFrame({"of": [of] * len(settings), "number": range(len(settings))})
    return pl.concat([own, pl.DataFrame(settings), scores.select(pl.exclude("setting"))], how="horizontal")


def with_all(results: pl.DataFrame) -> pl.DataFrame:
    """Add to the results of several claims those of all together, called ``all``: the least slack, the verdict."""
    if results["name"].n_unique() < 2:
        return results
    whole = [
        (setting, TOGETHER, replicate, together(rows["verdict"].to_list()), rows["value"].min())
        for (setting, replicate), rows in results.group_by("setting", "replicate", maintain_order=True)
    ]
    return pl.concat([pl.DataFrame(whole, RESULTS, orient="row"), results])


def anew_table(
    fit: Fit, box: Box, searched: pl.DataFrame, settings: Sequence[Setting], best: Sequence[int], anew: pl.DataFrame
) -> pl.DataFrame:
    """Return the rows of ``anew.csv``: the settings ``best`` and, of measures, the model as it is."""
    rows: list[dict[str, Any]] = []
    searched, anew = (with_all(results) if fit.of_claims else results for results in (searched, anew))
    for place, number in enumerate([*best, *([] if fit.of_claims else [None])]):
        setting = {part.key: AS_IS for part in box} if number is None else settings[number]
        for name in anew["name"].unique(maintain_order=True) if fit.of_claims else fit.goals:
            own = anew.filter(setting=place, name=name)
            before = searched.filter(setting=number, name=name)["value"] if number is not None else pl.Series([])
            row: dict[str, Any] = {"number": number, **setting}
            if fit.of_claims:
                counted = count(own["verdict"])
                low, high = counted.interval or (None, None)
                word = "fitted" if counted.word == "holds" else counted.label  # its parameters were chosen to keep it
                row |= {"claim": name, "kept": counted.holds, "replicates": counted.replicates, "low": low,
                        "high": high, "word": word, "slack in the search": before.mean(),
                        "slack anew": own["value"].mean()}  # fmt: skip
            else:
                known = own["value"].filter(own["value"].is_finite()).to_list()
                summary = summarise(known) if known else None
                row |= {"goal": name, "in the search": before.mean(), "anew": summary and summary.mean,
                        "low": summary and summary.ci_low, "high": summary and summary.ci_high,
                        "replicates": len(known)}  # fmt: skip
            rows.append(row)
    return pl.DataFrame(rows, infer_schema_length=None).with_columns(pl.selectors.float().fill_nan(None))


def conclude(
    plan: FitPlan, settings: Sequence[Setting], searched: pl.DataFrame, best: Sequence[int], anew: pl.DataFrame,
    even: Sequence[Setting], sample: pl.DataFrame, looks: int, shares: Mapping[str, Mapping[str, float]],
    failures: Sequence[Failure],
) -> Fitted:  # fmt: skip
    """Return the result of a fit, from the `RESULTS` of the search, of the judging anew and of the even sample."""
    fit, scores = plan.fit, scored(sample)
    parts = [("search", settings, scored(searched)), ("sample", even, scores)]
    table = pl.concat([settings_table(fit, *part) for part in parts])
    again = anew_table(fit, plan.box, searched, settings, best, anew)
    winner = ", ".join(f"{key}={value}" for key, value in settings[best[0]].items())
    box = "; ".join(map(str, plan.box))
    last = (f"searched: {len(settings)} settings of {box}, replicates each: {fit.study.replicates}; times that the"
            f" seeds of the judging anew were looked at: {looks}")  # fmt: skip
    if fit.of_claims:
        first, own = again.row(0, named=True), table.row(best[0], named=True)
        counted = count(with_all(anew).filter(setting=0, name=again["claim"][0])["verdict"])
        kept = scores.filter(kept=len(names_of(scores.columns))).height
        share = Count(kept, len(even) - kept)
        luck = {TOGETHER: _less(first["slack in the search"], first["slack anew"])}
        word = "fitted" if counted.word == "holds" else "not fitted"
        if own["kept"] < own["claims"]:
            word = "not fitted"
        elif counted.kind == "counted" and not counted.fails:
            word = "no word"
        few = f" (it needs {LEAST_JUDGED} replicates)" if word == "no word" else ""
        low, high = share.interval or (0.0, 1.0)
        lines = [
            f"{word}{few}: {winner} keeps {own['kept']} of {own['claims']}"
            f" claims in the search, and all of them in {counted} replicates that it never saw",
            f"its least slack is {_number(first['slack in the search'])} smallest differences in the search and"
            f" {_number(first['slack anew'])} in the mean of {counted.replicates} fresh replicates; luck of the search:"
            f" {_number(luck[TOGETHER])}",
            f"{kept} of {len(even)} settings that fill the box evenly keep every claim: {kept / len(even):.3g} of the"
            f" box, 95 % interval {low:.3g} to {high:.3g}",
        ]
        return Fitted(plan, table, again, word, share, luck, {}, shares, looks, [*lines, last], failures)
    luck, gain, lines = {}, {}, []
    for goal, sign in fit.goals.items():
        of_goal = again.filter(goal=goal)
        one, start = of_goal.row(0, named=True), of_goal.row(-1, named=True)
        luck[goal], gain[goal] = _less(one["in the search"], one["anew"], sign), _less(one["anew"], start["anew"], sign)
        values = [sign * value for value in scores[goal] if math.isfinite(value)]
        best_even = _number(sign * max(values) if values else None)
        lines.append(
            f"{goal}: {winner} has {_number(one['anew'])} in the mean of {one['replicates']} replicates anew, the model"
            f" {AS_IS} {_number(start['anew'])}; luck of the search: {_number(luck[goal])}; best of the {len(even)}"
            f" settings that fill the box evenly: {best_even}"
        )
    return Fitted(plan, table, again, "", None, luck, gain, shares, looks, [*lines, last], failures)


def _less(one: float | None, other: float | None, sign: int = 1) -> float | None:
    """Return a difference, ``None`` where it is not known, and 0 where it is but rounding."""
    if one is None or other is None:
        return None
    return 0.0 if math.isclose(one, other, rel_tol=1e-12) else sign * (one - other)


def _number(value: float | None) -> str:
    return "no value" if value is None else f"{value:.4g}"


# Running it.


def typed(
    experiments: str, over: tuple[str, ...], claims: tuple[str, ...], model: str, assignments: tuple[str, ...],
    maximise: tuple[str, ...], minimise: tuple[str, ...], replicates: int, numbers: Mapping[str, Any],
) -> Fit:  # fmt: skip
    """Return the fit of experiments, joined by commas, that is no file's; ``numbers`` are further fields of `Fit`."""
    names = tuple(filter(None, experiments.split(",")))
    called = "-".join(name if name in BOARDS else registry.find(name).name for name in names)
    goals = ", ".join((*maximise, *minimise))
    study = Study(
        f"fit-{called}", f"parameters for {goals}" if goals else "parameters that keep claims", claims=claims,
        experiments=names, models=(model,), assignments=assignments, repeats=None, replicates=replicates,
        every_trial=False,
    )  # fmt: skip
    return Fit(study, over, maximise=maximise or (() if minimise else (SLACK,)), minimise=minimise, **numbers)


def planned(fit: Fit, seed: int = 0) -> FitPlan:
    """Check a fit, with everything that its first batch, the sample and the judging anew would refuse.

    Raises
    ------
    UsageError
        Something is not legal, or Optuna is not installed.
    """
    if importlib.util.find_spec("optuna") is None:
        raise UsageError("a fit needs optuna, which is not installed: run 'sh tools/setup.sh --fit', or install"
                         " colias-sim[fit]")  # fmt: skip
    check_counts(seed, fit.held_out, "--held-out")
    names = () if fit.board else fit.study.experiments or sweep_plan.answering(fit.study.claims)
    experiments = [registry.find(name) for name in names]
    box = box_of(fit.over, fit.study, experiments)
    outside = [part for part in box if not part.network]
    if fit.board:
        # No times, which another run would not repeat.
        known = leaderboard.SCORES if fit.board == LEADERBOARD else tune.numbers()
        if wrong := next((goal for goal in fit.goals if goal not in known), ""):
            raise UsageError(f"--maximise {wrong}: {fit.board} has no such number; it has {', '.join(known)}")
        ends = any(apart(key)[1] for part in box for key in keys_of(part.key))
        if outside or ends or fit.study.assignments or fit.search_repeats is not None:
            raise UsageError(f"{fit.board}: only whole parameters of the model are free, without --set and --repeats")
    elif not names:
        raise UsageError("--claims: a fit without experiments needs some, for example C13,C15")
    else:
        middle = [setting_at(box, [0.5] * len(box))]
        plan, judging = (sweep_plan.planned(study_of(fit, middle, anew=anew), seed) for anew in (False, True))
        if fit.of_claims and not plan.claims:
            raise UsageError(f"{', '.join(names)}: no claim there can be fitted to")
        measures = [measure.name for measure, _ in plan.measures]
        if wrong := next((goal for goal in fit.goals if not fit.of_claims and goal not in measures), ""):
            raise UsageError(f"--maximise {wrong}: not measured there; measured are {', '.join(measures)}")
        fewest = min(*plan.repeats, *judging.repeats)
        for claim, _ in plan.claims if plan.things == "trials" else ():
            if fewest < claim.least:
                raise UsageError(
                    f"--repeats {fewest}: {claim.id} needs at least {claim.least} trials of each condition"
                )
    size = PAIR * fit.share
    renderings = 1 if not outside else size if len(outside) == len(box) else PAIR
    return FitPlan(fit, box, seed, renderings, size // renderings)


def run(plan: FitPlan, out: Path, resources: Resources) -> Fitted:
    """Run what a fit's folder lacks, and write its tables and figure.

    Parameters
    ----------
    plan
        From `planned`.
    out
        The fit's folder: a new one, or one that holds a part of this fit. More settings may be searched than before.
    resources
        Workers, or a cluster.

    Raises
    ------
    UsageError
        There is another run.
    """
    import optuna

    fit, failures = plan.fit, list[Failure]()
    over = [str(part) for part in plan.box]
    begin_whole(out, "fit", study=fit.study.name, seed=plan.seed, over=over, optuna=optuna.__version__)
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    search: Any = optuna.create_study(directions=["maximize"] * len(fit.goals))
    settings: list[Setting] = []
    batches: list[pl.DataFrame] = []

    def play(name: str, shown: Sequence[Setting], seed: int, replicates: int, *, anew: bool = False) -> pl.DataFrame:
        if not fit.board:
            study = replace(study_of(fit, shown, anew=anew), replicates=replicates)
            result = sweep.play(sweep_plan.planned(study, seed), out / name, pool, resources, name)
            failures.extend(result.failures)
            return pl.DataFrame(list(_of_sweep(result, fit)), RESULTS, orient="row")
        rows: list[tuple[Any, ...]] = []
        texts = [text_of(fit, setting) for setting in shown]
        for number in range(replicates):
            folder = out / (f"{name}-{number}" if replicates > 1 else name)
            found, more = _on_board(fit, texts, seed + APART * number, folder, pool, resources)
            failures.extend(more)
            rows += [(place, goal, number, None, math.nan if (value := found[text].get(goal)) is None else value)
                     for place, text in enumerate(texts) for goal in fit.goals]  # fmt: skip
        return pl.DataFrame(rows, RESULTS, orient="row")

    with resources.pool() as pool:
        for number in range(plan.batches):
            asked = ask_for(search, plan, number)
            shown = [{part.key: part.text(trial.params[part.key]) for part in plan.box} for trial in asked]
            results = play(f"search-{number:04d}", shown, plan.seed, fit.study.replicates)
            tell(search, asked, scored(results), fit)
            batches.append(results.with_columns(pl.col("setting") + len(settings)))
            settings += shown
            searched = pl.concat(batches)
        best = best_of(scored(searched), settings, fit)
        again: list[Setting] = [settings[place] for place in best] + ([] if fit.of_claims else [{}])
        anew = play(f"held-out-{len(settings)}", again, plan.seed + TEST, fit.held_out, anew=True)
        even = spread(plan.box, fit.sample, plan.seed)
        sample = play(f"sample-{fit.sample}", even, plan.seed + SAMPLE, fit.study.replicates)
    looks = len({folder.name.split("-")[2] for folder in out.glob("held-out-*") if begun(folder)})
    names = searched["name"].unique(maintain_order=True).to_list()
    shares = {TOGETHER: importance(search, plan)} if fit.of_claims and len(names) > 1 else {}
    shares |= {name: importance(search, plan, name) for name in names}
    fitted = conclude(plan, settings, searched, best, anew, even, sample, looks, shares, failures)
    write(fitted, out)
    return fitted


def write(fitted: Fitted, folder: Path) -> None:
    """Write ``fit.csv``, ``anew.csv``, ``fit.json``, ``fit.svg`` and ``fit.png``."""
    from experiments.bench.report import fit as report  # not before: workers do without matplotlib
    from experiments.bench.report import style

    files, study, share = Files(folder), fitted.plan.fit.study, fitted.share
    low, high = (share.interval if share else None) or (None, None)
    files.write_rows("fit.csv", fitted.settings.to_dicts())
    files.write_rows("anew.csv", fitted.anew.to_dicts())
    files.write_json("fit.json", {
        "fit": study.name, "summary": study.summary, "sentences": fitted.sentences, "seed": fitted.plan.seed,
        "winner": dict(fitted.winner), "word": fitted.word, "goals": fitted.plan.fit.goals, "luck": fitted.luck,
        "gain": fitted.gain, "looks": fitted.looks, "importance": fitted.importance, "failures": fitted.failures,
        "share": share and {"kept": share.holds, "of": share.replicates, "low": low, "high": high},
    })  # fmt: skip
    style.save(report.draw(fitted), folder / "fit")

"""Fits: a search for parameters under which claims hold together or measures are largest, judged on fresh seeds.

Each batch of settings is a sweep of one axis, a leaderboard or tuning curves, and is continued as any other.
"""

from __future__ import annotations

import importlib.util
import itertools
import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import polars as pl
from polars.dataframe.group_by import GroupBy
from pydantic import Field, SkipValidation
from pydantic.dataclasses import dataclass as validated

from experiments.bench import leaderboard, registry, sweep, sweep_plan, tune
from experiments.bench.grid import ENDS, apart, keys_of
from experiments.bench.measures import SPIKES
from experiments.bench.report.terminal import error_console
from experiments.bench.run import provenance
from experiments.bench.run.description import KIND, begun, reconciled, write_new
from experiments.bench.run.errors import UsageError
from experiments.bench.run.files import Files
from experiments.bench.run.models import PRESET, ask, look_up
from experiments.bench.run.provenance import drawn_from, tables_of
from experiments.bench.run.rows import Failure
from experiments.bench.run.runs import Resources
from experiments.bench.run.settings import changed, check_counts, collect, schema_of, unit_of
from experiments.bench.run.streams import stream
from experiments.bench.run.workers import Workers
from experiments.bench.sources.clips import OfflineExperiment
from experiments.bench.stats.checks import MARGIN, Check
from experiments.bench.stats.count import LEAST_JUDGED, Count, count
from experiments.bench.stats.tests import summarise
from experiments.bench.stats.verdict import Outcome, together
from experiments.bench.study import Axis, Level, Study, make_tuples
from experiments.bench.sweep import TOGETHER

Setting = Mapping[str, str]
"""Key of each range of the box -> its value as ``--set`` takes it."""
SLACK, KEPT = "slack", "kept"
"""Goals of claims: the least slack over claims and replicates, or the number of claims kept."""
LEADERBOARD, TUNING = "leaderboard", "tuning"
"""What may stand in place of experiments: the leaderboard's scores, or the numbers of tuning curves."""
BOARD_NAMES = {
    LEADERBOARD: tuple(
        name for panels in leaderboard.PANELS.values() for names in panels.values() for name in names
        if name not in leaderboard.TIMES
    ),
    TUNING: tune.NUMBERS,
}  # fmt: skip
"""The numbers that a fit may make large there: no times, which another run would not repeat."""
PAIR = 2
"""Settings of the renderings in a batch, where both they and the network are searched."""
NEXT_BEST = 10
"""Settings that are judged anew beside the winner."""
TEST, SAMPLE, APART = 1_000_000, 2_000_000, 1000
"""Added to the seed of the search for the judging anew and for the sample; distance of a board's replicates."""
MOST_SLACK = 100.0
"""Slack at which each claim is clipped, in smallest differences. A claim that cannot be judged has it below 0."""
AS_IS = "as it is"
"""Name of the model without a setting."""
LOG_FROM = 100.0
"""Ratio of the ends of a range from which it is searched by its logarithm."""
TO = ".."


AtLeastOne = Annotated[int, Field(ge=1)]


@validated(frozen=True, slots=True)
class Fit:
    """A search for the parameters under which all claims of a study hold, or measures are largest.

    Parameters
    ----------
    study
        Claims or measures, experiments, one model, what holds at every point, and the replicates that each setting is
        searched by. It has no axes. Its experiments may be ``("leaderboard",)`` or ``("tuning",)`` alone.
    over
        The box: ``KEY=A..B``, ``KEY=V1,V2`` or ``KEY`` texts, one for each parameter, or for several of one value with
        ``+`` between their keys. ``KEY`` alone is its whole legal range. A range of positive numbers whose ends are 100
        times apart is searched by its logarithm.
    trials
        Settings that are searched, rounded up to whole batches of twice ``share``.
    share
        Settings of the network that are shown the frames of one rendering.
    sample
        Settings of the space-filling sample, each with a rendering of its own.
    held_out
        Replicates in which the winner and the ten next best are judged anew.
    sampler
        What chooses the settings: Optuna's ``tpe``, or ``random``.
    search_repeats
        Trials of each condition in a replicate of search and sample; ``None``: those of the study, which the judging
        anew always has. Fewer make a search quicker, and its slack rougher.
    maximise, minimise
        The goals, made large, and small: ``slack`` or ``kept`` of claims, the study's measures, columns of the
        leaderboard's table or of ``preferences.csv``. Several give a front: the settings that none betters in all.

    Raises
    ------
    UsageError
        The study has axes or several models, or the goals do not go together.
    pydantic.ValidationError
        A number is out of its range.

    Examples
    --------
    >>> from experiments import Fit, Study
    >>> speed = Study("threshold", "C15 at some threshold", claims=("C15",), replicates=1)
    >>> Fit(speed, over=("dsnn.t_sp=0.05..0.3",), trials=60).sample
    64
    """

    study: SkipValidation[Study]
    over: tuple[str, ...]
    trials: AtLeastOne = 400
    share: AtLeastOne = 10
    sample: AtLeastOne = 64
    held_out: AtLeastOne = 20
    sampler: Literal["tpe", "random"] = "tpe"
    search_repeats: AtLeastOne | None = None
    maximise: tuple[str, ...] = (SLACK,)
    minimise: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        make_tuples(self, f"fit {self.study.name}", ("over", "maximise", "minimise"))
        study, goals = self.study, list(self.goals)
        if study.axes or study.over or study.measures or study.as_run or len(study.models) != 1:
            raise UsageError(f"fit {study.name}: its study must have one model, and neither axes nor measures")
        if not goals or (len(goals) > 1 and {SLACK, KEPT} & {*goals}) or {SLACK, KEPT} & {*self.minimise}:
            raise UsageError(f"--maximise {','.join(goals)}: slack and kept are made large, each as the only goal")
        if self.board and len(study.experiments) > 1:
            raise UsageError(f"{self.board}: it is fitted to alone, without {', '.join(study.experiments)}")
        if study.claims and not self.of_claims:
            raise UsageError(f"--claims: {goals[0]} is no number of claims; leave out --claims, or --maximise")

    @property
    def goals(self) -> dict[str, int]:
        """The goals in order, each with 1, or -1 where it is made small."""
        return dict.fromkeys(self.maximise, 1) | dict.fromkeys(self.minimise, -1)

    @property
    def of_claims(self) -> bool:
        """True if the goal is one of claims, and not a measure."""
        return next(iter(self.goals)) in (SLACK, KEPT)

    @property
    def board(self) -> str:
        """``leaderboard`` or ``tuning``; empty where the fit is to experiments."""
        return next((name for name in self.study.experiments if name in BOARD_NAMES), "")


# The box.


@dataclass(frozen=True, slots=True)
class Range:
    """The values that one parameter may take, or several together: those between two ends, or some by name.

    Parameters
    ----------
    key
        As ``--over`` has it: ``dsnn.t_sp``, or ``dsnn.tau_s.first`` for an end of several values, or
        ``plain.fps+cluttered.fps`` for parameters that have one value.
    low, high
        The ends, which belong to it.
    whole
        Whether it takes whole numbers alone.
    choices
        The values by name; empty where there are ends.
    unit
        Of the values; empty where none is known.
    network
        Whether it is a parameter of the model, so that its values can share their frames.
    """

    key: str
    low: float = 0.0
    high: float = 1.0
    whole: bool = False
    choices: tuple[str, ...] = ()
    unit: str = ""
    network: bool = False

    @property
    def log(self) -> bool:
        """True if it is searched by its logarithm: both ends are above 0, and their ratio is `LOG_FROM` or more."""
        return not self.choices and self.low > 0.0 and self.high / self.low >= LOG_FROM

    def text(self, value: float | str) -> str:
        """Return a value as ``--set`` takes it, a number to six digits."""
        return value if isinstance(value, str) else str(int(value)) if self.whole else f"{value:.6g}"

    def at(self, share: float) -> str:
        """Return the value below which a share of the range lies, 0 up to below 1; whole numbers have equal shares."""
        if self.choices:
            return self.choices[int(share * len(self.choices))]
        if self.log:
            value = math.exp(math.log(self.low) + share * math.log(self.high / self.low))
            return self.text(round(value) if self.whole else value)
        if self.whole:
            return self.text(int(self.low) + int(share * (round(self.high - self.low) + 1)))
        return self.text(self.low + share * (self.high - self.low))

    def __str__(self) -> str:
        """Return the text of ``--over``."""
        return f"{self.key}={','.join(self.choices) or f'{self.text(self.low)}{TO}{self.text(self.high)}'}"


Box = tuple[Range, ...]
"""All ranges of a fit."""


def setting_at(box: Box, shares: Sequence[float]) -> dict[str, str]:
    """Return the setting at a place of the unit cube, one share for each range."""
    return {part.key: part.at(share) for part, share in zip(box, shares, strict=True)}


def box_of(over: Sequence[str], study: Study, experiments: Sequence[Any]) -> Box:
    """Return the box of ``KEY=A..B``, ``KEY=V1,V2`` and ``KEY`` texts, checked against the experiments that they move.

    Parameters
    ----------
    over
        One text for each parameter, or for several of one value with ``+`` between their keys.
    study
        Says the models and what holds at every point.
    experiments
        Declarations of one kind; empty where models alone are moved.

    Raises
    ------
    UsageError
        A text is not of these forms, its key is of no experiment or model or is there twice, an end is not legal, or
        ``--set`` settles the key.
    """
    sections: dict[str, Any] = {model.section: model.chosen.network for model in look_up(study.models)}
    networks = set(sections)
    free = replace(study, assignments=())
    for experiment in experiments:
        on_clips = isinstance(experiment, OfflineExperiment)
        part = (sweep_plan.clips_part(experiment, free, 0, (), None) if on_clips
                else sweep_plan.robot_part(experiment, study.models, free, 0, None))  # fmt: skip
        sections |= {section: values[0] for section, values in part.bases()[0].items()}
    settled = {text.partition("=")[0] for text in study.assignments}
    ranges: list[Range] = []
    taken: set[str] = set()
    for text in over:
        name, equals, ends = text.partition("=")
        parts = [_range(f"{key}{equals}{ends}", sections, networks) for key in keys_of(name)]
        for key in keys_of(name):
            if key in taken or apart(key)[0] in settled:
                raise UsageError(f"--over {text}: {key} is there twice, or --set settles it")
            taken.add(key)
        if len({replace(part, key=name, unit="") for part in parts}) > 1:
            raise UsageError(f"--over {text}: {' and '.join(keys_of(name))} take no one value")
        ranges.append(replace(parts[0], key=name))
    if not ranges:
        raise UsageError("--over: a fit needs one parameter or more, for example --over dsnn.t_sp=0.05..0.3")
    return tuple(ranges)


def _range(text: str, sections: Mapping[str, Any], networks: set[str]) -> Range:
    key, equals, ends = text.partition("=")
    parameter, end = apart(key)
    collect([f"{parameter}={ends}"], sections, option="--over")  # the key is known
    section, _, name = parameter.partition(".")
    value, network = sections[section], section in networks
    if name == PRESET and network:
        raise UsageError(f"--over {text}: a preset of a model is not searched; its parameters are")
    schema, unit, present = schema_of(value, name), unit_of(value, name), getattr(value, name, None)
    if isinstance(present, tuple) != bool(end):
        raise UsageError(f"--over {text}: KEY.first or KEY.last is for a parameter of several values, and only for one")
    if end:
        schema = (schema.get("prefixItems") or [schema["items"]])[0]
    choices: tuple[str, ...] = ()
    low = high = 0.0
    if equals and TO not in ends:
        choices = tuple(dict.fromkeys(filter(None, ends.split(","))))
        if len(choices) < 2:
            raise UsageError(f"--over {text}: expected KEY=A{TO}B, or two values or more as KEY=V1,V2; --set sets one")
    elif not equals and ("enum" in schema or schema.get("type") == "boolean"):
        choices = tuple(map(str, schema["enum"])) if "enum" in schema else ("false", "true")
    else:
        low, high = _ends(text, ends, schema)
    for one in choices or (f"{low:.6g}", f"{high:.6g}"):
        parts = [str(part) for part in present or ()] if end else [one]
        parts[ENDS.get(end, 0)] = one
        changed("", value, {name: ",".join(parts)}, lambda _name, _text: f"--over {text}")
    return Range(key, low, high, schema.get("type") == "integer" and not choices, choices, unit, network)


def _ends(text: str, ends: str, schema: Mapping[str, Any]) -> tuple[float, float]:
    """Return the ends that were typed, or those of the legal range."""
    if schema.get("type") not in ("number", "integer"):
        raise UsageError(f"--over {text}: it is no number; list its values as KEY=V1,V2")
    if not ends:
        if not {"minimum", "maximum"} <= schema.keys():
            raise UsageError(f"--over {text}: its legal range has no two ends; give them as KEY=A{TO}B")
        return float(schema["minimum"]), float(schema["maximum"])
    try:
        low, high = (float(part) for part in ends.split(TO))
    except ValueError:
        low = high = math.nan
    if not -math.inf < low < high < math.inf:
        raise UsageError(f"--over {text}: expected two numbers as KEY=A{TO}B, the lower first")
    if schema["type"] == "integer" and not (low.is_integer() and high.is_integer()):
        raise UsageError(f"--over {text}: the parameter takes whole numbers, and so do its ends")
    return low, high


def spread(box: Box, number: int, seed: int) -> list[dict[str, str]]:
    """Return settings that fill a box evenly: the first points of a scrambled Sobol sequence.

    References
    ----------
    Owen 1998, Scrambling Sobol' and Niederreiter-Xing points.
    """
    from scipy.stats import qmc

    sequence = qmc.Sobol(len(box), scramble=True, rng=stream("fit.sample", seed))
    points = sequence.random_base2((number - 1).bit_length())[:number]
    return [setting_at(box, [min(float(share), np.nextafter(1.0, 0.0)) for share in point]) for point in points]


# The search.


class Search:
    """Ask Optuna for settings, batch by batch, and tell it their values.

    The sampler is made anew for each batch, seeded by the seed of the fit and the batch's number. So equal seeds give
    equal settings, whatever plays them; and a fit that was cut short asks again for what it had, and finds it played.

    Parameters
    ----------
    box, seed
        Where to search, and the seed of the fit.
    renderings, share
        Settings of the renderings in a batch, and settings of the network that share each.
    fit
        Says sampler and goals.
    """

    def __init__(self, box: Box, seed: int, renderings: int, share: int, fit: Fit) -> None:
        import optuna

        optuna.logging.set_verbosity(optuna.logging.WARNING)
        self._optuna: Any = optuna
        self._box, self._seed, self._renderings, self._share, self._fit = box, seed, renderings, share, fit
        self.study: Any = optuna.create_study(directions=["maximize"] * len(fit.goals))
        self._free = {part.key: self._distribution(part) for part in box}
        self._asked: list[Any] = []
        self._batch = 0

    def _distribution(self, part: Range) -> Any:
        distributions = self._optuna.distributions
        if part.choices:
            return distributions.CategoricalDistribution(part.choices)
        if part.whole:
            return distributions.IntDistribution(int(part.low), int(part.high), log=part.log)
        return distributions.FloatDistribution(part.low, part.high, log=part.log)

    def ask(self) -> list[dict[str, str]]:
        """Return the settings of the next batch; those that share a rendering one after another."""
        state = int(np.random.SeedSequence(self._seed, spawn_key=(self._batch,)).generate_state(1)[0])
        samplers = self._optuna.samplers
        if self._fit.sampler == "tpe":
            self.study.sampler = samplers.TPESampler(seed=state, constant_liar=True)
        else:
            self.study.sampler = samplers.RandomSampler(seed=state)
        self._asked = []
        for _ in range(self._renderings):
            first = self.study.ask(self._free)
            self._asked.append(first)
            outside = {part.key: first.params[part.key] for part in self._box if not part.network}
            for _ in range(self._share - 1):
                if outside:
                    self.study.enqueue_trial(outside)
                self._asked.append(self.study.ask(self._free))
        self._batch += 1
        return [{part.key: part.text(trial.params[part.key]) for part in self._box} for trial in self._asked]

    def tell(self, scores: pl.DataFrame) -> None:
        """Tell the `scored` values of the last batch; a setting without a value counts as failed."""
        failed = self._optuna.trial.TrialState.FAIL
        for trial, row in zip(self._asked, scores.iter_rows(named=True), strict=True):
            for name in names_of(row):
                trial.set_user_attr(name, row[name])
            values = worth(row, self._fit)
            known = all(map(math.isfinite, values))
            self.study.tell(trial, values if known else None, state=None if known else failed)

    def importance(self, name: str = "") -> dict[str, float]:
        """Return the share of each parameter in whether the first goal, a claim or a measure is among the best tenth.

        By PED-ANOVA (Watanabe, Bansal and Hutter 2023); all 0 where every setting came to the same.
        """
        sign = self._fit.goals.get(name, 1)

        def number(trial: Any) -> float:
            return sign * float(trial.user_attrs[name] if name else trial.values[0])

        known = [trial for trial in self.study.get_trials(deepcopy=False) if trial.values]
        if len({number(trial) for trial in known}) < 2:
            return dict.fromkeys(self._free, 0.0)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "PedAnova.*low `target`", UserWarning)  # it is given the slack below 0
            shares = self._optuna.importance.get_param_importances(
                self.study, evaluator=self._optuna.importance.PedAnovaImportanceEvaluator(),
                target=lambda trial: -number(trial),
            )  # fmt: skip
        return {key: float(shares.get(key, 0.0)) for key in self._free}


# Results of settings: a table with a row for each setting, claim or measure, and replicate.

RESULTS = pl.Schema(
    {"setting": pl.Int64, "name": pl.String, "replicate": pl.Int64, "verdict": pl.String, "value": pl.Float64}
)
"""``value`` is the slack of a claim, or a measure, NaN where it has none; ``verdict`` is of claims alone."""


def slack(outcome: Outcome) -> float:
    """Return how far inside its bounds a claim lies in one replicate, in smallest differences.

    Returns
    -------
    float
        The least over its checks, from -`MOST_SLACK` to `MOST_SLACK`; -`MOST_SLACK` where it could not be judged, so
        that a silent network gains nothing by silence.
    """
    if not outcome.judged or not outcome.checks:
        return -MOST_SLACK
    return float(np.clip(min(map(_differences, outcome.checks)), -MOST_SLACK, MOST_SLACK))


def _differences(check: Check) -> float:
    """Return slack over smallest difference: that of potentials where the reading has no unit, else 1 of the unit."""
    return -MOST_SLACK if np.isnan(check.slack) else check.slack / MARGIN["spikes" if check.unit else "potential"]


def names_of(columns: Iterable[str]) -> list[str]:
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


# Playing settings.


def assigned(setting: Setting) -> tuple[str, ...]:
    """Return a setting as ``KEY=VALUE`` texts, one for each parameter of those that move together."""
    return tuple(f"{key}={value}" for name, value in setting.items() for key in keys_of(name))


def settings_axis(settings: Sequence[Setting]) -> Axis:
    """Return the axis of a study whose levels are settings, by their numbers."""
    return Axis("setting", tuple(Level(str(number), assigned(setting)) for number, setting in enumerate(settings)))


def study_of(fit: Fit, *, anew: bool = False) -> Study:
    """Return the study that a fit plays, with the measures that are its goals; the search may have fewer trials."""
    study = fit.study if anew or fit.search_repeats is None else replace(fit.study, repeats=fit.search_repeats)
    if fit.of_claims:
        return study
    measures = [SPIKES if name.partition(":")[0] == SPIKES else name for name in fit.goals]
    return replace(study, measures=tuple(dict.fromkeys(sorted(measures, key=SPIKES.__eq__))))


def text_of(fit: Fit, setting: Setting) -> str:
    """Return the model of a fit with a setting, as ``--model`` takes it."""
    (model,) = fit.study.models
    parts = ",".join(text.partition(".")[2] for text in assigned(setting))
    return model if not parts else f"{model},{parts}" if ask(model).settings else f"{model}:{parts}"


@dataclass(frozen=True, slots=True)
class Player:
    """Plays settings of a fit in folders of its own, and takes note of what fails."""

    fit: Fit
    out: Path
    resources: Resources
    failures: list[Failure]

    def __call__(
        self, name: str, settings: Sequence[Setting], seed: int, replicates: int, pool: Workers, *, anew: bool = False
    ) -> pl.DataFrame:
        """Play what the folder ``name`` lacks of settings, and return their `RESULTS`."""
        play = self._board if self.fit.board else self._sweep
        return pl.DataFrame(list(play(name, settings, seed, replicates, pool, anew)), RESULTS, orient="row")

    def _sweep(
        self, name: str, settings: Sequence[Setting], seed: int, replicates: int, pool: Workers, anew: bool
    ) -> Any:
        study = replace(study_of(self.fit, anew=anew), axes=(settings_axis(settings),), replicates=replicates)
        plan = sweep_plan.planned(study, seed)
        with sweep.batch(plan, name).run(self.out / name, pool, self.resources) as folder:
            result = sweep.Sweep(plan, folder.trials().to_dicts(), folder.failures())
        self.failures.extend(result.failures)
        measures = {measure.name: (measure, experiment) for measure, experiment in plan.measures}
        for point, model in plan.judged:
            number = int(point[0][1])
            for claim, _ in plan.claims if self.fit.of_claims else ():
                for place, outcome in enumerate(result.outcomes[point, model, claim.id]):
                    yield number, claim.id, place, outcome.verdict, slack(outcome)
            for goal in () if self.fit.of_claims else self.fit.goals:
                for place, value in enumerate(result.values(*measures[goal], point, model)):
                    yield number, goal, place, None, math.nan if value is None else value

    def _board(
        self, name: str, settings: Sequence[Setting], seed: int, replicates: int, pool: Workers, _anew: bool
    ) -> Any:
        texts = [text_of(self.fit, setting) for setting in settings]
        shown = list(dict.fromkeys(texts))
        for place in range(replicates):
            folder, own = self.out / (f"{name}-{place}" if replicates > 1 else name), seed + APART * place
            if self.fit.board == LEADERBOARD:
                planned = leaderboard.plan(shown, None, own)
                responses, failures = leaderboard.play(planned, folder, pool, self.resources)
                tables = [board.to_dicts() for board in leaderboard.rank(planned, responses).values()]
            else:
                _, preferences, failures = tune.run(tune.plan(shown, (), (), own), folder, pool, self.resources)
                tables = [list(preferences)]
            self.failures.extend(failures)
            rows: dict[str, dict[str, Any]] = {}
            for row in itertools.chain(*tables):
                rows.setdefault(row["model"], {}).update(row)
            for number, text in enumerate(texts):
                row = rows.get(look_up([text])[0].chosen.label, {})
                for goal in self.fit.goals:
                    value = row.get(goal)
                    yield number, goal, place, None, math.nan if value is None else value


# The result.


@dataclass(frozen=True)
class Fitted:
    """The result of a fit: settings searched, the best of them judged anew, and a sample of the box.

    Parameters
    ----------
    fit
        The fit that was asked for.
    box
        The parameters that are free, and their ranges.
    seed
        Seed of the whole run.
    settings
        Every setting that was searched, in order.
    searched
        Their results: a row for each setting, claim or measure, and replicate.
    best
        Numbers of the winner and of the next best among these; of several goals those of the front.
    anew
        The results of the best at seeds that the search never saw; of measures the model as it is comes after them.
    even
        The settings that fill the box evenly.
    sample
        Their results.
    looks
        Number of times that settings were judged at those seeds, this one included.
    importance
        Claim or measure -> parameter -> its share of what varies; empty is all claims together, or the first goal.
    failures
        Everything that failed.
    """

    fit: Fit
    box: Box
    seed: int
    settings: tuple[Setting, ...]
    searched: pl.DataFrame
    best: tuple[int, ...]
    anew: pl.DataFrame
    even: tuple[Setting, ...]
    sample: pl.DataFrame
    looks: int
    importance: dict[str, dict[str, float]]
    failures: tuple[Failure, ...] = ()

    @property
    def winner(self) -> Setting:
        """The best setting as the search saw it; of several goals the best in the first."""
        return self.settings[self.best[0]]

    @property
    def names(self) -> list[str]:
        """The claims, or the measures."""
        return self.searched["name"].unique(maintain_order=True).to_list()

    def values(self, results: pl.DataFrame, setting: int, name: str = "") -> list[float]:
        """Return the values of a claim or a measure in each replicate.

        Parameters
        ----------
        results
            ``searched``, ``anew`` or ``sample``.
        setting
            Number of the setting there.
        name
            A claim or a measure; empty: the least slack of all claims.

        Returns
        -------
        list of float
            Slack in smallest differences, or the measure; NaN where it has no value.
        """
        return _replicates(results, setting, name).agg(pl.col("value").min())["value"].to_list()

    def goal(self, results: pl.DataFrame) -> list[float]:
        """Return the first goal of each setting.

        Parameters
        ----------
        results
            ``searched`` or ``sample``.

        Returns
        -------
        list of float
            Least slack, claims kept, or the mean of a measure.
        """
        sign = next(iter(self.fit.goals.values()))
        return [sign * worth(row, self.fit)[0] for row in scored(results).to_dicts()]

    def kept(self, results: pl.DataFrame, setting: int, claim: str = "") -> Count:
        """Count the replicates in which a claim is kept.

        Parameters
        ----------
        results
            ``searched``, ``anew`` or ``sample``.
        setting
            Number of the setting there.
        claim
            Its id; empty: all claims together.

        Returns
        -------
        Count
            How often it is kept, fails, and cannot be judged.
        """
        verdicts = _replicates(results, setting, claim).agg("verdict")["verdict"].to_list()
        return count(together(each) for each in verdicts)

    @property
    def share(self) -> Count:
        """The count of the sample's settings in which every claim is kept: the share of the box, with its interval."""
        kept = int((scored(self.sample)["kept"] == len(self.names)).sum())
        return Count(kept, len(self.even) - kept)

    @property
    def word(self) -> str:
        """The verdict on the winner: ``fitted``; ``not fitted``; or ``no word``, of too few replicates judged anew."""
        anew, before = self.kept(self.anew, 0), self.kept(self.searched, self.best[0])
        if before.holds < before.replicates:
            return "not fitted"
        if anew.word == "holds":
            return "fitted"
        return "no word" if anew.kind == "counted" and not anew.fails else "not fitted"

    def luck(self, goal: str = "") -> float | None:
        """Return by how much the search promised too much of its winner: its goal there less that at fresh seeds.

        Parameters
        ----------
        goal
            A measure; empty: the mean of the least slack of all claims.

        Returns
        -------
        float or None
            Above 0 where the search promised too much; ``None`` where it is not known.
        """
        before = _mean(self.values(self.searched, self.best[0], goal), whole=True)
        after = _mean(self.values(self.anew, 0, goal))
        if before is None or after is None:
            return None
        return 0.0 if math.isclose(before, after, rel_tol=1e-12) else self.fit.goals.get(goal, 1) * (before - after)

    def gain(self, goal: str) -> float | None:
        """Return by how much the winner is better than the model as it is, both at fresh seeds.

        Parameters
        ----------
        goal
            A measure.

        Returns
        -------
        float or None
            Above 0 where the winner is better; ``None`` where a value is not known.
        """
        after, start = (_mean(self.values(self.anew, place, goal)) for place in (0, len(self.best)))
        return None if after is None or start is None else self.fit.goals[goal] * (after - start)

    def pairs(self) -> pl.DataFrame:
        """Count in how many settings of search and sample two claims are kept, each and both together.

        Returns
        -------
        polars.DataFrame
            ``claim``, ``other``, ``kept``, ``other kept``, ``both``, ``settings``.
        """
        held: dict[str, set[tuple[str, int]]] = {}
        for of, results in (("search", self.searched), ("sample", self.sample)):
            holds = results.group_by("setting", "name", maintain_order=True).agg((pl.col("verdict") == "holds").all())
            for setting, name, kept in holds.iter_rows():
                held.setdefault(name, set()).update([(of, setting)] if kept else [])
        return pl.DataFrame([
            {"claim": one, "other": other, "kept": len(held[one]), "other kept": len(held[other]),
             "both": len(held[one] & held[other]), "settings": len(self.settings) + len(self.even)}
            for one, other in itertools.combinations(self.names, 2)
        ])  # fmt: skip

    def table(self) -> pl.DataFrame:
        """Return the settings of search and sample.

        Returns
        -------
        polars.DataFrame
            A row for each: ``of``, ``number``, its values, and the slacks of claims or the means of measures.
        """
        parts = []
        for of, settings, results in (("search", self.settings, self.searched), ("sample", self.even, self.sample)):
            scores = scored(results)
            if self.fit.of_claims:
                scores = scores.select(
                    "kept", pl.lit(len(self.names)).alias("claims"), pl.col("least").alias("least slack"),
                    *(pl.col(name).alias(f"slack {name}") for name in self.names),
                )  # fmt: skip
            own = pl.DataFrame({"of": [of] * len(settings), "number": range(len(settings))})
            parts.append(
                pl.concat([own, pl.DataFrame(settings), scores.select(pl.exclude("setting"))], how="horizontal")
            )
        return pl.concat(parts)

    def judged_anew(self) -> pl.DataFrame:
        """Return the settings that were judged anew.

        Returns
        -------
        polars.DataFrame
            A row for each and each claim or goal: the count or the mean, the ends of its 95 % interval, and the value
            in the search.
        """
        rows: list[dict[str, Any]] = []
        numbers: list[int | None] = [*self.best, *([] if self.fit.of_claims else [None])]
        several = ["", *self.names] if len(self.names) > 1 else self.names
        for place, number in enumerate(numbers):
            setting = {part.key: AS_IS for part in self.box} if number is None else self.settings[number]
            for name in several if self.fit.of_claims else self.fit.goals:
                row: dict[str, Any] = {"number": number, **setting}
                before = [] if number is None else self.values(self.searched, number, name)
                after = self.values(self.anew, place, name)
                if self.fit.of_claims:
                    counted = self.kept(self.anew, place, name)
                    low, high = counted.interval or (None, None)
                    row |= {"claim": name or TOGETHER, "kept": counted.holds, "replicates": counted.replicates,
                            "low": low, "high": high, "word": word(counted), "slack in the search": np.mean(before),
                            "slack anew": np.mean(after)}  # fmt: skip
                else:
                    known = [value for value in after if math.isfinite(value)]
                    summary = summarise(known) if known else None
                    low, high = (summary.ci_low, summary.ci_high) if summary else (None, None)
                    row |= {"goal": name, "in the search": _mean(before, whole=True), "anew": _mean(after),
                            "low": low, "high": high, "replicates": len(known)}  # fmt: skip
                rows.append(row)
        return pl.DataFrame(rows, infer_schema_length=None).with_columns(pl.selectors.float().fill_nan(None))

    def sentences(self) -> list[str]:
        """Return the answer in sentences.

        Returns
        -------
        list of str
            The winner judged anew, how much of it was luck, the even sample, and what was searched.
        """
        ranges = "; ".join(f"{part}{f' {part.unit}' if part.unit else ''}" for part in self.box)
        replicates = self.fit.study.replicates
        return [
            *(self._of_claims() if self.fit.of_claims else self._of_measures()),
            f"searched: {len(self.settings)} settings of {ranges}, in {replicates} replicate{'s' * (replicates != 1)}"
            f" each; looked at the seeds of the judging anew {self.looks} time{'s' * (self.looks != 1)}",
        ]  # fmt: skip

    def _of_claims(self) -> list[str]:
        share, (low, high) = self.share, self.share.interval or (0.0, 1.0)
        kept = f"all {len(self.names)} claims are kept" if len(self.names) > 1 else f"{self.names[0]} is kept"
        lines = [
            f"in {share.holds} of {len(self.even)} settings that fill the box evenly {kept}:"
            f" {100.0 * share.holds / len(self.even):.3g} % of the box, 95 % interval {100.0 * low:.3g} % to"
            f" {100.0 * high:.3g} %"
        ]
        setting, anew = in_words(self.winner), self.kept(self.anew, 0)
        searched = {name: self.kept(self.searched, self.best[0], name) for name in self.names}
        broken = [name for name, counted in searched.items() if counted.holds < counted.replicates]
        if broken:
            lines.append(f"not fitted: none of the {len(self.settings)} settings searched keeps all; the best,"
                         f" {setting}, breaks {', '.join(broken)} in the search")  # fmt: skip
        else:
            few = "; ".join(f"{name} {self.kept(self.anew, 0, name)}" for name in self.names)
            verdict = f"too few for a verdict, which needs {LEAST_JUDGED}" if self.word == "no word" else self.word
            lines.append(f"{verdict}: {setting} keeps all in the search, and in {anew} replicates that it never saw"
                         f"{f' ({few})' if len(self.names) > 1 and self.word != 'fitted' else ''}")  # fmt: skip
        before, after = (np.mean(self.values(*of)) for of in ((self.searched, self.best[0]), (self.anew, 0)))
        lines.append(f"the least slack of that setting is {before:+.3g} smallest differences in the search and"
                     f" {after:+.3g} in the mean of {anew.replicates} replicates anew:"
                     f" {max(self.luck() or 0.0, 0.0):.3g} of it was luck")  # fmt: skip
        even = scored(self.sample).sort("least", descending=True, maintain_order=True).to_dicts()[0]
        if even["least"] > min(self.values(self.searched, self.best[0])):
            lines.append(f"an even setting has a larger slack, {even['least']:+.3g}, than any that was searched:"
                         f" {in_words(self.even[even['setting']])}; more --trials may find it")  # fmt: skip
        for pair in self.pairs().iter_rows(named=True):
            if pair["kept"] and pair["other kept"] and not pair["both"]:
                lines.append(f"{pair['claim']} and {pair['other']} exclude each other: kept in {pair['kept']} and in"
                             f" {pair['other kept']} of {pair['settings']} settings, both in none")  # fmt: skip
        return lines

    def _of_measures(self) -> list[str]:
        goals, lines, setting = self.fit.goals, list[str](), in_words(self.winner)
        if len(goals) > 1:
            lines.append(f"{len(self.best)} settings of the front of {', '.join(goals)}, which none betters in all, are"
                         f" judged anew; the winner is the best of them in {next(iter(goals))}")  # fmt: skip
        table = self.judged_anew()
        for goal in goals:
            winner, *_, start = table.filter(pl.col("goal") == goal).to_dicts()
            gain, luck = self.gain(goal), self.luck(goal)
            words = f"{goal}: {setting} has {_text(winner)} in the mean of {winner['replicates']} replicates anew"
            if gain is None or luck is None:
                lines.append(f"{words}; the model {AS_IS} has {_text(start)}")
                continue
            promised = f"{winner['in the search']:.4g} in the search, so {luck:+.3g} of that was luck"
            ends = [winner["low"], winner["high"], start["low"], start["high"]]
            differ = None not in ends and (ends[0] > ends[3] or ends[1] < ends[2])
            lines.append(f"{words} ({promised if luck > 0 else 'as in the search'}); the model {AS_IS} has"
                         f" {_text(start)}: better by {gain:+.3g}"
                         f"{'' if differ else ', which these replicates do not tell apart'}")  # fmt: skip
        scores = scored(self.sample)
        even = []
        for goal, sign in goals.items():
            values = scores[goal].filter(scores[goal].is_finite()).to_numpy()
            best = sign * (sign * values).max(initial=-math.inf)
            what = f"{best:.4g} at best, {np.median(values):.4g} in the median" if values.size else "has no value"
            even.append(f"{goal} {what}")
        return [*lines, f"of {len(self.even)} settings that fill the box evenly: {'; '.join(even)}"]

    def described(self) -> dict[str, Any]:
        """Return what ``fit.json`` holds.

        Returns
        -------
        dict
            The sentences, the winner, the share of the box or the gain, luck and importances.
        """
        study, claims = self.fit.study, self.fit.of_claims
        low, high = (self.share.interval or (None, None)) if claims else (None, None)
        goals = {goal: "minimise" if sign < 0 else "maximise" for goal, sign in self.fit.goals.items()}
        own: dict[str, Any] = {
            "word": self.word, "claims": self.names, "pairs": self.pairs().to_dicts(), "luck": self.luck(),
            "share": {"kept": self.share.holds, "of": len(self.even), "low": low, "high": high},
        } if claims else {
            "goals": goals, "gain": {goal: self.gain(goal) for goal in goals},
            "luck": {goal: self.luck(goal) for goal in goals},
            "front": front([worth(row, self.fit) for row in scored(self.searched).to_dicts()])
            if len(goals) > 1 else [],
        }  # fmt: skip
        first = TOGETHER if claims else next(iter(goals))
        return {
            "fit": study.name, "summary": study.summary, "sentences": self.sentences(), "seed": self.seed,
            "winner": dict(self.winner), "looks": self.looks, **own,
            "importance": {name or first: shares for name, shares in self.importance.items()},
            "failures": self.failures,
        }  # fmt: skip


def _replicates(results: pl.DataFrame, setting: int, name: str) -> GroupBy:
    """Group the results of a setting, of one claim or measure where it is named, by replicate."""
    own = results.filter(pl.col("setting") == setting, pl.col("name") == name if name else pl.lit(True))
    return own.group_by("replicate", maintain_order=True)


def in_words(setting: Setting) -> str:
    """Return a setting in words."""
    return ", ".join(f"{key}={value}" for key, value in setting.items())


def word(counted: Count) -> str:
    """Return the word of a count, where a claim that holds is ``fitted``: its parameters were chosen to keep it."""
    return "fitted" if counted.word == "holds" else counted.label


def _mean(values: Sequence[float], *, whole: bool = False) -> float | None:
    """Return the mean of the known values, or of all if each is to be known; ``None`` where there is none."""
    known = [value for value in values if math.isfinite(value)]
    return float(np.mean(known)) if known and not (whole and len(known) < len(values)) else None


def _text(row: Mapping[str, Any]) -> str:
    if row["anew"] is None:
        return "no value"
    same = row["low"] is None or row["low"] == row["high"]
    return f"{row['anew']:.4g}" + ("" if same else f" [{row['low']:.4g}, {row['high']:.4g}]")


# Running it.


def typed(
    experiments: str, over: tuple[str, ...], claims: tuple[str, ...], model: str, assignments: tuple[str, ...],
    maximise: tuple[str, ...], minimise: tuple[str, ...], replicates: int, numbers: Mapping[str, Any],
) -> Fit:  # fmt: skip
    """Return the fit of experiments, joined by commas, that is no file's; ``numbers`` are further fields of `Fit`."""
    names = tuple(filter(None, experiments.split(",")))
    called = "-".join(name if name in BOARD_NAMES else registry.find(name).name for name in names)
    goals = ", ".join((*maximise, *minimise))
    study = Study(
        f"fit-{called}", f"parameters for {goals}" if goals else "parameters that keep claims", claims=claims,
        experiments=names, models=(model,), assignments=assignments, repeats=None, replicates=replicates,
        every_trial=False,
    )  # fmt: skip
    return Fit(study, over, maximise=maximise or (() if minimise else (SLACK,)), minimise=minimise, **numbers)


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
        known = BOARD_NAMES[fit.board]
        if wrong := next((goal for goal in fit.goals if goal not in known), ""):
            raise UsageError(f"--maximise {wrong}: {fit.board} has no such number; it has {', '.join(known)}")
        ends = any(apart(key)[1] for part in box for key in keys_of(part.key))
        if outside or ends or fit.study.assignments or fit.search_repeats is not None:
            raise UsageError(f"{fit.board}: only whole parameters of the model are free, without --set and --repeats")
    elif not names:
        raise UsageError("--claims: a fit without experiments needs some, for example C13,C15")
    else:
        middle = settings_axis([setting_at(box, [0.5] * len(box))])
        plan = sweep_plan.planned(replace(study_of(fit), axes=(middle,)), seed)
        measures = [measure.name for measure, _ in plan.measures]
        if fit.of_claims and not plan.claims:
            raise UsageError(f"{', '.join(names)}: no claim there can be fitted to")
        if wrong := next((goal for goal in fit.goals if not fit.of_claims and goal not in measures), ""):
            raise UsageError(f"--maximise {wrong}: not measured there; measured are {', '.join(measures)}")
        declared = {experiment.name: experiment.repeats for experiment in experiments}
        for claim, name in plan.claims if plan.things == "trials" else ():
            fewest = min(min(plan.repeats), fit.study.repeats or declared[name])  # of the search, and of the judging
            if fewest < claim.least:
                raise UsageError(f"{claim.id} needs at least {claim.least} trials of each condition, and there are"
                                 f" {fewest} in the search or in {name}")  # fmt: skip
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
    fit, failures = plan.fit, list[Failure]()
    _begin(plan, out, resources)
    play = Player(fit, out, resources, failures)
    search = Search(plan.box, plan.seed, plan.renderings, plan.share, fit)
    settings: list[Setting] = []
    batches: list[pl.DataFrame] = []
    sums: list[pl.DataFrame] = []
    with resources.pool() as pool:
        for number in range(plan.batches):
            asked = search.ask()
            results = play(f"search-{number:04d}", asked, plan.seed, fit.study.replicates, pool)
            batches.append(results.with_columns(pl.col("setting") + len(settings)))
            sums.append(scored(batches[-1]))
            search.tell(sums[-1])
            settings += asked
            if not resources.quiet:
                error_console.print(_best_so_far(pl.concat(sums), fit), soft_wrap=True, markup=False)
        searched, scores = pl.concat(batches), pl.concat(sums)
        best = _best(scores, settings, fit)
        again: list[Setting] = [settings[place] for place in best] + ([] if fit.of_claims else [{}])
        anew = play(f"held-out-{len(settings)}", again, plan.seed + TEST, fit.held_out, pool, anew=True)
        even = spread(plan.box, fit.sample, plan.seed)
        sample = play(f"sample-{fit.sample}", even, plan.seed + SAMPLE, fit.study.replicates, pool)
    looks = len({folder.name.split("-")[2] for folder in out.glob("held-out-*") if begun(folder)})
    shares = {name: search.importance(name) for name in ("", *names_of(scores.columns))}
    fitted = Fitted(fit, plan.box, plan.seed, tuple(settings), searched, tuple(best), anew, tuple(even), sample, looks,
                    shares, tuple(failures))  # fmt: skip
    write(fitted, out)
    return fitted


def write(fitted: Fitted, folder: Path) -> None:
    """Write ``fit.csv``, ``anew.csv``, ``fit.json``, ``fit.svg`` and ``fit.png``."""
    from experiments.bench.report import fit as report  # not before: workers do without matplotlib
    from experiments.bench.report import style

    files = Files(folder)
    files.write_rows("fit.csv", fitted.table().to_dicts())
    files.write_rows("anew.csv", fitted.judged_anew().to_dicts())
    files.write_json("fit.json", fitted.described())
    style.save(report.draw(fitted), folder / "fit", drawn_from(tables_of(folder)))


def _begin(plan: FitPlan, out: Path, resources: Resources) -> None:
    """Make the folder, or hold it against this fit; its batches say themselves what computes."""
    import optuna

    fit = plan.fit
    description: dict[str, Any] = {
        KIND: "fit", "experiment": "fit", "over": [str(part) for part in plan.box],
        "box": [asdict(part) for part in plan.box], "share": fit.share, "seed": plan.seed,
        "replicates per setting": fit.study.replicates, "held_out": fit.held_out, "sampler": fit.sampler,
        "optuna": str(optuna.__version__), "study": fit.study.name, "versions": provenance.versions(),
        **({} if fit.search_repeats is None else {"repeats of the search": fit.search_repeats}),
        **({} if fit.maximise == (SLACK,) else {"maximise": fit.maximise, "minimise": fit.minimise}),
    }  # fmt: skip
    out.mkdir(parents=True, exist_ok=True)
    if begun(out):
        reconciled(out, description, resources.other_code)
    else:
        write_new(out, description)


def rank(fit: Fit) -> Callable[[Mapping[str, Any]], tuple[float, ...]]:
    """Return the key that rows of `scored` are sorted by: of claims whether all hold, the goal, and the mean slack."""

    def key(row: Mapping[str, Any]) -> tuple[float, ...]:
        (value, *_) = worth(row, fit)
        if not fit.of_claims:
            return (value if math.isfinite(value) else -math.inf,)
        return float(row["kept"] == len(names_of(row))), value, row["mean"]

    return key


def _best(scores: pl.DataFrame, settings: Sequence[Setting], fit: Fit) -> list[int]:
    """Return the places of the settings to judge anew: the winner and the next best, or the front of several goals."""
    rows = scores.to_dicts()
    if len(fit.goals) > 1:
        return front([worth(row, fit) for row in rows])[: NEXT_BEST + 1]
    key = rank(fit)
    first: dict[tuple[tuple[str, str], ...], int] = {}  # a box of names alone has settings twice
    for place in sorted(range(len(rows)), key=lambda place: key(rows[place]), reverse=True):
        first.setdefault(tuple(settings[place].items()), place)
    return list(first.values())[: NEXT_BEST + 1]


def _best_so_far(scores: pl.DataFrame, fit: Fit) -> str:
    rows = scores.to_dicts()
    best = max(rows, key=rank(fit))
    of = f"best of {len(rows)} settings: "
    if fit.of_claims:
        return (f"{of}{best['kept']} of {len(names_of(best))} claims kept, least slack {best['least']:+.3g} smallest"
                " differences")  # fmt: skip
    return of + ", ".join(f"{goal} {best[goal]:.4g}" for goal in fit.goals)

"""Fits: a search for parameters under which claims hold together, judged on fresh seeds.

Each batch of settings is a sweep of one axis, and resumes as any other.
"""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from experiments.base.errors import UsageError
from experiments.base.files import Files
from experiments.base.streams import stream
from experiments.declare.outcome import together
from experiments.declare.study import TOGETHER, Fit, Study
from experiments.draw import fit as report, style
from experiments.judge.sweep import MOST_SLACK, slack
from experiments.judge.verdict import Count, count
from experiments.kinds import registry, sweep, sweep_plan
from experiments.kinds.result import Kind, load
from experiments.settings.grid import apart, take
from experiments.settings.models import look_up
from experiments.settings.settings import by_section, check_counts, schema_of
from experiments.store.asked import Asked
from experiments.store.folder import begin_whole, begun
from experiments.store.plan import Plan
from experiments.store.workers import Workers

Setting = Mapping[str, str]
"""Key of each range of the box -> its value as ``--set`` takes it."""
Ranges = Mapping[str, Any]
"""Key of each free parameter, as ``--over`` has it -> Optuna's distribution of its values."""
PAIR = 2
"""Settings of the renderings in a batch, where both they and the network are searched."""
NEXT_BEST = 10
"""Settings that are judged again with the winner."""
TEST, SAMPLE = 1_000_000, 2_000_000
"""Added to the seed of the search for the second judging and for the sample."""
LOG_FROM = 100.0
"""Ratio of the ends of a range from which it is searched by its logarithm."""
LEAST, MEAN = "least slack", "mean slack"
RESULTS = pl.Schema(
    {"setting": pl.Int64, "name": pl.String, "replicate": pl.Int64, "verdict": pl.String, "value": pl.Float64,
     "random": pl.Boolean}
)  # fmt: skip
"""Columns of the results of settings: ``value`` is the slack of a claim, ``random`` whether its replicates differ."""


# The box.


def box_of(fit: Fit) -> tuple[Ranges, list[str]]:
    """Return the box of a fit, and those of its keys that change what is rendered.

    Raises
    ------
    UsageError
        A text of ``over`` is not ``KEY=A..B`` or ``KEY=V1,V2``, or its key is unknown, there twice or settled.
    """
    models = look_up(fit.study.models)
    sections: dict[str, Any] = {model.section: model.network for model in models}
    networks = set(sections)
    for name in fit.study.experiments or registry.answering_for(fit.study.claims):
        sections |= sweep_plan.sections_of(registry.find(name))
    fixed, taken = {text.partition("=")[0] for text in fit.study.assignments}, set[str]()
    box = {}
    for text in fit.over:
        name, _, ends = text.partition("=")
        take(text, taken, fixed)
        box[name] = _distribution(name.split("+")[0], ends, sections)
    if not box:
        raise UsageError("--over: a fit needs one parameter or more, for example --over dsnn.t_sp=0.05..0.3")
    return box, [name for name in box if name.partition(".")[0] not in {*networks, "processor"}]


def _distribution(key: str, ends: str, sections: Mapping[str, Any]) -> Any:
    """Return Optuna's distribution of the values that ``KEY=A..B`` or ``KEY=V1,V2`` allows."""
    from optuna import distributions as kinds

    parameter, end = apart(key)
    by_section({parameter: ends}, sections, "--over")  # the key is known
    section, _, name = parameter.partition(".")
    schema = schema_of(sections[section], name)
    if end and schema.get("type") == "array":
        schema = (schema.get("prefixItems") or [schema["items"]])[0]
    low, dots, high = ends.partition("..")
    if not dots and ends:
        return kinds.CategoricalDistribution(ends.split(","))
    try:
        least, most = float(low), float(high)
    except ValueError:
        least = most = math.nan
    if not -math.inf < least < most < math.inf:
        raise UsageError(f"--over {key}={ends}: expected KEY=A..B, the lower number first, or KEY=V1,V2")
    log = least > 0.0 and most / least >= LOG_FROM
    if schema.get("type") == "integer":
        return kinds.IntDistribution(int(least), int(most), log=log)
    return kinds.FloatDistribution(least, most, log=log)


def text_of(value: Any) -> str:
    """Return a value as ``--set`` takes it, a number to six digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def at(kind: Any, share: float) -> str:
    """Return the value below which a share of a distribution lies, 0 up to below 1; whole numbers have equal shares."""
    if hasattr(kind, "choices"):
        return str(kind.choices[int(share * len(kind.choices))])
    whole = isinstance(kind.low, int)
    if kind.log:
        value = math.exp(math.log(kind.low) + share * math.log(kind.high / kind.low))
        return text_of(round(value) if whole else value)
    if whole:
        return str(kind.low + int(share * (kind.high - kind.low + 1)))
    return text_of(kind.low + share * (kind.high - kind.low))


def spread(box: Ranges, number: int, seed: int) -> list[Setting]:
    """Return settings that fill a box evenly: the first points of a scrambled Sobol sequence.

    References
    ----------
    Owen 1998, Scrambling Sobol' and Niederreiter-Xing points.
    """
    from scipy.stats import qmc

    sequence = qmc.Sobol(len(box), scramble=True, rng=stream("fit.sample", seed))
    points = np.minimum(sequence.random_base2((number - 1).bit_length())[:number], np.nextafter(1.0, 0.0))
    return [{key: at(kind, share) for (key, kind), share in zip(box.items(), point, strict=True)} for point in points]


# The search: Optuna asks for settings batch by batch.


def ask_for(
    search: Any, box: Ranges, outside: Sequence[str], size: tuple[int, int], seed: int, number: int
) -> list[Any]:
    """Return Optuna's trials of a batch: so many renderings, each with so many networks, one after another.

    The sampler is made again for each batch, seeded by the seed of the fit and the batch's number. So equal seeds give
    equal settings, whatever plays them; and a fit that was cut short asks again for what it had, and finds it played.
    """
    from optuna.samplers import TPESampler

    state = int(np.random.SeedSequence(seed, spawn_key=(number,)).generate_state(1)[0])
    search.sampler = TPESampler(seed=state, constant_liar=True)
    asked: list[Any] = []
    renderings, share = size
    for place in range(renderings * share):
        if outside and place % share:
            search.enqueue_trial({key: asked[-1].params[key] for key in outside})
        asked.append(search.ask(dict(box)))
    return asked


def importance(search: Any) -> dict[str, float]:
    """Return the share of each parameter in whether the goal is among the best tenth; empty where all came to the same.

    References
    ----------
    Watanabe, Bansal and Hutter 2023, PED-ANOVA.
    """
    from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances

    if len({trial.value for trial in search.get_trials(deepcopy=False)}) < 2:
        return {}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "PedAnova.*low `target`", UserWarning)
        return dict(get_param_importances(search, evaluator=PedAnovaImportanceEvaluator()))


# Results of settings.


def study_of(fit: Fit, settings: Sequence[Setting]) -> Study:
    """Return the study whose points are settings, by their numbers."""
    texts = [tuple(f"{key}={value}" for name, value in setting.items() for key in name.split("+"))
             for setting in settings]  # fmt: skip
    return replace(fit.study, axes={"setting": {str(number): level for number, level in enumerate(texts)}})


def scored(results: pl.DataFrame) -> pl.DataFrame:
    """Sum up the results of settings over their replicates.

    Returns
    -------
    polars.DataFrame
        A row for each setting: how many of its ``claims`` are ``satisfied``, holding in every replicate; the least
        slack of all and of each, and the mean slack.
    """
    value, claim = pl.col("value"), pl.col("name")
    names = results["name"].unique(maintain_order=True)
    return results.group_by("setting", maintain_order=True).agg(
        (claim.n_unique() - claim.filter(pl.col("verdict") != "holds").n_unique()).alias("satisfied"),
        claim.n_unique().alias("claims"),
        value.min().alias(LEAST),
        *(value.filter(claim == name).min().alias(f"slack {name}") for name in names),
        value.mean().alias(MEAN),
    )


def with_all(results: pl.DataFrame) -> pl.DataFrame:
    """Put those of all claims together, called ``all``, before the results of several: the least slack, the verdict."""
    if results["name"].n_unique() < 2:
        return results
    whole = [
        (setting, TOGETHER, replicate, together(rows["verdict"].to_list()), rows["value"].min(), rows["random"].any())
        for (setting, replicate), rows in results.group_by("setting", "replicate", maintain_order=True)
    ]
    return pl.concat([pl.DataFrame(whole, RESULTS, orient="row"), results])


def again_table(settings: Sequence[Setting], best: Sequence[int], searched: pl.DataFrame, anew: pl.DataFrame) -> Any:
    """Return the rows of ``anew.csv``: each setting of ``best`` with each claim.

    ``low`` and ``high`` are the ends of the 95 % interval of the share of replicates that satisfy a claim.
    """
    rows: list[dict[str, Any]] = []
    searched, anew = with_all(searched), with_all(anew).sort("setting", maintain_order=True)
    for (place, name), own in anew.group_by("setting", "name", maintain_order=True):
        number, random = best[int(place)], own["random"][0]
        counted = count(own["verdict"] if random else own["verdict"][:1], random=random)
        low, high = counted.interval or (None, None)
        rows.append({
            "number": number, **settings[number], "name": name,
            "in the search": searched.filter(setting=number, name=name)["value"].mean(), "anew": own["value"].mean(),
            "replicates": counted.replicates, "satisfied": counted.holds,
            "word": "fitted" if counted.word == "holds" else counted.label,  # its parameters were chosen to satisfy it
            "low": low, "high": high,
        })  # fmt: skip
    return pl.DataFrame(rows, infer_schema_length=None)


# Running it.


def plan(asked: Asked) -> Plan[Any]:
    """Return the plan of a fit, checked with the corners of its box. Its settings are asked for as it goes.

    Parameters
    ----------
    asked
        What was asked for: a fit, or experiments. Its options are ``over``, the box as ``KEY=A..B`` texts; ``claims``
        and ``replicates``; and ``trials``, ``share``, ``sample``, ``held_out`` and ``search_repeats``, as of
        `experiments.Fit`.

    Raises
    ------
    UsageError
        An argument is invalid.
    ImportError
        Optuna is not installed.
    """
    fit = fit_of(asked)
    check_counts(asked.seed, fit.held_out, "--held-out")
    box, outside = box_of(fit)
    corners = [{key: at(kind, share) for key, kind in box.items()} for share in (0.0, np.nextafter(1.0, 0.0))]
    swept = sweep_plan.sweep_of(study_of(fit, corners), asked.seed, repeats=fit.search_repeats)
    if not swept.claims:
        raise UsageError(f"{', '.join(swept.experiments)}: no claim there can be fitted to")
    import optuna

    resolved = {"study": fit.study.name, "seed": asked.seed, "over": fit.over, "optuna": optuna.__version__}
    return Plan(asked, fit.study.name, resolved=resolved, declared=Search(fit, box, outside))


def fit_of(asked: Asked) -> Fit:
    """Return the fit that was asked for: as it was given, or experiments with a box."""
    numbers = {name: asked.option(name) for name in ("trials", "share", "sample", "held_out", "search_repeats")}
    given = {name: value for name, value in numbers.items() if value is not None}
    if asked.declared is not None:
        declared: Fit = asked.declared
        return replace(declared, **given)
    if not asked.what:
        raise UsageError("a script gave it a fit of its own: run the script")
    name = f"fit-{'-'.join(Path(one).stem for one in asked.what)}"
    study = registry.typed(
        ",".join(asked.what), name=name, claims=asked.option("claims"), models=asked.models or None,
        assignments=asked.values, replicates=asked.option("replicates"),
    )  # fmt: skip
    return Fit(study, tuple(asked.option("over", ())), **given)


@dataclass(frozen=True)
class Search:
    """A checked fit: its box, and those of the box's keys that change what is rendered."""

    fit: Fit
    box: Ranges
    outside: Sequence[str]

    @property
    def size(self) -> tuple[int, int]:
        """How many renderings a batch has, and settings of the network that share each."""
        whole = PAIR * self.fit.share
        renderings = 1 if not self.outside else whole if len(self.outside) == len(self.box) else PAIR
        return renderings, whole // renderings


def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
    """Search, judge the best again, sample the box, and write tables and figure; a search may go on for longer.

    Raises
    ------
    UsageError
        There is another run.
    """
    import optuna

    fit, box, seed = plan.declared.fit, plan.declared.box, plan.asked.seed
    begin_whole(out, plan.document())
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    search: Any = optuna.create_study(direction="maximize")

    def play(name: str, shown: Sequence[Setting], seed: int, replicates: int, *, again: bool = False) -> pl.DataFrame:
        study = replace(study_of(fit, shown), name=name, replicates=replicates)
        asked = Asked(kind="sweep", declared=study, seed=seed, repeats=None if again else fit.search_repeats)
        result = sweep.played(sweep.plan(asked), out / name, pool)
        rows = [
            (int(point[0][1]), claim, number, one.verdict, slack(one), result.is_random(point, claim))
            for (point, _, claim), outcomes in result.outcomes.items()
            for number, one in enumerate(outcomes)
        ]
        silence = pl.col("value").fill_null(-MOST_SLACK)  # it gains nothing
        return pl.DataFrame(rows, RESULTS, orient="row").with_columns(silence)

    settings, searched = _searched(plan, search, play)
    found = _scores("search", settings, searched)
    # The winner and the next best: first where all claims are satisfied, then by the slack.
    ranked = found.sort(pl.col("satisfied") == pl.col("claims"), LEAST, MEAN, descending=True, maintain_order=True)
    best = ranked["number"].head(NEXT_BEST + 1).to_list()
    shown = [settings[place] for place in best]
    anew = play(f"held-out-{len(settings)}", shown, seed + TEST, fit.held_out, again=True)
    even = spread(box, fit.sample, seed)
    filled = _scores("sample", even, play(f"sample-{fit.sample}", even, seed + SAMPLE, fit.study.replicates))
    rows = again_table(settings, best, searched, anew)
    files = Files(out)
    files.write_rows("fit.csv", pl.concat([found, filled]).to_dicts())
    files.write_rows("anew.csv", rows.to_dicts())
    looks = len([folder for folder in out.glob("held-out-*") if begun(folder)])
    result = _result(settings[best[0]], rows, found.row(best[0], named=True), filled, looks,
                     random=bool(anew.filter(setting=0)["random"].any()))  # fmt: skip
    files.write_json("fit.json", {
        "fit": fit.study.name, "summary": fit.study.summary, **result, "importance": importance(search),
    })  # fmt: skip
    style.save(report.draw(load(out)), out / "fit")


def _searched(plan: Plan[Any], search: Any, play: Callable[..., pl.DataFrame]) -> tuple[list[Setting], pl.DataFrame]:
    """Search batch by batch; return all settings, and their results."""
    fit, box, (renderings, share) = plan.declared.fit, plan.declared.box, plan.declared.size
    settings: list[Setting] = []
    results = pl.DataFrame(schema=RESULTS)
    for number in range(-(-fit.trials // (renderings * share))):
        batch = ask_for(search, box, plan.declared.outside, (renderings, share), plan.asked.seed, number)
        shown = [{key: text_of(trial.params[key]) for key in box} for trial in batch]
        found = play(f"search-{number:04d}", shown, plan.asked.seed, fit.study.replicates)
        for trial, value in zip(batch, scored(found)[LEAST], strict=True):
            search.tell(trial, value)
        results = pl.concat([results, found.with_columns(pl.col("setting") + len(settings))])
        settings += shown
    return settings, results


def _scores(of: str, settings: Sequence[Setting], results: pl.DataFrame) -> pl.DataFrame:
    """Return a row for each setting: of what it is one, its number, its values and its scores."""
    own = pl.DataFrame({"of": [of] * len(settings), "number": range(len(settings))})
    return pl.concat([own, pl.DataFrame(settings), scored(results).drop("setting")], how="horizontal")


def _result(
    winner: Setting, rows: pl.DataFrame, own: Mapping[str, Any], filled: pl.DataFrame, looks: int, *, random: bool
) -> dict[str, Any]:
    """Return what ``fit.json`` says of the winner, judged again, and of the even sample."""
    first = rows.row(0, named=True)
    counted = Count(first["satisfied"], first["replicates"] - first["satisfied"], random=random)
    satisfied = filled.filter(pl.col("satisfied") == pl.col("claims")).height
    share, luck = Count(satisfied, filled.height - satisfied), first["in the search"] - first["anew"]
    few = counted.state == "counted" and not counted.fails
    word = "no word" if few else "fitted" if counted.word == "holds" else "not fitted"
    word = word if own["satisfied"] == own["claims"] else "not fitted"
    low, high = share.interval or (0.0, 1.0)
    named = ", ".join(f"{key}={value}" for key, value in winner.items())
    found = f"{word}: {named} satisfies {own['satisfied']} of {own['claims']} claims in the search"
    lines = [
        f"{found}; all of them on fresh seeds: {counted.sentence()}",
        f"{share} settings spread evenly satisfy every claim: 95 % interval {low:.3g} to {high:.3g} of the box",
        f"luck of the search: {luck:.4g}; looks at its fresh seeds: {looks}",
    ]
    return {"sentences": lines, "winner": winner, "word": word,
            "share": {"satisfied": share.holds, "of": share.replicates, "low": low, "high": high}, "luck": luck,
            "looks": looks}  # fmt: skip


KIND = Kind(plan, work, report.draw, report.show, summary="fit.csv", whole=True)

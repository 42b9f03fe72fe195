"""Claims of the paper's off-line tests, as checks on the rows of clips.

A claim is judged on the clips that its words are about, at one seed. It never bends a bound: a claim that misses it
fails, and the verdict says by how much.

A claim's least number is every combination of `CONDITIONS`, each once: the same clip gives the same answer, so a
repeat adds nothing. Where there is a background, a seed is one scene, as the paper shows one; in how many scenes it
holds is reported beside the verdict.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

from experiments.bench.clips.judging import DSNN, EVERY, SHADES, SIGNED, Row, Rows
from experiments.bench.run.errors import short
from experiments.bench.run.models import NO_SPIKES
from experiments.bench.stats import claims as shipped
from experiments.bench.stats.claim import Claim
from experiments.bench.stats.numbers import is_number, unreadable
from experiments.bench.stats.verdict import Outcome
from scenes.hints import nearest

POTENTIALS = ("peak_hs", "trough_hs", "peak_vs", "trough_vs")
HARDLY = 0.5
"""Px a frame below which a background hardly moves: it takes two frames and more to pass a pixel."""


@dataclass(frozen=True, kw_only=True)
class ClipClaim(Claim):
    """A claim about clips that models were shown.

    An off-line experiment declares it in ``claims=``, beside ids of the paper's. It is judged at each seed.

    Parameters
    ----------
    id
        Its name in tables: up to 60 letters, digits, ``.``, ``-`` and ``_``. The paper's ids are taken.
    judge
        From the rows of one seed's ``trials.parquet``, those of the clips and models that the claim is about, and a
        spiking threshold, to an `Outcome`. The threshold is the DSNN's; of a claim that does not take the DSNN it is
        that of its first model by name. Where the judge raises, the claim is not judged.
    says, source
        Its words, and where they are from.
    silent_passes
        Whether a model that never answers would keep it; it is not judged for one that answers no translation.
    models
        The labels of the models that it takes; without one of them it is not judged. Left out: the DSNN alone, so a
        claim about another model has to name it.
    conditions
        Column -> the values of clips that its words name; other clips do not count. Every combination is needed.
        Without any, all clips count.
    of_every_clip
        Whether it is about every single clip: then one that breaks it refutes it, whichever others are missing.
    of_potentials
        Whether it is about potentials alone: then a model without a spiking threshold is judged too, by one of 0.
    alone
        The condition that clips without an object have to meet, where it is about such clips too.
    least_greys
        How many grey levels of the object it needs.
    of_dsnn
        What it says of the DSNN alone, where the rest is about a model whose constants are not known.
    settled
        Whether the constants of the models that it compares with count as known: those that are shown.
    title, cause, eye, tried, mechanism, implied, equal_terms
        What is told of it beside its words, as of an `experiments.Claim`. The row of a clip is the whole clip: a judge
        gets no time course.

    Raises
    ------
    ValueError
        It has no words or no judge, its id is taken, or a value is not legal.

    Examples
    --------
    >>> from experiments import Check, ClipClaim, Outcome
    >>> def silent(rows, threshold):
    ...     worst = max(max(row["peak_hs"], -row["trough_hs"]) for row in rows)
    ...     return Outcome.of([Check(f"|HS| up to {worst:.2f}", worst, threshold, "below")])
    >>> claim = ClipClaim(id="depth-is-silent", says="HS stays below T", judge=silent,
    ...                   conditions={"motion": ("looming", "receding")})
    """

    judge: Callable[[Rows, float], Outcome]
    models: frozenset[str] = frozenset({DSNN})
    conditions: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    of_every_clip: bool = False
    of_potentials: bool = False
    alone: str = ""
    least_greys: int = 0
    of_dsnn: str = ""
    settled: bool = False

    def __post_init__(self) -> None:
        Claim.__post_init__(self)
        if isinstance(self.models, str) or not self.models or not all(isinstance(label, str) for label in self.models):
            raise ValueError(f"claim {self.id}: models={short(self.models)}: legal is a set of labels, one or more")
        object.__setattr__(self, "models", frozenset(self.models))
        table = self.conditions
        if not isinstance(table, Mapping) or not all(isinstance(values, tuple) for values in table.values()):
            legal = "legal is a mapping of columns to tuples of values"
            raise ValueError(f"claim {self.id}: conditions={short(table)}: {legal}")

    @property
    def spiking(self) -> str:
        """The model whose spiking threshold the judge gets."""
        return DSNN if DSNN in self.models else min(self.models)


def paper_claims() -> Mapping[str, ClipClaim]:
    """Return the paper's claims that clips answer for, by id."""
    return shipped.of_kind(ClipClaim)


def find(claim: Claim | str) -> ClipClaim:
    """Return a claim by its id; ``KeyError`` if clips do not answer for it."""
    return shipped.find(claim, ClipClaim)


def judge(
    claim: ClipClaim | str, rows: Rows, thresholds: Mapping[str, float | None], all_rows: Rows | None = None
) -> Outcome:
    """Judge one claim on the rows of one seed.

    Parameters
    ----------
    claim
        The claim, or its id.
    rows
        Rows of ``trials.parquet``, of all models.
    thresholds
        Each model's spiking threshold.
    all_rows
        Rows of other clips and seeds too, where there are more than ``rows``. A claim that a silent network would
        keep is held against the translations among them.
    """
    asked = find(claim)
    outcome = _judged(asked, rows, thresholds)
    threshold = thresholds.get(asked.spiking)
    if asked.silent_passes and threshold is not None:
        outcome = outcome.against_silence(_answers(asked, rows if all_rows is None else all_rows, threshold), "clip")
    again = asked.on_equal_terms(rows)
    if not again:
        return outcome
    equal = judge(replace(asked, settled=True, equal_terms={}), again, thresholds, all_rows)
    return replace(outcome, equal=equal)


def _answers(claim: ClipClaim, all_rows: Rows, threshold: float) -> dict[str, list[bool]]:
    """Return whether a model answers each crossing that the paper has it answer; without any, each translation.

    See `ANSWERED`. An answer is a potential past T in the direction of the motion.
    """
    across = [row for row in all_rows
              if row["model"] == claim.spiking and row["motion"] in SIGNED and row["object"] != "absent"]  # fmt: skip
    kinds = {name: [row for row in across if is_of(row)] for name, is_of in ANSWERED.items()}
    named = kinds if any(kinds.values()) else {"translation": across}
    return {name: [_reached(row) > threshold for row in rows] for name, rows in named.items()}


def _reached(row: Row) -> float:
    """Return how far the potential of a translation's direction goes to its side; 0 where it is no number."""
    name, sign = SIGNED[row["motion"]]
    return sign * float(row[name]) if is_number(row[name]) else 0.0


def _at_paper_speed(row: Row) -> bool:
    return bool(row["speed"] == PAPER_SPEED and row["speed_unit"] == "px/s")


def _plain(row: Row) -> bool:
    return row["stimulus"] == "plain" and _at_paper_speed(row)


def _cluttered(row: Row) -> bool:
    extreme = row["grey"] in (0.0, 255.0) and row["background_speed"] == -8.0 and row["motion"] == "rightward"
    return row["stimulus"] == "cluttered" and extreme and _at_paper_speed(row)


PAPER_SPEED = 120.0
"""Of the crossings that the paper has HS or VS answer past T, px/s."""
ANSWERED: Mapping[str, Callable[[Row], bool]] = {
    f"a plain object at {PAPER_SPEED:g} px/s": _plain,
    f"a dark or light object at {PAPER_SPEED:g} px/s before -8 px/s": _cluttered,
}
"""The crossings that a model has to answer so as not to count as silent: those of C1 and C6."""


def _judged(asked: ClipClaim, rows: Rows, thresholds: Mapping[str, float | None]) -> Outcome:
    missing = sorted(asked.models - {row["model"] for row in rows})
    if missing:
        return Outcome.unjudged(f"needs {' and '.join(missing)}")
    threshold = thresholds[asked.spiking]
    if threshold is None and not asked.of_potentials:
        return Outcome.unjudged(NO_SPIKES)
    unknown = [name for name in asked.conditions if name not in ("shade", *rows[0])]
    if unknown:
        hint = nearest(unknown[0], rows[0], "; ")
        return Outcome.unjudged(f"clips have no column {unknown[0]}{hint}", n=len(rows))
    chosen = about(asked, rows)
    without = _unanswered(chosen, asked.models) or unreadable(chosen, POTENTIALS)
    if without:
        return Outcome.unjudged(f"of the clips {without}", n=len(chosen))
    lacking = _lacking(asked, chosen)
    if lacking and not (chosen and asked.of_every_clip):
        return Outcome.unjudged(lacking)
    outcome = asked.ask(chosen, 0.0 if threshold is None else threshold)
    told = replace(
        outcome, measured="; ".join(filter(None, (outcome.measured, "" if asked.own else _shift(asked, chosen))))
    )
    told = told.settled() if asked.settled else told
    return told.withheld(lacking) if lacking and told.verdict in ("holds", "unknown constants") else told


def _shift(claim: ClipClaim, rows: Rows) -> str:
    """Return how fast the background shifts in px a frame, in words; empty for a claim that names no speed of it."""
    if "background_speed" not in claim.conditions:
        return ""
    per_frame = {
        abs(row["background_speed"]) / (row["fps"] if row["speed_unit"] == "px/s" else 1.0)
        for row in rows
        if is_number(row["background_speed"]) and is_number(row["fps"])
    }
    if not per_frame:
        return ""
    least, most = f"{min(per_frame):.2g}", f"{max(per_frame):.2g}"
    reach = least if least == most else f"{least} to {most}"
    return f"the background shifts {reach} px a frame{', hardly moving' if max(per_frame) < HARDLY else ''}"


def about(claim: ClipClaim, rows: Rows) -> list[Row]:
    """Return the rows of the clips and models that a claim's words are about."""
    return [row for row in rows if row["model"] in claim.models and _is_about(claim, row)]


def _is_about(claim: ClipClaim, row: Row) -> bool:
    """Return whether a claim's words are about what a row was shown."""
    if row["object"] == "absent" and not _may_be_alone(claim):
        return bool(claim.alone) and row[claim.alone] in claim.conditions[claim.alone]
    return all(_value(row, name) in values for name, values in claim.conditions.items() if values != EVERY)


def _may_be_alone(claim: ClipClaim) -> bool:
    """Return whether clips of the background alone are like any others to a claim: its conditions choose among them."""
    return claim.own or "object" in claim.conditions


def _value(row: Row, name: str) -> Any:
    """A column's value, or of ``shade`` what the object is against its ground; ``None`` if neither, or unknown."""
    if name != "shade":
        return row[name]
    if not (is_number(row["grey"]) and is_number(row["background_mean"])) or row["grey"] == row["background_mean"]:
        return None
    return SHADES[row["grey"] > row["background_mean"]]


def _unanswered(rows: Rows, models: frozenset[str]) -> str:
    """Clips to which a model has no row, as it failed there, in words; empty if none."""
    clips = list(dict.fromkeys(row["clip"] for row in rows))
    there = {(row["model"], row["clip"]) for row in rows}
    lost = {model: [clip for clip in clips if (model, clip) not in there] for model in sorted(models)}
    return "; ".join(f"{', '.join(names)} has no answer of {model}" for model, names in lost.items() if names)


def _lacking(claim: ClipClaim, rows: Rows) -> str:
    """Return what the claim's words name and no clip shows, in words; empty if all is there."""
    present = [row for row in rows if row["object"] != "absent" or _may_be_alone(claim)]
    wanted = {
        name: values or tuple(sorted({row[name] for row in present if row[name] is not None}))
        for name, values in claim.conditions.items()
    }
    there = {tuple(_value(row, name) for name in wanted) for row in present}
    names = [" ".join(map(_said, wanted, combination)) for combination in product(*wanted.values())
             if combination not in there]  # fmt: skip
    if names or not present:
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        return f"needs clips of {names[0] if names and names[0] else 'an object'}{more}"
    if claim.least_greys and len(wanted["grey"]) < claim.least_greys:
        return f"needs at least {claim.least_greys} grey levels (has {len(wanted['grey'])})"
    if claim.alone and len(present) == len(rows):
        return f"needs clips of the {claim.alone.removesuffix('_speed')} alone"
    return ""


def _said(name: str, value: Any) -> str:
    unit = {"speed": "at {:g} px/s", "background_speed": "before {:g} px/s", "grey": "of grey {:g}"}.get(name)
    return unit.format(value) if unit else str(value)

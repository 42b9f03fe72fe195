"""Claims about clips that models were shown: what such a claim needs, its outcome at one seed, and parts of judges.

A claim is judged on the clips that its words are about, at one seed. It never bends a bound: a claim that misses it
fails, and the verdict says by how much.

A claim needs every combination of its `ClipClaim.conditions` once: the same clip gives the same answer, so a repeat
adds nothing. Where there is a background, a seed is one scene, as the paper shows one; the count of the scenes in which
it holds stands beside the verdict.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from itertools import pairwise, product
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from experiments.bench.run.errors import short
from experiments.bench.run.models import NO_SPIKES
from experiments.bench.stats.checks import Check, Needs, decide, exceeds, is_number, unreadable
from experiments.bench.stats.claim import Claim, find_claim, of_kind
from experiments.bench.stats.verdict import Outcome
from scenes.hints import nearest

if TYPE_CHECKING:
    import polars as pl

Row = Mapping[str, Any]
DSNN, EARLIER, EMD = "dsnn", "dsn2017", "emd"
SIGNED = {
    "rightward": ("peak_hs", 1),
    "leftward": ("trough_hs", -1),
    "downward": ("peak_vs", 1),
    "upward": ("trough_vs", -1),
}
"""Direction -> the extreme that answers it, and its sign."""

SHADES = ("dark", "light")
EVERY = ()
"""Of a column of a claim's conditions: each level that is there."""
LEAST_GREYS = 5
"""Grey levels that the claims about contrast need."""
MOST_OF_DRIVEN, LEAST_OF_OTHER = 0.05, 0.95
"""Of the answer to one edge, what C22 lets either blocked pathway leave: that which it drives, and the other."""

_UNREAD = "are neither in the paper nor in any public text or code that could be searched"
ASSUMED: Mapping[str, str] = {
    "dsn2017": f"the constants of the model of 2017 (Fu and Yue 2017, IJCNN) {_UNREAD}; it is taken to be the DSNN "
    "without FDSR, with the DSNN's constants",
    "emd": f"the constants of Iida's EMD (Iida and Lambrinos 2000; Iida 2003) {_UNREAD}; a high-pass of 250 ms, a "
    "delay of 50 ms and neighbouring pixels are assumed",
}
"""Model -> what is not known of it, and what is assumed.

The paper compares the DSNN with its forerunner of 2017 and with the elementary motion detectors of Iida. It gives the
constants of neither. What is assumed of them decides how such a claim comes out, so that it can neither be refuted nor
borne out by them.
"""
MATCHED: Mapping[str, str] = MappingProxyType({
    "dsn2017": "dsn2017:k_sig=33.22",
    "dsnn:fdsr=false": "dsnn:fdsr=false,k_sig=33.22",
    "dsnn:dog=false": "dsnn:dog=false,k_sig=0.3056",
    "emd": "emd:gain=0.7732",
})  # fmt: skip
"""Label of a model that the DSNN is compared with -> the same on equal terms.

At 30 frames a second FDSR leaves about 1/34 of a rise, so that the DSNN without it has products some 1,180 times as
large for any stimulus whatever, and a comparison of potentials compares gains. So each rival is judged a second time
with one gain, set by one rule, to four digits: its peak HS in the clip ``dark rightward`` of the experiment ``clean``
equals the DSNN's. There nothing is random and no background shifts, and no claim that compares with a rival is about
it. The gain of a model with a sigmoid is that ahead of the sigmoid, its scale K_sig, as what is behind it cannot pass
1; that of the EMD is the gain of its output. Nothing else of a rival is changed.
"""


def answer(row: Row) -> str | None:
    """Return the direction of the strongest potential of either system; ``None`` if two are equal, or all silent."""
    strengths = {direction: sign * row[column] for direction, (column, sign) in SIGNED.items()}
    strongest = max(strengths.values())
    named = [direction for direction, strength in strengths.items() if strength == strongest]
    return named[0] if len(named) == 1 else None


def rows_of(clips: pl.DataFrame, model: str = DSNN, **fixed: Any) -> list[dict[str, Any]]:
    """Return the rows of a model in which columns have the ``fixed`` values, in the table's order."""
    return clips.filter(model=model, **fixed).rows(named=True)


def levels(clips: pl.DataFrame, name: str) -> list[float]:
    """Return the values of a column, each once, from the lowest up."""
    return clips[name].drop_nulls().unique().sort().to_list()


def strongest(row: Row, system: str) -> float:
    """Return the largest absolute potential of ``hs`` or ``vs`` in a clip."""
    return float(max(row[f"peak_{system}"], -row[f"trough_{system}"]))


def passes(row: Row, name: str, sign: float, threshold: float) -> Check:
    """Return the check that a clip's potential goes past T to the side of ``sign``."""
    side: Needs = "above" if sign > 0 else "below"
    return Check(f"{row['clip']}: {name} {row[name]:+.3f}", row[name], sign * threshold, side, scale=threshold)


def inside(row: Row, what: str, value: float, threshold: float) -> Check:
    """Return the check that a potential of a clip stays inside +-T."""
    return Check(f"{row['clip']}: {what} up to {value:.3f}", value, threshold, "at most", scale=threshold)


def rises(clips: pl.DataFrame, threshold: float, what: str) -> list[Check]:
    """Return the checks of more peak HS at each speed than at the next lower one."""
    return [
        exceeds(f"{what}: peak HS {more:.3f} at {fast:g} px/s", more, less, f"at {slow:g}", "potential",
                scale=threshold)
        for (slow, less), (fast, more) in pairwise(clips.sort("speed").select("speed", "peak_hs").rows())
    ]  # fmt: skip


def compared(of_dsnn: Sequence[Check], of_other: Sequence[Check], model: str) -> Outcome:
    """Return the outcome of a claim that says one thing of the DSNN and another of a model of unknown constants.

    Parameters
    ----------
    of_dsnn
        What the claim asks of the DSNN, one check or more.
    of_other
        What it asks of the other model, or of the two held against each other, one check or more.
    model
        The label of the other model, one of `ASSUMED`.

    Returns
    -------
    Outcome
        ``fails`` where the DSNN's half does, whatever the other model does. Otherwise it cannot be judged, whichever
        way the other half comes out with the constants assumed; `Outcome.settled` is the outcome with them.
    """
    whole = Outcome.of([*of_dsnn, *of_other])
    alone, decided = decide(of_dsnn)
    if not alone:
        return Outcome("fails", whole.measured, decided=decided, checks=whole.checks)
    rest, by = decide(of_other)
    why = (
        f"the DSNN's half holds: {decided}; the rest hangs on constants of {model} that are not known, and with those "
        f"assumed {'holds' if rest else 'fails'}: {by}"
    )
    return Outcome("unknown constants", whole.measured, decided=why, checks=whole.checks)


Rows = Sequence[Row]
POTENTIALS = ("peak_hs", "trough_hs", "peak_vs", "trough_vs")


@dataclass(frozen=True, kw_only=True)
class ClipClaim(Claim):
    """A claim about clips that models were shown.

    An off-line experiment declares it in ``claims=``, beside ids of the paper's. It is judged at each seed.

    Parameters
    ----------
    id
        Its name in tables: up to 60 letters, digits, ``.``, ``-`` and ``_``. The paper's ids are taken.
    judge
        From a table of the clips and models that the claim is about and a spiking threshold to its checks. The table is
        a polars ``DataFrame`` with the rows and columns of ``trials.parquet``, of one seed. The threshold is the
        DSNN's; of a claim that does not take the DSNN it is that of its first model by name. Where the judge raises,
        the claim is not judged.
    says, source
        Its words, and where they are from.
    silent_passes
        Whether a model that never responds would satisfy it; it is not judged for one that answers no translation.
    models
        The labels of the models that it takes; without one of them it is not judged. Left out: the DSNN alone, so a
        claim about another model has to name it.
    conditions
        Column -> the values of clips that its words name; other clips do not count. Every combination is needed.
        Without any, all clips count. ``shade`` is no column: it is ``dark`` or ``light``, the clip's ``grey`` against
        its ``background_mean``.
    of_every_clip
        Whether it is about every single clip: then one that breaks it refutes it, whichever others are missing.
    of_potentials
        Whether it is about potentials alone: then a model without a spiking threshold is judged too, by one of 0.
    alone
        The condition that clips without an object have to meet, where it is about such clips too.
    least_greys
        How many grey levels of the object it needs.
    settled
        Whether the constants of the models that it compares with count as known: those that are shown.
    title, cause, eye, tried, mechanism, implied, of_dsnn, equal_terms
        Its other words, and its rivals on equal terms, as of an `experiments.Claim`.

    Raises
    ------
    ValueError
        It has no words, its id is taken, or its models or conditions are a text.

    Examples
    --------
    >>> from experiments import Check, ClipClaim
    >>> def silent(clips, threshold):
    ...     worst = max(clips["peak_hs"].max(), -clips["trough_hs"].min())
    ...     return [Check(f"|HS| up to {worst:.2f}", worst, threshold, "below")]
    >>> claim = ClipClaim(id="depth-is-silent", says="HS stays below T", judge=silent,
    ...                   conditions={"motion": ("looming", "receding")})
    """

    module: ClassVar[str] = "clips"

    judge: Callable[[pl.DataFrame, float], Outcome | Iterable[Check]]
    models: Set[str] = frozenset({DSNN})
    conditions: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    of_every_clip: bool = False
    of_potentials: bool = False
    alone: str = ""
    least_greys: int = 0
    settled: bool = False

    def __post_init__(self) -> None:
        Claim.__post_init__(self)
        if isinstance(self.models, str) or not self.models:
            raise ValueError(f"claim {self.id}: models must be a set of labels, got {short(self.models)}")
        object.__setattr__(self, "models", frozenset(self.models))
        for name, values in self.conditions.items():
            if not isinstance(values, tuple):
                raise ValueError(f"claim {self.id}: conditions['{name}'] must be a tuple, got {short(values)}")

    @property
    def spiking(self) -> str:
        """The model whose spiking threshold the judge receives."""
        return DSNN if DSNN in self.models else min(self.models)


def paper_claims() -> Mapping[str, ClipClaim]:
    """Return the paper's claims that clips answer for, by id."""
    return of_kind(ClipClaim)


def find(claim: Claim | str) -> ClipClaim:
    """Return a claim by its id; ``KeyError`` if clips do not answer for it."""
    return find_claim(claim, ClipClaim)


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
        satisfy is held against the translations among them.
    """
    asked = find(claim)
    outcome = _judged(asked, rows, thresholds)
    threshold = thresholds.get(asked.spiking)
    if asked.silent_passes and threshold is not None:
        outcome = outcome.against_silence(_answers(asked, rows if all_rows is None else all_rows, threshold), "clip")
    again = asked.on_equal_terms(rows)
    if not again:
        return outcome
    return replace(outcome, equal=judge(replace(asked, settled=True, equal_terms={}), again, thresholds, all_rows))


PAPER_SPEED = 120.0
"""Of the crossings that the paper has HS or VS answer past T, px/s."""
PLAIN = f"a plain object at {PAPER_SPEED:g} px/s"
CLUTTERED = f"a dark or light object at {PAPER_SPEED:g} px/s before -8 px/s"
"""The crossings that a model has to answer so as not to count as silent: those of C1 and C6."""


def _answers(claim: ClipClaim, all_rows: Rows, threshold: float) -> dict[str, list[bool]]:
    """Return whether a model answers each crossing that the paper has it answer; without any, each translation.

    An answer is a potential past T in the direction of the motion.
    """
    answers: dict[str, list[bool]] = {}
    for row in all_rows:
        if row["model"] != claim.spiking or row["motion"] not in SIGNED or row["object"] == "absent":
            continue
        column, sign = SIGNED[row["motion"]]
        reached = sign * row[column] if is_number(row[column]) else 0.0
        answers.setdefault(_crossing(row), []).append(reached > threshold)
    named = {name: answered for name, answered in answers.items() if name}
    return named or {"translation": answers.get("", [])}


def _crossing(row: Row) -> str:
    """Which crossing of the paper's a row is of; empty of another translation."""
    if row["speed"] != PAPER_SPEED or row["speed_unit"] != "px/s":
        return ""
    before = row["grey"] in (0.0, 255.0) and row["background_speed"] == -8.0 and row["motion"] == "rightward"
    return {"plain": PLAIN, "cluttered": CLUTTERED if before else ""}.get(row["stimulus"], "")


def _judged(asked: ClipClaim, rows: Rows, thresholds: Mapping[str, float | None]) -> Outcome:
    missing = sorted(asked.models - {row["model"] for row in rows})
    if missing:
        return Outcome.unjudged(f"needs {' and '.join(missing)}")
    threshold = thresholds[asked.spiking]
    if threshold is None and not asked.of_potentials:
        return Outcome.unjudged(NO_SPIKES)
    unknown = [name for name in asked.conditions if name not in ("shade", *rows[0])]
    if unknown:
        return Outcome.unjudged(f"clips have no column {unknown[0]}{nearest(unknown[0], rows[0], '; ')}", n=len(rows))
    chosen = [row for row in rows if row["model"] in asked.models and _is_about(asked, row)]
    without = _unanswered(chosen, asked.models) or unreadable(chosen, POTENTIALS)
    if without:
        return Outcome.unjudged(f"of the clips {without}", n=len(chosen))
    lacking = _lacking(asked, chosen)
    if lacking and not (chosen and asked.of_every_clip):
        return Outcome.unjudged(lacking)
    import polars as pl  # not before: it takes its time to load, and declarations need this file

    outcome = asked.ask(pl.DataFrame(chosen, infer_schema_length=None, strict=False), threshold or 0.0)
    if not asked.own:
        n = sum(row["model"] == asked.spiking for row in chosen)
        outcome = replace(outcome, n=n, fewest=n)
    outcome = outcome.settled() if asked.settled else outcome
    return outcome.withheld(lacking) if lacking and outcome.verdict in ("holds", "unknown constants") else outcome


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


def _unanswered(rows: Rows, models: Set[str]) -> str:
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
    lost = [values for values in product(*wanted.values()) if values not in there]
    if lost or not present:
        first = ", ".join(f"{name} {value}" for name, value in zip(wanted, lost[0], strict=True)) if lost else ""
        return f"needs clips of {first or 'an object'}" + (f", and {len(lost) - 1} more" if len(lost) > 1 else "")
    if claim.least_greys and len(wanted["grey"]) < claim.least_greys:
        return f"needs at least {claim.least_greys} grey levels (has {len(wanted['grey'])})"
    if claim.alone and len(present) == len(rows):
        return f"needs clips of the {claim.alone.removesuffix('_speed')} alone"
    return ""

"""Claims of the paper about the robot, as checks on a run's trials.

The paper's claims are those of `experiments.claims`, a file each; a user's own file may declare others. A judge never
bends a bound: a claim that misses it fails, and the verdict says by how much.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, get_args

from experiments.bench.run.errors import short
from experiments.bench.run.models import NO_SPIKES
from experiments.bench.run.rows import group, is_imported
from experiments.bench.sources.conditions import CONDITION_COLUMNS, Motion
from experiments.bench.sources.judging import ACROSS, DEPTH, DSNN, Rows, paper_trials
from experiments.bench.stats.checks import Check, is_number, unreadable
from experiments.bench.stats.claim import Claim, find_claim, of_kind
from experiments.bench.stats.verdict import Outcome, Verdict
from scenes.hints import nearest

SPEED_TOLERANCE, PATH_TOLERANCE_MM = 0.02, 1.0

EVERY_MOTION = (*ACROSS, *DEPTH)

EACH_TRIAL, MEANS = 5, 4
"""Trials of each condition, below which a claim is not judged.

A claim about every trial takes 5: if half of all trials broke it, five in a row would keep it once in 32 times. A
claim that means of conditions differ takes 4: four against four are the fewest of which a two-sided rank test can
reach p < 0.05 (2 of 70 arrangements).
"""


@dataclass(frozen=True, kw_only=True)
class RobotClaim(Claim):
    """A claim about trials with the robot.

    An experiment declares it in ``claims=``, beside ids of the paper's. It is judged once for each model, or once for
    all the ``models`` that it compares.

    Parameters
    ----------
    id
        Its name in tables: up to 60 letters, digits, ``.``, ``-`` and ``_``. The paper's ids are taken.
    judge
        From a model's rows of ``trials.parquet``, each a mapping by column, and its spiking threshold, to its checks or
        an `Outcome`. A row is a whole trial: a judge gets no time course. A claim that compares models gets the rows of
        all of them, told apart by the column ``model``, and the DSNN's threshold, or without the DSNN that of its
        first model by name. Where it raises, the claim is not judged.
    says, source
        Its words, and where they are from.
    silent_passes
        Whether a model that never answers anything would keep it. It is not judged for a model that answers no
        translation either, as far as the run has any.
    motions
        The motions it is judged on: ``translation``, ``approach``, ``recession``. Flaws of other trials do not touch
        it. Left out, it is judged on every trial, those with a path and a motion's name of their own too.
    reads
        The columns it is judged by. A row without a number in one leaves it unjudged.
    of_every_trial
        Whether it is about every single trial: then one that breaks it refutes it, however few there are.
    least
        Trials of each condition, below which it is not judged; otherwise 5 of a claim of every trial, and 4.
    about
        The kind of model it is about: one that declares a ``direction``, or a ``looming`` detector.
    models
        The labels of the models that it compares; without one of them it is not judged. None: it is about each model
        by itself.
    title, cause, tried
        The claim in a few words; in one line why it fails; what was tried to make it hold, or what limits it.
    eye
        In one line what the robot's own eye and wheels make of it.
    mechanism
        The experiment whose figure shows why it comes out as it does, and what that figure draws.
    implied
        Why the model's equations imply it, whatever it is shown; empty where they do not.
    of_dsnn
        What it says of the DSNN alone, where the rest is about a model whose constants are not known.
    equal_terms
        Label of a model that it compares with -> that of the same model on equal terms. It is judged a second time,
        with these in place of those.
    pools
        The experiments whose trials of a replicate it is judged on together; none: the one that answers for it.

    Raises
    ------
    ValueError
        It has no words or no judge, its id is taken, or a value is not legal.

    Examples
    --------
    >>> from experiments import Check, Claim, Outcome
    >>> def faster(rows, threshold):
    ...     slow, fast = ([row["spikes"] for row in rows if row["speed_cm_s"] == speed] for speed in (4, 6))
    ...     means = [sum(spikes) / len(spikes) for spikes in (slow, fast)]
    ...     return Outcome.of([Check(f"{means[1]:.1f} spikes at 6 cm/s", means[1], means[0], unit="spikes")])
    >>> claim = Claim(id="faster-fires-more", says="more spikes at 6 cm/s than at 4", judge=faster)
    """

    module: ClassVar[str] = "robot"

    judge: Callable[[Rows, float], Outcome | Iterable[Check]]
    motions: tuple[str, ...] = EVERY_MOTION
    reads: tuple[str, ...] = ("spikes",)
    of_every_trial: bool = False
    least: int = field(default=0)
    about: Literal["direction", "looming"] = "direction"
    models: Set[str] = frozenset()
    pools: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        Claim.__post_init__(self)
        for name, legal in (("motions", get_args(Motion)), ("reads", None)):
            value = getattr(self, name)
            if not isinstance(value, tuple) or not all(isinstance(level, str) for level in value):
                raise ValueError(f"claim {self.id}: {name}={short(value)}: legal is a tuple of texts")
            wrong = [level for level in value if legal is not None and level not in legal]
            if wrong:
                raise ValueError(f"claim {self.id}: {name}={short(value)}: legal are {', '.join(legal or ())}")
        if self.about not in ("direction", "looming"):
            raise ValueError(f"claim {self.id}: about={short(self.about)}: legal is direction or looming")
        if not isinstance(self.least, int) or self.least < 0:
            raise ValueError(f"claim {self.id}: least={short(self.least)}: legal is a whole number from 1 up")
        if isinstance(self.models, str) or not all(isinstance(label, str) for label in self.models):
            raise ValueError(f"claim {self.id}: models={short(self.models)}: legal is a set of labels")
        object.__setattr__(self, "models", frozenset(self.models))
        if not self.least:
            object.__setattr__(self, "least", EACH_TRIAL if self.of_every_trial else MEANS)

    def concerns(self, channels: Sequence[str]) -> bool:
        """Tell whether the claim is about a model.

        Parameters
        ----------
        channels
            The channels that the model answers by, of `dsnn.CHANNELS`.

        Returns
        -------
        bool
            Whether it is.
        """
        return (self.about == "looming") != ("hs" in channels)

    def reads_motion(self, motion: str) -> bool:
        """Tell whether the claim is judged on trials of a motion.

        Parameters
        ----------
        motion
            The motion's name.

        Returns
        -------
        bool
            Whether it is.
        """
        return motion in self.motions or self.motions == EVERY_MOTION

    @property
    def spiking(self) -> str:
        """The model whose spiking threshold the judge of a claim that compares models gets."""
        return DSNN if DSNN in self.models else min(self.models)


def paper_claims() -> Mapping[str, RobotClaim]:
    """Return the paper's claims that trials with the robot answer for, by id."""
    return of_kind(RobotClaim)


def find(claim: Claim | str) -> RobotClaim:
    """Return a claim by its id; ``KeyError`` if trials with the robot do not answer for it."""
    return find_claim(claim, RobotClaim)


def judge(
    claim: RobotClaim | str, rows: Rows, threshold: float | None, model: str = "dsnn", all_rows: Rows | None = None
) -> Verdict:
    """Judge one claim: `outcome` as a verdict about ``model``. A claim that compares models names them itself."""
    asked = find(claim)
    return Verdict.of(asked, [outcome(asked, rows, threshold, all_rows)], model="" if asked.models else model)


def outcome(claim: RobotClaim | str, rows: Rows, threshold: float | None, all_rows: Rows | None = None) -> Outcome:
    """Judge one claim on one model's trials, or on those of the models that it compares.

    Parameters
    ----------
    claim
        The claim, or its id.
    rows
        The model's rows of ``trials.parquet``; for a claim that compares models those of all models.
    threshold
        The spiking threshold of the model, or of `RobotClaim.spiking`; ``None`` leaves the claim unjudged.
    all_rows
        All the model's rows, of other experiments too, where there are more than ``rows``. A claim that a silent
        network would keep is held against the translations among them.
    """
    asked = find(claim)
    missing = sorted(asked.models - {row.get("model") for row in rows})
    if missing:
        return Outcome.unjudged(f"needs the models {', '.join(missing)}")
    result = _judged(asked, [row for row in rows if not asked.models or row["model"] in asked.models], threshold)
    if asked.silent_passes:
        result = result.against_silence(_answers(rows if all_rows is None else all_rows), "trial")
    again = asked.on_equal_terms(rows)
    return replace(result, equal=outcome(replace(asked, equal_terms={}), again, threshold)) if again else result


ANSWERED_AT_CM = 8.0
ANSWERED_CM_S = (4.0, 6.0, 10.0)
"""The crossings that a model has to answer so as not to count as silent: distance from the camera, and speeds.

The paper's text has the count rise with speed, peak at about 6 cm/s and then decline. Of 2 cm/s, the lowest speed that
it shows, it says no more than that the count is lower there.
"""


def _answers(all_rows: Rows) -> dict[str, list[bool]]:
    """Return whether a model answers each crossing that the paper has it answer; without any, each translation."""
    across = [row for row in all_rows if row["motion"] == "translation"]
    at_8_cm = paper_trials(across, distance_cm=ANSWERED_AT_CM)
    named = {f"crossing at {speed:g} cm/s": [row for row in at_8_cm if row["speed_cm_s"] == speed]
             for speed in ANSWERED_CM_S}  # fmt: skip
    groups = named if any(named.values()) else {"translation": across}
    return {name: [is_number(row["spikes"]) and row["spikes"] > 0 for row in rows] for name, rows in groups.items()}


def _judged(claim: RobotClaim, rows: Rows, threshold: float | None) -> Outcome:
    if threshold is None:
        return Outcome.unjudged(NO_SPIKES)
    of_motions = [row for row in rows if claim.reads_motion(row["motion"])]
    unknown = [name for name in claim.reads if of_motions and name not in of_motions[0]]
    if unknown:
        hint = nearest(unknown[0], of_motions[0], "; ")
        return Outcome.unjudged(f"trials have no column {unknown[0]}{hint}", n=len(of_motions))
    without = unreadable(of_motions, claim.reads)
    if without:
        return Outcome.unjudged(f"of the trials {without}", n=len(of_motions))
    result = claim.ask([dict(row) for row in rows], threshold)  # what a judge changes is its own
    if not result.judged:
        return result
    wrong = flaws([row for row in of_motions if not claim.models or row["model"] == claim.spiking])
    if wrong:
        return result.withheld(wrong)
    refuted = result.verdict == "fails" and claim.of_every_trial
    fewest = result.fewest or _fewest(of_motions, *(("model",) if claim.models else ()))
    if fewest < claim.least and not refuted:
        why = f"needs at least {claim.least} trials of each condition (has {fewest})"
        return replace(result.withheld(why), least=claim.least)
    return result


def _fewest(rows: Rows, *beside: str) -> int:
    """Trials of the condition that has the fewest; ``beside`` are columns that tell conditions apart too."""
    conditions: Mapping[Any, Rows] = group(rows, *beside, *CONDITION_COLUMNS)
    return min(map(len, conditions.values()), default=0)


def flaws(rows: Rows) -> str:
    """Return what makes trials something other than what their conditions say, in words; empty if nothing does.

    A trial that was driven open loop is what its stimulus did: its speed and path are told, and bound by no tolerance.
    Of a trial from a robot's log nobody knows them: it is taken at the log's word.
    """
    rows, problems = [row for row in rows if not is_imported(row)], []
    for name, what in (("achieved_speed_cm_s", "speed"), ("path_error_mm", "path")):
        lost = sum(not is_number(row[name]) for row in rows)
        if lost:
            problems.append(f"{lost} of {len(rows)} trials have no measured {what}")
    rows = [row for row in rows if row.get("drive") != "open"]
    speeds = [row for row in rows if is_number(row["achieved_speed_cm_s"])]
    off = [abs(row["achieved_speed_cm_s"] / row["speed_cm_s"] - 1) for row in speeds]
    astray = [row["path_error_mm"] for row in rows if is_number(row["path_error_mm"])]
    if any(error > SPEED_TOLERANCE for error in off):
        count = sum(error > SPEED_TOLERANCE for error in off)
        problems.append(f"{count} of {len(rows)} trials were off the commanded speed, by up to {max(off):.0%}")
    if any(error > PATH_TOLERANCE_MM for error in astray):
        count = sum(error > PATH_TOLERANCE_MM for error in astray)
        problems.append(f"{count} of {len(rows)} trials left their path, by up to {max(astray):.1f} mm")
    return "; ".join(problems)

"""Judge claims on the rows of a run: the trials that a claim is about, what leaves it unjudged, and silent models.

A judge never bends a bound: a claim that misses it fails, and the verdict says by how much. A claim on clips needs
every combination of its `Claim.conditions` once: the same clip gives the same answer, so a repeat adds nothing. Where
there is a background, a seed is one scene, as the paper shows one; the count of the scenes in which it holds stands
beside the verdict.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

from experiments.declare.claim import Claim
from experiments.declare.conditions import CONDITION_COLUMNS
from experiments.declare.outcome import Outcome, is_number, unreadable
from experiments.settings.models import NO_SPIKES
from experiments.store.tables import group, is_imported
from scenes.hints import nearest

Row = Mapping[str, Any]
Rows = Sequence[Row]

SPEED_TOLERANCE, PATH_TOLERANCE_MM = 0.02, 1.0
DEFAULTS: Mapping[str, Any] = {
    "shell_grey": None,
    "wall_contrast": None,
    "observer_speed_cm_s": 0.0,
    "observer_turn_deg_s": 0.0,
}
"""What the paper's trials leave as it is: those of other experiments do not count."""
SIGNED = {
    "rightward": ("peak_hs", 1),
    "leftward": ("trough_hs", -1),
    "downward": ("peak_vs", 1),
    "upward": ("trough_vs", -1),
}
"""Direction -> the extreme that answers it, and its sign."""
SHADES = ("dark", "light")
EVERY = ()
"""Marks a column of a claim on clips of which each level counts."""


def judge(claim: Claim, rows: Rows, threshold: float | None, all_rows: Rows | None = None) -> Outcome:
    """Judge one claim: on one model's rows, or on those of the models that it compares; of clips at one seed.

    Parameters
    ----------
    claim
        The claim.
    rows
        Rows of ``trials.parquet``: the model's, or for a claim with ``models`` those of all models.
    threshold
        The spiking threshold of the model, or of `Claim.spiking`; ``None`` leaves a claim about spikes unjudged.
    all_rows
        Rows of other experiments and seeds too, where there are more than ``rows``. A claim that a silent network would
        satisfy is held against the translations among them.
    """
    missing = sorted(claim.models - {row.get("model") for row in rows})
    if missing:
        return Outcome.unjudged(f"needs {' and '.join(missing)}")
    if threshold is None and not claim.of_potentials:
        return Outcome.unjudged(NO_SPIKES)
    outcome = _judged(
        claim, [row for row in rows if not claim.models or row["model"] in claim.models], threshold or 0.0
    )
    if claim.silent_passes and threshold is not None:
        everything = rows if all_rows is None else all_rows
        if claim.on == "clips":
            outcome = outcome.against_silence(_clips_answered(claim.spiking, everything, threshold), "clip")
        else:
            outcome = outcome.against_silence(_trials_answered(everything), "trial")
    again = _on_equal_terms(claim, rows)
    if not again:
        return outcome
    return replace(outcome, equal=judge(claim.settled(), again, threshold, all_rows))


def _on_equal_terms(claim: Claim, rows: Rows) -> list[Mapping[str, Any]]:
    """Return the rows of models on equal terms, under the labels that they stand for; none where none was shown."""
    labels = {equal: label for label, equal in claim.equal_terms.items()}
    if not labels or not labels.keys() <= {row["model"] for row in rows}:
        return []
    others = (row for row in rows if row["model"] not in {*labels, *labels.values()})
    return [*others, *({**row, "model": labels[row["model"]]} for row in rows if row["model"] in labels)]


def _judged(claim: Claim, rows: Rows, threshold: float) -> Outcome:
    things = "clips" if claim.on == "clips" else "trials"
    unknown = [name for name in (*claim.conditions, *claim.reads) if rows and name not in ("shade", *rows[0])]
    if unknown:
        hint = nearest(unknown[0], rows[0], "; ")
        return Outcome.unjudged(f"{things} have no column {unknown[0]}{hint}", n=len(rows))
    chosen = [row for row in rows if _is_about(claim, row)]
    clips_lost = _unanswered(chosen, claim) if claim.on == "clips" else ""
    if without := clips_lost or unreadable(chosen, claim.reads):
        blind = "_in_" in without and any(is_imported(row) and row["seconds_in_view"] is None for row in chosen)
        return Outcome.unjudged(f"{'the log has no poses: ' * blind}of the {things} {without}", n=len(chosen))
    return (_on_clips if claim.on == "clips" else _on_robot)(claim, chosen, threshold)


def _on_robot(claim: Claim, rows: Rows, threshold: float) -> Outcome:
    outcome = claim.evaluate([dict(row) for row in rows], threshold)  # what a judge changes is its own
    if not outcome.judged:
        return outcome
    wrong = flaws([row for row in rows if not claim.models or row["model"] == claim.spiking])
    if wrong:
        return outcome.withheld(wrong)
    beside = ("model",) if claim.models else ()
    fewest = outcome.fewest or min(map(len, group(rows, *beside, *CONDITION_COLUMNS).values()), default=0)
    if fewest < claim.least and not (outcome.verdict == "fails" and claim.of_each):
        why = f"needs at least {claim.least} trials of each condition (has {fewest})"
        return outcome.withheld(why)
    return outcome


def _on_clips(claim: Claim, rows: Rows, threshold: float) -> Outcome:
    lacking = _lacking(claim, rows)
    if lacking and not (rows and claim.of_each):
        return Outcome.unjudged(lacking)
    outcome = claim.evaluate([dict(row) for row in rows], threshold)
    if not claim.own:
        n = sum(row["model"] == claim.spiking for row in rows)
        outcome = replace(outcome, n=n, fewest=n)
    return outcome.withheld(lacking) if lacking and outcome.verdict in ("holds", "unknown constants") else outcome


# --- which trials and clips a claim is about --------------------------------------------------------------------------


def paper_trials(rows: Rows, **fixed: Any) -> list[Row]:
    """Return the paper's own trials with the ``fixed`` values."""
    return [row for row in rows if all(row[name] == value for name, value in {**DEFAULTS, **fixed}.items())]


def _is_about(claim: Claim, row: Row) -> bool:
    """Return whether a claim's words are about what a row was shown."""
    if claim.on == "clips" and row["object"] == "absent" and not _may_be_alone(claim):
        return bool(claim.alone) and row[claim.alone] in claim.conditions[claim.alone]
    return all(_value(row, name) in values for name, values in claim.conditions.items() if values != EVERY)


def _may_be_alone(claim: Claim) -> bool:
    """Return whether clips of the background alone are like any others to a claim: its conditions choose among them."""
    return claim.own or "object" in claim.conditions


def _value(row: Row, name: str) -> Any:
    """A column's value, or of ``shade`` what the object is against its ground; ``None`` if neither, or unknown."""
    if name != "shade":
        return row[name]
    if not (is_number(row["grey"]) and is_number(row["background_mean"])) or row["grey"] == row["background_mean"]:
        return None
    return SHADES[row["grey"] > row["background_mean"]]


def _unanswered(rows: Rows, claim: Claim) -> str:
    """Clips to which a model has no row, as it failed there, in words; empty if none."""
    clips = list(dict.fromkeys(row["clip"] for row in rows))
    there = {(row["model"], row["clip"]) for row in rows}
    lost = {model: [clip for clip in clips if (model, clip) not in there] for model in sorted(claim.models)}
    return "; ".join(f"{', '.join(names)} has no answer of {model}" for model, names in lost.items() if names)


def _lacking(claim: Claim, rows: Rows) -> str:
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


# --- what tells that a model is silent --------------------------------------------------------------------------------

ANSWERED_AT_CM = 8.0
ANSWERED_CM_S = (4.0, 6.0, 10.0)
"""The crossings that a model has to answer so as not to count as silent: distance from the camera, and speeds.

The paper's text has the count rise with speed, peak at about 6 cm/s and then decline. Of 2 cm/s, the lowest speed that
it shows, it says no more than that the count is lower there.
"""


def _trials_answered(all_rows: Rows) -> dict[str, list[bool]]:
    """Return whether a model answers each crossing that the paper has it answer; without any, each translation."""
    across = [row for row in all_rows if row["motion"] == "translation"]
    at_8_cm = paper_trials(across, distance_cm=ANSWERED_AT_CM)
    named = {f"crossing at {speed:g} cm/s": [row for row in at_8_cm if row["speed_cm_s"] == speed]
             for speed in ANSWERED_CM_S}  # fmt: skip
    groups = named if any(named.values()) else {"translation": across}
    return {name: [is_number(row["spikes"]) and row["spikes"] > 0 for row in rows] for name, rows in groups.items()}


PAPER_SPEED = 120.0
"""Speeds of the crossings at which, in the paper, HS or VS passes T, px/s."""
PLAIN = f"a plain object at {PAPER_SPEED:g} px/s"
CLUTTERED = f"a dark or light object at {PAPER_SPEED:g} px/s before -8 px/s"
"""The crossings that a model has to answer so as not to count as silent: those of C1 and C6."""


def _clips_answered(model: str, all_rows: Rows, threshold: float) -> dict[str, list[bool]]:
    """Return whether a model answers each crossing that the paper has it answer; without any, each translation.

    An answer is a potential past T in the direction of the motion.
    """
    answers: dict[str, list[bool]] = {}
    for row in all_rows:
        if row["model"] != model or row["motion"] not in SIGNED or row["object"] == "absent":
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


def flaws(rows: Rows) -> str:
    """Return what makes trials something other than what their conditions say, in words; empty if nothing does.

    A trial that was driven open loop is what its stimulus did: no tolerance bounds its speed and path.
    They are unknown for a trial from a robot's log, which counts as it is.
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
    if over := [error for error in off if error > SPEED_TOLERANCE]:
        problems.append(f"{len(over)} of {len(rows)} trials were off the commanded speed, by up to {max(over):.0%}")
    if over := [error for error in astray if error > PATH_TOLERANCE_MM]:
        problems.append(f"{len(over)} of {len(rows)} trials left their path, by up to {max(over):.1f} mm")
    return "; ".join(problems)

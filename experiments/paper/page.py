"""The report of a reproduction, one page: the robot's figure, a line for each claim, its evidence, every figure.

How much of a reproduction is run, and the names of its parts, are here too.
"""

import base64
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.base import palette
from experiments.base.files import Files, read_json
from experiments.base.templates import render
from experiments.declare.claim import EACH_TRIAL, texts
from experiments.declare.outcome import REASONS
from experiments.declare.study import WHOLE
from experiments.draw import style
from experiments.draw.robot import PAPER, panels
from experiments.draw.terminal import SIGNS, is_unshown, not_run, seen_as
from experiments.judge.verdict import (
    FAILS_TO,
    HOLDS_FROM,
    LEAST_JUDGED,
    Count,
    State,
    Verdict,
    verdicts as stored_verdicts,
)
from experiments.kinds.registry import claims_on
from experiments.kinds.result import Run, load, whole_networks
from experiments.kinds.tables import OFFLINE
from experiments.paper.claims.clips import ASSUMED
from experiments.paper.claims.readings import CHOSEN_FOR, READINGS, used_to_choose
from experiments.paper.studies.clips import compares_with
from experiments.paper.studies.onboard import STUDY as ONBOARD
from experiments.store import provenance
from experiments.store.folder import RENDERERS
from experiments.store.tables import group, in_words

SHORT = (
    "clean", "blocked", "clutter-depth", "clutter-translation", "edges", "apparent", "background-alone",
)  # fmt: skip
"""The off-line experiments without grids of long clips."""


READ_OFF = ("background", "constants-2017", "constants-emd")
"""The studies whose points are clips of an off-line experiment of the same name."""


REPLICATES, SENSITIVITY, SENSITIVITY_CLIPS = "replicates", "sensitivity", "sensitivity-clips"
"""Folders of the trials other than replicate 0's."""


COUNTED = (*READ_OFF, SENSITIVITY, SENSITIVITY_CLIPS, ONBOARD.name)
"""The studies whose counts the report has, each in ``NAME.json``, as far as they are run."""


@dataclass(frozen=True, slots=True)
class Scale:
    """The scale of a reproduction: how much of each part is run.

    Parameters
    ----------
    replicates
        Replicates of the experiments with the robot, 1 or more. Replicate r has the seed of the run plus r.
    repeats
        Trials of each condition in a replicate. Fewer than a claim's ``least`` leave it unjudged.
    moves
        Whether to run one replicate with each thing moved that the studies of sensitivity name, and clips so too.
    offline_replicates
        Replicates of the off-line experiments in which anything is random; the others have one.
    episodes
        Episodes of each behaviour.
    steps
        Frames of an episode at most; otherwise the env's own number.
    offline
        The off-line experiments to run.
    onboard
        Whether the network in the robot's own arithmetic watches the other replicates too.
    """

    replicates: int
    repeats: int
    moves: bool
    offline_replicates: int
    episodes: int
    steps: int | None = None
    offline: tuple[str, ...] = OFFLINE
    onboard: bool = False


QUICK = Scale(2, EACH_TRIAL, moves=False, offline_replicates=1, episodes=1, steps=150, offline=SHORT)


USUAL = Scale(5, WHOLE, moves=True, offline_replicates=5, episodes=20, steps=900)


FULL = Scale(40, WHOLE, moves=True, offline_replicates=LEAST_JUDGED, episodes=60, onboard=True)


SCALES: Mapping[str, Scale] = {"quick": QUICK, "usual": USUAL, "full": FULL}


MEANINGS: Mapping[State, str] = {
    "holds": f"it holds in at least {HOLDS_FROM:.0%} of replicates, by the exact 95 % interval; or nothing is random",
    "sometimes": "it holds in some replicates, and neither in most nor in few by that interval",
    "fails": f"it holds in at most {FAILS_TO:.0%} of replicates, by the exact 95 % interval; or nothing is random",
    "counted": f"it held in k of n replicates: the sign tells all, some or none; below {LEAST_JUDGED} there is no word",
    "unjudged": "not judged in any replicate, with the reason",
}  # fmt: skip
"""State -> what it means."""
PHRASES: Mapping[State, tuple[str, str]] = {
    "holds": ("holds", "hold"), "sometimes": ("holds in some", "hold in some"), "fails": ("fails", "fail"),
    "unjudged": ("is not judged", "are not judged"),
}  # fmt: skip
"""State -> a phrase about one claim, and about several."""

NO_CAUSE = "The cause is not known: it held when the defaults were chosen."
GROUPS = ("Fail, or hold in some replicates only", "Hold", "Not judged")
"""Headings of the claims, in order."""
CHAPTERS = ("Robot trials", "Clips", "Behaviours")
"""Chapters of the runs on the page, in order."""
MOST_FAILURES = 5
"""Failures of one part that the page shows; ``failures.json`` of the part has all."""


def write(folder: Path) -> Path:
    """Write ``report.html`` and the robot's panels into the folder of a reproduction; return the page's path."""
    design = read_json(folder / "design.json")  # of the last reproduction there alone
    there = {run.folder.name: run for run in load(folder).parts}
    runs = [there[name] for name in design["parts"] if name in there]
    if trials := {run.folder.name: whole_networks(run) for run in runs if run.done and run.folder.name in PAPER}:
        style.save(panels(trials), folder / "panels")
    Files(folder).write_text("report.html", report(folder, design, runs))
    return folder / "report.html"


def report(folder: Path, design: Mapping[str, Any], runs: Sequence[Run]) -> str:
    """Return the page of a reproduction, its ``design.json`` and parts: HTML that needs nothing from outside."""
    names = ("pooled", "readings", "claims", "behaviours")
    pooled, readings, claims, own = (read_json(folder / f"{name}.json") for name in names)
    verdicts = stored_verdicts(claims)
    rows = [_row(claim, pooled, readings) for claim in (*verdicts, *stored_verdicts(own))]
    sections = group(_sections(folder, design["parts"], runs), "chapter")
    drawn = {mark: name for run in runs for name, marks in run.description.get(RENDERERS, {}).items() for mark in marks}
    return render(
        "paper/page.html.j2",
        summary=[text.partition(":")[0] for text in totals([(claim.id, claim.count) for claim in verdicts])],
        unshown=not_run(verdicts), scale=design["scale"], seed=design["seed"], whole=WHOLE, colours=palette.css(),
        full=FULL.replicates, least=LEAST_JUDGED,
        panels=data_uri(folder / "panels.svg"),
        groups=sorted(group(rows, "group").items()), chapters=sections, headings=GROUPS,
        anchors={section["name"] for chapter in sections.values() for section in chapter},
        common=[reading for reading in READINGS if reading not in CHOSEN_FOR],
        meanings=[(SIGNS.get(kind, "k of n"), meaning) for kind, meaning in MEANINGS.items()], reasons=REASONS,
        versions=provenance.versions(), drawn=drawn,
    )  # fmt: skip


def _row(claim: Verdict, pooled: Mapping[str, Any], readings: Sequence[Mapping[str, str]]) -> dict[str, Any]:
    count = claim.count
    broken = count.fails and count.word != "holds"
    held = count.sentence() if claim.experiment else "not judged"
    words = texts()[claim.id]
    unless = words.get("cause", NO_CAUSE) if broken else "" if count.judged else style.sentence(claim.outcome.deciding)
    evidence = _evidence(claim, pooled.get(claim.id)) | {
        f"With {row['under']}": row["came_to"] for row in readings if row["claim"] == claim.id
    }
    return {
        "group": 2 if count.state == "unjudged" else 0 if broken else 1,
        "id": claim.id, "title": claim.title or claim.says, "kind": seen_as(count), "sign": SIGNS[seen_as(count)],
        "held": f"{count.word}: {held}" if count.word and count.random else held,
        "why": unless, "numbers": claim.numbers if claim.experiment else ("", ""), "unshown": is_unshown(claim),
        "evidence": [{"heading": name, "text": text} for name, text in evidence.items() if text],
        "figures": list(dict.fromkeys([*claim.experiment.split(", "), words.get("mechanism", "")])),
    }  # fmt: skip


def _evidence(claim: Verdict, whole: Mapping[str, Any] | None) -> dict[str, str]:
    """Return everything that is known of a claim: heading -> text, empty where there is nothing.

    ``whole`` is its outcome on the trials of all replicates together.
    """
    words, count, outcome = texts()[claim.id], claim.count, claim.outcome
    again, mechanism = outcome.equal, words.get("mechanism")
    evidence = {
        "The claim": f"{claim.says} ({claim.source})" if claim.source else claim.says,
        "The equations imply it": words.get("implied", ""),
    }
    if claim.experiment:
        number = f"replicate 0, {outcome.verdict}, n = {outcome.n}, {claim.experiment}"
        low, high = count.interval or (0.0, 0.0)
        together = f"{whole['verdict']}: {whole['measured']}" if whole and count.replicates > 1 else ""
        share = f"{low:.0%} to {high:.0%} of replicates (exact 95 % interval of the share in which it holds)"
        evidence |= {
            "Decided by": f"{outcome.deciding}; {number}",
            "Measured in replicate 0": "; ".join(filter(None, (outcome.measured, outcome.effect))),
            "Interval": share if count.interval else "",
            "All replicates together": together,
            "The DSNN's half": f"{words['of_dsnn']}: {count.half.sentence()}" if count.half else "",
            "What was tried": "" if count.word == "holds" or not count.fails else words.get("tried", ""),
            "Mechanism": f"{mechanism}: {texts()['mechanisms'][mechanism]}" if mechanism else "",
        }
        if claim.equal is not None and again is not None:
            rivals = ", ".join(claims_on("clips")[claim.id].equal_terms.values())
            evidence["On equal terms"] = f"{rivals}: {claim.equal.sentence()}; replicate 0: {again.deciding}"
    chosen = ", ".join(reading for reading in used_to_choose(claim.id) if reading in CHOSEN_FOR)
    return evidence | {
        "Used to choose": f"{chosen}: the claim is no test of what it was used to choose" if chosen else "",
        "With the robot's own eye and wheels": words.get("eye", ""),
        "Assumed of the other model": ASSUMED.get(compares_with(claim.id), ""),
    }


def _sections(folder: Path, names: Sequence[str], runs: Sequence[Run]) -> Iterator[dict[str, Any]]:
    """Yield every experiment, behaviour and study with its figure: chapter, name, title, text, figure, failures."""
    parts = [(chapter, run.folder.name, style.sentence(run.words), run.folder / "figure.svg")
             for chapter in CHAPTERS for run in runs if run.chapter == chapter]  # fmt: skip
    for path in (folder / f"{name}.json" for name in COUNTED if name in names):
        study = read_json(path)
        repeats = f" of {study['repeats'][0]} repeats" if study["repeats"][0] else ""
        text = f"{study['summary']}: {study['replicates']} replicates{repeats}, from seed {study['seed']}."
        parts.append(("What the claims survive", path.stem, text, path.with_suffix(".svg")))
    failures = {run.folder.name: run.failures.to_dicts() for run in runs}
    for chapter, name, text, figure in parts:
        failed = failures.get(name, [])
        yield {"chapter": chapter, "name": name, "text": style.sentence(text), "figure": data_uri(figure),
               "failed": len(failed), "failures": in_words(failed)[:MOST_FAILURES]}  # fmt: skip


def data_uri(path: Path) -> str:
    """Return an SVG file as a data URI; empty where there is none."""
    return f"data:image/svg+xml;base64,{base64.b64encode(path.read_bytes()).decode()}" if path.is_file() else ""


def totals(counts: Iterable[tuple[str, Count]]) -> list[str]:
    """Count the claims of each kind, in a phrase for each; those that hold come first.

    Where some have too few replicates for a word, all are counted by what became of them in these.

    Parameters
    ----------
    counts
        Pairs of a claim's id and its count.

    Examples
    --------
    >>> totals([("C1", Count(40)), ("C2", Count(0, 40))])
    ['1 of 2 claims holds', '1 fails: C2']
    >>> totals([("C1", Count(1, random=False)), ("C3", Count(5)), ("C4", Count(2, 3))])
    ['2 of 3 claims hold in every replicate judged', '1 holds in some: C4']
    """
    pairs = list(counts)
    few = any(counted.state == "counted" for _, counted in pairs)
    found: dict[State, list[str]] = {kind: [] for kind in PHRASES}
    for claim, counted in pairs:
        in_all: State = "holds" if not counted.fails else "sometimes" if counted.holds else "fails"
        half = "" if counted.half is None else f" (the DSNN's half: {counted.half.label})"
        found[in_all if counted.state == "counted" else counted.state].append(f"{claim}{half}")
    phrases: list[str] = []
    for kind, claims in found.items():
        of = "" if phrases else f" of {len(pairs)} claim{'s' * (len(pairs) != 1)}"
        every = " in every replicate judged" if few and kind in ("holds", "fails") else ""
        named = "" if kind == "holds" else f": {', '.join(claims)}"
        if claims:
            phrases.append(f"{len(claims)}{of} {PHRASES[kind][len(claims) > 1]}{every}{named}")
    return phrases

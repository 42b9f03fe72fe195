"""Take the documentation's measured figures over from a finished reproduction: ``python -m tools.numbers RUN_FOLDER``.

``colias reproduce`` leaves its design, verdicts and scores in its folder. This writes what the README and the chapters
of docs/ quote of them into ``docs/results.json``, with the design they were measured by, and renews the pages between
their markers. Nothing outside the markers, nor in what a claim says was tried, quotes a measured figure.
`tests/tools/test_numbers.py` holds the pages against the file, and the file's design against that of the code.
"""

from __future__ import annotations

import argparse
import csv
import dataclasses
import functools
import json
import math
import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import product
from pathlib import Path
from typing import Any

from experiments.bench import registry
from experiments.bench.reproduce import Scale, design, planned, rate
from experiments.bench.stats import stored
from experiments.bench.stats.claim import words
from experiments.bench.stats.count import SIGNS, Count, totals
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.store.files import rows_hash
from experiments.bench.studies.counts import count_of
from experiments.bench.studies.stored import studies
from experiments.claims.readings import used_to_choose
from experiments.studies.fidelity import EYE, STUDY, WHEELS

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "docs" / "results.json"
PAGES: Mapping[str, tuple[str, ...]] = {
    "README.md": ("summary",),
    "docs/index.md": ("summary",),
    "docs/results.md": ("claims", "cameras"),
    "docs/what-the-numbers-mean.md": ("readings", "onboard"),
    "docs/behaviours-and-training.md": ("behaviours",),
}
"""Page -> its measured parts, by the names in their markers."""
SUMMARY: Mapping[str, str] = {
    "C14": "The sign of HS tells the direction of a crossing",
    "C15": "Spikes peak near 6 cm/s",
    "C29": "The peak stays when one time window counts the spikes of all speeds",
    "C16": "Spikes fall with distance",
    "C13": "Straight approach and recession give no spikes",
    "C17": "An approach straight ahead gives the fewest spikes",
    "C19": "A recession straight ahead gives the fewest spikes",
    "C21": "Two looming detectors spike most in a straight approach",
}
"""Claim -> its words in the summary, which counts the others."""
CELLS: Mapping[tuple[str, str], str] = {
    (eye.label, wheels.label): f"{eye.label} eye, {wheels.label}" for eye, wheels in product(EYE.levels, WHEELS.levels)
}
"""Every eye and drive of the study `fidelity`, with a heading; the first are those of a reproduction."""
IDEAL = next(iter(CELLS))
ROBOTS = ("ov7670", IDEAL[1])
"""The summary's columns, with `IDEAL`: they differ by the camera alone."""
REASON: Mapping[str, str] = {
    "judge failed": "its judge failed",
    "not shown": "what it needs was not shown",
    "silent model": "the network is silent",
    "unknown constants": "a rival's constants are unknown",
}
"""Why a claim was not judged, in a few words."""
STALE = "The design has changed since: `make numbers` measures anew."
LOST_AND_GAINED, DISTANCE = (
    "Claims lost and gained against the float network", "Distance from the float network, frame by frame",
)  # fmt: skip
"""Tables of the study ``onboard`` that the documentation shows."""
OUTCOME_FIELDS = ("verdict", "decided", "measured")
SCORE_FIELDS = ("env", "behaviour", "measure", "episodes", "value", "ci_low", "ci_high")
BEGIN, END = "<!-- measured: {} -->\n", "<!-- end of measured -->"


class NotFinished(Exception):
    """A folder that holds no finished reproduction, or a page without its markers: what is missing."""


def taken(run: Path) -> dict[str, Any]:
    """Return what ``docs/results.json`` keeps of a finished reproduction in the folder ``run``."""
    design, pooled = (_json(run / f"{name}.json") for name in ("design", "pooled"))
    claims, behaviours = (stored.verdicts(_json(run / f"{name}.json")) for name in ("claims", "behaviours"))
    tables = sorted(run.glob("behave-*/scores.csv"))
    if not tables:
        raise NotFinished(f"{run}: no behave-*/scores.csv; run colias reproduce without --robot-only")
    scores = [row for table in tables for row in _scores(table)]
    return {
        "design": {name: design[name] for name in ("seed", "scale", "digest")},
        "measured_with": {"commit": _commit(run), **design["versions"]},
        "rows": {table.parent.name: rows_hash(table) for table in sorted(run.glob("*/trials.parquet"))},
        "claims": [kept(verdict) | {"rate": _rate(verdict.id, pooled.get(verdict.id))} for verdict in claims],
        "behaviours": [kept(verdict) | {"says": verdict.says} for verdict in behaviours],
        "eyes": _eyes_kept(run),
        "scores": scores,
        "onboard": _onboard_kept(run / "onboard.json"),
    }


def _eyes_kept(run: Path) -> list[dict[str, Any]]:
    """Return the count of each claim under each eye and drive; nothing of a reproduction without the study of them."""
    return [
        {"eye": row["point"][EYE.name], "drive": row["point"][WHEELS.name], "claim": row["claim"],
         "count": dataclasses.asdict(count_of(row))}
        for row in studies(run).get(STUDY.name, {}).get("counts", ())
    ]  # fmt: skip


def _onboard_kept(path: Path) -> dict[str, Any]:
    """Return what is kept of the study of the robot's arithmetic; nothing of a reproduction without it."""
    if not path.is_file():
        return {}
    study = _json(path)
    held = [{name: row[name] for name in ("model", "claim", "holds", "replicates")} for row in study["counts"]]
    return {"held": held, **{name: study["tables"][name] for name in (LOST_AND_GAINED, DISTANCE)}}


def kept(verdict: Verdict) -> dict[str, Any]:
    """Return what is kept of a verdict, as its file has it."""
    (entry,) = stored.document([verdict])["claims"]
    outcome = {name: entry["outcome"][name] for name in OUTCOME_FIELDS}
    equal = entry["outcome"]["equal"]
    beside = {name: equal[name] for name in OUTCOME_FIELDS} if equal else None
    return {"id": entry["id"], "word": entry["word"], "count": entry["count"], "outcome": outcome,
            "equal_terms": entry["equal_terms"], "equal_outcome": beside}  # fmt: skip


def _rate(claim: str, pooled: Mapping[str, Any] | None) -> str:
    """Return the share of all trials that break a claim about every single one; empty of others."""
    if pooled is None:
        return ""
    return rate(claim, Outcome(pooled["verdict"], pooled["measured"], n=pooled["n"], broken=pooled["broken"]))


def _json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        raise NotFinished(f"{path}: cannot be read; is the reproduction in that folder finished?") from None


def _scores(table: Path) -> list[dict[str, Any]]:
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return [
        {name: _number(row[name]) if name in ("episodes", "value", "ci_low", "ci_high") else row[name]
         for name in SCORE_FIELDS}
        for row in rows
    ]  # fmt: skip


def _number(text: str) -> float | str | None:
    """Return a finite number; ``None`` for none; an infinity as its name, which JSON has no number for."""
    value = float(text) if text else math.nan
    return None if math.isnan(value) else float(f"{value:.4g}") if math.isfinite(value) else "inf"


def _commit(run: Path) -> str:
    """Return the commits that computed a reproduction's parts; of a changed tree with "-dirty" at the end."""
    sources = [json.loads(path.read_text(encoding="utf-8")).get("source", {}) for path in run.glob("*/run.json")]
    commits = {str(source["commit"])[:7] for source in sources if source.get("commit")}
    if not commits:
        return "unknown"
    return f"{' and '.join(sorted(commits))}{'-dirty' if any(source.get('dirty') for source in sources) else ''}"


@functools.cache
def _digest(scale: Scale, seed: int) -> str:
    return str(design(planned(scale, seed))["digest"])


def stale(results: Mapping[str, Any]) -> bool:
    """Tell whether the figures are of another design than the code's."""
    measured = results["design"]
    known = {field.name for field in dataclasses.fields(Scale)}
    if set(measured["scale"]) != known:
        return True
    scale = Scale(**{**measured["scale"], "offline": tuple(measured["scale"]["offline"])})
    return bool(measured["digest"] != _digest(scale, measured["seed"]))


def unfit(results: Mapping[str, Any]) -> str:
    """Return why a release cannot have these numbers; empty where it can."""
    commit = results["measured_with"]["commit"]
    if stale(results):
        return f"the figures, measured by commit {commit}, are of another design than the code's: run make numbers"
    if commit.endswith("-dirty") or commit == "unknown":
        return f"the figures were measured by commit {commit}, which nobody can check out: run make numbers"
    if not results.get("rows"):
        return f"the figures, measured by commit {commit}, record no hash of their rows: run make numbers"
    return ""


def blocks(results: Mapping[str, Any]) -> dict[str, str]:
    """Return the measured parts of the pages by name, as Markdown."""
    return {
        "summary": _summary(results),
        "claims": _claims(results),
        "cameras": _cameras(results),
        "readings": _readings(results),
        "onboard": _onboard(results.get("onboard", {})),
        "behaviours": _behaviours(results),
    }


def _counts(results: Mapping[str, Any]) -> dict[str, tuple[Count | None, ...]]:
    """Return claim -> its count under each camera and drive of `CELLS`; ``None`` where it was not run there.

    The first count is that of the reproduction itself: a claim has one verdict there.
    """
    under: dict[str, dict[tuple[str, str], Count]] = {}
    for row in results.get("eyes", ()):
        under.setdefault(row["claim"], {})[row["eye"], row["drive"]] = Count(**row["count"])
    for claim in results["claims"]:
        under.setdefault(claim["id"], {})[IDEAL] = Count(**claim["count"])
    return {claim["id"]: tuple(map(under[claim["id"]].get, CELLS)) for claim in results["claims"]}


def _verdict(count: Count | None) -> str:
    """Say a claim's verdict with its sign, and in how many replicates it held."""
    if count is None:
        return "not run"
    of = count.half or count
    held = f"{of.holds} of {of.judged}" if count.random else "the same at any seed"
    if count.kind == "counted":
        return f"{SIGNS[count.kind]} held in {held}"
    if count.half:
        held = f"{REASON['unknown constants']}; the DSNN's half {held}"
    elif not count.judged:
        held = ", ".join(REASON[reason] for reason in count.unjudged)
    return f"{SIGNS[count.kind]} {count.label} ({held})"


def _tally(counts: Iterable[Count | None]) -> str:
    """Say how many claims have each verdict."""
    kinds = Counter(count and count.kind for count in counts)
    names = {"holds": "hold" + "s" * (kinds["holds"] == 1), "sometimes": "sometimes",
             "fails": "fail" + "s" * (kinds["fails"] == 1), "counted": "with too few replicates",
             "unjudged": "not judged"}  # fmt: skip
    parts = [f"{SIGNS[kind]} {kinds[kind]} {name}" for kind, name in names.items() if kinds[kind]]
    return ", ".join([*parts, *([f"{kinds[None]} not run"] if kinds[None] else [])])


def _summary(results: Mapping[str, Any]) -> str:
    """Tell in ten rows what claims came to, with an ideal camera and with a model of the robot's."""
    counts = _counts(results)
    columns = [list(CELLS).index(camera) for camera in (IDEAL, ROBOTS)]
    others = [claim for claim in counts if claim not in SUMMARY]
    clips = [claim for claim in others if claim not in registry.answering()]
    robot = [claim for claim in others if claim not in clips]
    of_clips, of_robot = (_tally(counts[claim][columns[0]] for claim in claims) for claims in (clips, robot))
    lines = [
        f"The paper's {len(counts)} claims with an ideal camera: {_tally(count[0] for count in counts.values())}."
        f"{f' {STALE}' if stale(results) else ''}",
        "",
        "| claim | ideal camera | model of the robot's camera |",
        "|---|---|---|",
        *(
            f"| {says} ({claim}) | {' | '.join(_verdict(counts[claim][column]) for column in columns)} |"
            for claim, says in SUMMARY.items()
            if claim in counts
        ),
        f"| The {len(robot)} other claims about the robot | {of_robot} "
        f"| {_tally(counts[claim][columns[1]] for claim in robot)} |",
        f"| The {len(clips)} claims about synthetic clips and footage | {of_clips} | clips have no camera |",
    ]
    return "\n".join(lines) + "\n"


def _cameras(results: Mapping[str, Any]) -> str:
    """Tell what each claim about the robot came to under each camera and drive."""
    lines = [f"| claim | {' | '.join(CELLS.values())} |", "|---" * (len(CELLS) + 1) + "|"]
    for claim, counts in _counts(results).items():
        if claim in registry.answering():
            lines.append(f"| {words(claim).title} ({claim}) | {' | '.join(map(_verdict, counts))} |")
    return "\n".join(lines) + "\n"


def _totals(results: Mapping[str, Any]) -> str:
    claims, scale, seed = results["claims"], results["design"]["scale"], results["design"]["seed"]
    sentence = "; ".join(totals([(claim["id"], Count(**claim["count"])) for claim in claims]))
    return (
        f"{sentence}. A replicate has {scale['repeats']} repeats of each of the robot's conditions, or every clip, at "
        f"one seed; replicate 0 has seed {seed}. Measured by commit {results['measured_with']['commit']}."
        f"{f' {STALE}' if stale(results) else ''}"
    )


def _claims(results: Mapping[str, Any]) -> str:
    """Tell of each claim its words, its verdict, and the number that decided in replicate 0, with its bound."""
    lines = [_totals(results), "", "| claim | verdict | what decided in replicate 0, and its bound |", "|---|---|---|"]
    for claim in (*results["claims"], *results["behaviours"]):
        asked, outcome = words(claim["id"]), Outcome(**claim["outcome"])
        implied = " The equations imply it." if asked.implied else ""
        says = f"**{asked.title}** ({claim['id']}): {asked.says}.{implied}"
        decided = outcome.deciding + (f"; all replicates: {claim['rate']}" if claim.get("rate") else "")
        count, equal = Count(**claim["count"]), claim.get("equal_outcome")
        verdict = _verdict(count)
        if equal:
            verdict += f"; on equal terms {_verdict(Count(**claim['equal_terms']))}"
            decided += f"; on equal terms {equal['verdict']}: {Outcome(**equal).deciding}"
        cause = asked.cause or ("Not known." if count.word in ("fails", "sometimes") else "")
        decided += f". *Why:* {cause}" if cause and count.word != "holds" else ""
        lines.append(f"| {' | '.join(map(_cell, (says, verdict, decided)))} |")
    return "\n".join(lines) + "\n"


def _readings(results: Mapping[str, Any]) -> str:
    """Tell which claims were used to choose each reading of the paper."""
    readings: dict[str, list[str]] = {}
    for claim in results["claims"]:
        for reading in used_to_choose(claim["id"]):
            readings.setdefault(reading.name, []).append(claim["id"])
    every = len(results["claims"])
    lines = [f"- {name}: {'all claims' if len(ids) == every else ', '.join(ids)}" for name, ids in readings.items()]
    return "\n".join(lines) + "\n"


def _onboard(study: Mapping[str, Any]) -> str:
    """Tell in how many replicates claims held in the robot's arithmetic, and how far HS is from the float network's."""
    if not study:
        return ""
    held = {(row["model"], row["claim"]): row for row in study["held"]}
    models, claims = (list(dict.fromkeys(names)) for names in zip(*held, strict=True))
    changes = {(row["format"], row["claim"]): row for row in study[LOST_AND_GAINED]}
    lines = [f"| claim | {' | '.join(f'`{model}`' for model in models)} |", "|---" * (len(models) + 1) + "|"]
    for claim in claims:
        cells = []
        for model in models:
            row, change = held[model, claim], changes.get((model, claim), {"lost": 0, "gained": 0})
            differs = f" (-{change['lost']} +{change['gained']})" if change["lost"] or change["gained"] else ""
            cells.append(f"{row['holds']} of {row['replicates']}{differs}")
        lines.append(f"| {claim} | {' | '.join(cells)} |")
    for row in study[DISTANCE]:
        lines += [
            "",
            f"The error of HS of `{row['format']}` over {row['frames']:,} frames has the median "
            f"{row['median of |HS error|']:.2g}, {row['99 %']:.2g} at 99 %, and {row['worst']:.2g} at the worst; of "
            f"{row['spikes in float']:,} spikes {row['lost']:,} were lost and {row['gained']:,} gained.",
        ]
    return "\n".join(lines) + "\n"


def _behaviours(results: Mapping[str, Any]) -> str:
    scale, seed = results["design"]["scale"], results["design"]["seed"]
    seconds = "" if scale["steps"] is None else f" of at most {scale['steps'] / 30:g} s"
    lines = [
        f"Over {scale['episodes']} episodes{seconds} each, at seeds {seed} to {seed + scale['episodes'] - 1}, with "
        "95 % intervals:",
        "",
        "| env | behaviour | measures |",
        "|---|---|---|",
    ]
    measured: dict[tuple[str, str], list[str]] = {}
    for row in results["scores"]:
        short = row["env"].partition("/")[2].partition("-")[0]
        measured.setdefault((short, row["behaviour"]), []).append(f"{row['measure']} {_score(row)}")
    lines += [f"| {env} | `{who}` | {_cell('; '.join(numbers))} |" for (env, who), numbers in measured.items()]
    lines.append("")
    for claim in results["behaviours"]:
        outcome = claim["outcome"]
        decided = f" Decided by: {outcome['decided']}." if outcome["decided"] else ""
        held = Count(**claim["count"]).sentence()
        lines.append(f"- {claim['id']} {held}: {claim['says']}. Measured: {outcome['measured']}.{decided}")
    return "\n".join(lines) + "\n"


def _score(row: Mapping[str, Any]) -> str:
    value, low, high = (_short(row[name]) for name in ("value", "ci_low", "ci_high"))
    return value if row["ci_low"] is None else f"{value} ({low} .. {high})"


def _short(value: float | str | None) -> str:
    return "-" if value is None else value if isinstance(value, str) else f"{value:.3g}"


def _cell(text: str) -> str:
    """Text inside a Markdown table."""
    return text.replace("|", r"\|").replace("\n", " ")


def renewed(page: str, text: str, parts: Mapping[str, str]) -> str:
    """Return the ``text`` of a page with its measured ``parts`` put between their markers."""
    for name, part in parts.items():
        begin = BEGIN.format(name)
        pattern = re.compile(re.escape(begin) + ".*?" + re.escape(END), re.DOTALL)
        if len(pattern.findall(text)) != 1:
            raise NotFinished(f"{page} should have the marker {begin.strip()} once, then {END}")
        text = pattern.sub(lambda _, whole=f"{begin}{part}{END}": whole, text)  # type: ignore[misc]
    return text


def main() -> None:
    """Take over the figures of the folder on the command line."""
    parser = argparse.ArgumentParser(prog="python -m tools.numbers", description="Renew the measured figures of docs.")
    parser.add_argument("run", type=Path, nargs="?", help="folder of a finished colias reproduce; else the pages alone")
    parser.add_argument("--check", action="store_true", help="write nothing: refuse figures that are stale")
    parser.add_argument("--root", type=Path, default=ROOT, help="folder of the pages, and of docs/results.json")
    given = parser.parse_args()
    root: Path = given.root
    kept_file = root / RESULTS.relative_to(ROOT)
    if given.check:
        why = unfit(_json(kept_file))
        sys.exit(_refuse(why) if why else 0)
    try:
        results = taken(given.run) if given.run else _json(kept_file)
        parts = blocks(results)
        pages = {
            root / page: renewed(page, (root / page).read_text(encoding="utf-8"), {name: parts[name] for name in names})
            for page, names in PAGES.items()
        }
    except NotFinished as error:
        sys.exit(_refuse(str(error)))
    for path, text in {kept_file: json.dumps(results, indent=1, allow_nan=False) + "\n", **pages}.items():
        path.write_text(text, encoding="utf-8")


def _refuse(text: str) -> int:
    print(f"numbers: {text}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    main()

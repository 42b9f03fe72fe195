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
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from experiments.bench import registry
from experiments.bench.judging import stored
from experiments.bench.judging.claim_files import BEHAVIOURS, claim_ids
from experiments.bench.judging.claims import used_to_choose, words
from experiments.bench.judging.count import SIGNS, Count, Kind, totals
from experiments.bench.judging.verdict import Outcome, Verdict
from experiments.bench.reproduction import eyes
from experiments.bench.reproduction.plan import Scale, design, planned
from experiments.bench.reproduction.replicates import rate
from experiments.bench.store.files import rows_hash
from tools import claim_sheet

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "docs" / "results.json"
SHEET = ROOT / "docs" / "claims.svg"
"""All claims as one picture, where the results have the readings that decided them."""
PAGES: Mapping[str, tuple[str, ...]] = {
    "README.md": ("groups",),
    "docs/index.md": ("home",),
    "docs/what-the-numbers-mean.md": ("onboard", "verdicts", "claims"),
    "docs/behaviours-and-training.md": ("behaviours",),
}
"""Page -> its measured parts, by the names in their markers."""
GROUPS: Mapping[str, tuple[str, ...]] = {
    "Plain clips: direction, depth, the two pathways": ("C1", "C2", "C3", "C4"),
    "Clips over a moving background": ("C5", "C6", "C7", "C8"),
    "Clips of five greys: speed, contrast, slow objects": ("C9", "C10", "C11"),
    "Streets, filmed and rendered": ("C12", "C28"),
    "Robot: crossings tell the direction, straight motion in depth is silent": ("C13", "C14"),
    "Robot: speed and distance of crossings": ("C15", "C16", "C29", "C30", "C31"),
    "Robot: angular approach and recession": ("C17", "C18", "C19", "C20"),
    "Robot: looming detectors on the same approaches": ("C21",),
    "What the mechanisms do": ("C22", "C23", "C24", "C25", "C26", "C27"),
    "Closed loop, claims of our own": ("B1", "B2", "B3", "B4"),
}
"""What claims are about -> their ids: the rows of the README's table."""
NOT_RUN, NEITHER = "not run", "n/a"
"""Words of a cell of the README's table for claims that were not run under its eye and drive, and that have neither."""
TABLE_KEY = (
    "*Hold*, *sometimes* and *fail* are the word over all replicates, and *k of n* is said where they are too few for a"
    " word. *Not judged*: there is no word, for the reason beside it. *Unknown constants*: the claim compares the DSNN"
    " with a model whose constants the paper does not give. *Silent model*: the model stays silent, as the claim asks,"
    " but does not answer the paper's own crossings either. *Not shown*: what the claim needs was missing. *Not run*:"
    " its trials were not run under that eye and drive. *n/a*: clips have neither eye nor drive."
)
"""What the words in the README's table mean, in Markdown."""
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
    claims, behaviours = (_read(run / f"{name}.json") for name in ("claims", "behaviours"))
    tables = sorted(run.glob("behave-*/scores.csv"))
    if not tables:
        raise NotFinished(f"{run}: no behave-*/scores.csv; run colias reproduce without --robot-only")
    scores = [row for table in tables for row in _scores(table)]
    return {
        "design": {name: design[name] for name in ("seed", "scale", "digest")},
        "measured_with": {"commit": _commit(run), **design["versions"]},
        "rows": {table.parent.relative_to(run).as_posix(): rows_hash(table) for table in _tables(run)},
        "claims": [kept(verdict) | {"rate": _rate(verdict.id, pooled.get(verdict.id))} for verdict in claims],
        "behaviours": [kept(verdict) | {"says": verdict.says} for verdict in behaviours],
        "eyes": [
            {"eye": eye, "drive": drive, "claim": claim, "count": dataclasses.asdict(count)}
            for claim, cells in eyes.by_eye(run).items()
            for (eye, drive), count in cells.items()
        ],
        "scores": scores,
        "onboard": _onboard_kept(run / "onboard.json"),
    }


def _onboard_kept(path: Path) -> dict[str, Any]:
    """Return what is kept of the study of the robot's arithmetic; nothing of a reproduction without it."""
    if not path.is_file():
        return {}
    study = _json(path)
    held = [{name: row[name] for name in ("model", "claim", "holds", "replicates")} for row in study["counts"]]
    return {"held": held, **{name: study["tables"][name] for name in (LOST_AND_GAINED, DISTANCE)}}


def _tables(run: Path) -> list[Path]:
    """Return the tables of rows in the folders of a reproduction's parts."""
    return sorted(path for path in run.glob("*/trials.parquet") if path.is_file())


def kept(verdict: Verdict) -> dict[str, Any]:
    """Return what is kept of a verdict, as its file has it."""
    (entry,) = stored.document([verdict])["claims"]
    outcome = {name: entry["outcome"][name] for name in OUTCOME_FIELDS}
    equal = entry["outcome"]["equal"]
    beside = {name: equal[name] for name in OUTCOME_FIELDS} if equal else None
    return {"id": entry["id"], "word": entry["word"], "count": entry["count"], "outcome": outcome,
            "equal_terms": entry["equal_terms"], "equal_outcome": beside,
            "decisions": [claim_sheet.kept(decision) for decision in verdict.decisions]}  # fmt: skip


def _rate(claim: str, pooled: Mapping[str, Any] | None) -> str:
    """Return the share of all trials that break a claim about every single one; empty of others."""
    if pooled is None:
        return ""
    return rate(claim, Outcome(pooled["verdict"], pooled["measured"], n=pooled["n"], broken=pooled["broken"]))


def _read(path: Path) -> list[Verdict]:
    """Return the verdicts in a file."""
    try:
        return stored.verdicts(_json(path))
    except ValueError as error:
        raise NotFinished(f"{path}: cannot be read ({error})") from None


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
    sources = [json.loads(path.read_text(encoding="utf-8")).get("source", {}) for path in run.glob("*/experiment.json")]
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
        "groups": _groups(results),
        "home": _home(results),
        "verdicts": _verdicts(results),
        "claims": _claims(results),
        "onboard": _onboard(results.get("onboard", {})),
        "behaviours": _behaviours(results),
    }


def _verdicts(results: Mapping[str, Any]) -> str:
    """Tell what claims came to, with a row a claim: its words, its word, and in how many replicates it held."""
    columns = "| claim | the paper says | word | in all replicates |"
    lines = [_totals(results), "", columns, "|---|---|---|---|"]
    for claim in results["claims"]:
        asked, count = words(claim["id"]), Count(**claim["count"])
        says = f"{asked.says} (the equations imply it: {asked.implied})" if asked.implied else asked.says
        held = "; ".join(filter(None, (count.sentence(), _on_equal_terms(claim))))
        lines.append(f"| {claim['id']} | {_cell(says)} | {count.word or '-'} | {_cell(held)} |")
    return "\n".join(lines) + "\n"


def _on_equal_terms(claim: Mapping[str, Any]) -> str:
    """Return what a claim came to with its rivals on equal terms; empty of a claim without."""
    equal = claim.get("equal_terms")
    return f"on equal terms {Count(**equal).sentence()}" if equal else ""


def _groups(results: Mapping[str, Any]) -> str:
    """Tell what claims came to by `GROUPS`, under each eye and drive: which hold, hold sometimes, fail."""
    counts = {claim["id"]: Count(**claim["count"]) for claim in (*results["claims"], *results["behaviours"])}
    under: dict[str, dict[eyes.Apparatus, Count]] = {}
    for row in results.get("eyes", ()):
        under.setdefault(row["claim"], {})[row["eye"], row["drive"]] = Count(**row["count"])
    first, *others = eyes.CELLS.values()
    columns = f"| about | clips, or {first} | {' | '.join(others)} |"
    lines = [_totals(results), "", *_sheet(results), columns, "|---" * (len(eyes.CELLS) + 1) + "|"]
    for about, claims in GROUPS.items():
        ids = [claim for claim in claims if claim in counts]
        sides = [eyes.side_by_side(claim, counts[claim], under) for claim in ids]
        cells = [_kinds(ids, column) for column in zip(*sides, strict=True)] if ids else [NEITHER] * len(eyes.CELLS)
        lines.append(f"| {' | '.join(_cell(cell) for cell in (about, *cells))} |")
    return "\n".join([*lines, "", TABLE_KEY]) + "\n"


def _home(results: Mapping[str, Any]) -> str:
    """Tell what claims came to in short, by `GROUPS`, with their picture."""
    counts = {claim["id"]: Count(**claim["count"]) for claim in (*results["claims"], *results["behaviours"])}
    phrases = totals([(claim["id"], Count(**claim["count"])) for claim in results["claims"]])
    lines = [
        f"**{phrases[0]}** in the last whole reproduction.",
        "",
        "| about | what became of the claims |",
        "|---|---|",
    ]
    for about, claims in GROUPS.items():
        ids = [claim for claim in claims if claim in counts]
        lines.append(f"| {about} | {_cell('; '.join(_short_words(ids, counts)))} |")
    picture = _sheet(results, "claims.svg")[:1]
    return "\n".join([*lines, *([""] if picture else []), *picture]) + "\n"


def _short_words(claims: Sequence[str], counts: Mapping[str, Count]) -> list[str]:
    """Say which claims have which word; of those with too few replicates for one, in how many they held."""
    by_kind: dict[Kind, list[str]] = {kind: [] for kind in SIGNS}
    for claim in claims:
        by_kind[counts[claim].kind].append(claim)
    counted = by_kind.pop("counted")
    named = [
        f"{SIGNS[kind]} {'not judged' if kind == 'unjudged' else kind}: {', '.join(ids)}"
        for kind, ids in by_kind.items()
        if ids
    ]
    return [*named, *(f"{claim} held in {counts[claim]}" for claim in counted)]


def _sheet(results: Mapping[str, Any], path: str = SHEET.relative_to(ROOT).as_posix()) -> list[str]:
    """Show the picture of all claims, at ``path`` from the page; nothing where the results have no readings."""
    if not claim_sheet.has_readings(results):
        return []
    claims = [*results["claims"], *results["behaviours"]]
    return [f"![{claim_sheet.described(claims)}]({path})", "", claim_sheet.KEY, ""]


def _kinds(claims: Sequence[str], counts: Sequence[Count | None]) -> str:
    """Say which claims hold, hold sometimes, fail, were not run, and of those without a word their counts."""
    pairs = [(claim, count) for claim, count in zip(claims, counts, strict=True) if count is not None]
    parts = []
    for word, heading in (("holds", "hold"), ("sometimes", "sometimes"), ("fails", "fail")):
        ids = [claim for claim, count in pairs if count.word == word]
        parts += [f"{heading}: {', '.join(ids)}"] if ids else []
    parts += [f"{claim}: {count}" for claim, count in pairs if not count.word]
    without = [claim for claim, count in zip(claims, counts, strict=True) if count is None]
    missing = [claim for claim in without if claim in (*registry.answering(), *claim_ids(BEHAVIOURS))]
    return "; ".join([*parts, *([f"{NOT_RUN}: {', '.join(missing)}"] if missing else [])]) or NEITHER


def _totals(results: Mapping[str, Any]) -> str:
    claims, scale, seed = results["claims"], results["design"]["scale"], results["design"]["seed"]
    sentence = "; ".join(totals([(claim["id"], Count(**claim["count"])) for claim in claims]))
    return (
        f"{sentence}. A replicate has {scale['repeats']} repeats of each of the robot's conditions, or every clip, at "
        f"one seed; replicate 0 has seed {seed}. Measured by commit {results['measured_with']['commit']}."
        f"{f' {STALE}' if stale(results) else ''}"
    )


def _claims(results: Mapping[str, Any]) -> str:
    lines = ["| claim | in all replicates | replicate 0 | decided there by |", "|---|---|---|---|"]
    for claim in results["claims"]:
        outcome, count = Outcome(**claim["outcome"]), Count(**claim["count"])
        broken = f"; all replicates: {claim['rate']}" if claim["rate"] else ""
        held, equal = _cell(count.sentence()), claim.get("equal_outcome")
        beside = f"; on equal terms {equal['verdict']}: {Outcome(**equal).deciding}" if equal else ""
        lines.append(f"| {claim['id']} | {held} | {outcome.verdict} | {_cell(outcome.deciding + broken + beside)} |")
    lines += ["", "Used to choose a reading of the paper:", ""]
    readings: dict[str, list[str]] = {}
    for claim in results["claims"]:
        for reading in used_to_choose(claim["id"]):
            readings.setdefault(reading.name, []).append(claim["id"])
    every = len(results["claims"])
    for reading, ids in readings.items():
        lines.append(f"- {reading}: {'all claims' if len(ids) == every else ', '.join(ids)}")
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
    parser.add_argument("run", type=Path, nargs="?", help="folder of a finished colias reproduce")
    parser.add_argument("--check", action="store_true", help="take nothing over: refuse figures that are stale")
    parser.add_argument("--root", type=Path, default=ROOT, help="folder of the pages, and of docs/results.json")
    given = parser.parse_args()
    root: Path = given.root
    if given.check == (given.run is not None):
        parser.error("give the folder of a run, or --check")
    if given.check:
        why = unfit(json.loads((root / RESULTS.relative_to(ROOT)).read_text(encoding="utf-8")))
        sys.exit(_refuse(why) if why else 0)
    try:
        results = taken(given.run)
        parts = blocks(results)
        pages = {
            root / page: renewed(page, (root / page).read_text(encoding="utf-8"), {name: parts[name] for name in names})
            for page, names in PAGES.items()
        }
    except NotFinished as error:
        sys.exit(_refuse(str(error)))
    files = {root / RESULTS.relative_to(ROOT): _as_json(results), **pages}
    if claim_sheet.has_readings(results):
        files[root / SHEET.relative_to(ROOT)] = claim_sheet.sheet(results)
    for path, text in files.items():
        path.write_text(text, encoding="utf-8")


def _as_json(results: Mapping[str, Any]) -> str:
    return json.dumps(results, indent=1, allow_nan=False) + "\n"


def _refuse(text: str) -> int:
    print(f"numbers: {text}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    main()

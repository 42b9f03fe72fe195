"""Results that the documentation shows: which runs they are of, and whether these still come out so.

    python -m tools.results take RUN... PLACE...   # note finished runs and what shows them
    python -m tools.results reproduction RUN       # take over a finished colias reproduce --full and renew the pages
    python -m tools.results check                  # refuse what is of no run, was changed since, or comes out otherwise

``docs/sources.json`` has of each run the command that makes it again, the commit, the numbers of its first trial and
the SHA-256 of what shows it: a picture in docs/ (``map-c6.png``), or a table of a page (``results/index.md#c13-c19``)
between ``<!-- table: c13-c19 -->`` and its end. ``docs/results.json`` has the verdicts and scores of the reproduction;
what stands between ``<!-- measured: NAME -->`` and its end is written from it.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
import re
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import polars as pl

from experiments.base.files import read_parquet
from experiments.declare.claim import BEHAVIOURS, PAPER, claim_ids, texts
from experiments.draw.terminal import SIGNS, seen_as
from experiments.judge.verdict import Count, Verdict, count_of, verdicts as stored_verdicts
from experiments.kinds import registry
from experiments.kinds.result import plan_of
from experiments.paper.page import Scale
from experiments.paper.reproduce import design
from experiments.paper.studies import why
from experiments.paper.studies.robot import EYES, FIDELITY, WHEELS
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import read_description
from experiments.store.provenance import UNREPEATABLE

ROOT = Path(__file__).parents[1]
SOURCES, RESULTS = Path("docs") / "sources.json", Path("docs") / "results.json"
SHOWN_TABLE = re.compile(r"<!-- table: ([\w-]+) -->\n(.*?)<!-- end of table -->", re.DOTALL)
MEASURED = re.compile(r"(<!-- measured: (\w+) -->\n).*?(<!-- end of measured -->)", re.DOTALL)
SUMMARY: Mapping[str, str] = {
    "C14": "The sign of HS tells the direction of a crossing",
    "C15": "Spikes peak near 6 cm/s: rightward, in the arena `bright`; the default camera's exposure is fixed",
    "C29": "The peak stays when one time window counts the spikes of all speeds",
    "C16": "Spikes fall with distance",
    "C13": "Straight approach and recession give no spikes",
    "C32": "Nine in ten straight approaches and recessions give no spikes",
    "C17": "An approach straight ahead gives the fewest spikes",
    "C19": "A recession straight ahead gives the fewest spikes",
}
"""Claim -> its words in the summary."""
CELLS = tuple(product(EYES, WHEELS))
"""Every eye and drive of the study `fidelity`; the first are those of a reproduction."""
DRAWN = ("eye.png", "layers.png")
"""Pictures of docs/ that show no run: `tools.eye` draws them."""
FIRST = "parts/000000-trials.parquet"
"""The first trial of a run that is under way."""
HEADS = ("robot's camera, 30 steps/s", "on equal terms", "gamma on, 15 steps/s", "gamma on, metered, 15 steps/s")
SUMMED = dict(zip(why.CORNERS, HEADS, strict=True))
"""Corner of the study `why` that the summary shows -> its head."""


def read(path: Path) -> Any:
    """Return the JSON in a file."""
    return json.loads(path.read_text(encoding="utf-8"))


def write(path: Path, value: Any) -> None:
    """Write JSON into a file."""
    path.write_text(json.dumps(value, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def places(root: Path) -> dict[str, str]:
    """Return what the documentation shows of runs: each picture and table, and its SHA-256."""
    docs = root / "docs"
    pictures = [path for path in docs.glob("*") if path.suffix in (".png", ".webp") and path.name not in DRAWN]
    shown = {path.name: path.read_bytes() for path in sorted(pictures)}
    for page in _pages(docs):
        tables = SHOWN_TABLE.findall(page.read_text(encoding="utf-8"))
        shown |= {f"{page.relative_to(docs).as_posix()}#{name}": text.encode() for name, text in tables}
    return {place: hashlib.sha256(content).hexdigest() for place, content in shown.items()}


def tables_of(run: Path) -> list[Path]:
    """Return the tables of a run's trials: its own, or those of its parts in the order in which they ended."""
    parts = sorted(run.glob("*/trials.parquet"), key=lambda path: path.stat().st_mtime)
    return [run / "trials.parquet"] if (run / "trials.parquet").is_file() else parts


def _pages(docs: Path) -> list[Path]:
    return sorted(page for page in docs.rglob("*.md") if page.relative_to(docs).parts[0] != "generated")


def note(run: Path, shows: Sequence[str], root: Path) -> dict[str, Any]:
    """Return what ``docs/sources.json`` has of a finished run.

    Parameters
    ----------
    run
        Its folder.
    shows
        Pictures in docs/, and tables as ``PAGE#NAME``.
    root
        The folder of docs/.

    Exits with a message where docs/ has no such place, or the run is of code that nobody can check out.
    """
    there = places(root)
    if unknown := [place for place in shows if place not in there]:
        sys.exit(f"docs/ has no {unknown[0]}; it has {', '.join(there)}")
    (part, *_), line = tables_of(run), read_description(run)["command"]["line"]
    commit = provenance.commit(read_description(part.parent)["source"])  # a leaderboard's parts alone know their code
    if not commit or not re.fullmatch("[0-9a-f]+", commit):
        sys.exit(f"{run} is of commit {commit}, which nobody can check out")
    for at in sorted(map(line.index, {"--out", "--workers"} & {*line}), reverse=True):  # neither changes a number
        del line[at : at + 2]
    return {
        "command": shlex.join(line),
        "commit": commit,
        "first": {} if line[0] == "train" else first_numbers(part),  # whose first trial comes after the training
        "shows": {place: there[place] for place in shows},
    }


def first_numbers(table: Path) -> dict[str, float]:
    """Return the numbers of a table's first trial that are not 0, by column, of its first model; none if it failed."""
    rows = read_parquet(table).filter(trial=0).drop(UNREPEATABLE, strict=False).to_dicts()
    return {name: value for row in rows[:1] for name, value in row.items() if isinstance(value, float) and value}


def differences(source: Mapping[str, Any]) -> dict[str, float | None]:
    """Run a noted command until its first trial is there; return the noted numbers that differ, ``None`` if gone."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        line = [*shlex.split(source["command"]), "--out", str(out), "--workers", "0", "--quiet"]
        with subprocess.Popen([sys.executable, "-P", "-m", "experiments.cli", *line]) as process:
            while process.poll() is None and not any(out.rglob(FIRST)):
                time.sleep(0.1)
            process.kill()
        now = first_numbers(next(out.rglob(FIRST), None) or tables_of(out)[0])
    return {name: now.get(name) for name, value in source["first"].items() if now.get(name) != value}


def check(root: Path) -> None:
    """Exit with a message for what is of no run, was changed since, or comes out otherwise now."""
    sources, results, there = read(root / SOURCES), read(root / RESULTS), places(root)
    for name, source in sources.items():
        for place, digest in source["shows"].items():
            if there.get(place) != digest:
                sys.exit(f"docs/{place} was changed since it was taken from the run {name}")
    if new := there.keys() - {place for source in sources.values() for place in source["shows"]}:
        sys.exit(f"docs/sources.json has no run of {', '.join(sorted(new))}")
    for page, text in renewed(root, results).items():
        if page.read_text(encoding="utf-8") != text:
            sys.exit(f"{page} has other numbers than {RESULTS}")
    measured, commit = results["design"], results["measured_with"]["commit"]
    scale = Scale(**{**measured["scale"], "offline": tuple(measured["scale"]["offline"])})
    now = design(plan_of(Asked(kind="reproduction", declared=scale, seed=measured["seed"])))["digest"]
    if "with changes" in commit + results["eyes"]["commit"] or now != measured["digest"]:
        sys.exit(f"the reproduction, of commit {commit}, has another design than the code: run make numbers")
    for name, source in sources.items():
        if source["first"] and (other := differences(source)):
            sys.exit(f"{name}: the first trial of colias {source['command']} has other numbers: {other}")
        print(f"results: {name} comes out as noted", file=sys.stderr)


def taken(run: Path, before: Mapping[str, Any]) -> dict[str, Any]:
    """Return what ``docs/results.json`` has of a finished reproduction, and of the study of eyes and drives.

    Parameters
    ----------
    run
        The reproduction's folder.
    before
        What the file has now: its study stays where the folder has none.
    """
    designed = read(run / "design.json")
    verdicts = [*stored_verdicts(read(run / "claims.json")), *stored_verdicts(read(run / "behaviours.json"))]
    scores = [pl.read_csv(path, infer_schema=False) for path in sorted(run.glob("behave-*/summary.csv"))]
    commits = {_commit(table.parent) for table in tables_of(run) if FIDELITY.name not in table.relative_to(run).parts}
    return {
        "design": {name: designed[name] for name in ("seed", "scale", "digest")},
        "measured_with": {"commit": " and ".join(sorted(commits)), **designed["versions"]},
        "claims": [_kept(verdict) for verdict in verdicts],
        "eyes": next((study_of(path) for path in run.glob(f"**/{FIDELITY.name}.json")), before.get("eyes")),
        "map": next((study_of(path) for path in run.glob(f"**/{why.STUDY.name}.json")), before.get("map")),
        "scores": pl.concat(scores, how="diagonal").to_dicts(),
    }  # fmt: skip


def _commit(folder: Path) -> str:
    """Return the commit of the code that wrote a run."""
    return provenance.commit(read_description(folder)["source"]) or "unknown"


def study_of(study: Path) -> dict[str, Any]:
    """Return the commit of a finished study, and its counts at the points that have all of its replicates."""
    described = read(study)
    rows = [
        {name: row[name] for name in (*described["axes"], "claim")} | {"count": dataclasses.asdict(count_of(row))}
        for row in described["counts"]
        if count_of(row).replicates == described["replicates"]
    ]
    return {"commit": _commit(tables_of(study.parent)[0].parent), "counts": rows}


def _kept(verdict: Verdict) -> dict[str, Any]:
    """Return what is kept of a verdict."""
    decided, outcome = verdict.outcome.deciding, verdict.outcome
    if outcome.equal:
        decided += f"; on equal terms {outcome.equal.verdict}: {outcome.equal.deciding}"
    count, equal = dataclasses.asdict(verdict.count), verdict.equal and dataclasses.asdict(verdict.equal)
    return {"id": verdict.id, "count": count, "equal_terms": equal, "measured": outcome.measured, "decided": decided}


def renewed(root: Path, results: Mapping[str, Any]) -> dict[Path, str]:
    """Return each page that has measured parts, with its text as the results have it."""
    parts = {"summary": summary, "claims": claims, "cameras": cameras, "own": own, "behaviours": behaviours}
    pages = [root / "README.md", *_pages(root / "docs")]
    return {
        page: MEASURED.sub(lambda part: f"{part[1]}{parts[part[2]](results)}{part[3]}", text)
        for page, text in ((page, page.read_text(encoding="utf-8")) for page in pages)
        if MEASURED.search(text)
    }


def markdown(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    escaped = ([cell.replace("|", r"\|").replace("\n", " ") for cell in row] for row in rows)
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|", *(f"| {' | '.join(row)} |" for row in escaped)]
    return "\n".join(lines) + "\n"


def counts(results: Mapping[str, Any]) -> dict[str, list[Count | None]]:
    """Return claim of the paper -> its count under each eye and drive of `CELLS`; ``None`` where it was not run."""
    eyes = {(row["claim"], row["eye"], row["wheels"]): Count(**row["count"]) for row in results["eyes"]["counts"]}
    return {
        claim["id"]: [Count(**claim["count"]), *(eyes.get((claim["id"], *cell)) for cell in CELLS[1:])]
        for claim in results["claims"]
        if claim["id"] in claim_ids(PAPER)
    }


def verdict(count: Count | None) -> str:
    """Say a claim's verdict with its sign, and in how many replicates it held."""
    if count is None:
        return "not run"
    held = str(count) if count.random else "at any seed"
    return f"{SIGNS[seen_as(count)]} {f'{count.word} ({held})' if count.word else held}"


def summary(results: Mapping[str, Any]) -> str:
    """Tell what claims of the robot came to, with the default camera and in the corners of the study `why`."""
    default = {claim: under[0] for claim, under in counts(results).items()}
    corners = {(row["claim"], row["gamma"], f"{row['steps a second']:g}"): Count(**row["count"])
               for row in results["map"]["counts"]}  # fmt: skip
    rows = [[f"{says} ({claim})", verdict(default.get(claim)),
             *(verdict(corners.get((claim, *corner))) for corner in SUMMED)]
            for claim, says in SUMMARY.items()]  # fmt: skip
    heads = ("claim", "default camera (fixed, bright exposure)", *SUMMED.values())
    return _commits(results) + markdown(heads, rows)


def _commits(results: Mapping[str, Any]) -> str:
    commits = results["measured_with"]["commit"], results["eyes"]["commit"], results["map"]["commit"]
    return "Measured by commit {}; cameras and drives by {}, gamma and steps by {}.\n\n".format(*commits)


def cameras(results: Mapping[str, Any]) -> str:
    """Tell what each claim about the robot came to under each camera and drive."""
    rows = [[f"{texts()[claim]['title']} ({claim})", *map(verdict, under)] for claim, under in counts(results).items()
            if claim in registry.answering()]  # fmt: skip
    return markdown(["claim", *(f"{eye} eye, {drive}" for eye, drive in CELLS)], rows)


def claims(results: Mapping[str, Any]) -> str:
    """Tell of the paper's claims, in a table for each of its figures, what `_told` tells of them."""
    by_figure: dict[str, list[Mapping[str, Any]]] = {}
    for claim in results["claims"]:
        if claim["id"] in claim_ids(PAPER):
            by_figure.setdefault(texts()[claim["id"]]["source"].removesuffix(" and its text"), []).append(claim)
    return _commits(results) + "\n".join(f"### {figure}\n\n{_told(told)}" for figure, told in by_figure.items())


def own(results: Mapping[str, Any]) -> str:
    """Tell of our own claims, about behaviours, what `_told` tells of them."""
    return _told([claim for claim in results["claims"] if claim["id"] in claim_ids(BEHAVIOURS)])


def _told(claims: Iterable[Mapping[str, Any]]) -> str:
    """Tell of each claim its words, its verdict, and the number that decided in replicate 0, with its bound."""
    rows = []
    for claim in claims:
        words, count = texts()[claim["id"]], Count(**claim["count"])
        says = f"**{words['title']}** ({claim['id']}): {words['says']}."
        if "implied" in words:
            says += " The equations imply it."
        equal = f"; on equal terms {verdict(Count(**claim['equal_terms']))}" if claim["equal_terms"] else ""
        cause = f". *Why:* {words.get('cause', 'Not known.')}" if count.word in ("fails", "sometimes") else ""
        rows.append([says, verdict(count) + equal, claim["decided"] + cause])
    return markdown(("claim", "verdict", "what decided in replicate 0"), rows)


def behaviours(results: Mapping[str, Any]) -> str:
    """Tell the scores of each behaviour in each env, with their intervals."""
    measured: dict[tuple[str, str], list[str]] = {}
    for row in results["scores"]:
        value, low, high = (f"{float(row[name] or 'nan'):.3g}" for name in ("value", "ci_low", "ci_high"))
        text = f"{row['measure']} {value}" + ("" if low == "nan" else f" ({low} .. {high})")
        measured.setdefault((row["env"].partition("/")[2], f"`{row['behaviour']}`"), []).append(text)
    heads = ("env", "behaviour", "measures, with 95 % intervals")
    return markdown(heads, ([*key, "; ".join(texts)] for key, texts in measured.items()))


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> None:
    """Take runs, take a reproduction, or check all; exit with a message where something is stale."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.results", description="Results that the documentation shows."
    )
    parser.add_argument("action", choices=("take", "reproduction", "check"))
    parser.add_argument("words", nargs="*", metavar="RUN... PLACE", help="folders, then pictures and tables in docs/")
    given = parser.parse_args(arguments)
    runs = [Path(word) for word in given.words if Path(word).is_dir()]
    if given.action == "check":
        check(root)
    elif given.action == "take":
        shows = [word for word in given.words if Path(word) not in runs]
        write(root / SOURCES, read(root / SOURCES) | {run.name: note(run, shows, root) for run in runs})
    else:
        write(root / RESULTS, taken(runs[0], read(root / RESULTS)))
        for page, text in renewed(root, read(root / RESULTS)).items():
            page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()

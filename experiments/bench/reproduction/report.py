"""The report of a reproduction: one self-contained page."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from experiments.bench.clips.constants import COMPARING
from experiments.bench.clips.experiment import OfflineExperiment
from experiments.bench.clips.judging.assumed import deciding
from experiments.bench.clips.summary import OfflineReport
from experiments.bench.closed_loop.run import Played
from experiments.bench.core.claims.replicates import UNKNOWN
from experiments.bench.core.claims.texts import claim_texts
from experiments.bench.core.figures.plotting import STYLE
from experiments.bench.core.store.description import plain
from experiments.bench.core.store.files import Files
from experiments.bench.core.verdict import Outcome, Verdict
from experiments.bench.reproduction import chapters, robustness
from experiments.bench.reproduction.claims import is_random
from experiments.bench.reproduction.mechanisms import constants
from experiments.bench.reproduction.plan import WHOLE
from experiments.bench.reproduction.reproduce import Reproduction
from experiments.bench.robot.experiment import Drawing
from experiments.bench.robot.plan import Plan
from experiments.bench.robot.rows import varying
from experiments.bench.robot.summary import Report

SHADES = {"holds": "#2a9d8f", "fails": "#b5485d", "vacuous": "#e9dcb5", "untestable": "#b9c4dd", "untested": "#cfcfcf"}
SIGNS = {"holds": "holds", "fails": "fails", "vacuous": "vacuous", "untestable": "untestable", "untested": "-"}


ALTS: Mapping[Drawing, str] = {
    "spikes": "Spikes of every trial of {name}, and the HS potential over each",
    "mechanism": "Spikes, time in view, firing rate and HS potential of {name}",
    "excitation": "Excitation, weighted inhibition, HS and spikes over the trials of {name}",
}
"""What a figure is, for who cannot see it."""
TOTALS = (
    "held in every replicate", "held in some, not in every replicate", "held in no replicate",
    "vacuous in every replicate", f"untestable: {UNKNOWN}", "not judged",
)  # fmt: skip
TONES = ("holds", "mixed", "fails", "vacuous", "untestable", "untested")


def write(result: Reproduction) -> Path:
    """Write ``report.html`` and ``sensitivity.svg`` into the reproduction's folder; return the former's path."""
    folder = Files(result.folder)
    matrix = sensitivity_figure(result.sensitivity) if result.sensitivity else ""
    if matrix:
        folder.write_text("sensitivity.svg", matrix)
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    source = files("experiments.bench.reproduction").joinpath("report.html.j2").read_text(encoding="utf-8")
    page = environment.from_string(source).render(
        result=result,
        counted=totals(result.claims),
        tones={claim.id: tone(claim) for claim in result.claims},
        listed=sum(bool(claim.experiment) for claim in result.claims),
        unjudged=[
            *(claim.id for claim in result.claims if claim.verdict == "untested"),
            *(claim.id for claim in result.own_claims if claim.verdict == "untested"),
        ],
        chapters=chapters.rendered(result.folder),
        runs=[_run(plan, report) for plan, report in result.runs],
        shows=[_show(report) for report in result.offline],
        loops=[_loop(played) for played in result.behaviours],
        whole=WHOLE,
        unknown=UNKNOWN,
        constants={claim: _choices(constants(claim, result.offline)) for claim in COMPARING},
        places=_places(result),
        matrix=_inline(matrix.encode()) if matrix else "",
        parameters=json.dumps(result.description, indent=2, default=plain),
        versions=result.description["versions"],
    )
    folder.write_text("report.html", page)
    return result.folder / "report.html"


def _choices(found: Mapping[str, Outcome]) -> list[tuple[str, str, str]]:
    """Each choice of another model's constants, whether the claim holds with it, and the number that decides."""
    return [
        (choice, "holds" if each.verdict == "holds" else "does not hold", deciding(each))
        for choice, each in found.items()
    ]


def _places(result: Reproduction) -> set[str]:
    """The names of the experiments that have a place on the page."""
    return {plan.experiment.name for plan, _ in result.runs} | {
        report.plan.experiment.name for report in result.offline
    }


def totals(claims: Sequence[Verdict]) -> dict[str, list[str]]:
    """Return what claims came to over all replicates, in words -> the ids of those claims; without the empty ones."""
    found: dict[str, list[str]] = {name: [] for name in TOTALS}
    for claim in claims:
        found[_total(claim)].append(claim.id)
    return {said: own for said, own in found.items() if own}


def _total(claim: Verdict) -> str:
    if not claim.replicates or claim.standing == "unjudged":
        return "not judged"
    if claim.standing == "untestable":
        return f"untestable: {UNKNOWN}"
    if claim.replicates_vacuous == claim.replicates:
        return "vacuous in every replicate"
    held = claim.replicates_held or 0
    return f"held in {'every' if held == claim.replicates else 'some, not in every' if held else 'no'} replicate"


def tone(claim: Verdict) -> str:
    """Return the colour of a claim on the page, which goes by all replicates: the name of its class."""
    return "holds" if claim.standing == "robust" else dict(zip(TOTALS, TONES, strict=True))[_total(claim)]


def sensitivity_figure(verdicts: Mapping[str, Mapping[str, Outcome]]) -> str:
    """One matrix as SVG: what was moved, down; claims, across; the verdict in words and colour."""
    claims, names = robustness.ROBOT_CLAIMS, list(verdicts)
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(7.2, 0.6 + 0.3 * len(names)), layout="constrained")
        axes = drawn.subplots()
        for row, name in enumerate(names):
            for column, claim in enumerate(claims):
                verdict = verdicts[name][claim].verdict
                axes.barh(row, 0.94, left=column - 0.47, height=0.88, color=SHADES[verdict])
                axes.text(column, row, SIGNS[verdict], ha="center", va="center", fontsize=8,
                          color="white" if verdict in ("holds", "fails") else "black")  # fmt: skip
        axes.set_xticks(range(len(claims)), claims)
        axes.set_yticks(
            range(len(names)), ["defaults (replicate 0)" if name == robustness.MODEL else name for name in names]
        )
        axes.xaxis.tick_top()
        axes.tick_params(length=0)
        axes.spines[:].set_visible(False)
        axes.set(xlim=(-0.5, len(claims) - 0.5), ylim=(len(names) - 0.5, -0.5))
        stream = io.StringIO()
        drawn.savefig(stream, format="svg", metadata={"Date": None})
    return stream.getvalue()


def _run(plan: Plan, report: Report) -> dict[str, Any]:
    """What the page shows of one experiment."""
    figure = report.folder / "figure.svg"
    names = varying(report.rows, report.varies) if report.rows else []
    spikes = [row for row in report.summary if row["quantity"] == "spikes"]
    return {
        "name": plan.experiment.name,
        "summary": plan.experiment.summary,
        "figure": _inline(figure.read_bytes()) if report.rows else "",
        "alt": ALTS[plan.experiment.figure].format(name=plan.experiment.name),
        "columns": names,
        "conditions": [[_cell(row[name]) for name in names] for row in spikes],
        "spikes": spikes,
        "comparisons": report.comparisons,
        "tests": "; ".join(sorted({row["test"] for row in report.comparisons})),
        "condition_names": [name for name in names if name != "model"],
        "recordings": sorted(f"{plan.experiment.name}/recordings/{path.name}" for path in
                             (report.folder / "recordings").glob("*.rrd")),
        "failures": report.failures,
        "flaws": report.flaws,
    }  # fmt: skip


def _show(report: OfflineReport) -> dict[str, Any]:
    """What the page shows of one off-line experiment."""
    experiment, figure = report.plan.experiment, report.folder / "figure.svg"
    return {
        "name": experiment.name,
        "summary": experiment.summary,
        "models": ", ".join(model.label for model in report.plan.showings[0].models),
        "clips": len(experiment.clips),
        "seeds": report.plan.repeats,
        "random": is_random(report),
        "drawn": _differs(experiment),
        "figure": _inline(figure.read_bytes()) if report.rows else "",
        "own": [verdict for verdict in report.verdicts if verdict.id not in claim_texts()],
        "failures": report.failures,
    }


def _differs(experiment: OfflineExperiment) -> bool:
    """Whether its first clip begins otherwise at another seed, as one before a photograph does."""
    first, second = (next(iter(experiment.clips[0].build(seed))).luma for seed in (0, 1))
    return not np.array_equal(first, second)


def _loop(played: Played) -> dict[str, Any]:
    """What the page shows of the behaviours in one env."""
    figure, standings = played.folder / "figure.svg", played.standings
    return {
        "name": played.folder.name,
        "env": played.env.partition("/")[2],
        "episodes": len(standings[0].rows) if standings else 0,
        "measures": list(standings[0].scores) if standings else [],
        "rows": [(each.name, [str(score) for score in each.scores.values()]) for each in standings],
        "figure": _inline(figure.read_bytes()) if standings else "",
        "failures": played.failures,
    }


def _cell(value: Any) -> str:
    return "" if value is None else value if isinstance(value, str) else f"{value:g}"


def _inline(svg: bytes) -> str:
    """A picture inside the page, under no name that could clash with another's."""
    return "data:image/svg+xml;base64," + base64.b64encode(svg).decode()

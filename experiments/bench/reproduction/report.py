"""The report of a reproduction: one self-contained page, rendered from the templates in ``page/``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from experiments.bench.engine.templates import render
from experiments.bench.figures import plotting
from experiments.bench.reproduction import eyes
from experiments.bench.reproduction.page.cards import cards, limits
from experiments.bench.reproduction.page.drawn import drawing
from experiments.bench.reproduction.page.overview import overview, tile
from experiments.bench.reproduction.page.sections import clip_section, loop_section, robot_section
from experiments.bench.reproduction.page.stored import stored
from experiments.bench.reproduction.page.studies import study_section
from experiments.bench.reproduction.plan import FULL
from experiments.bench.reproduction.reproduce import Reproduction
from experiments.bench.stats.count import LEAST_JUDGED, REASONS
from experiments.bench.stats.tests import LEVEL, least_of_pairs
from experiments.bench.store.description import plain
from experiments.bench.store.files import Files
from experiments.bench.studies import figure
from experiments.bench.studies.stored import studies
from experiments.bench.studies.study import WHOLE
from experiments.claims.readings import READINGS


def write(result: Reproduction) -> Path:
    """Write ``report.html`` and the figure of sensitivity into the reproduction's folder; return the former's path."""
    if result.sensitivity:
        plotting.save(figure.draw(result.sensitivity), result.folder, "sensitivity")
    Files(result.folder).write_text("report.html", page(result))
    return result.folder / "report.html"


def page(result: Reproduction) -> str:
    """Return the page of a reproduction: HTML without scripts that needs nothing from outside."""
    return render("reproduction/page/page.html.j2", **_context(result))


def _context(result: Reproduction) -> dict[str, Any]:
    """Every name that the templates use."""
    evidence = cards(result)
    runs = [robot_section(plan, report, evidence) for plan, report in result.runs]
    clips = [clip_section(report, evidence) for report in result.offline]
    loops = [loop_section(played) for played in result.behaviours]
    return {
        "result": result,
        "first": overview(result),
        "eye_headings": list(eyes.CELLS.values()),
        "eyes_command": eyes.SHOWN,
        "not_validated": eyes.NOT_VALIDATED,
        "cards": evidence,
        "own": [(tile(claim), claim, limits(claim, result.folder)) for claim in result.own_claims],
        "runs": runs,
        "clips": clips,
        "loops": loops,
        "seen": next((run.seen for run in runs if run.seen.strips), None),
        "anchors": {entry.name for entry in runs} | {entry.name for entry in clips},
        "common": [reading.name for reading in READINGS if reading.of_all],
        "moved": result.sensitivity is not None,
        "stored": stored(result.folder),
        "studies": [study_section(study) for study in studies(result.folder).values()],
        "drawing": drawing(result.folder),
        "whole": WHOLE,
        "least_p": least_of_pairs,
        "level": LEVEL,
        "reasons": REASONS,
        "least": LEAST_JUDGED,
        "full": FULL.replicates,
        "parameters": json.dumps(result.description, indent=2, default=plain),
        "versions": result.description["versions"],
    }

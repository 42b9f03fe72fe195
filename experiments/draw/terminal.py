"""What commands print of runs: verdicts, silent models, and where everything is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.text import Text

from experiments.base import palette
from experiments.base.console import out_console
from experiments.judge.count import Count
from experiments.judge.verdict import Verdict
from experiments.store.tables import PEAKS

SIGNS: Mapping[str, str] = {
    "holds": "\N{CHECK MARK}", "sometimes": "~", "fails": "\N{MULTIPLICATION X}", "unjudged": "\N{EN DASH}",
}  # fmt: skip
"""State of a verdict, as colours have it -> the sign that stands before it: colour alone tells no verdict."""


def seen_as(count: Count) -> str:
    """Return the state whose sign and colour a count has: without a word, whether it held in all, some or none."""
    if count.state != "counted":
        return count.state
    return "sometimes" if count.holds and count.fails else "holds" if count.holds else "fails"


def show_verdicts(verdicts: Sequence[Verdict], *, model: bool = False, provenance: str = "") -> None:
    """Print each verdict as one sentence: the claim, in how many replicates it held, and the number that decided.

    What else was measured stands in ``claims.json``.

    Parameters
    ----------
    verdicts
        The verdicts.
    model
        Whether to name the model that each is about.
    provenance
        Where the trials come from; empty where they are simulated.
    """
    skipped = {verdict.id: verdict.outcome.least for verdict in verdicts if verdict.outcome.least}
    for verdict in (verdict for verdict in verdicts if not verdict.outcome.least):
        counted = verdict.count
        who = f" ({verdict.model})" if model and verdict.model else ""
        origin = f" [{provenance}]" if provenance else ""
        sentence = f"{verdict.title or verdict.says}; {verdict.outcome.deciding}"
        if verdict.equal is not None and verdict.outcome.equal is not None:
            sentence += f"; on equal terms {verdict.equal.sentence()}: {verdict.outcome.equal.deciding}"
        state = seen_as(counted)
        label = Text(f"{SIGNS[state]} {counted.sentence()}", palette.VERDICTS[state][2])
        out_console.print(Text.assemble((verdict.id, "b"), f"{who} ", label, f"{origin}: {sentence}"))
    for least in sorted(set(skipped.values())):
        names, option = ", ".join(name for name in skipped if skipped[name] == least), f" (--repeats {least})"
        out_console.print(f"skipped, for want of {least} trials of each condition{option * (not provenance)}: {names}")


def show_silent(rows: Iterable[Mapping[str, Any]]) -> None:
    """Print which models are silent: whose potentials are 0 in all rows, and how dark and bright their frames were."""
    by_model: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        by_model.setdefault(row["model"], []).append(row)
    for model, seen in sorted(by_model.items()):
        if not any(row[end] for row in seen for end in PEAKS):
            greys = [row[end] for row in seen for end in ("darkest", "brightest") if row.get(end) is not None]
            range_of = f"; its frames had grey levels from {min(greys)} to {max(greys)}" if greys else ""
            out_console.print(f"{model} is silent: all its potentials are 0{range_of}")

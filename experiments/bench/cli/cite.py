"""The command ``colias cite``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from experiments.bench.store.record import Record

TITLE = "colias-sim: a simulated Colias micro-robot testbed for fly-inspired motion vision"
AUTHORS = "the colias-sim authors"
PAPER = """@misc{fu2018directionally,
  title = {A Directionally Selective Neural Network with Separated {ON} and {OFF} Pathways for Translational Motion
           Perception in a Visually Cluttered Environment},
  author = {Fu, Qinbing and Bellotto, Nicola and Yue, Shigang},
  year = {2018},
  eprint = {1808.07692},
  archiveprefix = {arXiv},
}"""
"""The paper whose network and experiments these are, as CITATION.cff has it."""


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Print what a paper needs to name a run: version, commit, digest, command, seeds.")(cite)


def cite(run: Annotated[Path, typer.Argument(help="Folder of a run.")]) -> int:
    """Print what a paper needs to name a run, as text and as BibTeX: of this software, and of the paper it reproduces.

    The digest is one over the whole record: experiment.json, which has the digests of your own files, and every row.
    [b]colias rerun --digest[/b] compares a folder with it.
    """
    from experiments.bench.engine.terminal import out_console
    from experiments.bench.store.record import Record

    record = Record.read(run)
    digest = record.digest()
    facts = _facts(record)
    for name, value in {**facts, "digest": digest}.items():
        out_console.print(f"{name:<10}{value}", soft_wrap=True, markup=False, highlight=False)
    out_console.print()
    out_console.print(_entry(facts, digest, record), soft_wrap=True, markup=False, highlight=False)
    out_console.print(PAPER, soft_wrap=True, markup=False, highlight=False)
    return 0


def _facts(record: Record) -> dict[str, str]:
    """Return what is to be said of a run, name -> text."""
    from experiments.bench.store import description
    from experiments.bench.store.commands import in_words

    parts = [record, *record.parts]
    first: dict[str, Any] = next((dict(part.description) for part in parts if "versions" in part.description), {})
    command = record.description.get(description.COMMAND)
    source = first.get("source") if isinstance(first.get("source"), dict) else {}
    renderers = dict.fromkeys(name for part in parts for name in part.description.get(description.RENDERERS, ()))
    return {
        "version": f"colias-sim {_of(first.get('versions'), 'colias-sim')}",
        "commit": _commit(source),
        "source": f"sha256 {_of(source, 'digest')}",
        "command": in_words(command) if isinstance(command, dict) else "not noted",
        "seeds": _seeds(parts),
        "renderer": "; ".join(map(str, renderers)) or "none: no frame was drawn",
        "begun": str(record.description.get(description.BEGUN, "not noted")),
        "ended": str(next((part.description[description.ENDED] for part in reversed(parts)
                           if description.ENDED in part.description), "not noted")),
    }  # fmt: skip


def _of(table: Any, name: str) -> str:
    return str(table[name]) if isinstance(table, dict) and table.get(name) else "not noted"


def _commit(source: Any) -> str:
    commit = _of(source, "commit")
    return f"{commit} with changes" if isinstance(source, dict) and source.get("dirty") else commit


def _seeds(parts: list[Record]) -> str:
    """Return the seed of the whole, and the number of seeds of its trials with the lowest and the highest."""
    of_whole = ", ".join(dict.fromkeys(str(part.seed) for part in parts if part.seed is not None)) or "none"
    drawn = {seed for part in parts if not part.kind.parts and "seed" in part.trials.schema.names
             for seed in part.trials["seed"].to_pylist() if seed is not None}  # fmt: skip
    ends = f"; {len(drawn)} of trials, {min(drawn)} to {max(drawn)}" if drawn else ""
    return f"{of_whole}{ends}"


def _entry(facts: dict[str, str], digest: str, record: Record) -> str:
    """Return the software as BibTeX."""
    year = f"  year = {{{record.begun.year}}},\n" if record.begun else ""
    version = facts["version"].removeprefix("colias-sim ")
    return (
        "@software{colias-sim,\n"
        f"  title = {{{TITLE}}},\n"
        f"  author = {{{{{AUTHORS}}}}},\n"
        f"  version = {{{version}}},\n{year}"
        f"  note = {{Commit {facts['commit']}; digest of the run {digest}}},\n"
        "}"
    )

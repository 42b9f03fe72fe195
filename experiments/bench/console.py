"""What a run shows of itself on the terminal: the plan, progress, the table of conditions, the verdicts."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from colias_sim.gl import require_backend
from experiments.bench.contents import robot_contents
from experiments.bench.courses import nominal
from experiments.bench.declaration import CONDITION_COLUMNS, TrialSpec
from experiments.bench.description import begun
from experiments.bench.plan import Plan, describe
from experiments.bench.pool import Pool, open_pool
from experiments.bench.progress import error_console as error_console
from experiments.bench.progress import progress
from experiments.bench.results import Failure, Finished, RunFolder, group, varying
from experiments.bench.runner import AnySpec, Keep, run_all
from experiments.bench.runner import work as trial

if TYPE_CHECKING:
    from experiments.bench.claims import Verdict
    from experiments.bench.conclusion import Report
    from experiments.bench.offline_run import OfflineReport, OfflineVerdict
    from experiments.bench.reproduce import ClaimReport
    from experiments.bench.sweep import Part, Point

SHOWN_FAILURES = 10

SHORT = {
    "speed_cm_s": "cm/s", "distance_cm": "cm", "far_cm": "far cm", "angle_deg": "deg", "shell_grey": "shell",
    "wall_contrast": "wall", "observer_speed_cm_s": "own cm/s", "observer_turn_deg_s": "own deg/s",
    "acceleration_cm_s2": "cm/s2",
}  # fmt: skip

out_console = Console(highlight=False, width=None if sys.stdout.isatty() else 100)


@dataclass(frozen=True, slots=True)
class Means:
    """What to run with: worker processes or a cluster's address, and whether to keep quiet."""

    workers: int
    cluster: str | None = None
    quiet: bool = False
    other_code: bool = False
    """Whether to go on with a run that other code began."""


def amount(plans: Sequence[Plan], means: Means) -> str:
    """The design check: trials, frames, and on what. How long it takes is told by the first trials."""
    trials = sum(len(plan.specs()) for plan in plans)
    frames = sum(plan.frames() for plan in plans)
    return f"{trials} trials, about {frames:,} frames, {where(means)}"


def count(number: int, thing: str) -> str:
    """``1 trial``, ``2 trials``."""
    return f"{number} {thing}{'s' * (number != 1)}"


def where(means: Means) -> str:
    """On what a run is: ``on 2 workers``."""
    return f"on {means.cluster or count(max(means.workers, 1), 'worker')}"


def seconds(spec: TrialSpec) -> float:
    """How long a trial lasts, as planned: what it costs goes by that."""
    return nominal(spec.condition, spec.settings).seconds


def announce(plans: list[Plan], more: int, folder: Path, means: Means) -> None:
    """The design check of a reproduction: its experiments, and how many trials its studies have."""
    said = f"{len(plans)} experiments: {amount(plans, means)}; then {more} trials of the studies"
    error_console.print(f"{said}, into {folder}", soft_wrap=True, markup=False)


def run(plan: Plan, out: Path, means: Means, resume: bool, recordings: bool) -> Report:
    """Run a checked plan with a pool of its own, and show it."""
    if means.cluster is None:
        require_backend()
    with ExitStack() as held:
        with open_pool(means.workers, means.cluster) as pool:
            folder = held.enter_context(closing(open_folder(plan, out, means, resume, recordings)))
            failures = run_with(plan, folder, pool, means, recordings)
        # Not before: it loads libraries that the trials do without.
        from experiments.bench.conclusion import conclude

        report = conclude(plan, folder, failures)
    if not means.quiet:
        show(report, recordings)
    return report


def open_folder(plan: Plan, out: Path, means: Means, resume: bool, recordings: bool) -> RunFolder:
    """The run's folder, made or reopened."""
    folder = RunFolder(out)
    contents = robot_contents(plan.specs(), recordings=recordings)
    folder.enter({**describe(plan), "recordings": recordings}, resume, contents, means.other_code)
    return folder


def run_with(plan: Plan, folder: RunFolder, pool: Pool, means: Means, recordings: bool) -> list[Failure]:
    """Run what a plan has left to do, with progress."""
    before = len(folder.done())
    if not means.quiet:
        resumed = f"; {before} of them done already" if before else ""
        said = f"{plan.experiment.name}: {amount([plan], means)}{resumed}, into {folder.folder}"
        error_console.print(said, soft_wrap=True, markup=False)
    return do(
        plan.experiment.name, plan.specs(), folder, pool, means, partial(trial, keep=Keep(recordings)), size=seconds
    )


def do(
    name: str, specs: Sequence[AnySpec], folder: RunFolder, pool: Pool, means: Means,
    work: Callable[[AnySpec], Finished], things: str = "trials", size: Callable[[AnySpec], float] = lambda _: 1.0,
) -> list[Failure]:  # fmt: skip
    """Do those ``specs`` that ``folder`` lacks, with progress, and name what failed; returns all that ever failed.

    ``size`` says how much work one is, in any unit. Says how far it got if it is cut short.
    """
    done = folder.done()
    sizes = {spec.index: size(spec) for spec in specs if spec.index not in done}
    with progress(name, len(sizes), means.quiet, things, width=pool.width, whole=sum(sizes.values())) as advance:
        try:
            failures = run_all(specs, folder, pool, lambda index: advance(sizes[index]), work)
        except BaseException:
            said = f"stopped after {len(folder.done())} of {len(specs)} {things}; they are in {folder.folder}"
            error_console.print(said, soft_wrap=True, markup=False)
            raise
    tell(failures, folder)
    return failures


def tell(failures: Sequence[Failure], folder: RunFolder) -> None:
    """Name what failed, the first few each, and what is to be known of the tables."""
    for note in folder.notes():
        error_console.print(f"note: {note}", soft_wrap=True, markup=False)
    for failure in failures[:SHOWN_FAILURES]:
        error_console.print(str(failure), soft_wrap=True, markup=False)
    if len(failures) > SHOWN_FAILURES:
        error_console.print(f"... {len(failures) - SHOWN_FAILURES} more: see failures.json")


def show(report: Report, recordings: bool) -> None:
    """The table of conditions, the verdicts, and where everything is."""
    if report.rows:
        out_console.print(_conditions_table(report))
    several = len({row["model"] for row in report.rows}) > 1
    for verdict in report.verdicts:
        colour = {"holds": "green", "fails": "red", "untested": "yellow"}[verdict.verdict]
        who = f" ({escape(verdict.model)})" if several else ""
        out_console.print(f"\n[b]{verdict.id}[/b]{who} [{colour}]{verdict.verdict}[/{colour}]: {verdict.says}")
        _show_numbers(verdict)
    if report.comparisons:
        out_console.print(_comparisons_table(report))
    if report.flaws:
        out_console.print(f"\n[red]beware[/red]: {report.flaws}")
    places: dict[str, object] = {"figure": report.folder / "figure.png"} if report.rows else {}
    places["tables"] = report.folder / "trials.parquet"
    if report.failures:
        places["failures"] = report.folder / "failures.json"
    if recordings and report.rows:
        places["recordings"] = f"colias view {shlex.quote(str(report.folder))}"
    out_console.print()
    for name, place in places.items():
        out_console.print(f"{name:<12}{place}", soft_wrap=True, markup=False)


def _show_numbers(verdict: Verdict | OfflineVerdict) -> None:
    """Below a verdict: the number that decided, everything measured, the effect."""
    decided = f"decided by: {verdict.decided}" if verdict.decided else ""
    for line in filter(None, (decided, verdict.measured, verdict.effect)):
        out_console.print(f"    {line}", markup=False)


def _comparisons_table(report: Report) -> Table:
    tests = "; ".join(sorted({row["test"] for row in report.comparisons}))
    table = Table(
        title=f"\nmodels on the same frames ({tests}; p after Holm)", title_justify="left", box=None,
        header_style="bold", pad_edge=False,
    )  # fmt: skip
    names = [name for name in varying(report.rows, report.varies) if name != "model"]
    for name in (*(SHORT.get(name, name) for name in names), "models", "n", "difference", "rank-biserial", "p"):
        table.add_column(name, no_wrap=True)
    for row in report.comparisons:
        table.add_row(
            *("-" if row[n] is None else row[n] if isinstance(row[n], str) else f"{row[n]:g}" for n in names),
            escape(f"{row['model']} - {row['against']}"),
            f"{row['n']}",
            f"{row['mean_difference']:+z.1f}",
            f"{row['rank_biserial']:+z.2f}",
            f"{row['p_holm']:.4f}",
        )
    return table


def show_offline(report: OfflineReport, recorded: bool) -> None:
    """The peaks of every clip at the first seed, the verdicts, and where everything is."""
    table = Table(title="potentials of each clip, first seed", title_justify="left", box=None, header_style="bold",
                  pad_edge=False)  # fmt: skip
    for name in ("clip", "model", "HS", "VS", "looming", "spikes"):
        table.add_column(name, justify="left" if name in ("clip", "model") else "right", no_wrap=True)
    for row in (row for row in report.rows if row["repeat"] == 0):
        ranges = (f"{row[f'trough_{system}']:+z.3f} .. {row[f'peak_{system}']:+z.3f}" for system in ("hs", "vs"))
        table.add_row(
            escape(row["clip"]), escape(row["model"]), *ranges, f"{row['peak_looming']:.2f}", f"{row['spikes']}"
        )
    out_console.print(table)
    for verdict in report.verdicts:
        colour = {"holds": "green", "fails": "red", "untested": "yellow"}[verdict.verdict]
        seeds = f" (at {verdict.seeds_holding} of {verdict.seeds} seeds)" if verdict.seeds > 1 else ""
        out_console.print(f"\n[b]{verdict.id}[/b] [{colour}]{verdict.verdict}[/{colour}]{seeds}: {verdict.says}")
        _show_numbers(verdict)
    out_console.print()
    places: dict[str, object] = {"figure": report.folder / "figure.png"} if report.rows else {}
    if recorded and report.rows:
        places["recordings"] = f"colias view {shlex.quote(str(report.folder))}"
    for name, place in {**places, "tables": report.folder / "trials.parquet"}.items():
        out_console.print(f"{name:<12}{place}", soft_wrap=True, markup=False)


def show_claims(claims: Sequence[ClaimReport]) -> None:
    """The claims tested, with at how many seeds they hold and the number that decided; then those that were not."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("claim", "verdict", "seeds", "the paper says"):
        table.add_column(name, no_wrap=name != "the paper says")
    for claim in claims:
        if claim.experiment:
            colour = {"holds": "green", "fails": "red", "untested": "yellow"}[claim.verdict]
            unjudged = f" ({claim.seeds_untested} untested)" if claim.seeds_untested else ""
            seeds = "-" if claim.seeds is None else f"{claim.seeds_holding} of {claim.seeds}{unjudged}"
            decided = claim.decided or claim.measured.partition("; measured:")[0]
            said = f"{claim.says}\n[dim]{escape(decided)}[/dim]"
            table.add_row(claim.id, f"[{colour}]{claim.verdict}[/{colour}]", seeds, said)
    out_console.print(table)
    others = [claim.id for claim in claims if not claim.experiment]
    if others:
        out_console.print(f"\nnot judged: {', '.join(others)}; the report says what each would take")


def sweep(parts: Sequence[Part], points: Sequence[Point], varies: str, out: Path, means: Means) -> bool:
    """Run what is missing of a sweep's parts, write table and figure, show them; true if trials failed."""
    rows: list[dict[str, Any]] = []
    failed = False
    if (out / "sweep.csv").exists():
        raise FileExistsError(f"{out} already holds a sweep: choose another --out, or remove it")
    if means.cluster is None:
        require_backend()
    if not means.quiet and len(parts) > 1:
        whole_plan = amount([part.plan for part in parts], means)
        error_console.print(f"{len(points)} points: {whole_plan}, into {out}", soft_wrap=True, markup=False)
    with open_pool(means.workers, means.cluster) as pool:
        for part in parts:
            place = out / part.folder
            with closing(open_folder(part.plan, place, means, begun(place), recordings=False)) as folder:
                failed |= bool(run_with(part.plan, folder, pool, means, recordings=False))
                rows += part.tagged(folder.rows())
    from experiments.bench import sweep as grids

    if not rows:
        return failed
    keys = [key for key, _ in points[0].values]
    table = grids.table(rows, keys)
    title = f"{parts[0].plan.experiment.name}, n = {parts[0].plan.repeats}"
    picture = grids.write_figure(grids.draw(rows, keys, varies, title), out)
    # Last, as it makes the sweep a whole one, which is not gone on with.
    RunFolder(out).write_rows("sweep.csv", table)
    if not means.quiet:
        out_console.print(_sweep_table(table, grids.telling(rows, keys, varies), varies))
        for name, place in {"figure": picture, "table": out / "sweep.csv"}.items():
            out_console.print(f"{name:<12}{place}", soft_wrap=True, markup=False)
    return failed


def _sweep_table(rows: Sequence[dict[str, Any]], keys: Sequence[str], varies: str) -> Table:
    table = Table(title="mean spikes per trial", title_justify="left", box=None, header_style="bold", pad_edge=False)
    levels = list(dict.fromkeys(row[varies] for row in rows))
    for name in (
        *(SHORT.get(key, key) for key in keys),
        *(v if isinstance(v, str) else f"{v:g} {SHORT.get(varies, varies)}" for v in levels),
    ):
        table.add_column(name, justify="right")
    for values, chosen in group(rows, *keys).items():
        means = {level: [r["spikes_mean"] for r in chosen if r[varies] == level] for level in levels}
        said = ("-" if v is None else escape(v) if isinstance(v, str) else f"{v:g}" for v in values)
        table.add_row(*said, *(f"{sum(m) / len(m):.1f}" if m else "-" for m in means.values()))
    return table


def _conditions_table(report: Report) -> Table:
    table = Table(
        title="HS spikes per trial; highest and lowest HS",
        title_justify="left",
        box=None,
        header_style="bold",
        pad_edge=False,
    )
    conditions = group(report.summary, "model", *CONDITION_COLUMNS)
    names = varying(report.rows, report.varies)
    for name in names:
        text = name in ("model", "motion", "direction")
        table.add_column(SHORT.get(name, name), justify="left" if text else "right", no_wrap=True)
    several = "model" in names  # then there is no room for the rate
    for name in ("n", "mean", "95 %", *([] if several else ["rate Hz"]), "peak", "trough"):
        table.add_column(name, justify="right", no_wrap=True)
    for chosen in conditions.values():
        values, rows = chosen[0], {row["quantity"]: row for row in chosen}
        spikes = rows["spikes"]
        table.add_row(
            *("-" if v is None else escape(v) if isinstance(v, str) else f"{v:g}" for v in (values[n] for n in names)),
            f"{spikes['n']}",
            f"{spikes['mean']:.1f}",
            "-" if spikes["ci_low"] is None else f"{spikes['ci_low']:.1f} .. {spikes['ci_high']:.1f}",
            *([] if several else [f"{rows['firing_rate_hz']['mean']:.1f}"]),
            f"{rows['peak_hs']['mean']:+z.2f}",
            f"{rows['trough_hs']['mean']:+z.2f}",
        )
    return table

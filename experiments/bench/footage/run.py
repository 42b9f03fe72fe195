"""Watch footage and show it on the terminal: progress, the intervals of motion, what they cost, C12."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

import cv2
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Table
from rich.text import Text
from threadpoolctl import threadpool_limits

from dsnn import forms
from experiments.bench.footage.claims import CLAIM, FlowJudge, FootageOutcomes
from experiments.bench.footage.rows import FrameTable
from experiments.bench.footage.video import Footage, Picture, ahead
from experiments.bench.footage.watch import GAP_S, LEAST_FRAMES, Observer, Seen, Watcher, watch
from experiments.bench.report.terminal import coloured, error_console, out_console, show_line, show_outcome, show_table
from experiments.bench.run import provenance
from experiments.bench.run.models import ConfiguredModel, rate_notes
from experiments.bench.stats.claim import words
from experiments.bench.stats.count import count

WAYS = ("rightward", "leftward", "downward", "upward", "looming")
SAME_ASPECT = 1.05
EXIT_FAILED, EXIT_INTERRUPTED = 1, 130
STRONGER = "HS passes T, VS stays below T"


@dataclass(frozen=True, slots=True)
class Wanted:
    """Outputs to make of the footage: files that do not exist yet, a viewer, a verdict on C12."""

    record: Path | None = None
    table: Path | None = None
    view: bool = False
    judge: bool = False


def run(film: Footage, size: tuple[int, int], chosen: Sequence[ConfiguredModel], wanted: Wanted) -> int:
    """Show the footage at ``size`` (width, height) to the models, then print the summary; returns the exit status.

    However it ends, by Ctrl-C or an error too, the files hold all that was seen until then.
    """
    provenance.form()  # refuses one that cannot run
    cv2.setNumThreads(1)  # as in trials: more threads cost a second core for a sixth of the time
    watchers = [Watcher(model, size[::-1]) for model in chosen]
    thresholds = [model.thresholds.get("hs") for model in chosen]
    judge = FlowJudge(thresholds) if wanted.judge else None
    seen = Seen()
    with threadpool_limits(1), _interrupts() as stop, ExitStack() as outputs:
        outputs.callback(film.close)
        observers = [*_outputs(outputs, chosen, size, wanted), *([judge] if judge else [])]
        pictures = film.pictures(size)
        going = ahead(pictures, stop) if film.live else takewhile(lambda _: not stop.is_set(), pictures)
        watch(_counted(going, film), watchers, observers, seen)
    _show(film, size, watchers, seen)
    if judge is not None:
        _show_claim(watchers, judge.outcomes())
    early = film.ended_early()
    notes = (
        forms.note(),
        _other_aspect(film.size, size),
        *film.notes(),
        *rate_notes((model, film.rate) for model in chosen if film.rate is not None),
        *(observer.note for observer in observers),
        early,
    )
    for note in filter(None, notes):
        error_console.print(f"note: {note}", soft_wrap=True, markup=False)
    troubles = [f"{w.chosen.label} failed: {w.trouble}" for w in watchers if w.trouble]
    for line in troubles:
        error_console.print(line, soft_wrap=True, markup=False)
    return EXIT_INTERRUPTED if stop.is_set() else EXIT_FAILED if early or troubles else 0


def _outputs(
    stack: ExitStack, chosen: Sequence[ConfiguredModel], size: tuple[int, int], wanted: Wanted
) -> Iterator[Observer]:
    """Yield the viewer and files that are wanted, each closed by ``stack``."""
    if wanted.view or wanted.record is not None:
        # Of a viewer that was closed one line of ours is enough.
        os.environ.setdefault("RUST_LOG", "error,re_grpc_client=off,re_sdk=off")
        from experiments.bench.footage.recording import LiveLog  # not before: rerun takes its time

        if wanted.view:
            yield stack.enter_context(closing(LiveLog.to_viewer(chosen, size)))
        if wanted.record is not None:
            yield stack.enter_context(closing(LiveLog.to_file(wanted.record, chosen, size)))
    if wanted.table is not None:
        yield stack.enter_context(closing(FrameTable([model.label for model in chosen], wanted.table)))


@contextmanager
def _interrupts() -> Iterator[threading.Event]:
    """Yield an event that Ctrl-C sets, so that no file is broken off in mid-write; a second Ctrl-C does break off."""
    stop = threading.Event()

    def heed(*_: Any) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    before = signal.signal(signal.SIGINT, heed)
    try:
        yield stop
    finally:
        signal.signal(signal.SIGINT, before)


def _counted(pictures: Iterable[Picture], film: Footage) -> Iterator[Picture]:
    """Yield the pictures, counted on the terminal where there is one."""
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TextColumn("frames"))
    if not error_console.is_terminal:
        yield from pictures
        return
    with Progress(*columns, console=error_console, transient=True) as bar:
        task = bar.add_task(film.source, total=film.announced)
        for picture in pictures:
            yield picture
            bar.advance(task)


def _show(film: Footage, size: tuple[int, int], watchers: Sequence[Watcher], seen: Seen) -> None:
    """Print the whole summary but C12."""
    rate = f"{film.rate:g} frames/s" if film.rate else "no rate of its own"
    source = f"camera {film.source}" if film.live else film.source
    text = f"{source}: {_size(film.size)}, {rate}; {seen.frames} frames, {seen.until_s:.1f} s, seen at {_size(size)}"
    out_console.print(text, soft_wrap=True, markup=False)
    words = f" over T in {LEAST_FRAMES} frames or more, gaps under {GAP_S:g} s merged"
    out_console.print(Text.assemble("\n", ("motion", "b"), words))
    if any(watcher.motions() for watcher in watchers):
        show_table(_intervals(watchers))
    else:
        out_console.print("none")
    out_console.print(Text.assemble("\n", ("intervals", "b"), " each way, and spikes"))
    show_table(_totals(watchers, seen))
    _show_times(watchers, seen)


def _show_times(watchers: Sequence[Watcher], seen: Seen) -> None:
    """Print the time that a frame takes: of its own, and decoding (of a camera, waiting for the frame)."""
    frames = max(seen.frames, 1)
    models_ms, resizing, decoding = (
        seconds / frames * 1e3
        for seconds in (seen.resize_s + sum(watcher.seconds for watcher in watchers), seen.resize_s, seen.decode_s)
    )
    rate = 1e3 / max(models_ms, 1e-6)
    text = f"own time    {models_ms:.2f} ms a frame ({rate:.0f} frames/s), {resizing:.2f} of it luma and resizing"
    out_console.print()
    show_line(f"{text}; decoding {decoding:.2f} ms besides", 12)


def _show_claim(watchers: Sequence[Watcher], outcomes: Sequence[FootageOutcomes]) -> None:
    """Show C12 for each model, in the paper's stronger words too, and the grades. Nothing in a film is random."""
    for watcher, footage_outcomes in zip(watchers, outcomes, strict=True):
        who = f" ({watcher.chosen.label})" if len(watchers) > 1 else ""
        for name, says, outcome in (
            (Text.assemble("\n", (CLAIM, "b"), f"{who} "), words(CLAIM).says, footage_outcomes.claim),
            (Text("  in the paper's stronger words "), STRONGER, footage_outcomes.stronger),
        ):
            word = coloured(count([outcome.verdict], random=False))
            out_console.print(Text.assemble(name, word, f": {says}"))
            show_outcome(outcome)
        for line in footage_outcomes.grades.lines() if footage_outcomes.grades else ():
            show_line(f"  {line}", 4)


def _intervals(watchers: Sequence[Watcher]) -> Table:
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("model", "motion"):
        table.add_column(name, no_wrap=True)
    for name in ("from s", "to s", "frames over T", "peak", "spikes"):
        table.add_column(name, justify="right", no_wrap=True)
    for watcher in watchers:
        for m in watcher.motions():
            place = f"{m.start_s:.2f}", f"{m.end_s:.2f}"
            label = watcher.chosen.label
            table.add_row(label, m.direction, *place, f"{m.frames}", f"{m.peak:+.2f}", f"{m.spikes}")
    return table


def _totals(watchers: Sequence[Watcher], seen: Seen) -> Table:
    table = Table(box=None, header_style="bold", pad_edge=False)
    table.add_column("model", no_wrap=True)
    for name in ("step Hz", "T", *WAYS, "spikes", "ms a frame"):
        table.add_column(name, justify="right", no_wrap=name != "spikes")
    for watcher in watchers:
        ways = [motion.direction for motion in watcher.motions()]
        rate = getattr(watcher.chosen.network, "fps", None)
        table.add_row(
            watcher.chosen.label,
            "-" if rate is None else f"{rate:g}",
            "-" if watcher.chosen.threshold is None else f"{watcher.chosen.threshold:g}",
            *(f"{ways.count(way)}" for way in WAYS),
            " + ".join(f"{count} {channel.upper()}" for channel, count in watcher.spikes.items()) or "-",
            f"{watcher.seconds / max(seen.frames, 1) * 1e3:.2f}",
        )
    return table


def _other_aspect(size: tuple[int, int], seen: tuple[int, int]) -> str:
    """Return a note if a size of the user's distorts by over 5 %; empty otherwise."""
    ratio = size[0] * seen[1] / (size[1] * seen[0])
    stretch = max(ratio, 1 / ratio)
    if stretch <= SAME_ASPECT:
        return ""
    return f"{_size(seen)} is not the aspect of {_size(size)}: the network sees it distorted by {stretch - 1:.0%}"


def _size(size: tuple[int, int]) -> str:
    return f"{size[0]}x{size[1]}"

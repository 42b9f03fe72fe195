"""Show a video, a camera, a folder of pictures or a stimulus to models, and find when what moved which way."""

import math
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl

from dsnn import Response, ResponseSeries, forms
from dsnn.stimuli import STIMULI, StimulusEntry
from experiments.base import console, interrupts
from experiments.base.console import error_console, progress, show_files
from experiments.base.errors import TrialError, UsageError, as_usage_error
from experiments.base.files import NAME, part
from experiments.base.user_code import is_own
from experiments.declare.clip import Clip, find_stimulus
from experiments.draw import viewer
from experiments.draw.terminal import show_controls, show_verdicts
from experiments.judge import motion
from experiments.judge.controls import numbers
from experiments.judge.motion import GRADES, grades, near_miss
from experiments.judge.verdict import document
from experiments.kinds.result import Kind, Run
from experiments.kinds.tables import CLAIMS, shipped
from experiments.settings.models import rate_notes, shown_models
from experiments.settings.parameters import differing
from experiments.settings.settings import check_counts, in_sections, watchers
from experiments.show.clips import open_clip, recorded
from experiments.show.controls import controls
from experiments.show.play import Sample, Showing, Trial, play
from experiments.show.video import TRIALS, VideoSource
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import THRESHOLDS, RunFolder, begun, read_description
from experiments.store.plan import Plan, print_notes
from experiments.store.tables import COUNTS, PEAKS, TrialRecord, without_controls
from experiments.store.workers import Workers

BLOCK_FRAMES, EVERY_S = 64, 0.1
"""Frames that are recorded at once, and time between two parts that a viewer gets."""
NOTES = "notes"
"""The entry of ``run.json`` that says what to know of the source."""
NO_GRADES = dict.fromkeys(GRADES)
GRADED = TRIALS | pl.Schema(dict.fromkeys(GRADES, float))
"""Columns of ``trials.parquet``: those of `TRIALS`, and each model's grades against the optical flow."""
TRY = (
    "Try nearer motion, more contrast, another --size or a lower T (--set dsnn.t_sp=0.08), above a still scene's |HS|."
)
"""What helps where no motion passed the threshold."""
EARLY, STOPPED = "ended_early", "stopped"
"""The entries of ``run.json`` that say whether a part of the source is missing, and whether Ctrl-C ended it."""


# What is run.


def plan(asked: Asked) -> Plan[Trial]:
    """Return the plan of footage: one trial, whose condition is the source.

    Parameters
    ----------
    asked
        What was asked for: a video, the index of a camera as a text, a folder of pictures or a stimulus. Its options
        are ``size``, ``fps``, ``seconds``, ``jitter_px``, ``judge``, ``controls`` and ``recordings``, as `watch` has
        them. Whether a viewer opens is ``live`` in the plan.

    Raises
    ------
    UsageError
        There is nothing to read, or an argument is invalid.
    """
    (name,), seed, jitter_px = asked.what, asked.seed, asked.option("jitter_px", 0.0)
    seconds, size = asked.option("seconds"), asked.option("size")
    check_counts(seed)
    if seconds is not None and not seconds > 0:
        raise UsageError(f"seconds must be above 0, got {seconds}")
    labels = shown_models(["dsnn"], asked.models, asked.only)
    entry = find_stimulus(name) if name in STIMULI or name.endswith(".py") else None
    clip = None
    if entry:
        own = {key: value for key, value in asked.values.items() if key.partition(".")[0] == entry.name}
        clip = clip_of(entry, own, jitter_px)
    elif seed or jitter_px:
        raise UsageError(f"{name}: a seed and jitter are of a stimulus, which a film is not")
    stimulus = open_clip(clip, seed) if clip else None
    source = VideoSource(
        name, tuple(size) if size else None, seconds, flow=bool(asked.option("judge", False)),
        stimulus=stimulus,
    )  # fmt: skip
    chosen = watchers(labels, asked.values, {entry.name: entry.params} if entry else {}, asked.option("fps"))
    trial = Trial("watch", 0, 0, seed, source, chosen, controls=controls if asked.option("controls") else None)
    shown = {"stimulus": stimulus.stimulus.params, "jitter_px": jitter_px} if stimulus else {}
    files, changed = [source.name] if clip and is_own(source.name) else [], differing(chosen, offline=True)
    resolved = {
        "experiment": "watch", "source": source.name, "size": source.size, "fps": source.rate,
        "seconds": source.seconds, "judged": source.flow, "seed": trial.seed, "trials": 1, "models": trial.models,
        "changed": changed,
        THRESHOLDS: {model.label: model.thresholds for model in trial.models}, **shown,
        **provenance.of([*(model.source for model in trial.models), *files]),
    }  # fmt: skip
    return Plan(
        asked, "watch", (trial,), None, resolved, (GRADED, source.frame_columns), source, trial.models, changed,
        "frames", live=False,
    )  # fmt: skip


def clip_of(entry: StimulusEntry, values: Mapping[str, Any], jitter_px: float) -> Clip:
    """Return a stimulus with ``values`` by key, before a trembling camera; `UsageError` if not legal."""
    params = in_sections(values, {entry.name: entry.params})[entry.name]
    with as_usage_error(f"{entry.name}: "):
        return Clip(entry.name, replace(entry, params=params), (), jitter_px)


class Recorder:
    """Sends frames and responses on in blocks, so that nothing piles up; ends what every model failed in.

    Parameters
    ----------
    content
        What the recording has, a `Content`; nothing without one.
    stream
        Where they are sent, a `rerun.RecordingStream`; otherwise nowhere.
    every_s
        Time after which a block is sent that is not full.

    Attributes
    ----------
    trouble
        Why there is no recording, once that is known.
    """

    def __init__(self, content: Any = None, stream: Any = None, every_s: float = math.inf) -> None:
        self._content, self._stream, self._every_s = content, stream, every_s
        self._block: list[tuple[Sample, list[Response | None]]] = []
        self._frames, self._sent_s = 0, 0.0
        self.trouble: str | None = None

    def see(self, showing: Showing) -> None:
        """Take the last frame."""
        assert showing.sample is not None
        if not any(showing.responses):
            showing.source.stop()
        if self._stream is None:
            return
        self._block.append((showing.sample, showing.responses))
        if len(self._block) >= BLOCK_FRAMES or time.monotonic() - self._sent_s >= self._every_s:
            self.send()

    def send(self) -> None:
        """Send what is there."""
        from experiments.show import record as rerun

        if not self._block:
            return
        samples, responses = zip(*self._block, strict=True)
        by_model = dict(zip((model.label for model in self._content.models), zip(*responses, strict=True), strict=True))
        series = {label: ResponseSeries.from_responses(given) for label, given in by_model.items() if None not in given}
        frames, boxes = recorded(samples, series, self._frames)
        self._stream.send_chunks([*rerun.moving(self._content, frames), *boxes])
        self._block, self._frames, self._sent_s = [], self._frames + len(samples), time.monotonic()


@contextmanager
def _recorder(trial: Trial, file: Path | None, *, view: bool) -> Iterator[Recorder]:
    """Open the recording ``file`` and a viewer, as far as they are wanted; the file has its name once it is whole."""
    if file is None and not view:
        yield Recorder()
        return
    # A viewer that was closed is not missed, and a full disk is told below.
    os.environ.setdefault("RUST_LOG", "error,re_grpc_client=off,re_sdk=off,re_log_encoding=off")
    import rerun as rr

    from experiments.show import record

    content = record.Content(tuple(map(record.RecordedModel.of, trial.models)), eyes=("",))
    sinks: list[Any] = [rr.FileSink(part(file))] if file else []
    if view:
        sinks.append(rr.GrpcSink(viewer.opened("the Rerun viewer did not open on this screen: give --no-view")))
    stream = rr.RecordingStream(record.APPLICATION)
    try:
        stream.set_sinks(*sinks)
    except RuntimeError as error:
        raise OSError(f"{file}: {error}") from None
    record.send_layout(stream, record.layout_chunks(content))
    stream.send_recording_name(trial.label())
    stream.send_chunks(record.static(content))
    recorder = Recorder(content, stream, EVERY_S if view else math.inf)
    try:
        yield recorder
        recorder.send()
    finally:
        try:
            stream.flush(timeout_sec=5.0 if view else 60.0)
        except RuntimeError as error:
            error_console.print(f"note: not everything was shown or recorded: {error}")
        stream.disconnect()
        rr.init(record.APPLICATION, init_logging=False)  # or the stream's threads stay: see `record.write`
        if file is not None and record.is_whole(part(file)):
            part(file).replace(file)
        elif file is not None:
            part(file).unlink(missing_ok=True)  # the rows may find room there
            recorder.trouble = f"{file}: Rerun could not write it to its end: is the disk full?"


def work(plan: Plan[Trial], out: Path, pool: Workers) -> None:
    """Show the source to the models, then write tables, intervals of motion and verdicts into a new folder.

    Ctrl-C in a command ends the source: the files hold all that was seen until then.

    Raises
    ------
    UsageError
        The folder holds a run, or the viewer does not open.
    """
    source, (trial,), quiet = plan.declared, plan.trials, pool.quiet
    if begun(out):
        raise UsageError(f"{out}: holds a run already; choose another --out")
    with closing(RunFolder(out, *plan.schemas, plan.parameters)) as folder:
        folder.enter(plan.document())
        recording = folder.recording(0) if plan.asked.option("recordings", True) else None
        number, done = 0 if source.count is None else source.count, None
        with (
            interrupts.once(source.stop),
            _recorder(trial, recording, view=bool(plan.live)) as recorder,
            progress(source.label(), number, quiet or not number, "frames") as advance,
        ):

            def see(showing: Showing) -> None:
                recorder.see(showing)
                advance()

            try:
                done = play(trial, images=False, watch=see)
            except TrialError as error:
                folder.fail(0, source.label(), trial.seed, str(error))
        if done is not None:
            done = replace(graded(plan, done), recording=recorder.trouble)
            folder.add(done, source.label(), trial.seed)
        conclude(plan, folder)


def graded(plan: Plan[Trial], done: TrialRecord) -> TrialRecord:
    """Add each model's grades against the optical flow to its row; they are null where no flow was computed."""
    frames = done.frames.partition_by("model", as_dict=True)
    levels = {model.label: model.thresholds.get("hs") for model in plan.models}
    rows = [{**row, **(grades(frames[row["model"],], levels[row["model"]])
                       if plan.declared.flow and row["model"] in levels else NO_GRADES)}
            for row in done.rows]  # fmt: skip
    return replace(done, rows=tuple(rows))


# What it comes to.


def conclude(plan: Plan[Trial], folder: RunFolder) -> None:
    """Write the intervals of motion, the verdicts, and what to know of the source."""
    source, models, every = plan.declared, plan.models, folder.table("frames")
    frames = without_controls(every)
    one = frames.filter(pl.col("model") == frames["model"][0]) if frames.height else frames
    time_s = one["time_s"].to_numpy()
    early = source.ended_early(len(time_s), float(time_s[-1])) if len(time_s) else ""
    rates = [] if source.rate is None else rate_notes((model, source.rate) for model in models)
    notes = list(filter(None, [forms.note(), *source.notes(time_s), *rates, early]))
    found = motion.motions(frames, {model.label: model.thresholds for model in models})
    judged = shipped(CLAIMS["footage"]).verdicts(frames, models, "watch") if source.flow else []
    folder.write_text("summary.csv", found.write_csv())
    folder.write_json("claims.json", document(judged))
    if every.height > frames.height:
        folder.write_rows("controls.csv", numbers(every, models))
    folder.write_json(NAME, {**read_description(folder.folder), NOTES: notes, EARLY: bool(early),
                             STOPPED: source.stopped})  # fmt: skip
    folder.flush()
    folder.end()
    for note in notes:
        error_console.print(f"note: {note}")
    print_notes(folder)


# Reading it.


def show(run: Run) -> None:
    """Print what footage comes to: the intervals of motion, each model, the verdicts, and where everything is."""
    if not run.done:
        return
    if run.summary.height:
        console.show(run.summary, "motion over T")
    for model in sorted({*without_controls(run.trials)["model"]} - {*run.summary["model"]}):
        if near := near_miss(run.frames.filter(model=model), run.description[THRESHOLDS][model]):
            console.out_console.print(f"{model}: {near}\n  {TRY}")
    console.show(run.trials.head(1).select("source", "width", "height", "fps", "frames", "seconds"), "as models saw it")
    console.show(_filled(run.trials.select("model", *COUNTS, *PEAKS)), "each model")
    if run.description["judged"]:
        console.show(_filled(run.trials.select("model", *GRADES)), "HS and optical flow, with 95 % intervals")
    show_controls(run.controls)
    show_verdicts(run.verdicts, model=len(run.models) > 1)
    show_files(run.folder, console.count(run.trials["frames"][0], "frame"))


def _filled(table: pl.DataFrame) -> pl.DataFrame:
    """Return a table without the columns that have only nulls."""
    return table.select(column for column in table if column.null_count() < table.height)


KIND = Kind(plan, work, "footage has no figure; its recording shows it", show, renders=None)

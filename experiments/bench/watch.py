"""Show a video, a camera, a folder of pictures or a stimulus to models, and find when what moved which way."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl

from dsnn import Response, ResponseSeries, forms
from dsnn.stimuli import STIMULI, StimulusEntry
from experiments.bench.report import viewer
from experiments.bench.report.terminal import error_console, progress
from experiments.bench.result import Run, load
from experiments.bench.run import interrupts, provenance
from experiments.bench.run.command import begun_by
from experiments.bench.run.description import THRESHOLDS, begun, read_description
from experiments.bench.run.errors import TrialError, UsageError, as_usage_error
from experiments.bench.run.files import NAME, new_folder, part
from experiments.bench.run.folder import RunFolder
from experiments.bench.run.models import ConfiguredModel, model_texts, rate_notes, shown_models
from experiments.bench.run.parameters import differing
from experiments.bench.run.play import Sample, Showing, Trial, play
from experiments.bench.run.runs import print_notes
from experiments.bench.run.settings import assignments, changed, check_counts, collect, watchers
from experiments.bench.run.user_code import is_own
from experiments.bench.sources import motion
from experiments.bench.sources.clips import Clip, find_stimulus, recorded
from experiments.bench.sources.video import TRIALS, VideoSource
from experiments.bench.stats import stored
from experiments.claims import footage

BLOCK_FRAMES, EVERY_S = 64, 0.1
"""Frames that are recorded at once, and time between two parts that a viewer gets."""
NOTES = "notes"
"""The entry of ``run.json`` that says what to know of the source."""
EARLY = "ended_early"
"""The entry of ``run.json`` that says whether a part of the source is missing."""


def describe(trial: Trial) -> dict[str, Any]:
    """Return what ``run.json`` holds."""
    source, stimulus = trial.condition, trial.condition.stimulus
    shown = {"stimulus": stimulus.stimulus.params, "jitter_px": stimulus.clip.jitter_px} if stimulus else {}
    files = [source.name] if stimulus and is_own(source.name) else []
    return {
        "kind": "watch", "experiment": "watch", "source": source.name, "size": source.size, "fps": source.rate,
        "seconds": source.seconds, "judged": source.flow, "seed": trial.seed, "trials": 1, "models": trial.models,
        "changed": differing(trial.models, offline=True),
        THRESHOLDS: {model.label: model.thresholds for model in trial.models}, **shown,
        **provenance.of([*(model.source for model in trial.models), *files]),
    }  # fmt: skip


def plan(
    source: str, models: Sequence[str] = (), texts: Sequence[str] = (), *, only: bool = False,
    size: tuple[int, int] | None = None, fps: float | None = None, seconds: float | None = None, seed: int = 0,
    jitter_px: float = 0.0, judge: bool = False,
) -> Trial:  # fmt: skip
    """Return a checked trial, whose condition is the source.

    The parameters are those of `watch`, with settings as ``SECTION.NAME=VALUE`` texts.

    Raises
    ------
    UsageError
        There is nothing to read, or an argument is invalid.
    """
    check_counts(seed)
    if seconds is not None and not seconds > 0:
        raise UsageError(f"seconds must be above 0, got {seconds}")
    labels = shown_models(["dsnn"], models, only)
    entry = find_stimulus(source) if source in STIMULI or source.endswith(".py") else None
    sections = {entry.name: entry.params} if entry else {}
    clip = None
    if entry:
        clip = clip_of(entry, [text for text in texts if text.partition(".")[0] == entry.name], jitter_px)
    elif seed or jitter_px:
        raise UsageError(f"{source}: a seed and jitter are of a stimulus, which a film is not")
    shown = VideoSource(source, size, seconds, flow=judge, stimulus=clip.open(seed) if clip else None)
    chosen, _ = watchers(labels, texts, sections, fps)
    return Trial("watch", 0, 0, seed, shown, chosen)


def clip_of(entry: StimulusEntry, texts: Sequence[str], jitter_px: float) -> Clip:
    """Return a stimulus with ``NAME.PARAM=VALUE`` set, before a trembling camera; `UsageError` if not legal."""
    changes = collect(texts, {entry.name: entry.params})
    params = changed(entry.name, entry.params, changes.get(entry.name, {}))
    with as_usage_error(f"{entry.name}: "):
        return Clip(entry.name, replace(entry, params=params), (), jitter_px)


class Recorder:
    """Sends frames and responses on in blocks, so that nothing piles up; ends what every model failed in.

    Parameters
    ----------
    models
        The models.
    stream
        Where they are sent, a `rerun.RecordingStream`; otherwise nowhere.
    every_s
        Time after which a block is sent that is not full.

    Attributes
    ----------
    trouble
        Why there is no recording, once that is known.
    """

    def __init__(self, models: Sequence[ConfiguredModel], stream: Any = None, every_s: float = math.inf) -> None:
        self._models, self._stream, self._every_s = models, stream, every_s
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
        from experiments.bench.run import record as rerun

        if not self._block:
            return
        samples, responses = zip(*self._block, strict=True)
        by_model = dict(zip((model.label for model in self._models), zip(*responses, strict=True), strict=True))
        series = {label: ResponseSeries.from_responses(given) for label, given in by_model.items() if None not in given}
        frames, boxes = recorded(samples, series, self._frames)
        self._stream.send_chunks([*rerun.moving(content_of(self._models), frames), *boxes])
        self._block, self._frames, self._sent_s = [], self._frames + len(samples), time.monotonic()


def content_of(models: Sequence[ConfiguredModel]) -> Any:
    """Return what the recording of footage has."""
    from experiments.bench.run import record as rerun

    return rerun.Content(tuple(map(rerun.RecordedModel.of, models)), eyes=("",))


@contextmanager
def _recorder(trial: Trial, file: Path | None, *, view: bool) -> Iterator[Recorder]:
    """Open the recording ``file`` and a viewer, as far as they are wanted; the file has its name once it is whole."""
    if file is None and not view:
        yield Recorder(trial.models)
        return
    # A viewer that was closed is not missed, and a full disk is told below.
    os.environ.setdefault("RUST_LOG", "error,re_grpc_client=off,re_sdk=off,re_log_encoding=off")
    import rerun as rr

    from experiments.bench.run import record

    content = content_of(trial.models)
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
    recorder = Recorder(trial.models, stream, EVERY_S if view else math.inf)
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


def run(trial: Trial, out: Path, *, recordings: bool = True, view: bool = False, quiet: bool = False) -> Run:
    """Show the source to the models, then write tables, intervals of motion and verdicts into a new folder.

    Ctrl-C in a command ends the source: the files hold all that was seen until then.

    Raises
    ------
    UsageError
        The folder holds a run, or the viewer does not open.
    """
    source = trial.condition
    if begun(out):
        raise UsageError(f"{out}: holds a run already; choose another --out")
    with closing(RunFolder(out, TRIALS, source.frame_columns, differing(trial.models, offline=True))) as folder:
        folder.enter(describe(trial))
        count, done = 0 if source.count is None else source.count, None
        with (
            interrupts.once(source.stop),
            _recorder(trial, folder.recording(0) if recordings else None, view=view) as recorder,
            progress(source.label(), count, quiet or not count, "frames") as advance,
        ):

            def see(showing: Showing) -> None:
                recorder.see(showing)
                advance()

            try:
                done = play(trial, images=False, watch=see)
            except TrialError as error:
                folder.fail(0, source.label(), trial.seed, str(error))
        if done is not None:
            folder.add(replace(done, recording=recorder.trouble), source.label(), trial.seed)
        frames = folder.table("frames")
        one = frames.filter(pl.col("model") == frames["model"][0]) if frames.height else frames
        time_s = one["time_s"].to_numpy()
        early = source.ended_early(len(time_s), float(time_s[-1])) if len(time_s) else ""
        rates = [] if source.rate is None else rate_notes((model, source.rate) for model in trial.models)
        notes = list(filter(None, [forms.note(), *source.notes(time_s), *rates, early]))
        found = motion.motions(frames, {model.label: model.thresholds for model in trial.models})
        judged = footage.verdicts(frames, trial.models, "watch") if source.flow else []
        folder.write_text("summary.csv", found.write_csv())
        folder.write_json("claims.json", stored.document(judged))
        folder.write_json(NAME, {**read_description(out), NOTES: notes, EARLY: bool(early)})
        folder.flush()
        folder.end()
        for note in notes:
            error_console.print(f"note: {note}")
        print_notes(folder)
        return load(out)


def watch(
    source: str | os.PathLike[str],
    *,
    models: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    only: bool = False,
    settings: Mapping[str, Any] | None = None,
    size: tuple[int, int] | None = None,
    fps: float | None = None,
    seconds: float | None = None,
    seed: int = 0,
    judge: bool = False,
    out: str | os.PathLike[str] | None = None,
    recordings: bool = True,
    quiet: bool = False,
) -> Run:
    """Show a video, a camera, pictures or a stimulus to models, with progress, and find when what moved which way.

    Parameters
    ----------
    source
        A video file, the index of a camera as a text (``"0"``), a folder of pictures, or a stimulus: a name, or the
        path of a .py file that declares ``STIMULUS``.
    models
        Models to show it to beside ``dsnn``: names, or paths of .py files.
    only
        Whether to show it just to those of ``models``.
    settings
        Parameter -> value, as ``{"dsnn.n_con": 6}``, of models and of the stimulus.
    size
        Width and height that the models see, px; otherwise 320 px along the longer side, of a stimulus its own.
    fps
        The models' frame rate; otherwise 30, to which the default thresholds belong, whatever the source's.
    seconds
        How much to show; otherwise all. A camera has no end.
    seed
        Seed of a stimulus's random draws.
    judge
        Whether to compute optical flow between frames, to grade the models and judge claim C12 by it.
    out
        A new folder for the results; otherwise ``runs/watch-TIME``.
    recordings
        Whether to write a Rerun recording.
    quiet
        Whether to show no progress.

    Returns
    -------
    Run
        ``summary``: a row per interval of motion and model, with ``direction`` (rightward, leftward, downward, upward,
        looming), ``start_s``, ``end_s``, ``frames`` over the threshold, ``peak`` and ``spikes``. ``frames``: a row per
        frame and model. ``trials``: a row per model. ``failures``, ``claims``, and ``description["notes"]``: what is to
        be known of the source.

    Raises
    ------
    UsageError
        There is nothing to read, or an argument is invalid. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import watch
    >>> watch("street.mp4", models=["hybrid"]).summary
    """
    given: dict[str, Any] = {
        "only": only, "size": size, "fps": fps, "seconds": seconds, "seed": seed, "judge": judge,
    }  # fmt: skip
    name, labels, texts = os.fspath(source), model_texts(models), assignments(settings)
    planned = plan(name, labels, texts, **given)
    folder = new_folder("watch") if out is None else Path(out)
    arguments = {"source": name, "models": labels, "settings": texts, **given}
    with begun_by({"call": "experiments.watch", "arguments": arguments}):
        return run(planned, folder, recordings=recordings, quiet=quiet)

"""A video file or a camera behind the page, in place of the arena: read and shown as ``colias watch`` does."""

from __future__ import annotations

import shlex
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from experiments.bench.footage.video import Footage, Picture, ahead, usual_size
from experiments.bench.footage.watch import Seen, Watcher, watched
from experiments.bench.live.session import Session, View
from experiments.bench.result import Run
from experiments.bench.run.errors import TrialError, UsageError
from experiments.bench.run.models import ConfiguredModel, rate_notes
from experiments.bench.run.settings import watchers

USUAL_FPS = 30.0
"""Frames per second of footage that tells no rate."""


class FootageSession(Session):
    """Models that watch footage. A file begins again after its end; other models go on from the present frame.

    Parameters
    ----------
    source
        A video file, or the index of a camera.
    models
        One or more.
    assignments
        ``SECTION.NAME=VALUE`` texts, of the models' parameters.

    Raises
    ------
    UsageError
        There is nothing to decode, a model or a parameter is not known, or a value is not legal.
    """

    def __init__(self, source: str, models: Sequence[str], assignments: Sequence[str] = ()) -> None:
        super().__init__(models, assignments)
        self.source = source
        chosen = self._chosen(self.models, self.settings)
        self._open()
        self._show(self.models, chosen)

    @property
    def title(self) -> str:
        """Return what is shown, in words."""
        (width, height), (columns, rows) = self.film.size, self._size
        name = f"camera {self.source}" if self.film.live else Path(self.source).name
        return f"{name}, {width}x{height} px, seen at {columns}x{rows}"

    def notes(self) -> list[str]:
        """Return what to know of the models before this footage, a line each."""
        rate = self.film.rate
        return [] if rate is None else rate_notes((runner.chosen, rate) for runner in self.watching)

    def begin(self) -> None:
        """Begin the file again; a camera goes on, and the models begin from rest."""
        if not self.film.live:
            self._open()
        self._show(self.models, self._chosen(self.models, self.settings))

    def choose_models(self, models: Sequence[str]) -> None:
        """Show other models, from the next frame on."""
        settings = self._kept(self.settings, models)
        self._show(models, self._chosen(models, settings))
        self.settings = settings

    def record(self) -> Run:
        """Refuse: footage is recorded by another command, which the refusal has."""
        raise UsageError(f"footage is not recorded from the page; this does it: {self.command()} --record OUT.rrd")

    def command(self) -> str:
        """Return the command line of ``colias watch`` for these models, as they are now."""
        values = dict(self.settings)
        for runner in self.watching:
            values |= {f"{runner.section}.{name}": text for name, text in self.values.get(runner.label, {}).items()}
        models = [part for model in self.models for part in ("--model", model)]
        settings = [part for key, text in values.items() for part in ("--set", f"{key}={text}")]
        return shlex.join(["colias", "watch", self.source, "--only", *models, *settings])

    def close(self) -> None:
        """Let go of the file or the camera."""
        self.film.close()

    def step(self) -> View:
        """Advance by a frame.

        Raises
        ------
        TrialError
            The footage ended early, or all models have broken.
        """
        before = [runner.seconds for runner in self.watching]
        going = next(self._answered, None)
        if going is None:
            troubles = [f"{runner.label} broke: {runner.trouble}" for runner in self.watching if runner.trouble]
            if trouble := "\n".join(troubles) or self.film.ended_early():
                raise TrialError(trouble)
            self.begin()
            return self.step()
        picture, answers = going
        return self._view(picture.time_s, picture.luma, answers, before, {})

    def _chosen(self, models: Sequence[str], settings: Mapping[str, str]) -> tuple[ConfiguredModel, ...]:
        return watchers(models, [f"{key}={text}" for key, text in settings.items()])[0]

    def _open(self) -> None:
        self.film = film = Footage(self.source)
        self._size = usual_size(film.size)
        pictures = film.pictures(self._size)
        self._pictures: Iterator[Picture] = ahead(pictures, threading.Event()) if film.live else pictures
        self.interval_s, self.paced = 1.0 / (film.rate or USUAL_FPS), not film.live

    def _show(self, models: Sequence[str], chosen: Sequence[ConfiguredModel]) -> None:
        at_work = [Watcher(model, self._size[::-1]) for model in chosen]
        self._answered = watched(self._pictures, at_work, Seen())
        self._watch(models, [watcher.runner for watcher in at_work])

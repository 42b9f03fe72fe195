"""A video, a camera, pictures or a stimulus behind the page, in place of the arena: shown as ``colias watch`` does."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

from experiments.bench.live.session import Session, View
from experiments.bench.result import Run
from experiments.bench.run.errors import TrialError, UsageError
from experiments.bench.run.models import ConfiguredModel, rate_notes
from experiments.bench.run.play import Showing
from experiments.bench.run.settings import watchers
from experiments.bench.sources.video import VideoSource


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
        self.source, self._until_s = source, 0.0
        chosen = self._chosen(self.models, self.settings)
        self._open()
        self._show(self.models, chosen)

    @property
    def title(self) -> str:
        """Return what is shown, in words."""
        (width, height), (columns, rows) = self.film.own_size, self.film.size
        name = self.film.label() if self.film.is_camera else Path(self.source).name
        return f"{name}, {width}x{height} px, seen at {columns}x{rows}"

    def notes(self) -> list[str]:
        """Return what to know of the models before this footage, a line each."""
        rate = self.film.rate
        return [] if rate is None else rate_notes((runner.chosen, rate) for runner in self.watching)

    def begin(self) -> None:
        """Begin the file again; a camera goes on, and the models begin from rest."""
        if not self.film.is_camera:
            self._open()
        self._show(self.models, self._chosen(self.models, self.settings))

    def choose_models(self, models: Sequence[str]) -> None:
        """Show other models, from the next frame on."""
        settings = self._kept(self.settings, models)
        self._show(models, self._chosen(models, settings))
        self.settings = settings

    def record(self) -> Run:
        """Refuse: footage is recorded by another command, which the refusal has."""
        raise UsageError(f"footage is not recorded from the page; this does it: {self.command()}")

    def command(self) -> str:
        """Return the command line of ``colias watch`` for these models, as they are now."""
        values = dict(self.settings)
        for runner in self.watching:
            values |= {f"{runner.section}.{name}": text for name, text in self.values.get(runner.label, {}).items()}
        models = [part for model in self.models for part in ("--model", model)]
        settings = [part for key, text in values.items() for part in ("--set", f"{key}={text}")]
        return shlex.join(["colias", "watch", self.source, "--only", *models, *settings])

    def step(self) -> View:
        """Advance by a frame.

        Raises
        ------
        TrialError
            The footage ended early, or all models have broken.
        """
        before = [runner.seconds for runner in self.watching]
        sample = next(self._samples, None)
        if sample is None:
            if early := self.film.ended_early(self.number, self._until_s):
                raise TrialError(early)
            self.begin()
            return self.step()
        if not any(self._showing.responses):
            raise TrialError("\n".join(f"{label} broke: {why}" for label, why in self._showing.troubles().items()))
        self._until_s = sample.time_s
        return self._view(sample.time_s, sample.image, self._showing.responses, before, {})

    def _chosen(self, models: Sequence[str], settings: Mapping[str, str]) -> tuple[ConfiguredModel, ...]:
        return watchers(models, [f"{key}={text}" for key, text in settings.items()])[0]

    def _open(self) -> None:
        self.film = VideoSource(self.source)
        self.paced, self.interval_s = not self.film.is_camera, 1.0 / self.film.fps

    def _show(self, models: Sequence[str], chosen: Sequence[ConfiguredModel]) -> None:
        """Show the frames from the next one on to these models."""
        self._showing = Showing(self.film, chosen, keep=False)
        self._samples, self._until_s = iter(self._showing), 0.0
        self._watch(models, self._showing.runners)

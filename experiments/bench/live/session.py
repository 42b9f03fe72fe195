"""The session behind the page: models that watch frames, and what a person may do with them. It knows no page."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from colias_sim import Pose
from dsnn import Response
from experiments.bench.result import Run
from experiments.bench.run.errors import UsageError, short
from experiments.bench.run.models import look_up
from experiments.bench.run.play import ModelRunner, change


@dataclass(frozen=True, slots=True)
class View:
    """A frame of the session, for the page.

    Parameters
    ----------
    number, time_s
        Of the frame, since the beginning.
    luma
        The frame, (R, C) uint8.
    answers
        Model's label -> its answer; ``None`` of one that has broken.
    seconds
        Model's label -> time that it took.
    poses
        Robot -> where it is; footage has none.
    """

    number: int
    time_s: float
    luma: npt.NDArray[np.uint8]
    answers: Mapping[str, Response | None]
    seconds: Mapping[str, float]
    poses: Mapping[str, Pose] = field(default_factory=dict)


class Session(ABC):
    """Models that watch frames without an end, and what one does with them.

    Attributes
    ----------
    models
        Their texts, as after ``--model``.
    given
        Those that it began with.
    settings
        Parameter -> text, as after ``--set``.
    watching
        The models at work.
    values
        Model's label -> parameter -> text: those that were changed on the page.
    number
        The number of the frame that is next.
    interval_s
        Time between two frames.
    paced
        Whether frames are to be shown at that rate; a camera has a rate of its own.

    Parameters
    ----------
    models
        One or more.
    assignments
        ``SECTION.NAME=VALUE`` texts.
    """

    interval_s: float
    paced = True

    def __init__(self, models: Sequence[str], assignments: Sequence[str]) -> None:
        cv2.setNumThreads(1)
        self.models = self.given = tuple(models)
        self.settings = dict(text.partition("=")[::2] for text in assignments)
        self.watching: list[ModelRunner] = []
        self.values: dict[str, dict[str, str]] = {}
        self.number = 0
        self._maps = False

    @property
    @abstractmethod
    def title(self) -> str:
        """Return what is shown, in words."""

    @abstractmethod
    def begin(self) -> None:
        """Begin again.

        Raises
        ------
        UsageError
            That cannot be. What is under way goes on then.
        """

    @abstractmethod
    def choose_models(self, models: Sequence[str]) -> None:
        """Show other models; they begin from rest.

        Raises
        ------
        UsageError
            A model is not known. What is under way goes on then.
        """

    @abstractmethod
    def record(self) -> Run:
        """Record what was done since the beginning, as a run.

        Raises
        ------
        UsageError
            There is nothing to record.
        """

    @abstractmethod
    def step(self) -> View:
        """Advance by a frame.

        Raises
        ------
        UsageError
            It went wrong.
        """

    def close(self) -> None:  # noqa: B027  (a trial has nothing to let go of)
        """Let go of what the frames come from."""

    def change(self, model: str, name: str, text: str) -> None:
        """Change a parameter of a model, from the next frame on; there it begins anew, from rest.

        Raises
        ------
        UsageError
            The value is not legal; nothing has changed.
        """
        self._change(model, {name: text})
        self.values.setdefault(model, {})[name] = text

    def _change(self, model: str, values: Mapping[str, str]) -> None:
        change(self.watching, model, values)

    def reset_parameters(self) -> None:
        """Give every model the parameters that it began with, from the next frame on."""
        for runner in self.watching:
            if changed := self.values.pop(runner.label, None):
                began = {name: _text(getattr(runner.chosen.network, name)) for name in changed}
                self._change(runner.label, began)

    def show_maps(self, wanted: bool) -> None:
        """Let the first model compute its layer maps, from the next frame on, or no longer."""
        self._maps = wanted
        self.watching[0].maps = wanted

    def _watch(self, models: Sequence[str], runners: list[ModelRunner]) -> None:
        """Let these models watch from now on, with what was changed of those that watched before."""
        self.models, self.watching, self.number = tuple(models), runners, 0
        self.show_maps(self._maps)
        labels = {runner.label for runner in runners}
        self.values = {label: values for label, values in self.values.items() if label in labels}
        for label, values in self.values.items():
            self._change(label, values)

    def _kept(self, assignments: Mapping[str, str], models: Sequence[str]) -> dict[str, str]:
        """Return the assignments without those of models that are no longer shown."""
        before, now = ({model.section for model in look_up(texts)} for texts in (self.models, models))
        return {key: text for key, text in assignments.items() if key.partition(".")[0] not in before - now}

    def _view(self, time_s: float, luma: npt.NDArray[np.uint8], answers: Sequence[Response | None],
              before: Sequence[float], poses: Mapping[str, Pose]) -> View:  # fmt: skip
        self.number += 1
        return View(
            self.number - 1, time_s, luma,
            {runner.label: answer for runner, answer in zip(self.watching, answers, strict=True)},
            {runner.label: runner.seconds - seconds for runner, seconds in zip(self.watching, before, strict=True)},
            poses,
        )  # fmt: skip


def _text(value: Any) -> str:
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


def number_of(text: Any) -> float:
    """Return a number that a page sent; `UsageError` where it is none."""
    try:
        value = float(text)
    except (TypeError, ValueError):
        raise UsageError(f"{short(text)}: legal is a number") from None
    if not np.isfinite(value):
        raise UsageError(f"{value}: legal is a finite number")
    return value

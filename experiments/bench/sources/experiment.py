"""Experiments: a design that lists its conditions, repeats, and the claims it bears on."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol, get_args

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from experiments.bench.run.errors import check_declared, short
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.user_code import run_main
from experiments.bench.sources.conditions import CONDITION_COLUMNS, WHERE_SET, Condition
from experiments.bench.sources.excitation import NEEDED
from experiments.bench.stats.claim import Claim, check_claims

Drawing = Literal["spikes", "mechanism", "excitation"]


class Design(Protocol):
    """The parameters of an experiment, a frozen dataclass that ``--set experiment.NAME=VALUE`` reaches."""

    @property
    def pose_sd_mm(self) -> float:
        """Spread of the stimulus's start position."""

    @property
    def heading_sd_deg(self) -> float:
        """Spread of the stimulus's start heading."""

    def conditions(self) -> Iterable[Condition]:
        """Every condition, in the order tables and figures show them; the same ones at every call."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """A declaration of trials with the robot.

    Parameters
    ----------
    name
        Letters, digits, ``-`` and ``_``.
    summary
        A line for ``colias list``.
    design
        A dataclass that lists the conditions: `Translation`, `Angular`, `General`, `Contrast`, `Clutter`, `Egomotion`,
        or one of your own with ``conditions()``, which returns `Condition` objects, and the fields ``pose_sd_mm`` and
        ``heading_sd_deg``, 0 to 100. Its fields answer to ``--set experiment.NAME=VALUE``.
    varies
        The column of conditions that the figure is drawn against, a field of `Condition`: ``speed_cm_s``, say.
    repeats
        Trials of each condition, 1 or more.
    claims
        Ids of the paper's claims, and claims of your own (`experiments.Claim`).
    models
        What it shows, with settings of their own as ``"dsnn:n_con=4"``; ``--model`` shows others beside them.
    figure
        ``spikes``: every trial's count, and the potential over the trial. ``mechanism``: counts, time in view, firing
        rate and potential against ``varies``, a number, of crossings. ``excitation``: excitation and inhibition of HS
        over the trial, from the models that ``approach-mechanism`` declares.
    arena
        The arena that it is shown in, where ``--set scene.arena`` names no other: a name that ``colias list`` shows, or
        the path of an .xml or .py file, relative to the file of the experiment; ``__file__`` where that declares
        ``ARENA`` too. Empty: ``bright``.
    settings
        Parameter -> value that its trials have where ``--set`` says nothing: ``{"scene.arena": "dim"}``.
    file
        The .py file that declares it, which commands and `experiments.run` fill in.

    Raises
    ------
    ValueError
        The declaration cannot be run as it stands.

    Examples
    --------
    >>> from experiments import Experiment, Translation
    >>> fast = Experiment("fast", "fast crossings", Translation((15, 25), (6,)), varies="speed_cm_s", repeats=5)
    """

    name: str
    summary: str
    design: Design
    varies: str
    repeats: int = 10
    claims: tuple[str | Claim, ...] = ()
    models: tuple[str, ...] = ("dsnn",)
    figure: Drawing = "spikes"
    arena: str = dataclasses.field(default="", metadata=WHERE_SET)
    settings: Mapping[str, Any] = dataclasses.field(default_factory=dict, metadata=WHERE_SET)
    file: str = dataclasses.field(default="", compare=False, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        check_declared("experiment", self.name, self.summary, self.repeats)
        check_claims(self.name, self.claims)
        where = f"experiment {self.name}"
        if isinstance(self.models, str) or not self.models:
            raise ValueError(f"{where}: models must be a tuple of one name or more, got {short(self.models)}")
        object.__setattr__(self, "models", tuple(self.models))
        if self.figure not in get_args(Drawing):
            raise ValueError(f"{where}: figure must be one of {', '.join(get_args(Drawing))}, got {short(self.figure)}")
        if self.figure == "excitation" and not set(NEEDED) <= set(self.models):
            raise ValueError(f"{where}: figure='excitation' needs the models {', '.join(NEEDED)}")
        conditions = self.conditions()
        if not conditions or self.varies not in CONDITION_COLUMNS or None in self._varied(conditions):
            raise ValueError(f"{where}: varies must be a field that every condition sets, got {self.varies!r}")
        columns = [tuple(condition.columns().values()) for condition in conditions]
        if twice := [one.label() for index, one in enumerate(conditions) if columns[index] in columns[:index]]:
            raise ValueError(f"{where}: the condition '{twice[0]}' is there twice; give each path a motion of its own")
        crossings = all(condition.motion == "translation" for condition in conditions)
        if self.figure == "mechanism" and not (crossings and isinstance(self._varied(conditions)[0], float)):
            raise ValueError(f"{where}: figure='mechanism' needs translations alone, and varies to be a number")

    def _varied(self, conditions: Iterable[Condition]) -> list[Any]:
        return [getattr(condition, self.varies) for condition in conditions]

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions of its design, in order.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(self.design.conditions())

    def main(self) -> None:
        """Run the experiment of the file that is executed, as ``colias run FILE`` does with its options.

        Examples
        --------
        The last lines of a file that declares ``EXPERIMENT``:

        >>> if __name__ == "__main__":  # doctest: +SKIP
        ...     EXPERIMENT.main()
        """
        run_main()


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of the trials of a run. Every model of ``models`` sees the same frames."""

    models: tuple[ConfiguredModel, ...]
    robot: RobotConfig
    camera: CameraConfig
    scene: SceneConfig
    pose_sd_mm: float
    heading_sd_deg: float

"""The box of a fit: a range for each parameter that is free, as ``--over`` has it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from experiments.bench.grid import ENDS, apart, keys_of
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import PRESET, look_up
from experiments.bench.run.settings import changed, collect, schema_of, unit_of
from experiments.bench.sources.clips import OfflineExperiment
from experiments.bench.study import Study
from experiments.bench.sweep_plan import clips_part
from experiments.bench.trials import sections as robot_sections

Setting = Mapping[str, str]
"""Key of each range of the box -> its value as ``--set`` takes it."""
LOG_FROM = 100.0
"""Ratio of the ends of a range from which it is searched by its logarithm."""
TO = ".."
"""Text between the ends of a range."""


@dataclass(frozen=True, slots=True)
class Range:
    """The values that one parameter may take, or several together: those between two ends, or some by name.

    Parameters
    ----------
    key
        As ``--over`` has it: ``dsnn.t_sp``, or ``dsnn.tau_s.first`` for an end of several values, or
        ``plain.fps+cluttered.fps`` for parameters that have one value.
    low, high
        The ends, which belong to it.
    whole
        Whether it takes whole numbers alone.
    choices
        The values by name; empty where there are ends.
    unit
        Of the values; empty where none is known.
    network
        Whether it is a parameter of the model, so that its values can share their frames.
    """

    key: str
    low: float = 0.0
    high: float = 1.0
    whole: bool = False
    choices: tuple[str, ...] = ()
    unit: str = ""
    network: bool = False

    @property
    def keys(self) -> tuple[str, ...]:
        """The parameters that it moves, with their ends."""
        return keys_of(self.key)

    @property
    def log(self) -> bool:
        """True if it is searched by its logarithm: both ends are above 0, and their ratio is `LOG_FROM` or more."""
        return not self.choices and self.low > 0.0 and self.high / self.low >= LOG_FROM

    @property
    def size(self) -> int:
        """The number of values that it takes; 0 where these are a continuum."""
        return len(self.choices) or (round(self.high - self.low) + 1 if self.whole else 0)

    def text(self, value: float | str) -> str:
        """Return a value as ``--set`` takes it, a number to six digits."""
        return value if isinstance(value, str) else str(value) if self.whole else f"{value:.6g}"

    def at(self, share: float) -> str:
        """Return the value below which a share of the range lies, 0 to 1; of whole numbers and names each has as much.

        Parameters
        ----------
        share
            From 0 up, below 1.
        """
        if self.choices:
            return self.choices[int(share * len(self.choices))]
        if self.whole and not self.log:
            return self.text(int(self.low) + int(share * self.size))
        if self.log:
            value = math.exp(math.log(self.low) + share * math.log(self.high / self.low))
            return self.text(round(value) if self.whole else value)
        return self.text(self.low + share * (self.high - self.low))

    def __str__(self) -> str:
        """Return the text of ``--over``."""
        ends = ",".join(self.choices) or f"{self.text(self._end(self.low))}{TO}{self.text(self._end(self.high))}"
        return f"{self.key}={ends}"

    def _end(self, value: float) -> float:
        return int(value) if self.whole else value


@dataclass(frozen=True, slots=True)
class Box:
    """All ranges of a fit.

    Parameters
    ----------
    ranges
        One or more, each of another parameter.
    """

    ranges: tuple[Range, ...]

    @property
    def outside(self) -> tuple[Range, ...]:
        """The ranges of robot, camera, scene, design and stimuli: each setting of these is rendered anew."""
        return tuple(part for part in self.ranges if not part.network)

    def at(self, shares: Sequence[float]) -> dict[str, str]:
        """Return the setting at a place of the unit cube, one share for each range."""
        return {part.key: part.at(share) for part, share in zip(self.ranges, shares, strict=True)}


def expanded(setting: Setting) -> list[tuple[str, str]]:
    """Return the key and the value of each parameter of a setting, those that move together one by one."""
    return [(key, value) for name, value in setting.items() for key in keys_of(name)]


def box_of(over: Sequence[str], study: Study, experiments: Sequence[Any]) -> Box:
    """Return the box of ``KEY=A..B``, ``KEY=V1,V2`` and ``KEY`` texts, checked against the experiments that they move.

    Parameters
    ----------
    over
        One text for each parameter, or for several of one value with ``+`` between their keys. ``KEY`` alone is its
        whole legal range.
    study
        Says the models and what holds at every point.
    experiments
        Declarations of one kind.

    Raises
    ------
    UsageError
        A text is not of these forms, its key is of no experiment or model or is there twice, an end is not legal, or
        ``--set`` settles the key.
    """
    values = _sections(study, experiments)
    networks = {model.section for model in look_up(study.models)}
    settled = {text.partition("=")[0]: text for text in study.assignments}
    ranges: list[Range] = []
    taken: set[str] = set()
    for text in over:
        name, equals, ends = text.partition("=")
        parts: list[Range] = []
        for key in keys_of(name):
            if key in taken:
                raise UsageError(f"--over {text}: {key} is there twice")
            taken.add(key)
            if apart(key)[0] in settled:
                raise UsageError(f"--over {text}: --set {settled[apart(key)[0]]} settles that; give one of them")
            parts.append(_range(f"{key}{equals}{ends}", values, networks))
        if len({replace(part, key=name, unit="") for part in parts}) > 1:
            raise UsageError(f"--over {text}: {' and '.join(keys_of(name))} take no one value: legal are parameters of"
                             " one kind, all of the model or none, and one range")  # fmt: skip
        ranges.append(replace(parts[0], key=name))
    if not ranges:
        raise UsageError("--over: a fit needs one parameter or more, for example --over dsnn.t_sp=0.05..0.3")
    return Box(tuple(ranges))


def _sections(study: Study, experiments: Sequence[Any]) -> dict[str, Any]:
    """Return a dataclass for each section of ``--set`` that any of the experiments, or else the models, have."""
    table: dict[str, Any] = {}
    if not experiments:
        return {model.section: model.chosen.network for model in look_up(study.models)}
    for experiment in experiments:
        if isinstance(experiment, OfflineExperiment):
            sections = clips_part(experiment, replace(study, assignments=()), 0, (), None).bases()[0]
            table = {**{section: values[0] for section, values in sections.items()}, **table}
        else:
            table = {**robot_sections(experiment, study.models), **table}
    return table


def _range(text: str, values: Mapping[str, Any], networks: set[str]) -> Range:
    key, equals, ends = text.partition("=")
    parameter, end = apart(key)
    collect([f"{parameter}={ends}"], values, option="--over")  # the key is known
    section, _, name = parameter.partition(".")
    value, network = values[section], section in networks
    if name == PRESET and network:
        raise UsageError(f"--over {text}: a preset of a model is not searched; its parameters are")
    schema = schema_of(value, name)
    unit = unit_of(value, name)
    present = getattr(value, name, None)
    if end and not isinstance(present, tuple):
        raise UsageError(f"--over {text}: {parameter} has one value, neither a first nor a last")
    if isinstance(present, tuple):
        if not end:
            raise UsageError(f"--over {text}: {parameter} has several values; give {parameter}.first or .last")
        schema = (schema.get("prefixItems") or [schema["items"]])[0]
    if equals and TO not in ends:
        choices = tuple(dict.fromkeys(filter(None, ends.split(","))))
        if len(choices) < 2:
            raise UsageError(f"--over {text}: expected KEY=A{TO}B, or two values or more as KEY=V1,V2; --set sets one")
    elif not equals and ("enum" in schema or schema.get("type") == "boolean"):
        choices = tuple(map(str, schema["enum"])) if "enum" in schema else ("false", "true")
    else:
        low, high = _ends(text, ends, schema)
        _check(text, value, name, present, end, (f"{low:.6g}", f"{high:.6g}"))
        return Range(key, low, high, schema["type"] == "integer", unit=unit, network=network)
    _check(text, value, name, present, end, choices)
    return Range(key, choices=choices, unit=unit, network=network)


def _ends(text: str, ends: str, schema: Mapping[str, Any]) -> tuple[float, float]:
    """Return the ends that were typed, or those of the legal range."""
    if schema.get("type") not in ("number", "integer"):
        raise UsageError(f"--over {text}: it has no ends, as it is no number; list its values as KEY=V1,V2")
    if not ends:
        if not {"minimum", "maximum"} <= schema.keys():
            raise UsageError(f"--over {text}: its legal range has no two ends; give them as KEY=A{TO}B")
        return float(schema["minimum"]), float(schema["maximum"])
    try:
        low, high = (float(part) for part in ends.split(TO))
    except ValueError:
        raise UsageError(f"--over {text}: expected two numbers, as KEY=A{TO}B") from None
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise UsageError(f"--over {text}: legal is a lower end below the upper one, both finite")
    if schema["type"] == "integer" and not (low.is_integer() and high.is_integer()):
        raise UsageError(f"--over {text}: the parameter takes whole numbers, and so do its ends")
    return low, high


def _check(text: str, value: Any, name: str, present: Any, end: str, texts: Sequence[str]) -> None:
    """Raise `UsageError` for a value that is not legal by itself."""
    for one in texts:
        whole = one
        if end:
            parts = [str(part) for part in present]
            parts[ENDS[end]] = one
            whole = ",".join(parts)
        changed("", value, {name: whole}, lambda _name, _text: f"--over {text}")

"""The box of a fit: the parameters that are free, each with its range, and settings that fill it evenly."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from experiments.bench import sweep_plan
from experiments.bench.grid import apart, keys_of, sets, take, title_of
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import look_up
from experiments.bench.run.settings import changed, collect, schema_of
from experiments.bench.run.streams import stream
from experiments.bench.study import Study

LOG_FROM = 100.0
"""Ratio of the ends of a range from which it is searched by its logarithm."""
TO = ".."


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
    title
        What it means in a few words, with its unit.
    network
        Whether it is a parameter of the model, so that its values can share their frames.
    """

    key: str
    low: float = 0.0
    high: float = 1.0
    whole: bool = False
    choices: tuple[str, ...] = ()
    title: str = ""
    network: bool = False

    @property
    def log(self) -> bool:
        """True if it is searched by its logarithm: both ends are above 0, and their ratio is `LOG_FROM` or more."""
        return not self.choices and self.low > 0.0 and self.high / self.low >= LOG_FROM

    def text(self, value: float | str) -> str:
        """Return a value as ``--set`` takes it, a number to six digits."""
        return value if isinstance(value, str) else str(int(value)) if self.whole else f"{value:.6g}"

    def at(self, share: float) -> str:
        """Return the value below which a share of the range lies, 0 up to below 1; whole numbers have equal shares."""
        if self.choices:
            return self.choices[int(share * len(self.choices))]
        if self.log:
            value = math.exp(math.log(self.low) + share * math.log(self.high / self.low))
            return self.text(round(value) if self.whole else value)
        if self.whole:
            return self.text(int(self.low) + int(share * (round(self.high - self.low) + 1)))
        return self.text(self.low + share * (self.high - self.low))

    def __str__(self) -> str:
        """Return the text of ``--over``."""
        return f"{self.key}={','.join(self.choices) or f'{self.text(self.low)}{TO}{self.text(self.high)}'}"


Box = tuple[Range, ...]
"""All ranges of a fit."""


def setting_at(box: Box, shares: Sequence[float]) -> dict[str, str]:
    """Return the setting at a place of the unit cube, one share for each range."""
    return {part.key: part.at(share) for part, share in zip(box, shares, strict=True)}


def spread(box: Box, number: int, seed: int) -> list[dict[str, str]]:
    """Return settings that fill a box evenly: the first points of a scrambled Sobol sequence.

    References
    ----------
    Owen 1998, Scrambling Sobol' and Niederreiter-Xing points.
    """
    from scipy.stats import qmc

    sequence = qmc.Sobol(len(box), scramble=True, rng=stream("fit.sample", seed))
    points = sequence.random_base2((number - 1).bit_length())[:number]
    return [setting_at(box, [min(float(share), np.nextafter(1.0, 0.0)) for share in point]) for point in points]


def box_of(over: Sequence[str], study: Study, experiments: Sequence[Any]) -> Box:
    """Return the box of ``KEY=A..B``, ``KEY=V1,V2`` and ``KEY`` texts, checked against the experiments that they move.

    Parameters
    ----------
    over
        One text for each parameter, or for several of one value with ``+`` between their keys.
    study
        Says the models and what holds at every point.
    experiments
        Declarations of one kind; empty where models alone are moved.

    Raises
    ------
    UsageError
        A text is not of these forms, its key is of no experiment or model or is there twice, an end is not legal, or
        ``--set`` settles the key.
    """
    sections: dict[str, Any] = {model.section: model.network for model in look_up(study.models)}
    networks = set(sections)
    for experiment in experiments:
        _, _, base, _ = next(sweep_plan.part_of(experiment, replace(study, assignments=()), 0).readers())
        sections |= {section: values[0] for section, values in base.items()}
    fixed, taken = {text.partition("=")[0] for text in study.assignments}, set[str]()
    ranges: list[Range] = []
    for text in over:
        name, equals, ends = text.partition("=")
        take(text, taken, fixed)
        parts = [_range(f"{key}{equals}{ends}", sections, networks) for key in keys_of(name)]
        if len({replace(part, key=name, title="") for part in parts}) > 1:
            raise UsageError(f"--over {text}: {' and '.join(keys_of(name))} take no one value")
        ranges.append(replace(parts[0], key=name, title=" and ".join(dict.fromkeys(part.title for part in parts))))
    if not ranges:
        raise UsageError("--over: a fit needs one parameter or more, for example --over dsnn.t_sp=0.05..0.3")
    return tuple(ranges)


def _range(text: str, sections: Mapping[str, Any], networks: set[str]) -> Range:
    key, equals, ends = text.partition("=")
    parameter, end = apart(key)
    collect([f"{parameter}={ends}"], sections, option="--over")  # the key is known
    section, _, name = parameter.partition(".")
    value = sections[section]
    schema, present = schema_of(value, name), getattr(value, name, None)
    if isinstance(present, tuple) != bool(end):
        raise UsageError(f"--over {text}: KEY.first or KEY.last is for a parameter of several values, and only for one")
    if end:
        schema = (schema.get("prefixItems") or [schema["items"]])[0]
    number = schema.get("type") in ("number", "integer")
    choices: tuple[str, ...] = ()
    low = high = 0.0
    if equals and TO not in ends:
        choices = tuple(dict.fromkeys(filter(None, ends.split(","))))
    elif not equals and not number:
        choices = tuple(map(str, schema.get("enum", ("false", "true"))))
    else:
        least, most = ends.split(TO, 1) if equals else (schema.get("minimum", "nan"), schema.get("maximum", "nan"))
        try:
            low, high = float(least), float(most)
        except ValueError:
            low = high = math.nan
        if not number or not -math.inf < low < high < math.inf:
            raise UsageError(f"--over {text}: expected two numbers as KEY=A{TO}B, the lower first; values of another"
                             " kind as KEY=V1,V2")  # fmt: skip
    for one in choices or (f"{low:.6g}", f"{high:.6g}"):  # each is legal
        moved = sets([f"{key}={one}"], {section: (value,)})[parameter]
        changed("", value, {name: moved}, lambda _name, _text: f"--over {text}")
    whole = schema.get("type") == "integer" and not choices
    return Range(key, low, high, whole, choices, title_of(key, [{section: (value,)}]), section in networks)

"""Parameters of the on-board network: the DSNN's, and the formats of its numbers."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from dsnn.field_docs import parameters, unit
from dsnn.filters import alpha, residue
from dsnn.params import DSNNParams

LARGEST_RESIDUE = 0.99
"""Largest sum of ``a_i``. At 1 or more P grows without bound, and near 1 it exceeds 16 bits."""
READINGS: Mapping[str, bool | str] = {"rectified": True, "polarity": "common", "lowpass": "backward-euler"}
"""Option of the DSNN -> its only value here: F has no sign bit, and the tables assume these gains."""
LARGEST_LA = 32767
"""Grey levels: LA - A is a whole number of 16 bits."""
LEAST_ALPHA = 0.5 / 32768.0
"""A gain below this is 0 in 15 fractional bits: the low-pass would never move."""


@parameters
class OnboardParams(DSNNParams):
    """The DSNN's parameters, and the formats of its numbers on the robot.

    By default the paper's eight spacings at 99x72 fit into the robot's memory, together with three camera frames and 16
    kB for other use (``colias firmware budget``). Of such formats the default has the least error.

    Examples
    --------
    >>> from dsnn import OnboardParams
    >>> OnboardParams().state_bits, OnboardParams.presets()["bits16"].state_bits
    (8, 16)
    """

    state_bits: Annotated[Literal[8, 16], unit("bits")] = 8
    """Width of a delayed signal D. A cell has 2 n_con of them, most of the memory. With n_con = 8 only 8 bits fit into
    256 kB together with the camera's frames."""
    companding: bool = True
    """Whether an 8-bit D has segments whose step doubles from one to the next, as G.711 encodes speech. Equal steps
    lose the small values of a slow low-pass. Without effect on 16 bits."""
    lamina_bits: Annotated[Literal[8, 16], unit("bits")] = 8
    """Width of the LA stored for the next frame. With 8 bits it is a whole number of grey levels that saturates at 255.
    16 bits take two more bytes a cell: with n_con = 8 there is room for two camera frames, not three."""
    f_bits: Annotated[int | None, unit("bits")] = Field(default=None, ge=0, le=15)
    """Fractional part of F, which saturates at some 32,000 steps. None: as many as the largest F from a rise of LA
    allows. F is tau_fast / (dt + tau_fast) of that rise, under 9 grey levels at 30 fps."""
    rounding: Literal["nearest", "truncate"] = "nearest"
    """How a number loses its lowest bits. Truncation, as in the public firmware, drops half a step each frame, so that
    every low-pass falls too fast."""
    halved: bool = False
    """Whether the change of luminance is halved to a byte, as in the public firmware: without its lowest bit, clipped
    to -127..127. It counts steps of two grey levels, so thresholds stay the same."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        """Refuse parameters that would overflow or never change a signal, and options without an integer form."""
        for name, legal in READINGS.items():
            if getattr(self, name) != legal:
                given = str(getattr(self, name)).lower()
                raise ValueError(f"{name} must be {str(legal).lower()} in dsnn-onboard, got {given}")
        left = sum(residue(self.u, i) for i in range(1, self.n_p + 1))
        if left > LARGEST_RESIDUE:
            raise ValueError(
                f"the residues of n_p={self.n_p} and u={self.u:g} must sum to 0.99 or less, got {left:.3g}"
            )
        if self.sigma_l > LARGEST_RESIDUE:
            raise ValueError(f"sigma_l must be at most 0.99, or LA leaves 16 bits, got {self.sigma_l:g}")
        for name, tau in (("tau_s", max(self.delays())), ("tau_mp", self.tau_mp)):
            if alpha(tau, self.dt) < LEAST_ALPHA:
                raise ValueError(f"{name} must be at most {65534 * self.dt:g} ms at fps={self.fps:g}, got {tau:g}")
        largest_la = largest_change(self) / (1.0 - self.sigma_l)
        if largest_la > LARGEST_LA:
            raise ValueError(
                f"LA must stay within {LARGEST_LA} grey levels, got up to {largest_la:.3g}"
                f" with n_p={self.n_p}, u={self.u:g}, sigma_l={self.sigma_l:g}"
            )
        if self.f_bits is not None and self.f_bits > most_f_bits(largest_la):
            raise ValueError(
                f"f_bits must be at most {most_f_bits(largest_la)} with an LA of {largest_la:.3g}, got {self.f_bits}"
            )
        return self

    @classmethod
    def presets(cls) -> Mapping[str, Self]:
        """Make the presets: the settings of the robot in several formats.

        ``bits8`` is the default. ``lamina16`` and ``bits16`` have 16 bits for the lamina and for all states.
        ``linear8`` has equal steps, ``truncated`` drops the lowest bits, and ``firmware-input`` halves the change of
        luminance. ``grey-levels`` is a negative control.

        Returns
        -------
        mapping of str to OnboardParams
            Name of the format -> parameters.
        """
        robot = cls.robot()
        changes: Mapping[str, Mapping[str, Any]] = {
            "bits8": {},
            "lamina16": {"lamina_bits": 16},
            "bits16": {"state_bits": 16, "lamina_bits": 16},
            "linear8": {"companding": False},
            "truncated": {"rounding": "truncate"},
            "firmware-input": {"halved": True},
            "grey-levels": {"companding": False, "f_bits": 0, "rounding": "truncate"},
        }
        return {name: dataclasses.replace(robot, **change) for name, change in changes.items()}


def most_f_bits(largest_la: float) -> int:
    """Count the fractional bits of F with which LA - A stays below 2 to the power 30; 15 at most."""
    return min(28 - math.ceil(math.log2(largest_la)), 15)


def largest_change(params: OnboardParams) -> float:
    """Compute the largest ``|P|`` that frames of 0..255 can give, in grey levels.

    P is a linear filter of the frames. Let h be its response to one step of luminance. P weighs the frames by ``h(i) -
    h(i - 1)``, and is largest if all frames of positive weight are 255 and the others 0.
    """
    gains = [residue(params.u, i) for i in range(1, params.n_p + 1)]
    h = [1.0]
    for _ in range(511):
        h.append(math.fsum(a * b for a, b in zip(gains, reversed(h), strict=False)))
    tail = max(1.0 / (1.0 - math.fsum(gains)) - math.fsum(h), 0.0)
    weights = [after - before for before, after in zip([0.0, *h], h, strict=False)]
    either = (math.fsum(max(sign * w, 0.0) for w in weights) for sign in (1, -1))
    return 255.0 * (max(either) + tail)

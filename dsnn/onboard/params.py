"""The parameters of the on-board network: those of the DSNN, and the formats of its numbers."""

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
"""Largest sum of ``a_i``: with 1 or more P grows without bound, and near 1 it leaves 16 bits."""
READINGS: Mapping[str, bool | str] = {"rectified": True, "polarity": "common", "lowpass": "backward-euler"}
"""Open reading of the paper -> the one that is here: F has no bit for a sign, and tables are of these gains."""
LARGEST_LA = 32767
"""Grey levels: LA - A is a whole number of 16 bits."""
LEAST_ALPHA = 0.5 / 32768.0
"""A gain below this is 0 in 15 fractional bits: the low-pass would never move."""


@parameters
class OnboardParams(DSNNParams):
    """The DSNN's parameters, and the formats of the numbers that it computes with.

    The defaults are the format with the least error among those with which the paper's eight spacings fit into the
    robot's memory at 99x72, beside three frames of its camera and 16 kB of other use (``colias firmware budget``).
    """

    state_bits: Annotated[Literal[8, 16], unit("bits")] = 8
    """Width of a delayed signal D; 2 n_con of them a cell are most of the memory, and with n_con = 8 only those of 8
    bits fit into 256 kB beside the camera's frames."""
    companding: bool = True
    """Whether an 8-bit D has segments whose step doubles from one to the next, as G.711 codes speech: equal steps lose
    the small values from which a slow low-pass rises and to which it falls; of no effect on 16 bits."""
    lamina_bits: Annotated[Literal[8, 16], unit("bits")] = 8
    """Width of the LA that is kept for the next frame; with 8 it is a whole number of grey levels that saturates at
    255. 16 take two bytes a cell more: with n_con = 8 they fit beside two camera frames, not three."""
    f_bits: Annotated[int | None, unit("bits")] = Field(default=None, ge=0, le=15)
    """Fractional part of F, which saturates at some 32,000 steps; None: as many as the largest F that a rise of LA
    gives leaves, since F is tau_fast / (dt + tau_fast) of it, under 9 grey levels at 30 fps."""
    rounding: Literal["nearest", "truncate"] = "nearest"
    """How a number loses its lowest bits; truncating, as the public firmware does, drops half a step at each frame, by
    which every low-pass falls too fast."""
    halved: bool = False
    """Whether the change of luminance is halved, without its lowest bit and clipped to -127..127, as in the public
    firmware, where it fits a byte; counted in steps of two grey levels, so that thresholds stay as they are."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        """Refuse what would overflow, or never move, and readings that its whole numbers have no room for."""
        for name, legal in READINGS.items():
            if getattr(self, name) != legal:
                given = str(getattr(self, name)).lower()
                raise ValueError(f"{name}={given}: dsnn-onboard computes one reading: legal is {str(legal).lower()}")
        left = sum(residue(self.u, i) for i in range(1, self.n_p + 1))
        if left > LARGEST_RESIDUE:
            raise ValueError(f"the residues of n_p={self.n_p} and u={self.u:g} sum to {left:.3g}: legal is up to 0.99")
        if self.sigma_l > LARGEST_RESIDUE:
            raise ValueError(f"sigma_l={self.sigma_l:g}: legal is up to 0.99, or LA leaves 16 bits")
        for name, tau in (("tau_s", max(self.delays())), ("tau_mp", self.tau_mp)):
            if alpha(tau, self.dt) < LEAST_ALPHA:
                raise ValueError(f"{name}={tau:g} ms at fps={self.fps:g}: legal is up to {65534 * self.dt:g} ms")
        largest_la = largest_change(self) / (1.0 - self.sigma_l)
        if largest_la > LARGEST_LA:
            raise ValueError(
                f"n_p={self.n_p}, u={self.u:g}, sigma_l={self.sigma_l:g}: LA may reach {largest_la:.3g} grey levels:"
                f" legal is up to {LARGEST_LA}"
            )
        if self.f_bits is not None and self.f_bits > most_f_bits(largest_la):
            raise ValueError(
                f"f_bits={self.f_bits}: legal is up to {most_f_bits(largest_la)} with an LA of {largest_la:.3g}"
            )
        return self

    @classmethod
    def presets(cls) -> Mapping[str, Self]:
        """Make the presets: the settings of the robot in several formats.

        ``bits8`` is the default. ``lamina16`` and ``bits16`` have 16 bits for the lamina and for all states,
        ``linear8`` has equal steps, ``truncated`` drops lowest bits, ``firmware-input`` halves the change of luminance.
        ``grey-levels`` is the control that does not work.

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
    """Return the fractional bits of F with which LA - A stays below 2 to the power 30; 15 at most."""
    return min(28 - math.ceil(math.log2(largest_la)), 15)


def largest_change(params: OnboardParams) -> float:
    """Return the largest ``|P|`` that frames of 0..255 can give, grey levels.

    P is a linear filter of the frames. With h its response to one step of luminance, P weighs the frames by
    ``h(i) - h(i - 1)``; it is largest where all frames of positive weight are 255 and the others 0.
    """
    gains = [residue(params.u, i) for i in range(1, params.n_p + 1)]
    h = [1.0]
    for _ in range(511):
        h.append(math.fsum(a * b for a, b in zip(gains, reversed(h), strict=False)))
    tail = max(1.0 / (1.0 - math.fsum(gains)) - math.fsum(h), 0.0)
    weights = [after - before for before, after in zip([0.0, *h], h, strict=False)]
    either = (math.fsum(max(sign * w, 0.0) for w in weights) for sign in (1, -1))
    return 255.0 * (max(either) + tail)

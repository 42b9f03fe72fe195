"""Parameters of the DSNN, with the paper's names (Fu, Bellotto and Yue 2018, table ``tableParams``)."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any, Literal, Self

from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import alpha


@parameters
class DSNNParams:
    """Parameters of the DSNN. The defaults are the paper's off-line setting.

    Time constants are in milliseconds, lengths in pixels. Ranges are wider than the paper's, which each description
    gives.

    References
    ----------
    Fu, Bellotto and Yue 2018, arXiv 1808.07692: table ``tableParams``.

    Examples
    --------
    >>> from dsnn import DSNNParams
    >>> params = DSNNParams.robot(n_con=4)
    >>> params.t_sp, len(params.delays())
    (0.2, 4)
    """

    n_p: Annotated[int, unit("frames")] = Field(default=2, ge=0, le=60)
    """Duration N_p of the residual luminance change (paper: 0..6)."""
    u: float = Field(default=1.0, ge=0.0, le=100.0)
    """Decay u of the residual luminance change (paper: 1)."""
    d: Annotated[int, unit("px")] = Field(default=1, ge=1, le=16)
    """Detector spacing and DoG width (paper: 1..4)."""
    n_con: int = Field(default=8, ge=1, le=64)
    """Connected cells per cell and direction, N_con (paper: 4..8)."""
    w_i: float = Field(default=0.9, ge=0.0, le=1.0)
    """Weight of inhibition (paper: 0.9)."""
    sigma_l: float = Field(default=0.1, ge=0.0, lt=1.0)
    """Residue of the lamina's signal from frame to frame (paper: 0.1)."""
    tau_fast: Milliseconds = 1.0
    """FDSR time constant on a rise (paper: 1)."""
    tau_slow: Milliseconds = 100.0
    """FDSR time constant on a fall (paper: 100)."""
    tau_s: tuple[Milliseconds, Milliseconds] = (10.0, 200.0)
    """Correlator delay at the nearest and the farthest pair (paper: 10..200)."""
    tau_mp: Milliseconds = 10.0
    """Time constant of the membrane potentials' low-pass (paper: 10)."""
    k_sig: float = Field(default=0.01, gt=0.0, le=1e3)
    """Scale of the sigmoid (paper: 0.01)."""
    k_sp: float = Field(default=2.0, ge=0.0, le=20.0)
    """Spike gain (paper: 1..3)."""
    t_sp: float = Field(default=0.16, ge=0.0, le=1.0)
    """Spike threshold (paper: 0.16..0.2)."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, gt=0.0, le=10_000.0)
    """Frame rate (paper: 30)."""
    on: bool = True
    """Whether the ON pathway is intact; false blocks it."""
    off: bool = True
    """Whether the OFF pathway is intact; false blocks it."""
    dog: bool = True
    """Whether the lamina has its difference of Gaussians; false passes P on unchanged."""
    fdsr: bool = True
    """Whether fast-depolarising-slow-repolarising adaptation acts; false removes it."""
    polarity: Literal["common", "centre"] = "common"
    """Sign of LA (the paper leaves it open). common: the sign that both Gaussians share, and LA is 0 where they differ.
    centre: the centre's sign everywhere."""
    rectified: bool = True
    """Whether F = LA - A is half-wave rectified; false passes it on with its sign (the paper names no rectifier)."""
    lowpass: Literal["backward-euler", "exact", "two-tap", "two-tap-fdsr"] = "backward-euler"
    """Low-passes (the paper gives no gain). backward-euler: recursive, with the gain a = dt / (dt + tau). exact: with
    1 - exp(-dt / tau). two-tap: those of each cell, FDSR and delays, are a x(t) + (1 - a) x(t - 1) of their input, as
    in the first author's public code. two-tap-fdsr: FDSR alone."""

    @classmethod
    def offline(cls, **changes: Any) -> Self:
        """Make the preset of the paper's synthetic and real-footage tests (``t_sp`` 0.16).

        Parameters
        ----------
        **changes
            Other values of parameters, by name.

        Returns
        -------
        DSNNParams
            The parameters.

        Raises
        ------
        pydantic.ValidationError
            A value is out of range, or the parameter is unknown.
        """
        return dataclasses.replace(cls(), **changes)

    @classmethod
    def robot(cls, **changes: Any) -> Self:
        """Make the preset of the on-board tests: ``t_sp`` 0.2, and ``k_sp`` at the low end of the paper's range.

        Parameters
        ----------
        **changes
            Other values of parameters, by name.

        Returns
        -------
        DSNNParams
            The parameters.

        Raises
        ------
        pydantic.ValidationError
            A value is out of range, or the parameter is unknown.
        """
        return dataclasses.replace(cls(t_sp=0.2, k_sp=1.0), **changes)

    @property
    def dt(self) -> float:
        """Frame interval in milliseconds."""
        return 1000.0 / self.fps

    def alpha(self, tau: float) -> float:
        """Compute the gain of a low-pass by the network's discretisation.

        Parameters
        ----------
        tau
            Time constant, ms.

        Returns
        -------
        float
            The share of the distance to its input that the low-pass covers in a frame, 0 to 1.
        """
        return alpha(tau, self.dt, exact=self.lowpass == "exact")

    def delays(self) -> tuple[float, ...]:
        """Compute ``tau_s`` of each spacing, linear from the nearest pair to the farthest.

        Returns
        -------
        tuple of float
            ``n_con`` delays in ms.
        """
        near, far = self.tau_s
        span = max(self.n_con - 1, 1)
        return tuple(near + (far - near) * j / span for j in range(self.n_con))

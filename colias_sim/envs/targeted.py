"""The base class of the envs with a target: the first other robot is the target, the rest are parked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from colias_sim.config import CameraConfig
from colias_sim.envs.base import ColiasEnv
from colias_sim.envs.options import Options
from colias_sim.envs.world import OBSERVER, TARGET, parked_robots
from colias_sim.pose import bearing

HALF_VIEW = math.radians(CameraConfig().hfov_deg / 2)
"""Half of the horizontal field of view, in radians."""


class TargetEnv(ColiasEnv[Options]):
    """Base class of an env whose first other robot is the target."""

    def _others(self) -> Mapping[str, str]:
        return {TARGET: "colias_black"} | parked_robots(self.options.robots - 1)

    def _measures(self) -> dict[str, Any]:
        off = self._bearing()
        return {"bearing_deg": math.degrees(off), "in_view": abs(off) < HALF_VIEW}

    def _centre(self) -> float:
        """Return the reward's term for a centred target: 1 on the axis, 0 at the edge of the view, at least -1."""
        return max(1.0 - abs(self._bearing()) / HALF_VIEW, -1.0)

    def _bearing(self) -> float:
        """Return the target's angle off the optical axis in radians, right positive."""
        eye = self._sim.camera_config.forward_cm / 100
        return bearing(self._sim.robots[OBSERVER].pose, self._sim.robots[TARGET].pose, eye)

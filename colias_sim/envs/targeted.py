"""What the envs with a robot to look at share: one target, the other robots parked, and where it is in the view."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from colias_sim.config import CameraConfig
from colias_sim.envs.base import OBSERVER, TARGET, ColiasEnv, Options, parked
from colias_sim.robot import bearing

HALF_VIEW = math.radians(CameraConfig().hfov_deg / 2)


class TargetEnv(ColiasEnv[Options]):
    """An env whose first other robot is the target."""

    def _others(self) -> Mapping[str, str]:
        return {TARGET: "colias_black"} | parked(self.options.robots - 1)

    def _measures(self) -> dict[str, Any]:
        off = self._bearing()
        return {"bearing_deg": math.degrees(off), "in_view": abs(off) < HALF_VIEW}

    def _centre(self) -> float:
        """The reward of having the target in the middle: 1 there, 0 at the view's edge, at least -1."""
        return max(1.0 - abs(self._bearing()) / HALF_VIEW, -1.0)

    def _bearing(self) -> float:
        """The target's angle off the optical axis in radians, left positive."""
        eye = self._sim.camera_config.forward_cm / 100
        return bearing(self._sim.robots[OBSERVER].pose, self._sim.robots[TARGET].pose, eye)

"""Where the envs' neural observations get their models by name: the one room that knows both sides."""

from __future__ import annotations

from dsnn import VisionModel, model_entry


def build(name: str, shape: tuple[int, int]) -> VisionModel:
    """The registered model ``name`` with its parameters for the robot, for frames of ``shape`` (R, C).

    Raises ``ValueError`` naming the nearest on an unknown name.
    """
    entry = model_entry(name)
    return entry.build(shape, entry.robot)

"""Plan a map: of experiments with the robot, or of off-line ones."""

from __future__ import annotations

from collections.abc import Sequence

from experiments.bench.clips.experiment import OfflineExperiment
from experiments.bench.engine.errors import UsageError
from experiments.bench.maps import clips, robot
from experiments.bench.maps.plan import Asked, MapPlan
from experiments.bench.robot.experiment import Experiment


def planned(experiments: Sequence[Experiment | OfflineExperiment], asked: Asked) -> MapPlan:
    """Check and list all that a map runs.

    Parameters
    ----------
    experiments
        Declarations, all with the robot or all off-line.
    asked
        The rest of what was asked for.

    Raises
    ------
    UsageError
        The experiments are of both kinds, or something asked for is not legal.
    """
    with_robot = [each for each in experiments if isinstance(each, Experiment)]
    offline = [each for each in experiments if isinstance(each, OfflineExperiment)]
    if with_robot and offline:
        said = f"{with_robot[0].name} has a robot and {offline[0].name} is off-line"
        raise UsageError(f"EXPERIMENT: {said}; a map has experiments of one kind")
    return clips.planned(offline, asked) if offline else robot.planned(with_robot, asked)

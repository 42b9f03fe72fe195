"""Measure a camera from folders of its frames: settings of the simulated eye, and what is doubtful about them."""

from pathlib import Path

from colias_sim.calibrate import Measured, exposure, noise, row_time
from experiments.base.errors import UsageError, as_usage_error
from experiments.robot.log_trial import read_frames


def measure(folder: Path, fps: float, gain: float) -> Measured:
    """Measure what the folders in a folder show.

    Parameters
    ----------
    folder
        Its folders hold pictures (``.pgm``, ``.png``, in the order of their numbers) and are named by what they show:
        ``still*`` a still scene of many greys under constant light, ``edge*`` first the empty scene and then a dark
        upright object that crosses the view, ``loop*`` a still scene after the light has changed, until the picture
        rests.
    fps
        Frames per second of ``edge*``.
    gain
        The camera's gain, as ``camera.gain`` has it: noise before it is what the settings hold.

    Returns
    -------
    dict
        Parameter of the camera -> value.
    list of str
        What is doubtful about it.

    Raises
    ------
    UsageError
        There is nothing to measure, or frames do not show what their folder's name says.
    """
    settings: dict[str, object] = {}
    notes: list[str] = []
    kinds = {"still": lambda films: noise(films, gain), "edge": lambda films: row_time(films, fps), "loop": exposure}
    for kind, measured in kinds.items():
        films = [read_frames(path) for path in sorted(folder.glob(f"{kind}*"))]
        with as_usage_error(f"{folder}, {kind}*: "):
            found, doubts = measured(films) if films else ({}, [])
        settings |= found
        notes += [f"{kind}*: {doubt}" for doubt in doubts]
    if not settings and not notes:
        raise UsageError(f"{folder} must have folders of frames called still*, edge* or loop*")
    return settings, notes

"""Tuning curves: what is shown, along which axes. How answers become curves is in `curves`.

Clips have 144x108 px at 30 frames/s. Gratings drift for a second; their wavelengths divide the frame's width, so that
a field's mean does not depend on the phase. Objects start and end whole inside the frame, dark on grey 200. Approaches
have 99x72 px, through the robot's lens, and so has the disc that looms, recedes and crosses.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal

from dsnn.stimuli import StimulusEntry
from experiments.bench.run import settings
from experiments.bench.run.errors import UsageError
from experiments.bench.sources.clips import Clip
from scenes.hints import nearest

Kind = Literal["curve", "map", "polar", "approach"]

FRAME: dict[str, Any] = {"rows": 108, "columns": 144, "rest_s": 0.2}
OBJECT: dict[str, Any] = {"width": 24.0, "height": 24.0, "speed": 120.0, "enters": False}
GRATING: dict[str, Any] = {"period_px": 24.0, "temporal_hz": 2.0, "duration_s": 1.0}

SPEEDS_PX_S = (15.0, 21.0, 30.0, 42.0, 60.0, 85.0, 120.0, 170.0, 240.0, 340.0, 480.0, 680.0)
SIZES_PX = (3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0, 90.0)
CONTRASTS = (0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3, 0.45, 0.65, 0.8, 1.0)
WAVELENGTHS_PX = (4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 36.0, 48.0, 72.0)
TEMPORAL_HZ = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.3)
"""Up to three quarters of the Nyquist frequency of 30 frames/s: above it a drift turns round."""
DIRECTIONS = 16
PHASES = 5
"""Phases of the grating that each direction is shown at: how far a preferred direction varies between them is noise."""
L_OVER_V_S = (0.02, 0.04, 0.08, 0.16, 0.32, 0.64)
SHADES = {"dark looming": (40.0, 200.0), "light looming": (200.0, 40.0)}
"""Grey of the square, and of what is behind it."""
DISC: dict[str, Any] = {"outline": "disc", "start_deg": 8.0, "end_deg": 40.0, "grey": 40.0, "background_grey": 200.0}
DISC_L_OVER_V_S = (0.08, 0.16, 0.32)
LOOMS, RECEDES, CROSSES = "dark disc looming", "dark disc receding", "dark disc crossing"
DISC_LINES = {LOOMS: "looming", RECEDES: "receding", CROSSES: "rightward"}
"""Line -> motion: one disc at one speed. It crosses at the size at which the others end or begin."""
CARDINAL = {0.0: "rightward", 90.0: "downward", 180.0: "leftward", 270.0: "upward"}

STIMULUS = "stimulus"
"""The name of the family that `of_stimulus` makes."""

GROUND = 127.0
"""Grey behind the objects of the contrast curve: as much room above as below."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One thing that varies: the column's name, and the words at the axis."""

    name: str
    label: str


@dataclass(frozen=True, slots=True)
class Probe:
    """A clip at one point of a curve, with the direction its motion has: 0 rightward, 90 downward, degrees."""

    clip: Clip
    line: str
    """Line of the family that it belongs to: the stimulus in words."""
    x: float
    y: float | None = None
    direction_deg: float = 0.0
    repeat: int = 0
    """Added to the run's seed: the same point at another phase. Curves and figures show repeat 0."""


@dataclass(frozen=True, slots=True)
class Family:
    """Tuning curves of one kind: the clips, the axes, how it is drawn.

    A ``curve`` is the response along ``x``; a ``map`` that over ``x`` and ``y``; a ``polar`` that against the
    direction of motion, which is its ``x``; an ``approach`` is of looming models alone, their potential, spikes and
    time to contact along ``x``. Raises ``ValueError`` where two probes are one point of one line.
    """

    name: str
    summary: str
    kind: Kind
    x: Axis
    probes: tuple[Probe, ...]
    y: Axis | None = None

    def __post_init__(self) -> None:
        points = [(probe.line, probe.x, probe.y, probe.repeat) for probe in self.probes]
        if len(set(points)) < len(points):
            raise ValueError(f"{self.name}: two probes at one point")

    @property
    def lines(self) -> tuple[str, ...]:
        """Return the family's lines, in order."""
        return tuple(dict.fromkeys(probe.line for probe in self.probes))

    def shown_to(self, channels: Sequence[str]) -> bool:
        """Tell whether a model that answers by ``channels`` is shown it."""
        return self.kind != "approach" or "looming" in channels


def _clip(name: str, stimulus: str, **changes: Any) -> Clip:
    return Clip(name, stimulus, tuple({**FRAME, **changes}.items()))


def _object(name: str, **changes: Any) -> Clip:
    return _clip(name, "plain", **{**OBJECT, **changes})


def _grating(name: str, **changes: Any) -> Clip:
    return _clip(name, "grating", **{**GRATING, **changes})


def _speed() -> Family:
    probes = (Probe(_object(f"speed {v:g}", speed=v), "dark object", v) for v in SPEEDS_PX_S)
    summary = "a dark square of 24 px, rightward"
    return Family("speed", summary, "curve", Axis("speed_px_s", "speed (px/s)"), tuple(probes))


def _size() -> Family:
    probes = (Probe(_object(f"size {s:g}", width=s, height=s), "dark object", s) for s in SIZES_PX)
    summary = "a dark square, rightward at 120 px/s"
    return Family("size", summary, "curve", Axis("size_px", "side of the square (px)"), tuple(probes))


def _contrast() -> Family:
    """Compute the contrast: of objects, the difference to the ground as a share of it; of gratings, Michelson's."""
    probes = []
    for line, sign in (("dark object", -1), ("light object", 1)):
        for c in CONTRASTS:
            clip = _object(f"{line}, contrast {c:g}", grey=GROUND * (1 + sign * c), background_grey=GROUND)
            probes.append(Probe(clip, line, c))
    for c in CONTRASTS:
        probes.append(Probe(_grating(f"grating, contrast {c:g}", contrast=c), "grating", c))
    summary = "a square of 24 px at 120 px/s on grey 127; a grating of wavelength 24 px at 2 Hz"
    return Family("contrast", summary, "curve", Axis("contrast", "contrast"), tuple(probes))


def _frequency() -> Family:
    probes = (
        Probe(_grating(f"grating {w:g} px, {f:g} Hz", period_px=w, temporal_hz=f), "grating", 1 / w, f)
        for w in WAVELENGTHS_PX
        for f in TEMPORAL_HZ
    )
    x, y = Axis("cycles_px", "spatial frequency (cycles/px)"), Axis("temporal_hz", "temporal frequency (Hz)")
    return Family("frequency", "drifting sine gratings, rightward", "map", x, tuple(probes), y)


def _direction() -> Family:
    turns = [360.0 * i / DIRECTIONS for i in range(DIRECTIONS)]
    probes = [Probe(_grating(f"grating {d:g} deg", direction_deg=d), "grating", d, direction_deg=d) for d in turns]
    probes += [replace(probe, repeat=phase) for phase in range(1, PHASES) for probe in probes]
    for d, motion in CARDINAL.items():
        probes.append(Probe(_object(f"object {d:g} deg", motion=motion), "dark object", d, direction_deg=d))
    axis = Axis("direction_deg", "direction of motion (degrees)")
    summary = "a grating of wavelength 24 px at 2 Hz in 16 directions; a dark square of 24 px at 120 px/s in 4"
    return Family("direction", summary, "polar", axis, tuple(probes))


def _l_over_v() -> Family:
    probes = (
        Probe(Clip(f"{line} {s:g} s", "looming", (("l_over_v_s", s), ("grey", grey), ("background_grey", ground))),
              line, s)
        for line, (grey, ground) in SHADES.items()
        for s in L_OVER_V_S
    )  # fmt: skip
    summary = "a square that looms at the centre, through the robot's lens, to looming models"
    return Family("l-over-v", summary, "approach", Axis("l_over_v_s", "l / v (s)"), tuple(probes))


def _disc() -> Family:
    probes = (
        Probe(Clip(f"{line} {s:g} s", "looming", tuple({**DISC, "motion": motion, "l_over_v_s": s}.items())), line, s)
        for line, motion in DISC_LINES.items()
        for s in DISC_L_OVER_V_S
    )
    summary = "a disc that grows from 8 to 40 degrees, shrinks, or crosses at 40, to looming models"
    return Family("disc", summary, "approach", Axis("l_over_v_s", "l / v (s)"), tuple(probes))


_DECLARED = {
    "speed": _speed, "size": _size, "contrast": _contrast, "frequency": _frequency, "direction": _direction,
    "l-over-v": _l_over_v, "disc": _disc,
}  # fmt: skip
"""Name -> what builds the family; that builds every clip of it once, to see that it can be."""

CURVES = tuple(_DECLARED)
"""The names of the curve families, in order."""


@cache
def curve_family(name: str) -> Family:
    """Return the family called ``name``, one of `CURVES`; built when it is first asked for."""
    return _DECLARED[name]()


def families(names: Iterable[str]) -> tuple[Family, ...]:
    """Return the families called ``names``, all of them for none; `UsageError` on an unknown name."""
    wanted = list(dict.fromkeys(names))
    for name in wanted:
        if name not in CURVES:
            raise UsageError(f"--curve {name}{nearest(name, CURVES, ' (', ')')}: known are {', '.join(CURVES)}")
    return tuple(curve_family(name) for name in CURVES if not wanted or name in wanted)


def of_stimulus(entry: StimulusEntry, assigned: Mapping[str, str], over: str, seed: int) -> Family:
    """Return the family of a stimulus by name or of a user's own file: its clips along one of its parameters.

    Parameters
    ----------
    entry
        The stimulus.
    assigned
        Its other parameters, name -> text, as ``--set`` has them.
    over
        ``NAME.PARAM=V1,V2,...``, or ``PARAM=...``, as typed after ``--over``.
    seed
        Of the run: the direction of a clip's motion is read from its truth at this seed.

    Raises
    ------
    UsageError
        The parameter is unknown or has no numbers, a value is not legal, or two are equal.
    """
    key, equals, text = over.partition("=")
    name = key.removeprefix(f"{entry.name}.")
    if not equals:
        raise UsageError(f"--over {over}: legal is {entry.name}.PARAM=V1,V2, with numbers")
    settings.collect([f"{entry.name}.{name}={text}"], {entry.name: entry.params},
                     f"colias stimulus {entry.name} --parameters", "--over")  # fmt: skip
    if type(getattr(entry.params, name)) not in (int, float):
        raise UsageError(f"--over {over}: {name} is no number, so nothing can be drawn along it")
    probes = []
    for value in text.split(","):
        typed = {**assigned, name: value.strip()}
        params = settings.changed(
            entry.name, entry.params, typed, lambda param, value: f"--over {entry.name}.{param}={value}"
        )
        changes = {param: getattr(params, param) for param in typed}
        try:
            clip = Clip(f"{name} {changes[name]:g}", entry, tuple(changes.items()))
            direction = direction_deg(clip, seed)
        except ValueError as error:
            raise UsageError(f"--over {over}: {error}") from error
        probes.append(Probe(clip, entry.name, float(changes[name]), direction_deg=direction))
    try:
        unit = settings.unit_of(entry.params, name)
        axis = Axis(name, f"{name.removesuffix('_' + unit.replace('/', '_')).replace('_', ' ')} ({unit or 'no unit'})")
        return Family(STIMULUS, f"{entry.name}: {entry.summary}", "curve", axis, tuple(probes))
    except ValueError:
        raise UsageError(f"--over {over}: legal is one or more values, each given once") from None


def direction_deg(clip: Clip, seed: int) -> float:
    """Return the direction of a clip's motion by its truth: that of the mean velocity over its moving frames, degrees.

    The velocity is the object's, or the background's where there is no object. Rightward, 0, where the truth gives
    none, or motions that cancel.
    """
    truths = [frame.truth for frame in clip.build(seed)]
    velocities = [truth.velocity or truth.background_velocity for truth in truths if truth.motion != "still"]
    x, y = (sum(velocity[axis] for velocity in velocities) for axis in (0, 1))
    return math.degrees(math.atan2(y, x)) % 360.0 if math.hypot(x, y) > 1e-9 * max(len(velocities), 1) else 0.0

"""The clips that the claims of the models' own papers are about, by groups."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

from experiments.declare.clip import Clip

L_OVER_V_S = (0.08, 0.16, 0.32)
OFF_CENTRE_DEG, OFF_CENTRE_S = (-20.0, 20.0), 0.16
FRAME = (("rows", 72), ("columns", 99))
DARK, LIGHT = (("grey", 40.0), ("background_grey", 200.0)), (("grey", 200.0), ("background_grey", 40.0))
DIRECTIONS = ("rightward", "leftward", "downward", "upward")
SPEEDS_PX_S, SIDE_PX = (60.0, 120.0), 25.0
GRATING = (("period_px", 16.0), ("contrast", 0.8))
GRATING_HZ, GRATING_DEG = (2.0, 4.0), (0.0, 90.0, 180.0, 270.0)
BEHIND = (
    ("grey", 40.0), ("background_grey", 127.5), ("background", "grating"), ("period_px", 16.0), ("contrast", 0.4),
    ("temporal_hz", 2.0),
)  # fmt: skip
FAINT = 4.0
"""What the contrast of a faint grating is divided by."""
PANNING = ("dead-leaves", "pink", "foliage", "street")


def _looming(group: str, *changes: tuple[str, Any]) -> tuple[Clip, ...]:
    """A clip for each l / v."""
    return tuple(Clip(f"{group} {s:g} s", "looming", (("l_over_v_s", s), *changes)) for s in L_OVER_V_S)


def _off_centre() -> tuple[Clip, ...]:
    changes = (("l_over_v_s", OFF_CENTRE_S), *DARK)
    return tuple(Clip(f"off-centre {a:+g} deg", "looming", (("azimuth_deg", a), *changes)) for a in OFF_CENTRE_DEG)


def _translating() -> tuple[Clip, ...]:
    size = (*FRAME, ("width", SIDE_PX), ("height", SIDE_PX))
    return tuple(
        Clip(f"translating {shade} {way} {speed:g} px/s", "plain", (*size, ("motion", way), ("speed", speed), *greys))
        for shade, greys in (("dark", DARK), ("light", LIGHT))
        for way in DIRECTIONS
        for speed in SPEEDS_PX_S
    )


def _gratings(group: str, *changes: tuple[str, Any]) -> tuple[Clip, ...]:
    shared = (*FRAME, *changes)
    return tuple(
        Clip(f"{group} {hz:g} Hz {deg:g} deg", "grating", (*shared, ("temporal_hz", hz), ("direction_deg", deg)))
        for hz in GRATING_HZ
        for deg in GRATING_DEG
    )


def _panning() -> tuple[Clip, ...]:
    """Scenes without an object, of several kinds, all at one speed."""
    shared = (*FRAME, ("object", "absent"), ("background_speed", -SPEEDS_PX_S[0]))
    return tuple(Clip(f"panning {scene}", "cluttered", (("background", scene), *shared)) for scene in PANNING)


def _targets(group: str, *changes: tuple[str, Any], fps: float = 1000.0, **over: Iterable[Any]) -> tuple[Clip, ...]:
    """Small targets on an even ground, or before a scene: a clip for each value of one parameter."""
    ((name, values),) = over.items()
    shared = (("fps", fps), ("duration_s", 0.4), *TARGET, *changes)
    return tuple(Clip(f"{group} {value}", "target", dict((*shared, (name, value)))) for value in values)


def _reverse_phi() -> tuple[Clip, ...]:
    return tuple(Clip(f"reverse-phi {way}", "reverse-phi", (*FRAME, ("motion", way))) for way in DIRECTIONS)


TARGET = (("background", "even"), ("background_speed", 0.0), ("speed", 200.0))
SMALL_PX, TALL_PX, FAST = (3.0, 5.0), (12.0, 15.0), ("speed", 150.0)
"""Heights of targets; the speed of those at 30 frames/s, which go on by their width in a frame."""
RECEDING = ("motion", "receding")
GROUPS: Mapping[str, tuple[Clip, ...]] = MappingProxyType(
    {
        "dark-looming": _looming("dark-looming", *DARK),
        "light-looming": _looming("light-looming", *LIGHT),
        "dark-receding": _looming("dark-receding", RECEDING, *DARK),
        "light-receding": _looming("light-receding", RECEDING, *LIGHT),
        "off-centre": _off_centre(),
        "low-contrast": _looming("low-contrast", ("grey", 160.0), ("background_grey", 200.0)),
        "translating": _translating(),
        "gratings": _gratings("gratings", *GRATING),
        "faint-gratings": _gratings("faint-gratings", GRATING[0], ("contrast", dict(GRATING)["contrast"] / FAINT)),
        "before-grating": _looming("before-grating", *BEHIND),
        "grating-alone": _looming("grating-alone", *BEHIND, ("object", "absent")),
        "panning-scenes": _panning(),
        "reverse-phi": _reverse_phi(),
        "small-targets": _targets("small target", height=SMALL_PX),
        "tall-targets": _targets("tall target", height=TALL_PX),
        "low-targets": _targets("low target", height=(1.0,)),
        "timely-targets": _targets("timely target", speed=(100.0, 200.0, 300.0)),
        "untimely-targets": _targets("untimely target", speed=(20.0, 1500.0)),
        "dark-targets": _targets("dark target", ("background_grey", 200.0), grey=(0.0,)),
        "light-targets": _targets("light target", ("background_grey", 55.0), grey=(255.0,)),
        "targets-in-clutter": _targets(
            "target before", ("background_speed", 100.0), ("speed", 150.0), background=PANNING
        ),
        "small-targets-30": _targets("small target at 30 Hz", FAST, fps=30.0, height=SMALL_PX),
        "tall-targets-30": _targets("tall target at 30 Hz", FAST, fps=30.0, height=TALL_PX),
        "looming-100": _looming("looming-100", ("fps", 100.0), *DARK),
    }
)
"""Group -> its clips. All are 99x72 px, as seen by the robot's camera."""


def names(groups: Iterable[str]) -> tuple[str, ...]:
    """The names of the clips of some groups."""
    return tuple(clip.name for group in groups for clip in GROUPS[group])


CLIPS: Mapping[str, Clip] = {clip.name: clip for clips in GROUPS.values() for clip in clips}
"""Every clip, by its name."""

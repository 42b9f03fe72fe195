"""Tuning curves: the clips that models are shown, the run, and what each model prefers.

Clips have 144x108 px at 30 frames/s. Gratings drift for a second; their wavelengths divide the frame's width, so that
a field's mean does not depend on the phase. Objects start and end whole inside the frame, dark on grey 200. Approaches
have 99x72 px, through the robot's lens, and so has the disc that looms, recedes and crosses.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import polars as pl

from dsnn.stimuli.looming import Looming
from experiments.base.console import count, show_files
from experiments.base.errors import UsageError, check_known
from experiments.declare.clip import Clip
from experiments.draw import style, tuning
from experiments.judge import curves
from experiments.kinds.result import Kind, Run, concluding
from experiments.settings.models import COMPARED, shown_models
from experiments.settings.parameters import differing
from experiments.settings.settings import check_counts, watchers
from experiments.show.clips import TRIALS, ClipTrial
from experiments.show.play import FRAMES, play
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import RunFolder
from experiments.store.plan import Plan

EXPERIMENT = "tuning"
FRAME: dict[str, Any] = {"rows": 108, "columns": 144, "rest_s": 0.2}
SQUARE: dict[str, Any] = {**FRAME, "width": 24.0, "height": 24.0, "speed": 120.0, "enters": False}
GRATING: dict[str, Any] = {**FRAME, "period_px": 24.0, "temporal_hz": 2.0, "duration_s": 1.0}
DISC: dict[str, Any] = {"outline": "disc", "start_deg": 8.0, "end_deg": 40.0, "grey": 40.0, "background_grey": 200.0}

SPEEDS_PX_S = (15.0, 21.0, 30.0, 42.0, 60.0, 85.0, 120.0, 170.0, 240.0, 340.0, 480.0, 680.0)
SIZES_PX = (3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0, 90.0)
CONTRASTS = (0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3, 0.45, 0.65, 0.8, 1.0)
"""Of objects the difference to the ground as a share of it, of gratings Michelson's."""
GROUND = 127.0
"""Grey behind the objects of the contrast curve: as much room above as below."""
WAVELENGTHS_PX = (4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 36.0, 48.0, 72.0)
TEMPORAL_HZ = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.3)
"""Up to three quarters of the Nyquist frequency of 30 frames/s: above it a drift turns round."""
DIRECTIONS_DEG = tuple(22.5 * i for i in range(16))
PHASES = 5
"""Phases of the grating that each direction is shown at: how far a preferred direction varies between them is noise."""
CARDINAL = {0.0: "rightward", 90.0: "downward", 180.0: "leftward", 270.0: "upward"}
L_OVER_V_S = (0.02, 0.04, 0.08, 0.16, 0.32, 0.64)
DISC_L_OVER_V_S = (0.08, 0.16, 0.32)
DARK, GRATINGS, LOOMING = "dark object", "grating", "dark looming"
"""Lines that preferences are read from."""
LOOMS, RECEDES, CROSSES = "dark disc looming", "dark disc receding", "dark disc crossing"
"""One disc at one speed. It crosses at the size at which the others end or begin."""
CURVES: Mapping[str, tuple[str, ...]] = {
    "speed": ("speed_px_s",), "size": ("size_px",), "contrast": ("contrast",),
    "frequency": ("cycles_px", "temporal_hz"), "direction": ("direction_deg",),
    "l-over-v": ("l_over_v_s",), "disc": ("l_over_v_s",),
}  # fmt: skip
"""Curve, or map, of responses -> the columns of its axes. Those over l/v are shown to looming models alone."""
AXES = ("speed_px_s", "size_px", "contrast", "cycles_px", "temporal_hz", "l_over_v_s")
"""Columns of axes in ``tuning.csv``."""
RANGES = ("speed_px_s", "size_px", "wavelength_px", "temporal_hz")
Row = Mapping[str, Any]


def shown_at(
    curve: str, line: str, name: str, stimulus: str, x: float, y: float | None = None, repeat: int = 0, **changes: Any
) -> tuple[Clip, Row]:
    """Return a clip with the point of a curve that it is: columns of `curves.points_schema`.

    ``repeat`` is added to the run's seed: the same point at another phase. Curves and figures show repeat 0.
    """
    turn = x if curve == "direction" else 0.0
    point = {"curve": curve, "line": line, "x": x, "y": y, "direction_deg": turn, "repeat": repeat}
    return Clip(name, stimulus, tuple(changes.items())), point | dict(zip(CURVES[curve], (x, y), strict=False))


def clips() -> Iterator[tuple[Clip, Row]]:
    """Yield the clips of all curves, each with the point that it is."""
    for v in SPEEDS_PX_S:
        yield shown_at("speed", DARK, f"speed {v:g}", "plain", v, **SQUARE | {"speed": v})
    for s in SIZES_PX:
        yield shown_at("size", DARK, f"size {s:g}", "plain", s, **SQUARE | {"width": s, "height": s})
    for (line, sign), c in product(((DARK, -1), ("light object", 1)), CONTRASTS):
        greys = {"grey": GROUND * (1 + sign * c), "background_grey": GROUND}
        yield shown_at("contrast", line, f"{line}, contrast {c:g}", "plain", c, **SQUARE | greys)
    for c in CONTRASTS:
        yield shown_at("contrast", GRATINGS, f"grating, contrast {c:g}", "grating", c, **GRATING | {"contrast": c})
    for wave, f in product(WAVELENGTHS_PX, TEMPORAL_HZ):
        drift = {"period_px": wave, "temporal_hz": f}
        yield shown_at(
            "frequency", GRATINGS, f"grating {wave:g} px, {f:g} Hz", "grating", 1 / wave, f, **GRATING | drift
        )
    for phase, d in product(range(PHASES), DIRECTIONS_DEG):
        drift = {"direction_deg": d}
        yield shown_at("direction", GRATINGS, f"grating {d:g} deg", "grating", d, repeat=phase, **GRATING | drift)
    for d, motion in CARDINAL.items():
        yield shown_at("direction", DARK, f"object {d:g} deg", "plain", d, **SQUARE | {"motion": motion})
    for (line, grey, ground), s in product(((LOOMING, 40.0, 200.0), ("light looming", 200.0, 40.0)), L_OVER_V_S):
        yield shown_at("l-over-v", line, f"{line} {s:g} s", "looming", s, l_over_v_s=s, grey=grey,
                       background_grey=ground)  # fmt: skip
    discs = {LOOMS: "looming", RECEDES: "receding", CROSSES: "rightward"}
    for (line, motion), s in product(discs.items(), DISC_L_OVER_V_S):
        yield shown_at("disc", line, f"{line} {s:g} s", "looming", s, l_over_v_s=s, motion=motion, **DISC)


# What is run.


def plan(asked: Asked) -> Plan[ClipTrial]:
    """Return the plan of tuning curves; `UsageError` for what cannot be run.

    Parameters
    ----------
    asked
        What was asked for. Its option is ``curves``: the curves' names, otherwise all.
    """
    names = tuple(asked.option("curves", ()))
    check_counts(asked.seed)
    for name in names:
        check_known("--curve", name, CURVES)
    chosen = watchers(shown_models(COMPARED, asked.models, asked.only), asked.values)
    looming = tuple(model for model in chosen if "looming" in model.channels)
    points, trials = list[Row](), list[ClipTrial]()
    for clip, point in clips():
        watching, repeat = looming if "l_over_v_s" in point else chosen, point["repeat"]
        if watching and (not names or point["curve"] in names):
            points.append(point)
            trials.append(ClipTrial(EXPERIMENT, len(trials), repeat, asked.seed + repeat, clip, watching))
    if not trials:
        raise UsageError(f"--curve {names[0]}: no model shown has a looming potential; add one by --model")
    models, seed = trials[0].models, trials[0].seed  # approaches, which fewer models see, come last
    changed = differing(models, offline=True)
    resolved = {
        "experiment": EXPERIMENT, "seed": seed, "trials": len(trials), "models": models,
        "changed": changed, "curves": list(dict.fromkeys(point["curve"] for point in points)),
        **provenance.of([model.source for model in models]),
    }  # fmt: skip
    return Plan(asked, EXPERIMENT, trials, play, resolved, (TRIALS, FRAMES), tuple(points), models, changed, "clips")


# What it comes to.


def conclude(plan: Plan[ClipTrial], folder: RunFolder) -> None:
    """Write ``tuning.csv``, ``preferences.csv`` and a figure for each curve."""
    points = responses(plan, folder.table("frames"))
    rows = [preferences(points, m.label, m.channels) for m in plan.models if m.label in points["model"]]
    if rows:
        folder.write_rows("tuning.csv", points.drop("x", "y").to_dicts())
        folder.write_rows("preferences.csv", pl.DataFrame(rows, infer_schema_length=None).drop(RANGES).to_dicts())
    for name in dict.fromkeys(point["curve"] for point in plan.declared):
        if len(own := points.filter(curve=name)):
            style.save(tuning.draw(own, CURVES[name], plan.parameters), folder.folder / name)


def responses(plan: Plan[ClipTrial], frames: pl.DataFrame) -> pl.DataFrame:
    """Return the points (`curves.points_schema`) of the clips whose ``frames`` are there, by clip, then model."""
    potentials = frames.partition_by("trial", "model", as_dict=True)
    rows = []
    for point, trial in zip(plan.declared, plan.trials, strict=True):
        clip = trial.condition.build(trial.seed)
        moving = np.flatnonzero([frame.truth.motion != "still" for frame in clip])
        contact_s = clip.contact_s() if isinstance(clip, Looming) else None
        if contact_s is not None:  # a potential may lag behind what looms, recedes or crosses
            moving = np.arange(moving[0], len(clip))
        for model in trial.models:
            if (own := potentials.get((trial.index, model.label))) is not None:
                series = {name: own[name].to_numpy() for name in ("hs", "vs", "looming", "looming_spikes")}
                rows.append({**point, "model": model.label, **curves.response(
                    series, moving, point["direction_deg"], model.channels,
                    approach="l_over_v_s" in point, contact_s=contact_s,
                )})  # fmt: skip
    return pl.DataFrame(rows, curves.points_schema(AXES))


def preferences(points: pl.DataFrame, model: str, channels: Sequence[str]) -> dict[str, Any]:
    """Return what a model prefers, by its points: a row of ``preferences.csv``, and its `RANGES` as texts.

    A range has its ends, and whether they are inside what was shown. ``dsi`` and ``prefers_deg`` are those of HS, or of
    a looming detector's potential, for gratings; ``error_deg`` is how far (hs, vs) points off them. ``fires_deg`` is
    the full angle at which a dark looming square makes it spike first, the median over l/v. ``looming_by_potential``
    and ``looming_by_spikes`` are from `prefers_looming`. What is within the noise is ``None``, and ``not_defined`` says
    why; so is what was not shown.
    """
    own = points.filter(pl.col("model") == model)
    undefined: dict[str, str] = {}
    contrast = curves.line(own, "contrast", DARK)
    x, y, response = curves.grid(own.filter(pl.col("curve") == "frequency"))
    known = np.nan_to_num(response, nan=-math.inf)
    waves, rates = (known.max(axis=axis, initial=-math.inf) for axis in (0, 1))
    fired = curves.line(own, "l-over-v", LOOMING).drop_nulls("contact_s")
    angles = 2 * np.degrees(np.arctan(fired["x"] / fired["contact_s"]))
    return {
        "model": model,
        **_range("speed_px_s", curves.line(own, "speed", DARK), undefined),
        **_range("size_px", curves.line(own, "size", DARK), undefined),
        "half_contrast": curves.half_contrast(contrast["x"], contrast["response"]),
        **_range("wavelength_px", {"x": 1 / x, "response": waves}, undefined, response),
        **_range("temporal_hz", {"x": y, "response": rates}, undefined, response),
        "slope": None if "temporal_hz" in undefined else curves.speed_slope(x, curves.best_rows(y, response)),
        **_of_directions(own, curves.directional(channels), undefined),
        "fires_deg": float(np.median(angles)) if len(angles) else None,
        "looming_by_potential": prefers_looming(own, "response"),
        "looming_by_spikes": prefers_looming(own, "spikes"),
        "not_defined": "; ".join(f"{name}: {why}" for name, why in undefined.items()),
    }


def _range(name: str, line: Any, undefined: dict[str, str], shape: Any = None) -> dict[str, Any]:
    """Return the columns of a preferred range of ``x`` by ``response``; why there is none goes into ``undefined``."""
    x, response = line["x"], line["response"]
    best = curves.preferred(x, response)
    text = best and curves.range_text(x, best)
    if text and text != "flat" and (why := curves.undefined_peak(response if shape is None else shape)):
        undefined[name] = why
        best = text = None
    low, high = best or (None, None)
    return {name: text, f"{name}_low": low, f"{name}_high": high, f"{name}_inside": best and curves.inside(x, best)}


def _of_directions(own: pl.DataFrame, directional: bool, undefined: dict[str, str]) -> dict[str, Any]:
    """Return the preferences of direction; why they are not defined goes into ``undefined``."""
    phases = [curves.line(own, "direction", GRATINGS, repeat) for repeat in range(PHASES)]
    # An index over some of the directions alone would be wrong, not rough.
    first, *_ = phases = [phase if len(phase) == len(DIRECTIONS_DEG) else phase.clear() for phase in phases]
    found = [curves.selectivity(phase["x"], phase["hs" if directional else "looming"]) for phase in phases]
    known = [selectivity for selectivity in found if selectivity]
    dsi, prefers = found[0] or (None, None)
    why = curves.undefined_direction([turn for _, turn in known], DIRECTIONS_DEG[1])
    if why and dsi is not None and max(known)[0] >= curves.SOME_DSI:
        undefined |= {"dsi": why, "prefers_deg": why}
        dsi = prefers = None
    vs = curves.selectivity(first["x"], first["vs"]) if directional else None
    error = curves.pointing_error(first) if directional else None
    return {"dsi": dsi, "prefers_deg": prefers, "vs_dsi": vs and vs[0], "error_deg": error}


def prefers_looming(own: pl.DataFrame, value: str) -> float | None:
    """Return the share of l/v at which a looming disc has more of a ``value`` than one that recedes or crosses.

    More by 1 % of the largest: two potentials at their ceiling are equal. ``None`` where the discs were not shown.
    """
    discs = own.filter(pl.col("curve") == "disc").pivot("line", index="x", values=value)
    if not {LOOMS, RECEDES, CROSSES} <= {*discs.columns}:
        return None
    others = np.maximum(discs[RECEDES].to_numpy(), discs[CROSSES].to_numpy())
    return float(np.mean(curves.PLATEAU * discs[LOOMS].to_numpy() > others))


# Reading it.


def show(run: Run) -> None:
    """Print what each model prefers, and where everything is."""
    if run.done and (run.folder / "preferences.csv").is_file():
        tuning.show(run.summary)
    show_files(run.folder, count(len(run.models), "model"))


DRAWN = "a run of tuning curves has a figure for each curve; see the pictures there"

KIND = Kind(plan, concluding(conclude), DRAWN, show, renders=False, summary="preferences.csv")

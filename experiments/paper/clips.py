"""The experiments with clips of synthetic stimuli, without a robot: the paper's, and three beyond it, which say so."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from typing import Any

from experiments import Clip, ClipFigure, OfflineExperiment

SIDEWAYS, DEPTH = ("rightward", "leftward"), ("looming", "receding")
EARLIER = ("dsnn", "dsn2017", "dsn2017:k_sig=33.22")
"""The DSNN and its forerunner of 2017, also with its gain matched."""


def cluttered(name: str, **changes: Any) -> Clip:
    """Declare a clip of an object before a natural image."""
    return Clip(name, "cluttered", changes)


# --- on an even ground ------------------------------------------------------------------------------------------------

SHADES = {"dark": (40.0, 200.0), "light": (200.0, 40.0)}
"""Object and ground: the golden vectors' greys, and the same exchanged."""
LONG_EDGE_AHEAD = dict.fromkeys(SIDEWAYS, (50.0, 90.0)) | dict.fromkeys(("downward", "upward"), (90.0, 50.0))
"""The rectangle is turned for the vertical motions: what moves is as long an edge."""


def _plain(motions: Iterable[str]) -> tuple[Clip, ...]:
    """Declare clips of a dark and a light object; those in depth begin as wide as a sideways one."""
    clips = []
    for (shade, (grey, ground)), motion in product(SHADES.items(), motions):
        width, height = LONG_EDGE_AHEAD.get(motion, (50.0, 90.0))
        changes = {"motion": motion, "grey": grey, "background_grey": ground, "width": width, "height": height}
        clips.append(Clip(f"{shade} {motion}", "plain", changes))
    return tuple(clips)


# The paper's simu-clean.
CLEAN = OfflineExperiment(
    "clean", "dark and light objects translate, loom and recede on an even ground",
    _plain((*LONG_EDGE_AHEAD, *DEPTH)), ("dsnn",), ("C1", "C2", "C3"),
)  # fmt: skip
# What ON and OFF each add: simu-clean-dth and -dtv.
BLOCKED = OfflineExperiment(
    "blocked", "translations on an even ground, with the ON or the OFF pathway blocked",
    _plain(LONG_EDGE_AHEAD), ("dsnn", "dsnn-on-blocked", "dsnn-off-blocked"), ("C4",),
)  # fmt: skip
# Which edge drives which. The leading edge of a dark object, as the trailing edge of a light one, darkens what it
# passes: an OFF edge. The other two brighten it: ON edges.
EDGES = OfflineExperiment(
    "edges", "one edge in view, ON or OFF, with either pathway blocked",
    [
        Clip(f"{label} {motion} {speed:g}", "edge", {"polarity": polarity, "motion": motion, "speed": speed})
        for polarity, label in (("off", "OFF (dark leads)"), ("on", "ON (dark trails)"))
        for motion, speed in product(SIDEWAYS, (60.0, 120.0))
    ],
    ("dsnn", "dsnn-on-blocked", "dsnn-off-blocked"), ("C22",),
)  # fmt: skip
# The paper's motion-models. With w_i = 1 the DSNN's answers to a single step cancel. An EMD of the same spacing
# correlates steps of either sign, and answers opposite signs the other way: a four-quadrant detector.
APPARENT = OfflineExperiment(
    "apparent", "two bars step one after the other, ON or OFF each",
    [
        Clip(f"{signs} {motion} {delay}", "apparent", {"polarity": signs, "motion": motion, "delay_frames": delay})
        for delay, signs, motion in product((1, 2), ("on-on", "off-off", "on-off", "off-on"), SIDEWAYS)
    ],
    ("dsnn", "dsnn:w_i=1", "emd:spacing=4"), ("C23",),
)  # fmt: skip

# --- before clutter ---------------------------------------------------------------------------------------------------

EXTREMES = {"dark": 0.0, "light": 255.0}
"""Darker and lighter than anything of the photograph."""
GREYS, SPEEDS = (0.0, 64.0, 128.0, 191.0, 255.0), (40.0, 60.0, 80.0, 100.0, 120.0)
SHIFTS = (-2.0, -4.0, -6.0, -8.0, -10.0)
"""Speeds of the background, px/s."""

# The paper's simu-nature-depth, -trans, simu-sys-speed and -grayscale.
CLUTTER_DEPTH = OfflineExperiment(
    "clutter-depth", "dark and light objects loom and recede before a natural image shifting at +8 px/s",
    [
        cluttered(f"{shade} {motion}", motion=motion, grey=EXTREMES[shade], background_speed=8.0)
        for shade, motion in product(EXTREMES, DEPTH)
    ],
    EARLIER, ("C5",), repeats=5,
)  # fmt: skip
CLUTTER_TRANSLATION = OfflineExperiment(
    "clutter-translation", "dark and light objects cross before a natural image shifting at -8 px/s",
    [cluttered(f"{shade} rightward", grey=grey, background_speed=-8.0) for shade, grey in EXTREMES.items()],
    EARLIER, ("C6",), repeats=5,
)  # fmt: skip
CLUTTER_SPEED = OfflineExperiment(
    "clutter-speed", "crossings at 40, 80, 120 px/s before a natural image shifting at -2 .. -10 px/s",
    [
        cluttered(f"{shade} {speed:g} before {shift:g}", grey=EXTREMES[shade], speed=speed, background_speed=shift)
        for shade, shift, speed in product(EXTREMES, SHIFTS, (40.0, 80.0, 120.0))
    ],
    EARLIER, ("C7", "C8"), repeats=2, recorded=False,
    figure=ClipFigure("peaks", along="speed", lines="background_speed", panels="grey"),
)  # fmt: skip
CLUTTER_CONTRAST = OfflineExperiment(
    "clutter-contrast", "objects of five greys cross at 40 .. 120 px/s before a natural image shifting at -8 px/s",
    [
        *(cluttered(f"grey {grey:g} at {speed:g}", grey=grey, speed=speed) for grey, speed in product(GREYS, SPEEDS)),
        cluttered("background alone", object="absent", speed=40.0),
    ],
    (
        "dsnn", "emd", "dsnn:n_con=1", "dsnn:n_con=2",
        "emd:gain=0.7732",  # its gain matched
        "dsnn:n_con=1,k_sig=0.00125", "dsnn:n_con=2,k_sig=0.0025",  # as a mean per correlator
    ),
    ("C9", "C10", "C11", "C24", "C26"), repeats=2, recorded=False, figure=ClipFigure("contrast"),
)  # fmt: skip
# What the DoG pre-filter and FDSR each take off the potentials; the last two with their gain matched.
BACKGROUND_ALONE = OfflineExperiment(
    "background-alone", "a natural image shifts at -2 .. -10 px/s, without DoG or FDSR",
    [cluttered(f"alone at {shift:g}", object="absent", background_speed=shift) for shift in SHIFTS],
    ("dsnn", "dsnn:dog=false", "dsnn:fdsr=false", "dsnn:dog=false,k_sig=0.3056", "dsnn:fdsr=false,k_sig=33.22"),
    ("C27",), repeats=5, figure=ClipFigure("background"),
)  # fmt: skip

PER_FRAME = (CLUTTER_DEPTH, CLUTTER_TRANSLATION, CLUTTER_SPEED, CLUTTER_CONTRAST, BACKGROUND_ALONE)
"""The experiments whose clips `clutter-frames` shows; their claims are judged under this reading too."""


def prefix(experiment: OfflineExperiment) -> str:
    """Return what the names of the clips of an experiment begin with in ``clutter-frames``."""
    return f"{experiment.name}: "


# At 30 frames a second that is 30 times as fast: beyond any correlator's span.
CLUTTER_FRAMES = OfflineExperiment(
    "clutter-frames",
    "the clips before clutter with speeds read as px per frame, as the paper writes them, and not as px/s",
    [
        replace(clip, name=prefix(experiment) + clip.name, changes=dict(clip.changes) | {"speed_unit": "px/frame"})
        for experiment in PER_FRAME
        for clip in experiment.clips
    ],
    ("dsnn", "dsn2017", "emd", "dsnn:n_con=1", "dsnn:n_con=2", "dsnn:dog=false", "dsnn:fdsr=false"),
    repeats=2, recorded=False, figure=ClipFigure("ranges"),
)  # fmt: skip

# The paper's real-world, in a street of our own rendering.
CAR = {"kind": "car", "height": 42.0, "speed": 120.0}
"""122 px long, at the fastest of the paper's synthetic clips: 4 m/s of a car of 4.2 m, as on a campus avenue."""
STREET = OfflineExperiment(
    "street", "a walker, a car, two one after the other in opposite directions, a group, among windblown foliage",
    [
        Clip("foliage alone", "street", {"object": "absent"}),
        *(
            Clip(name.format(way), "street", {"motion": way, **changes})
            for name, changes in (
                ("person {}", {}), ("car {}", CAR), ("two, {} first", {"movers": "opposite"}),
                ("group {}", {"movers": "group"}),
            )
            for way in SIDEWAYS
        ),
    ],
    ("dsnn",), ("C28",), repeats=5,
)  # fmt: skip

# --- beyond the paper -------------------------------------------------------------------------------------------------

FASTER = (2.0, 8.0, 15.0, 30.0, 60.0, 150.0, 300.0)
"""Speeds of the background, px/s: 0.07 to 10 px a frame. The paper's, as they are read here, are up to a third."""
# Claims C5 to C11 along the speed of the background.
BACKGROUND = OfflineExperiment(
    "background", "objects before a natural image shifting at 0.07 .. 10 px a frame: where C5 to C11 break",
    [
        *(
            cluttered(
                f"{shade} {motion} before {behind:g}", motion=motion, grey=EXTREMES[shade], background_speed=behind
            )
            for behind, shade, motion in product(FASTER, EXTREMES, DEPTH)
        ),
        *(
            cluttered(f"grey {grey:g} at {speed:g} before {-shift:g}", grey=grey, speed=speed, background_speed=-shift)
            for shift, grey, speed in product(FASTER, GREYS, SPEEDS)
        ),
        *(
            cluttered(f"alone at {-behind:g}", object="absent", speed=40.0, background_speed=-behind)
            for behind in FASTER
        ),
    ],
    ("dsnn", "dsn2017", "emd"), recorded=False, figure=ClipFigure("background"),
)  # fmt: skip

# The paper compares the DSNN with two models and gives none of their constants: claims along these. With the DSNN's
# sigmoid scale, 0.01, the model of 2017 is at its ceiling in every clip before clutter.
VARIANTS_2017 = tuple(f"dsn2017:k_sig={scale}" for scale in ("0.01", "0.1", "1", "3", "10", "30", "100", "1000"))
VARIANTS_EMD = tuple(
    f"emd:spacing={spacing},tau_lp={delay_ms},tau_hp={high_pass_ms}"
    for high_pass_ms, spacing, delay_ms in product((50, 250), (1, 2, 4, 8), (15, 50, 150))
)
CONSTANTS_2017 = OfflineExperiment(
    "constants-2017", "C5, C6 and C7 with the model of 2017 at sigmoid scales over five decades",
    (*CLUTTER_DEPTH.clips, *CLUTTER_SPEED.clips), ("dsnn", *VARIANTS_2017), recorded=False, figure=ClipFigure("ranges"),
)  # fmt: skip
CONSTANTS_EMD = OfflineExperiment(
    "constants-emd", "C11 and C26 with the EMD at 24 choices of spacing, delay and high-pass", CLUTTER_CONTRAST.clips,
    ("dsnn", *VARIANTS_EMD), recorded=False, figure=ClipFigure("ranges"),
)  # fmt: skip

EXPERIMENTS = (
    CLEAN, BLOCKED, CLUTTER_DEPTH, CLUTTER_TRANSLATION, CLUTTER_SPEED, CLUTTER_FRAMES, CLUTTER_CONTRAST, STREET, EDGES,
    APPARENT, BACKGROUND_ALONE, BACKGROUND, CONSTANTS_2017, CONSTANTS_EMD,
)  # fmt: skip

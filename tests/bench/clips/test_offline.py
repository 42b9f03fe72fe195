"""Off-line experiments: what their clips are, the judges on made-up rows, runs from the command line."""

import json
import subprocess
import sys

import numpy as np
import pyarrow.parquet as pq
import pytest

from dsnn import DSNN, DSNNParams
from experiments import OFFLINE
from experiments.bench import registry
from experiments.bench.clips.claims import find, judge, paper_claims
from experiments.bench.clips.judging import SIGNED
from experiments.bench.offline import play_clip
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import choose
from experiments.bench.sources.clips import Clip, OfflineExperiment
from tests.helpers import user_files

CLAIMS = paper_claims()

BLOCKED, FEWER = ("dsnn-on-blocked", "dsnn-off-blocked"), ("dsnn:n_con=1", "dsnn:n_con=2")
WITHOUT = ("dsnn:dog=false", "dsnn:fdsr=false")
T = {"emd": None, **dict.fromkeys(("dsnn", "dsn2017", *BLOCKED, *FEWER, *WITHOUT), 0.16)}


@pytest.mark.parametrize("name", OFFLINE)
def test_every_declaration_can_be_shown_and_judged(name):
    experiment = registry.find(name)
    assert experiment.name == name and experiment.summary
    for claim in experiment.claims:
        assert find(claim).models <= set(experiment.models)
    with pytest.raises(UsageError, match="has no robot"):
        registry.load(name)


def test_all_off_line_claims_are_judged_once():
    judged = [claim for name in OFFLINE for claim in registry.find(name).claims if isinstance(claim, str)]
    assert sorted(judged) == sorted(CLAIMS) == sorted(f"C{i}" for i in (*range(1, 12), 22, 23, 24, 26, 27, 28))


def row(clip="a", model="dsnn", **changes):
    base = {
        "clip": clip, "model": model, "motion": "rightward", "grey": 0.0, "speed": 40.0, "background_speed": -8.0,
        "stimulus": "cluttered", "speed_unit": "px/s", "fps": 30.0, "polarity": None,
        "object": "present", "movers": None, "foliage": None, "background_mean": 128.0, "peak_hs": 0.0,
        "trough_hs": 0.0, "peak_vs": 0.0, "trough_vs": 0.0, "peak_looming": 0.0, "hs_rightward": None,
        "hs_leftward": None, "hs_against": None,
    }  # fmt: skip
    return {**base, **changes}


def both_shades(rows):
    return [{**clip_row, "clip": f"{shade} {clip_row['clip']}", "grey": grey} for shade, grey in
            (("dark", 0.0), ("light", 255.0)) for clip_row in rows]  # fmt: skip


def translations(right=0.2, left=-0.2, down=0.2, up=-0.2, aside=0.05):
    return both_shades([
        row("right", motion="rightward", peak_hs=right, peak_vs=aside),
        row("left", motion="leftward", trough_hs=left, peak_vs=aside),
        row("down", motion="downward", peak_vs=down, trough_hs=-aside),
        row("up", motion="upward", trough_vs=up, peak_hs=aside),
    ])  # fmt: skip


def depth(receding=-0.15):
    return both_shades([
        row("l", motion="looming", peak_hs=0.15), row("r", motion="receding", trough_vs=receding)
    ])  # fmt: skip


@pytest.mark.parametrize(
    ("claim", "rows", "verdict"),
    [
        ("C1", translations(), "holds"),
        ("C1", translations(left=-0.15), "fails"),
        ("C1", translations(up=0.2), "fails"),
        ("C2", translations(), "holds"),
        ("C2", translations(aside=0.17), "fails"),
        ("C3", depth(), "holds"),
        ("C3", depth(receding=-0.17), "fails"),
        ("C3", [], "not shown"),
    ],
)
def test_judges_of_the_plain_clips(claim, rows, verdict):
    assert judge(claim, rows, T).verdict == verdict


def blocked(on, off, whole=0.2):
    peaks = {"dsnn": whole, "dsnn-on-blocked": on, "dsnn-off-blocked": off}
    return [
        row(motion, model, motion=motion, **{column: sign * peak})
        for motion, (column, sign) in SIGNED.items()
        for model, peak in peaks.items()
    ]


@pytest.mark.parametrize(
    ("on", "off", "verdict"),
    [(0.1, 0.1, "holds"), (0.081, 0.119, "holds"), (0.07, 0.13, "fails"), (0.1, 0.11, "fails")],
)
def test_blocked_pathways_leave_half_and_add_nothing(on, off, verdict):
    assert judge("C4", blocked(on, off), T).verdict == verdict


def test_a_claim_about_two_models_needs_both():
    assert judge("C5", [row(motion="looming")], T).measured == "needs dsn2017"
    assert judge("C11", [row()], T).measured == "needs emd"


@pytest.mark.parametrize(
    ("own", "earlier", "verdict", "rest"),
    [
        (0.1, 0.9, "unknown constants", "holds"),
        (0.17, 0.9, "fails", "fails"),
        (0.1, 0.15, "unknown constants", "fails"),
    ],
)
def test_depth_over_clutter(own, earlier, verdict, rest):
    rows = [
        row(motion, model, motion=motion, background_speed=8.0, **peak)
        for motion in ("looming", "receding")
        for model, peak in (("dsnn", {"peak_hs": own}), ("dsn2017", {"peak_vs": earlier}))
    ]
    outcome = judge("C5", rows, T)
    assert (outcome.verdict, outcome.settled().verdict) == (verdict, rest)


@pytest.mark.parametrize(
    ("hs", "vs", "earlier", "verdict"),
    [
        (0.2, 0.1, 0.5, "unknown constants"),
        (0.1, 0.1, 0.5, "fails"),
        (0.2, 0.17, 0.5, "fails"),
        (0.2, 0.1, 0.1, "unknown constants"),
    ],
)
def test_translation_over_clutter(hs, vs, earlier, verdict):
    rows = [row(peak_hs=hs, peak_vs=vs), row(model="dsn2017", peak_vs=earlier)]
    assert judge("C6", rows, T).verdict == verdict


def grid(model, peak, vs=0.0):
    return [
        row(f"{g} {s} {b}", model, grey=g, speed=s, background_speed=b, peak_hs=peak(s, b), peak_vs=vs)
        for g in (0.0, 255.0)
        for b in (-2.0, -4.0, -6.0, -8.0, -10.0)
        for s in (40.0, 80.0, 120.0)
    ]


def test_speed_over_clutter():
    wavering = grid("dsn2017", lambda s, b: s / 400 - b / 20)
    steady = grid("dsnn", lambda s, b: s / 400 - b / 1000)
    assert judge("C7", steady + wavering, T).settled().verdict == "holds"
    flat = grid("dsn2017", lambda s, b: 1.0)
    failed = judge("C7", steady + flat, T)
    assert failed.verdict == "unknown constants" and "varies by 0.0080, dsn2017's by 0.0000" in failed.measured
    assert failed.settled().verdict == "fails"
    assert judge("C7", grid("dsnn", lambda s, b: min(s, 80) / 400) + wavering, T).verdict == "fails"
    assert judge("C8", steady, T).verdict == "holds"
    assert judge("C8", grid("dsnn", lambda s, b: 0.2, vs=0.16), T).verdict == "fails"


def greys(peak):
    return [
        row(f"{g} {s}", grey=g, speed=s, peak_hs=peak(g, s), background_mean=120.0)
        for g in (0.0, 64.0, 128.0, 191.0, 255.0)
        for s in (40.0, 60.0, 80.0, 100.0, 120.0)
    ]


def test_contrast_over_clutter():
    valley = greys(lambda g, s: (abs(g - 128) + 10) * s / 1e5)
    assert judge("C9", valley, T).verdict == judge("C10", valley, T).verdict == "holds"
    assert judge("C9", greys(lambda g, s: abs(g - 128) + 1), T).verdict == "fails"
    assert judge("C10", greys(lambda g, s: abs(g - 64) + s), T).verdict == "fails", "lowest beside the nearest"
    at_one = greys(lambda g, s: abs(g - (64 if s == 60.0 else 128)) / 1e3)
    assert judge("C10", at_one, T).verdict == "fails", "at one speed of five, whatever the means over speeds do"
    at_one = judge("C10", at_one, T)
    assert at_one.effect == "4 of 5 speeds" and at_one.decided.startswith("60 px/s: ")


@pytest.mark.parametrize(
    ("emd", "dsnn", "verdict", "rest"),
    [
        (0.30, 0.05, "unknown constants", "holds"),
        (0.40, 0.05, "unknown constants", "fails"),
        (0.30, 0.005, "fails", "fails"),
    ],
)
def test_separation_from_background(emd, dsnn, verdict, rest):
    rows = [row("alone", "emd", object="absent", trough_hs=-0.35), row("alone", "dsnn", object="absent", peak_hs=0.01)]
    for speed in (40.0, 60.0, 80.0, 100.0, 120.0):
        rows += [row(f"{speed}", model, speed=speed, peak_hs=hs) for model, hs in (("emd", emd), ("dsnn", dsnn))]
    outcome = judge("C11", rows, T)
    assert (outcome.verdict, outcome.settled().verdict) == (verdict, rest)


CLIP = Clip("c", "plain", (("rows", 60), ("columns", 80), ("width", 20), ("height", 30), ("speed", 240.0)))


def test_a_row_is_what_the_model_says_of_the_clip():
    """And the mean of the ground that an object passes leaves the object out."""
    experiment = OfflineExperiment("mine", "", (CLIP,), ("dsnn",))
    (showing,) = experiment.trials((choose("dsnn", "offline"),), 1, 0)
    done = play_clip(showing)
    clip = CLIP.build(0)
    series = DSNN(clip.shape, DSNNParams.offline()).run(frame.luma for frame in clip)
    (clip_row,) = done.rows
    assert (clip_row["peak_hs"], clip_row["trough_vs"]) == (series.hs.max(), series.vs.min())
    assert clip_row["spikes"] == np.abs(series.hs_spikes).sum()
    assert (clip_row["motion"], clip_row["grey"], clip_row["background_speed"]) == ("rightward", 40.0, None)
    assert clip_row["background_mean"] == 200.0 and clip_row["fps"] == 30.0 and clip_row["polarity"] is None
    np.testing.assert_array_equal(done.frames["hs"].to_numpy(), series.hs)


def test_repeats_share_a_background_and_differ_between_each_other():
    clips = tuple(Clip(str(speed), "cluttered", (("speed", speed), ("columns", 80))) for speed in (300.0, 600.0))
    all_showings = OfflineExperiment("mine", "", clips, ("dsnn",)).trials((choose("dsnn", "offline"),), 2, 5)
    assert [s.seed for s in all_showings] == [5, 5, 6, 6]
    first = [s.condition.build(s.seed)[0].luma for s in all_showings]
    assert np.array_equal(first[0], first[1]) and not np.array_equal(first[0], first[2])


OWN = """
from experiments.bench.sources.clips import Clip
from experiments.bench.sources.clips import OfflineExperiment

SMALL = (("rows", 60), ("columns", 80), ("width", 20), ("height", 30), ("speed", 240.0))
EXPERIMENT = OfflineExperiment(
    name="mine", summary="small crossings", models=("dsnn",), claims=("C2",),
    clips=(Clip("right", "plain", SMALL), Clip("left", "plain", (*SMALL, ("motion", "leftward")))),
)
"""


def test_an_off_line_experiment_and_a_model_of_one_s_own(colias):
    """Run by path, recorded, judged, drawn; resumed with nothing to do; the same on no worker and on two."""
    (colias.folder / "mine.py").write_text(OWN)
    (colias.folder / "my_model.py").write_text(user_files.MODEL)
    arguments = ("run", "mine.py", "--model", "my_model.py", "--set", "gradient.gain=0.1")
    done = colias(*arguments, "--out", "out", "--workers", "2")
    assert done.returncode == 0, done.stderr
    assert "mine: 2 clips, 64 frames" in done.stderr and "C2 held in 0 of 1 replicate" in done.stdout, (
        "too small a field"
    )
    folder = colias.folder / "out"
    rows = pq.read_table(folder / "trials.parquet").to_pylist()
    assert [(r["clip"], r["model"]) for r in rows] == [
        (clip, model) for clip in ("right", "left") for model in ("dsnn", "gradient")
    ]
    recordings = sorted((folder / "recordings").glob("*.rrd"))
    subprocess.run([sys.executable, "-m", "rerun", "rrd", "verify", *map(str, recordings)], check=True)
    assert len(recordings) == 2 and (folder / "figure.svg").exists()
    assert json.loads((folder / "run.json").read_text())["clips"]["right"]["speed"] == 240.0
    again = colias(*arguments, "--out", "out", "--workers", "0")
    assert again.returncode == 0 and "2 of them done already" in again.stderr
    other = colias(*arguments[:-2], "--out", "out")
    assert (other.returncode, other.stderr.count("\n")) == (2, 1) and "gain" in other.stderr
    alone = colias(*arguments, "--out", "alone", "--workers", "0", "--no-recordings", "-q")
    assert alone.returncode == 0
    same = pq.read_table(colias.folder / "alone" / "trials.parquet").drop_columns(["wall_s"])
    assert same.equals(pq.read_table(folder / "trials.parquet").drop_columns(["wall_s"]))

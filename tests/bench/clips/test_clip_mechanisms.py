"""The claims about mechanisms (C22 to C27) and those along the background's speed: the judges, and the experiments."""

import json

import numpy as np
import pytest

from dsnn import DSNN, DSNNParams
from dsnn.stimuli import stimulus
from experiments.background import SPEEDS
from experiments.bench import registry
from experiments.bench.clips.claims import judge, paper_claims
from experiments.bench.studies import run
from experiments.bench.studies.counts import Counts
from experiments.studies.background import BACKGROUND, BESIDE, NAME, STUDY, answered, at_speed
from tests.bench.clips.test_offline import BLOCKED, FEWER, WITHOUT, T, greys, row

CLAIMS = paper_claims()

DIRECTIONS = ("rightward", "leftward")
PAIRS = ("on-on", "off-off", "on-off", "off-on")


def signed(motion, hs):
    """HS that goes the way of the motion."""
    return {"peak_hs": hs} if motion == "rightward" else {"trough_hs": -hs}


def edges(driven=0.0, other=0.2, whole=0.2):
    """One edge of either polarity both ways, with the pathway that it drives blocked, and with the other."""
    drives = {"on": BLOCKED, "off": BLOCKED[::-1]}
    return [
        row(f"{polarity} {motion}", model, stimulus="edge", polarity=polarity, motion=motion, **signed(motion, hs))
        for polarity, (driven_blocked, beside) in drives.items()
        for motion in DIRECTIONS
        for model, hs in (("dsnn", whole), (driven_blocked, driven), (beside, other))
    ]


def strokes(same=0.2, opposite=0.01, **changed):
    """Two steps of every pair both ways; ``changed`` has the answers of one clip, by its name with underscores."""
    rows = []
    for polarity in PAIRS:
        for motion in DIRECTIONS:
            hs = signed(motion, same) if polarity in PAIRS[:2] else {"peak_hs": opposite}
            hs = changed.get(f"{polarity}_{motion}".replace("-", "_"), hs)
            rows.append(row(f"{polarity} {motion}", stimulus="apparent", polarity=polarity, motion=motion, **hs))
    return rows


def ensembles(fewer=0.1):
    """Peaks of 0.16 and more in some clips, and a share of them with fewer connected cells."""
    whole = greys(lambda g, s: (abs(g - 128) + 10) * s / 6e4)
    return whole + [
        {**clip_row, "model": model, "peak_hs": fewer * clip_row["peak_hs"]} for model in FEWER for clip_row in whole
    ]


def speed_responses(middle=lambda s: 0.3, ends=lambda s: 0.3 + s / 1e4):
    """The EMD answers the background by HS to the left; only with a black or a white object does |HS| rise."""
    dsnn_rows = greys(lambda g, s: s / 1e3)
    answers = {grey: ends if grey in (0.0, 255.0) else middle for grey in (0.0, 64.0, 128.0, 191.0, 255.0)}
    other = {"model": "emd", "peak_hs": 0.0}
    return dsnn_rows + [
        {**clip_row, **other, "trough_hs": -answers[clip_row["grey"]](clip_row["speed"])} for clip_row in dsnn_rows
    ]


def alone(factor=2.5):
    """The background alone at the paper's five speeds."""
    return [
        row(f"alone {behind}", model, object="absent", background_speed=behind, peak_hs=0.001 * times,
            trough_vs=-0.002 * times)
        for behind in (-2.0, -4.0, -6.0, -8.0, -10.0)
        for model, times in (("dsnn", 1.0), *((model, factor) for model in WITHOUT))
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("rows", "verdict"),
    [
        (edges(), "holds"),
        (edges(driven=0.0099), "holds"),
        (edges(driven=0.0101), "fails"),
        (edges(other=0.189), "fails"),
        (edges(driven=0.2, other=0.0), "fails"),  # the pathways exchanged
        (edges(whole=0.0, driven=0.0, other=0.0), "fails"),  # silence is no driven pathway
        (edges(other=0.2)[:3], "not shown"),
    ],
)
def test_c22(rows, verdict):
    assert judge("C22", rows, T).verdict == verdict


@pytest.mark.parametrize(
    ("rows", "verdict"),
    [
        (strokes(), "holds"),
        (strokes(opposite=0.0199), "holds"),
        (strokes(opposite=0.021), "fails"),
        (strokes(opposite=-0.021), "holds"),  # a peak below 0 is none: HS starts at rest
        (strokes(on_off_leftward={"trough_hs": -0.03}), "fails"),  # in its direction or against it
        (strokes(on_off_leftward={"peak_hs": 0.03}), "fails"),
        (strokes(on_on_leftward={"peak_hs": 0.2}), "fails"),  # the wrong way
        (strokes(on_on_leftward={"peak_hs": 0.2, "trough_hs": -0.19}), "fails"),  # the flash outweighs the direction
        (strokes(off_off_rightward={"peak_hs": 0.05}), "fails"),  # the weaker of both is what it is a share of
        (strokes(same=0.0, opposite=0.0), "fails"),
        (strokes()[:-1], "not shown"),
        ([*strokes(), {**strokes()[0], "clip": "more"}], "not shown"),
    ],
)
def test_c23(rows, verdict):
    assert judge("C23", rows, T).verdict == verdict


def test_c23_tells_how_much_of_it_is_direction():
    """A flash answer to either side is no answer of direction; it fails the words all the same."""
    outcome = judge("C23", strokes(opposite=0.05), T)
    assert outcome.verdict == "fails" and "25% of 0.200 for one sign (needs under 10%)" in outcome.decided
    assert "on-on +0.2000" in outcome.measured and "on-off +0.0000" in outcome.measured
    assert outcome.effect == "opposite signs: 0.0% of the part that tells direction"


@pytest.mark.parametrize("worst", ["on-off rightward", "on-off leftward", "off-on rightward", "off-on leftward"])
def test_c23_tells_the_largest_answer_to_opposite_signs_wherever_it_is(worst):
    rows = strokes(opposite=0.004, **{worst.replace("-", "_").replace(" ", "_"): {"peak_hs": 0.016}})
    pair, motion = worst.split()
    assert f"|HS| up to 8% of it ({motion} {pair})" in judge("C23", rows, T).measured


@pytest.mark.parametrize(("fewer", "verdict"), [(0.1, "holds"), (0.5, "holds"), (1.0, "fails"), (1.2, "fails")])
def test_c24_off_line(fewer, verdict):
    outcome = judge("C24", ensembles(fewer), T)
    assert outcome.verdict == verdict and outcome.measured.startswith("off-line part")


def test_c24_is_of_every_clip_and_of_how_many_pass():
    rows = ensembles()
    lost = rows.index(
        next(clip_row for clip_row in rows if clip_row["model"] == FEWER[0] and clip_row["clip"] == "128.0 40.0")
    )
    outcome = judge("C24", [*rows[:lost], {**rows[lost], "peak_hs": 0.2}, *rows[lost + 1 :]], T)
    assert outcome.verdict == "fails" and outcome.decided.startswith("128.0 40.0: peak HS")
    none = [{**clip_row, "peak_hs": min(clip_row["peak_hs"], 0.15)} for clip_row in rows]
    assert judge("C24", none, T).decided == "passes T in 0 clips (needs more than 0 of dsnn:n_con=1)"


@pytest.mark.parametrize(
    ("changes", "rest"),
    [
        ({}, "holds"),
        ({"middle": lambda s: 0.3 - s / 1e4}, "holds"),
        ({"middle": lambda s: 0.3 + s / 1e4}, "fails"),  # for the others too
        ({"middle": lambda s: 0.3 + s / 2e4}, "holds"),  # by less than the margin at every step
        ({"middle": lambda s: 0.3 + min(s, 100.0) / 1e4}, "holds"),  # not at every step
        ({"ends": lambda s: 0.3}, "fails"),
    ],
)
def test_c26(changes, rest):
    outcome = judge("C26", speed_responses(**changes), T)
    assert (outcome.verdict, outcome.settled().verdict) == ("unknown constants", rest)
    assert f"with those assumed {rest}" in outcome.decided


def test_c26_is_of_the_dsnn_at_all_greys():
    rows = speed_responses()
    flat = [
        {**clip_row, "peak_hs": 0.1} if (clip_row["model"], clip_row["grey"]) == ("dsnn", 64.0) else clip_row
        for clip_row in rows
    ]
    outcome = judge("C26", flat, T)
    assert outcome.verdict == "fails" and outcome.decided.startswith("dsnn, grey 64")


@pytest.mark.parametrize(("factor", "verdict"), [(2.5, "holds"), (2.0, "holds"), (1.99, "fails"), (0.0, "fails")])
def test_c27(factor, verdict):
    assert judge("C27", alone(factor), T).verdict == verdict


def test_c27_is_of_each_filter_and_each_system():
    for model in WITHOUT:
        for column in ("peak_hs", "trough_vs"):
            rows = alone()
            index = next(i for i, clip_row in enumerate(rows) if clip_row["model"] == model)
            rows[index] = {**rows[index], column: 0.0}
            outcome = judge("C27", rows, T)
            assert outcome.verdict == "fails" and model in outcome.decided
    nothing = [{**clip_row, "peak_hs": 0.0, "trough_vs": 0.0} for clip_row in alone()]
    assert judge("C27", nothing, T).verdict == "fails", "nothing cannot be twice nothing"


# --- along the background's speed -------------------------------------------------------------------------------------


def crossings(vs_at, hs=0.2):
    """Clips of C6 and C8 at every speed; VS as a function of it."""
    return [
        row(f"{grey} {speed} {behind}", model, grey=grey, speed=speed, background_speed=-behind, peak_hs=hs,
            peak_vs=0.9 if model == "dsn2017" else vs_at(behind))
        for grey in (0.0, 255.0)
        for speed in (40.0, 80.0, 120.0)
        for behind in SPEEDS
        for model in ("dsnn", "dsn2017")
    ]  # fmt: skip


def judged_at(claim, speed, rows):
    (asked,) = [of_study for of_study in STUDY.claims if of_study.id == claim]
    return judge(at_speed(asked, {NAME: f"{speed:g}"}), rows, T)


def test_a_claim_is_asked_at_one_speed_of_the_background_at_a_time():
    for claim in ("C6", "C8"):
        still, faster = crossings(lambda behind: 0.0), crossings(lambda behind: behind / 300.0)
        best = "unknown constants" if CLAIMS[claim].of_dsnn else "holds"
        assert {judged_at(claim, speed, still).verdict for speed in SPEEDS} == {best}
        holds = [speed for speed in SPEEDS if judged_at(claim, speed, faster).verdict == best]
        assert holds == [speed for speed in SPEEDS if speed / 300.0 < 0.16]
        slow = [clip_row for clip_row in still if clip_row["background_speed"] > -300.0]
        lacking = judged_at(claim, 300.0, slow)
        assert lacking.verdict == "not shown" and "before -300 px/s" in lacking.measured


def test_the_half_of_c7_that_one_speed_can_answer_has_a_name_of_its_own():
    assert "C7" not in {claim.id for claim in STUDY.claims}
    rows = [{**clip_row, "peak_hs": clip_row["speed"] / 1e3} for clip_row in crossings(lambda behind: 0.0)]
    assert {judged_at("C7-rises", speed, rows).verdict for speed in SPEEDS} == {"holds"}
    flat = [{**clip_row, "peak_hs": 0.1} if clip_row["background_speed"] == -300.0 else clip_row for clip_row in rows]
    assert [speed for speed in SPEEDS if judged_at("C7-rises", speed, flat).verdict == "fails"] == [300.0]


def test_the_axis_has_the_speeds_that_the_clips_show():
    speeds = {abs(dict(clip.changes)["background_speed"]) for clip in registry.find("background").clips}
    assert speeds == set(SPEEDS) == {float(label) for label in BACKGROUND.labels}
    assert (min(SPEEDS) / 30, max(SPEEDS) / 30) == (pytest.approx(0.07, abs=0.005), 10.0)


def test_crossings_are_counted_by_the_system_and_the_sign_of_the_strongest_answer():
    """Every model of the run, one that answers the background from 1 px a frame on among them."""
    plan = run.planned(STUDY)
    assert [model.label for model in plan.specs[0].models] == ["dsnn", "dsn2017", "emd", *BESIDE]
    quiet = {"trough_hs": 0.0, "peak_vs": 0.0, "trough_vs": 0.0}
    rows = [
        {"trial": spec.index, "experiment": "background", "model": model, "motion": changes.get("motion", "rightward"),
         "object": changes.get("object", "present"), "background_speed": behind, "peak_hs": 0.2, **quiet,
         **({"trough_hs": -0.3} if model == "emd" and abs(behind) >= 30 else {})}
        for spec in plan.specs
        for changes in [dict(spec.condition.changes)]
        for behind in [changes["background_speed"]]
        for model in ("dsnn", "emd")
    ]  # fmt: skip
    right, wrong = answered(Counts(plan, rows))
    assert right == {"model": "dsnn", **dict.fromkeys(("0.067", "0.27", "0.5", "1", "2", "5", "10"), "25/25")}
    assert [wrong[column] for column in ("0.067", "0.5", "1", "10")] == ["25/25", "25/25", "0/25", "0/25"]


# --- the mechanisms themselves ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", DIRECTIONS)
@pytest.mark.parametrize("w_i", [0.9, 1.0])
def test_a_pathway_never_mixes_signs(motion, w_i):
    """Steps of opposite signs answer as their flashes do, alike in both directions; with w_i = 1 not at all."""
    same, opposite = (
        DSNN((60, 120), DSNNParams.offline(w_i=w_i)).run(
            frame.luma for frame in stimulus("apparent", motion=motion, polarity=polarity, rows=60, columns=120)
        )
        for polarity in ("on-on", "on-off")
    )
    sign = 1 if motion == "rightward" else -1
    assert (sign * same.hs).max() > 0.1
    flashes = 0.35 if w_i < 1 else 0.03
    assert np.abs(opposite.hs).max() < flashes * (sign * same.hs).max()
    assert (opposite.hs.max() > 0.02) == (w_i < 1)


@pytest.mark.parametrize("name", ["edges", "apparent", "background-alone", "background"])
def test_the_experiments_run_from_the_command_line(colias, name):
    """One small clip of each model and claim: the declaration cut down, the rest as it ships."""
    every = 29 if name == "background" else 1
    text = f"""
import dataclasses

from experiments.{name.replace("-", "_")} import EXPERIMENT as WHOLE

SMALL = (("rows", 48), ("columns", 80))
EXPERIMENT = dataclasses.replace(
    WHOLE, name="small", repeats=1,
    clips=[dataclasses.replace(clip, changes=(*clip.changes, *SMALL)) for clip in WHOLE.clips[::{every}]],
)
"""
    (colias.folder / "small.py").write_text(text)
    done = colias("run", "small.py", "--no-recordings", "--workers", "0", "--out", "out")
    assert done.returncode == 0, done.stderr
    verdicts = json.loads((colias.folder / "out" / "claims.json").read_text())["claims"]
    assert [verdict["id"] for verdict in verdicts] == [
        claim if isinstance(claim, str) else claim.id for claim in registry.find(name).claims
    ]
    assert (colias.folder / "out" / "figure.png").stat().st_size > 10_000


def test_fdsr_prefers_objects_to_background_and_the_dog_does_not():
    """What the documentation says of C27: the share of an object's HS to that of the background alone.

    With a sigmoid so wide that potentials stay linear, and from when the background's start has died away.
    """

    def strongest_hs(present, **switches):
        field = {"rows": 60, "columns": 160, "height": 40.0, "grey": 255.0, "object": present}
        clip = stimulus("cluttered", background_speed=-30.0, **field)
        answer = DSNN(clip.shape, DSNNParams.offline(k_sig=1000.0, **switches)).run(frame.luma for frame in clip)
        return np.abs(answer.hs[12:]).max() if present == "absent" else answer.hs[12:].max()

    share = {
        switch: strongest_hs("present", **changes) / strongest_hs("absent", **changes)
        for switch, changes in {"intact": {}, "dog": {"dog": False}, "fdsr": {"fdsr": False}}.items()
    }
    assert share["dog"] > 1.5 * share["intact"], "without the DoG an object stands out more"
    assert share["fdsr"] < share["intact"] / 1.5, "without FDSR less"

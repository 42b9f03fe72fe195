"""The leaderboard: scores of made-up rows, and the command as a user runs it, with a model of their own."""

import csv
import dataclasses
import math
from itertools import count

import numpy as np
import pytest
from scipy import stats

from dsnn import MODELS
from experiments.bench.leaderboard import run as board
from experiments.bench.leaderboard.kinds import DIRECTION, Ranking
from experiments.bench.leaderboard.looming_stimuli import looming_experiments
from experiments.bench.leaderboard.scores import (
    BACKGROUND,
    DEPTH,
    MEASURES,
    Score,
    Standing,
    answer,
    direction_accuracy,
    false_alarms,
    frame_time,
    ranked,
    scores,
    separation,
    shown,
    strength,
)
from experiments.bench.leaderboard.stimuli import ROBOT, clip_experiments
from experiments.bench.leaderboard.timing import ROUNDS, time_models
from experiments.bench.offline import plan, play_clip
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import COMPARED, choose, shown_models
from experiments.bench.run.runs import Resources
from experiments.bench.sources.clips import Clip
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.designs import Translation
from experiments.bench.stats.clips import SIGNED
from experiments.bench.stats.tests import area_under_roc, median_interval
from tests.helpers import user_files

CLIPS = count()


def clip(motion, hs=(0.0, 0.0), vs=(0.0, 0.0), spikes=0, looming=0.0, absent=False, vs_spikes=0, looming_spikes=None):
    """A row of an off-line clip, with lowest and highest potentials; each is a clip of its own."""
    return {
        "experiment": "clips", "clip": f"clip {next(CLIPS)}",
        "motion": motion, "object": "absent" if absent else "present", "peak_looming": looming,
        "spikes": spikes, "hs_spikes": spikes, "vs_spikes": vs_spikes, "looming_spikes": looming_spikes,
        "trough_hs": hs[0], "peak_hs": hs[1], "trough_vs": vs[0], "peak_vs": vs[1],
    }  # fmt: skip


def trial(motion, direction, strength):
    """A row of a robot's trial that answers ``strength`` rightward."""
    row = clip(motion, hs=(0.0, strength))
    del row["object"], row["clip"]
    return {**row, **dict.fromkeys(CONDITION_COLUMNS), "motion": motion, "direction": direction}


def right_answer(motion, strength=0.5):
    column, sign = SIGNED[motion]
    return {**clip(motion), column: sign * strength}


def test_what_was_shown():
    assert shown(trial("translation", "leftward", 0.1)) == "leftward"
    assert shown(trial("approach", "straight", 0.1)) == shown(trial("recession", "leftward", 0.1)) == DEPTH
    assert shown(clip("upward")) == "upward"
    assert shown(clip("looming")) == shown(clip("receding")) == DEPTH
    assert shown(clip("rightward", absent=True)) == shown({"motion": None, "object": None}) == BACKGROUND


def test_the_strongest_answer_of_both_systems_counts():
    assert answer(clip("rightward", hs=(-0.1, 0.3), vs=(-0.2, 0.2))) == "rightward"
    assert answer(clip("rightward", hs=(-0.4, 0.3), vs=(-0.2, 0.2))) == "leftward"
    assert answer(clip("rightward", hs=(-0.1, 0.3), vs=(-0.2, 0.31))) == "downward"
    assert answer(clip("rightward", hs=(-0.1, 0.3), vs=(-0.31, 0.2))) == "upward"
    assert answer(clip("rightward", hs=(-0.3, 0.3))) is None
    assert answer(clip("rightward")) is None, "silence is no answer"


def test_direction_accuracy_of_all_none_and_half():
    good = [right_answer(motion) for _ in range(5) for motion in SIGNED]
    perfect = direction_accuracy(good)
    assert (perfect.value, perfect.high, perfect.n) == (1.0, 1.0, 20)
    assert perfect.low == pytest.approx(0.025 ** (1 / 20)), "Clopper and Pearson's lower bound of 20 in 20"
    silent = [clip(motion) for _ in range(5) for motion in SIGNED]
    assert direction_accuracy(silent).value == 0.0
    assert direction_accuracy(good + silent).value == 0.5
    rest = [clip("looming"), clip("rightward", absent=True)]
    assert direction_accuracy([*good, *rest]) == perfect, "of translations alone"
    assert direction_accuracy(rest) is None


def test_repeats_of_a_condition_are_no_independent_trials():
    """Four clips, five repeats each: where repeats agree they tell no more than four clips do."""
    conditions = [right_answer(motion) for motion in SIGNED]
    agree = direction_accuracy([row for row in conditions for _ in range(5)])
    assert (agree.value, agree.n) == (1.0, 20)
    assert (agree.low, agree.high) == (direction_accuracy(conditions).low, 1.0)
    silent = [{**row, **dict.fromkeys(("peak_hs", "trough_hs", "peak_vs", "trough_vs"), 0.0)} for row in conditions]
    by_clip = direction_accuracy([*(conditions[:2] * 5), *(silent[2:] * 5)])
    by_repeat = direction_accuracy([*(conditions * 2), *(silent * 2), *conditions[:2], *silent[2:]])
    assert by_clip.high - by_clip.low > by_repeat.high - by_repeat.low, "all of the spread is between clips"
    looms = [{**clip("looming", hs=(0.0, 0.1)), "repeat": repeat} for repeat in range(4)]
    alone = separation([*conditions, *looms])
    again = separation([*(conditions * 5), *(looms * 5)])
    assert alone.value == again.value == 1.0 and again.low == pytest.approx(alone.low)


@pytest.mark.parametrize(("across", "depth", "area"), [
    ([3, 4, 5], [0, 1, 2], 1.0), ([0, 1], [2, 3], 0.0), ([1, 1], [1, 1, 1], 0.5), ([0, 2], [1, 1], 0.5),
    ([1, 2], [1, 0], 0.875),
])  # fmt: skip
def test_area_under_roc(across, depth, area):
    value, low, high = area_under_roc(across, depth)
    assert value == area
    assert low <= value <= high


def test_area_under_roc_is_mann_whitney_s_and_its_interval_covers():
    rng = np.random.default_rng(0)
    true = stats.norm.cdf(1 / math.sqrt(2))  # of two unit normals one apart
    covered = 0
    for _ in range(50):
        across, depth = rng.normal(1, 1, 60), rng.normal(0, 1, 30)
        value, low, high = area_under_roc(across, depth)
        assert value == pytest.approx(stats.mannwhitneyu(across, depth).statistic / (60 * 30))
        covered += low <= true <= high
    assert 43 <= covered <= 50


def test_separation_by_the_largest_of_both_systems():
    rows = [clip("rightward", hs=(-0.9, 0.1)), clip("upward", vs=(-0.8, 0.0)),
            clip("looming", hs=(-0.2, 0.7), looming=0.9), clip("rightward", absent=True, hs=(0.0, 1.0))]  # fmt: skip
    assert strength(rows[0]) == 0.9
    assert (separation(rows).value, separation(rows).n) == (1.0, 3)
    assert separation(rows[:2]) is None
    robot = [trial("translation", "leftward", 0.6), trial("approach", "straight", 0.1)]
    assert separation(robot).value == 1.0


def test_false_alarms_are_of_backgrounds_alone():
    rows = [clip("rightward", absent=True, spikes=3), clip("rightward", absent=True), clip("rightward", spikes=9)]
    assert (false_alarms(rows).value, false_alarms(rows).n) == (0.5, 2)
    assert false_alarms(rows[2:]) is None
    others = [clip("still", absent=True, vs_spikes=1), clip("still", absent=True, looming_spikes=2)]
    assert false_alarms(others).value == 1.0, "a spike of any declared channel is one"


def test_times():
    score = frame_time([3.0] * 20 + [5.0] * 21)
    assert (score.value, score.low, score.high, score.n) == (5.0, 3.0, 5.0, 41)
    assert frame_time(None) is None
    low, high = median_interval(range(1, 41))  # binomial(40, 1/2): ranks 14 and 27
    assert (low, high) == (14.0, 27.0)


def test_what_does_not_apply_is_a_dash():
    clips = [right_answer("upward"), clip("looming"), clip("rightward", absent=True, spikes=1)]
    assert scores([], clips, {}, spikes=True)["false_alarms"].value == 1.0
    plain = scores([], clips, {"us_99x72": [4.0]}, spikes=False)
    assert plain["false_alarms"] is None and plain["direction_clips"].value == 1.0
    assert plain["auc_robot"] is None and plain["us_99x72"].value == 4.0 and plain["us_320x180"] is None
    (row,) = Ranking(DIRECTION, [Standing("a", plain)]).rows()
    assert row["false_alarms"] is None and row["us_99x72"] == 4.0
    assert row["us_99x72_low"] is None, "one round has no interval"
    assert (row["direction_clips"], row["direction_clips_n"]) == (1.0, 1)


def standing(name, direction, auc):
    def both(kind, value):
        return {f"{kind}_{s}": None if value is None else Score(value, value, value, 9) for s in ("robot", "clips")}

    return Standing(name, dict.fromkeys(MEASURES) | both("direction", direction) | both("auc", auc))


def test_ranking_by_direction_then_auc_then_name():
    given = [
        ("loom", None, 0.9),
        ("b", 0.8, 0.5),
        ("c", 0.8, 0.9),
        ("d", 0.9, 0.1),
        ("a", 0.8, 0.5),
        ("gone", None, None),
    ]
    assert [s.name for s in ranked(standing(*row) for row in given)] == ["d", "c", "a", "b", "loom", "gone"]


def test_trials_and_clips_are_what_the_help_says():
    conditions = ROBOT.design.conditions()
    assert [sum(c.motion == m for c in conditions) for m in ("translation", "approach", "recession")] == [12, 3, 3]
    plain, clutter = clip_experiments(["dsnn"])
    assert (len(plain.clips), plain.repeats, len(clutter.clips), clutter.repeats) == (24, 1, 16, 5)
    for experiment in (plain, clutter):
        assert all(clip_spec.build(0).shape == (180, 320) for clip_spec in experiment.clips)
    assert [clip.build(0).params for clip in plain.clips] == [clip.build(9).params for clip in plain.clips]


def test_a_trembling_clip():
    still, trembling = Clip("a", "foliage"), Clip("b", "foliage", (), 0.3)
    assert (still.build(1)[9].luma != trembling.build(1)[9].luma).any()
    with pytest.raises(ValueError, match="sd_px must be between 0 and 10"):
        Clip("c", "foliage", (), 11.0)


def test_contenders():
    every = shown_models(COMPARED, ["dsnn", "my.py", "my.py"], only=False)
    assert every == [*(name for name in MODELS if name != "dsnn-reference"), "my.py"]
    assert shown_models(COMPARED, ["emd"], only=True) == ["emd"]
    with pytest.raises(UsageError, match="--only"):
        shown_models(COMPARED, [], only=True)


def test_a_model_that_raises_is_not_timed(tmp_path):
    text = example().replace('"gradient"', '"odd"').replace("now = luma", "raise ValueError(1)\n        now = luma")
    (tmp_path / "odd.py").write_text(text)
    taken = time_models([choose("emd"), choose(str(tmp_path / "odd.py"))], (24, 32))
    assert set(taken) == {"emd"}
    assert len(taken["emd"]) == ROUNDS and min(taken["emd"]) > 0


def example():
    """The model of docs/your-own-model.md."""
    return user_files.MODEL


def written(folder, name="leaderboard.csv"):
    with (folder / name).open() as file:
        rows = list(csv.DictReader(file))
    assert all(float(row["us_99x72"]) > 0 for row in rows)
    return [{name: value for name, value in row.items() if not name.startswith("us_")} for row in rows]


def fewer(models):
    return tuple(
        dataclasses.replace(experiment, clips=experiment.clips[::5]) for experiment in clip_experiments(models)
    )


def fewer_looming(models):
    return tuple(
        dataclasses.replace(experiment, clips=experiment.clips[::9]) for experiment in looming_experiments(models)
    )


@pytest.fixture
def few(monkeypatch):
    """A board of two robot trials and a few clips."""
    monkeypatch.setattr(board, "ROBOT", dataclasses.replace(ROBOT, design=Translation((10.0,), (6.0,), "both")))
    monkeypatch.setattr(board, "clip_experiments", fewer)
    monkeypatch.setattr(board, "looming_experiments", fewer_looming)


def test_a_user_s_model_is_ranked_and_the_folder_goes_on(colias, capsys, few):
    (colias.folder / "my_model.py").write_text(example())
    user_model, out = str(colias.folder / "my_model.py"), colias.folder / "out"
    done = colias("leaderboard", "--repeats", "1", "--only", "--model", "lgmd1", "--model", user_model, "--out", "out")
    assert done.returncode == 0, done.stderr
    first, looming = written(out), written(out, "looming.csv")
    (row,) = first  # each kind stands apart
    assert row["model"] == "gradient" and row["direction_robot_n"] == "2" and float(row["direction_robot"]) == 1.0
    (row,) = looming
    assert row["model"] == "lgmd1"

    (out / "leaderboard.csv").unlink()
    board.run(out, ["lgmd1", user_model], 1, 0, Resources(0))
    assert capsys.readouterr().err.count(" of them done already") == 5
    assert (written(out), written(out, "looming.csv")) == (first, looming)
    with pytest.raises(UsageError, match=r"--model is lgmd1, gradient there and emd now"):
        board.run(out, ["emd"], 1, 0, Resources(0, quiet=True))


def test_the_number_of_workers_changes_nothing_but_the_times(tmp_path, monkeypatch, few):
    monkeypatch.setattr(board, "time_models", lambda models, shape: {model.label: [1.0] for model in models})
    for workers in (0, 2):
        board.run(tmp_path / f"{workers}", ["emd", "lgmd1"], 1, 3, Resources(workers, quiet=True))
    for name in ("leaderboard.csv", "looming.csv"):
        assert written(tmp_path / "0", name) == written(tmp_path / "2", name)


def test_an_answer_that_is_no_number_fails_by_name(tmp_path):
    text = example().replace("return Response(hs=hs,", "return Response(hs=float('nan'),")
    (tmp_path / "none.py").write_text(text)
    (experiment, _) = clip_experiments(["emd", str(tmp_path / "none.py")])
    done = play_clip(plan(experiment, (), (), 1, 0).trials[0])
    assert [row["model"] for row in done.rows] == ["emd"]
    assert [failure.model for failure in done.failures] == ["gradient"]

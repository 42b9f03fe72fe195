"""The leaderboard: scores of generated tables, the golden tests of stimuli, and a board with a user's own model."""

import dataclasses
import re

import numpy as np
import polars as pl
import pytest

from dsnn import MODELS
from experiments.base.errors import UsageError
from experiments.declare.clip import Clip
from experiments.declare.experiment import Translation
from experiments.draw import scoreboard
from experiments.judge.judge import SIGNED
from experiments.kinds.result import perform
from experiments.paper import boards as board
from experiments.paper.boards import DIRECTION, LOOMING, RESPONSES
from experiments.paper.claims.clips import answer
from experiments.settings.models import choose
from experiments.show.clips import ClipTrial
from experiments.store.asked import Asked
from experiments.store.workers import Workers
from tests.helpers import user_files


def planned(*models):
    """The plan of a board of these models, at one repeat."""
    return board.plan(Asked(kind="leaderboard", models=models, only=True, repeats=1))


def table(*rows):
    """Responses; each row is a condition of its own where it names none."""
    made = [{"condition": f"c{i}", "model": "m", **row} for i, row in enumerate(rows)]
    return pl.DataFrame([dict.fromkeys(RESPONSES) | row for row in made], RESPONSES)


def translations(right, **more):
    return [{"shown": way, "right": way in right, **more} for way in SIGNED]


def extremes(hs=(0.0, 0.0), vs=(0.0, 0.0)):
    return dict(zip(("trough_hs", "peak_hs", "trough_vs", "peak_vs"), (*hs, *vs), strict=True))


def test_the_strongest_potential_of_both_systems_is_the_answer():
    assert answer(extremes((-0.1, 0.3), (-0.2, 0.2))) == "rightward"
    assert answer(extremes((-0.4, 0.3), (-0.2, 0.2))) == "leftward"
    assert answer(extremes((-0.1, 0.3), (-0.2, 0.31))) == "downward"
    assert answer(extremes((-0.1, 0.3), (-0.31, 0.2))) == "upward"
    assert answer(extremes((-0.3, 0.3))) is answer(extremes()) is None, "two alike, or silence, is no answer"


def test_shares_are_of_translations_and_have_clopper_and_pearson_s_interval():
    scores = board.direction_scores(table(*translations(SIGNED) * 5), table(*translations(["upward"])))
    assert (scores["direction_robot"].value, scores["direction_robot"].high, scores["direction_robot"].n) == (1, 1, 20)
    assert scores["direction_robot"].low == pytest.approx(0.025 ** (1 / 20))
    assert scores["direction_clips"].value == 0.25
    assert scores["auc_robot"] is None, "nothing moved in depth"
    spiking = [{"shown": "background", "spiked": spiked} for spiked in (True, False)]
    clips = table(*spiking, {"shown": "rightward", "spiked": True}, {"shown": "background"})
    assert board.direction_scores(table(), clips)["false_alarms"].value == 0.5, "of backgrounds, of spiking models"


def test_alarms_and_seconds_of_a_clip_are_by_its_own_frame_rate():
    """Spikes 40 frames apart are one alarm at 100 frames/s, and would be two at 30."""
    trial = ClipTrial("looming", 0, 0, 4, Clip("near", "looming", {"fps": 100.0}), ())
    clip = list(trial.condition.build(4))
    spikes = np.zeros(len(clip), int)
    spikes[[-60, -20]] = 1
    row = {**extremes(), "model": "m", "experiment": "looming", "stimulus": "looming", "object": None, "fps": 100.0,
           "motion": "looming", "hs_spikes": None, "vs_spikes": None, "looming_spikes": 2, "peak_looming": 0.8,
           "frames": len(clip)}  # fmt: skip
    found = board.response(row, trial, pl.DataFrame({"looming_spikes": spikes}))
    assert (found["alarms"], found["seconds"], found["shown"]) == (1, len(clip) / 100, "looming")
    assert found["contact_s"] == pytest.approx(clip[-60].truth.time_to_contact_s)


def looming_clips(peak, alarms, spiking=True):
    """Three approaches straight ahead at 0.9, and others at ``peak``."""
    ahead = zip((0.04, 0.08, 0.16), (0.2, 0.4, 1.0), strict=True)
    rows = [{"shown": "looming", "looming": 0.9, "condition": f"looming-even dark looming {s:g} s", "contact_s": t}
            for s, t in ahead]  # fmt: skip
    rows += [{"shown": shown, "looming": peak} for shown in ("receding", "upward", "grating")]
    counts = [alarms] * 3 + [0, 0, 3]
    spikes = [{"alarms": count, "seconds": 30.0} if spiking else {"contact_s": None} for count in counts]
    return table(*(row | spike for row, spike in zip(rows, spikes, strict=True)))


def test_scores_of_an_ideal_looming_detector_of_a_silent_one_and_of_one_without_a_threshold():
    ideal = board.looming_scores(table(), looming_clips(0.6, 1))
    assert ideal["auc_translation"].value == ideal["auc_recession"].value == ideal["auc_background"].value == 1.0
    assert (ideal["answered"].value, ideal["answered"].n) == (1.0, 3)
    dark = ideal["contact_dark_s"]
    assert (dark.value, dark.low, dark.high, dark.n) == (0.4, 0.2, 1.0, 3) and ideal["contact_light_s"] is None
    assert (ideal["alarms_translation"].value, ideal["alarms_gratings"].value) == (0.0, 6.0)
    assert ideal["alarms_background"] is None and ideal["auc_translation_robot"] is None
    silent = board.looming_scores(table(), looming_clips(0.9, 0))
    assert (silent["auc_translation"].value, silent["answered"].value) == (0.5, 0.0)
    without = board.looming_scores(table(), looming_clips(0.6, 0, spiking=False))
    assert without["answered"] is without["alarms_gratings"] is without["contact_dark_s"] is None
    assert without["auc_recession"].value == 1.0


def test_models_rank_by_the_first_mean_then_by_the_second_then_by_name(monkeypatch):
    """Of a model without any score nothing is known: it comes last."""
    given = {"loom": (0, 0), "b": (3, 1), "c": (3, 3), "d": (4, 0), "a": (3, 1), "gone": None}
    rows = []
    for name, value in given.items():
        rights, strong = value or (0, 0)
        ways = [{"shown": way, "right": i < rights, "strength": float(i < strong), "model": name}
                for i, way in enumerate(SIGNED)]  # fmt: skip
        rows += [*ways, {"shown": "looming", "strength": 0.5, "model": name}] if value else []
    shown = table(*rows)
    models = [dataclasses.replace(choose("emd"), label=name) for name in given]
    (ranked,) = board.rank({DIRECTION: models}, {"robot": shown, DIRECTION: shown}, {"us_99x72": {"c": [4.0]}}).values()
    assert ranked["model"].to_list() == ["d", "c", "a", "b", "loom", "gone"]
    second = ranked.row(1, named=True)
    assert (second["direction_robot"], second["direction_robot_n"], second["us_99x72"]) == (0.75, 4, 4.0)
    assert second["us_99x72_low"] is second["false_alarms"] is None, "one round has no interval"


def test_the_gain_is_the_score_over_that_of_the_best_control_but_for_mirror_and_shuffle():
    rights = {"m": 4, "m~frozen": 1, "m~absent": 0, "m~reversed": 2, "m~mirrored": 3, "m~shuffled": 3, "alone": 4}
    shown = table(*({"shown": way, "right": i < count, "strength": 1.0, "model": name}
                    for name, count in rights.items() for i, way in enumerate(SIGNED)))  # fmt: skip
    models = [dataclasses.replace(choose("emd"), label=name) for name in ("m", "alone")]
    (ranked,) = board.rank({DIRECTION: models}, {"robot": shown, DIRECTION: shown}, {}).values()
    assert dict(ranked.select("model", "gain").rows()) == {"m": 0.5, "alone": None}
    assert "gain" in board.measures(ranked)


def test_each_model_stands_on_the_boards_of_its_channels():
    parts = board.parts_of(planned(*MODELS))
    boards = {part: {model.label for model in parts[part][0].models} for part in (DIRECTION, LOOMING)}
    assert boards[DIRECTION] & boards[LOOMING] == {"hybrid"}
    assert boards[LOOMING] == {name for name in MODELS if "looming" in MODELS[name].channels}
    assert boards[DIRECTION] | boards[LOOMING] == set(MODELS)


def test_a_figure_has_each_score_and_its_interval_in_the_row_that_names_its_model():
    """Every measure is lacking in one of three models, whose row stays blank there and keeps its place."""
    columns = {"model": ["first", "second", "third"]}
    for place, name in enumerate(board.LABELS):
        values = [None if (row + place) % 3 == 0 else 0.1 + 0.2 * row + 0.01 * place for row in range(3)]
        for end, far in (("", 0.0), ("_low", -0.03), ("_high", 0.05)):
            columns[name + end] = [value and value + far for value in values]
        columns[f"{name}_n"] = [value and 5 + row for row, value in enumerate(values)]
    given = pl.DataFrame(columns)
    figure = scoreboard.draw(given, board.LABELS, board.CHANCE, "", "")
    rows = {tick.get_position()[1]: tick.get_text() for tick in figure.axes[0].get_yticklabels()}
    drawn = {" ".join(axes.get_title("left").split()[1:]): axes for axes in figure.axes if axes.lines}
    assert drawn.keys() == set(board.LABELS.values())
    numbers = re.findall(r"=(\d)\sto\s(\d)", figure._supxlabel.get_text())
    assert numbers == [(f"{given[f'{name}_n'].min()}", f"{given[f'{name}_n'].max()}") for name in board.LABELS]
    for name, label in board.LABELS.items():
        (dots,) = [line for line in drawn[label].lines if line.get_marker() == "o"]
        (whiskers,) = drawn[label].collections
        chance = {line.get_xdata()[0] for line in drawn[label].lines if line.get_linestyle() == ":"}
        assert chance == {"direction": {0.25}, "auc": {0.5}}.get(name.partition("_")[0], set())
        known = given.select("model", name, f"{name}_low", f"{name}_high").drop_nulls().rows()
        assert [rows[y] for y in dots.get_ydata()] == [model for model, *_ in known], name
        ends = [segment[:, 0] for segment in whiskers.get_segments()]
        np.testing.assert_allclose(np.column_stack([dots.get_xdata(), ends]), [one[1:] for one in known], err_msg=name)


@pytest.fixture
def few(monkeypatch):
    """A board of two robot trials and a few clips, without timing."""
    whole = board.clip_experiments

    def some(kind, models):
        return tuple(dataclasses.replace(part, clips=part.clips[::15]) for part in whole(kind, models))

    robot = dataclasses.replace(board.ROBOT, design=Translation((10.0,), (6.0,), "both"))
    monkeypatch.setattr(board, "ROBOT", robot)
    monkeypatch.setattr(board, "clip_experiments", some)
    monkeypatch.setattr(board, "time_models", lambda models, shape: {model.label: [1.0] for model in models})


def test_a_board_with_controls_ranks_the_same_models_and_has_their_gain(tmp_path, few):
    asked = Asked(kind="leaderboard", models=("emd",), only=True, repeats=1, options={"controls": True})
    run = perform(board.plan(asked), tmp_path / "out", Workers(0, quiet=True))
    (row,) = board.tables(run)[DIRECTION].to_dicts()
    assert row["model"] == "emd" and 0.5 < row["gain"] <= 1.0


def test_a_user_s_model_is_ranked_and_the_folder_goes_on(tmp_path, capsys, few):
    (tmp_path / "my_model.py").write_text(user_files.MODEL)
    plan = planned("lgmd1", str(tmp_path / "my_model.py"))
    run = perform(plan, tmp_path / "out", Workers(0))
    boards = board.tables(run)
    assert run.failures.is_empty()
    assert boards[DIRECTION].select("model", "direction_robot", "direction_robot_n").rows() == [("gradient", 1.0, 2)]
    assert boards[LOOMING]["model"].to_list() == ["lgmd1"]
    again = board.tables(perform(plan, tmp_path / "out", Workers(0)))
    assert capsys.readouterr().err.count(" of them done already") == 5
    for kind in (DIRECTION, LOOMING):
        assert boards[kind].equals(again[kind])
        assert pl.read_csv(tmp_path / "out" / f"{board.FILES[kind]}.csv").drop_nulls("model").height == 1
    with pytest.raises(UsageError, match="emd"):
        perform(planned("emd"), tmp_path / "out", Workers(0, quiet=True))

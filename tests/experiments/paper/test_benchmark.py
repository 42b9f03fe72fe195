"""The benchmark: its frozen tasks, marks and places of generated rows, entries that are true, forged and tuned."""

import dataclasses
import hashlib
import json
import math
import re
import shutil
from itertools import product
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from experiments.base.errors import UsageError
from experiments.cli import main
from experiments.declare.experiment import Listed
from experiments.draw import scoreboard
from experiments.judge.judge import SIGNED
from experiments.paper.benchmark import entry, tasks
from experiments.paper.benchmark.rows import ROWS, difference, summed
from experiments.store.tables import table

LABELS = {name: name for name in ("direction, robot", "AUC against background", "gain of AUC over the best control")}
BOTH = ("hs", "vs", "looming")
DIGESTS = {
    ("hs", "vs"): "8d357d3084fdd99392c0533baf4b1098d5abb80a6ba7e2103c8413204a074c73",
    ("looming",): "63c66df0dcd10e023289476cee1aa912a2e58ce219d6fc006c249ac171cc4bdf",
    ("target",): "54d6144d032da02ea8cac96538b235812fa72594dd2e45dcc5150c96d838d847",
    BOTH: "9ddcd4385e0df144c5a1e260cea7496b62d41d3c8b1e02193858a4fbdff6e3c7",
}
MEASURED = "7efcf4d4ac3e1e677d2b17265d7c2a4a6cd91abf5d015be50676922c453d86cf"
"""Of CB-1. It may be another one only under another name."""
PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "benchmark.md"
TUNED = re.findall(r"```text\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[0]


def scores_of_made_up_rows():
    """All scores to four digits: what computes them is frozen too."""
    kinds, made = [*SIGNED, "receding", "looming", "background"], []
    for task, control, i in product(tasks.TASKS, ("", *tasks.CONTROLS), range(96)):
        value = (7919 * (i + 11 * len(task) + 5 * len(control)) % 97) / 97
        made.append({
            "task": task, "control": control, "cluster": f"c{i % 8}", "level": float(i // 8 % 6), "shown": kinds[i % 7],
            "right": value < 0.9, "seconds": 2.0, "alarms": i % 3, "looming": value, "contact_s": value,
            "flow_r": value,
        })  # fmt: skip
    scores, _ = summed(table(made, ROWS), BOTH)
    return {
        name: [f"{number:.4g}" for number in (score.value, score.low, score.high)] for name, score in scores.items()
    }


def test_the_tasks_are_those_of_cb_1():
    assert {channels: entry.digest(channels) for channels in DIGESTS} == DIGESTS
    assert hashlib.sha256(json.dumps(scores_of_made_up_rows()).encode()).hexdigest() == MEASURED
    assert sum(task.seconds for task in tasks.TASKS.values()) < 600


def test_a_task_that_changes_has_another_digest(monkeypatch):
    task = tasks.TASKS["looming"]
    fewer = dataclasses.replace(task.declared, clips=task.declared.clips[1:])
    monkeypatch.setitem(tasks.TASKS, "looming", dataclasses.replace(task, declared=fewer))
    entry.digest.cache_clear()
    changed = entry.digest(("looming",)), entry.digest(("hs", "vs"))
    entry.digest.cache_clear()
    assert changed[0] != DIGESTS["looming",] and changed[1] == DIGESTS["hs", "vs"]


def responses(seed=0, **more):
    """Rows of a model that is right in four of five crossings, and looms a little more in approaches."""
    rng, made = np.random.default_rng(seed), []
    for task, i in ((task, i) for task in tasks.TASKS for i in range(56)):
        shown = (*SIGNED, "looming", "receding", "background")[i % 7]
        made.append({
            "seeds": "public", "task": task, "trial": i, "seed": i, "control": "", "cluster": f"c{i // 7} {shown}",
            "level": 1.0, "shown": shown, "right": bool(rng.random() < 0.8), "strength": rng.random(), "seconds": 2.0,
            "looming": rng.random() + (shown == "looming"), "spiked": True, "alarms": 0, "flow_r": rng.random(), **more,
        })  # fmt: skip
    return table(made, ROWS)


def test_marks_have_the_scores_as_their_means():
    scores, marks = summed(responses(), BOTH)
    for name in ("direction, robot", "AUC against all else, robot", "correlation of HS with true flow"):
        for side in marks[name]:
            assert np.mean([*side.values()]) == pytest.approx(scores[name].value, abs=1e-4), name
    assert "direction, robot" not in summed(responses(), ("looming",))[0], "it does not apply"


def test_an_order_is_stated_only_where_the_paired_interval_says_so():
    marks = [{f"c{i}": value for i, value in enumerate(values)} for values in ([1.0] * 8, [0.0] * 8, [1.0, 0.0] * 4)]
    ahead, unsure = difference([marks[0]], [marks[1]]), difference([marks[2]], [{f"c{i}": 0.4 for i in range(8)}])
    assert ahead.low > 0 > unsure.low and unsure.high > 0
    assert math.isnan(difference([{"a": 1.0, "b": 1.0}], [{"a": 0.0, "b": 0.0}]).low), "two clusters cannot tell"
    made = [{"model": name, "beacon": "", "marks": {"public": {"direction, robot": [side]}}}
            for name, side in zip("abc", marks, strict=True)]  # fmt: skip
    assert [entry.place(one, made, "direction, robot") for one in made] == ["1 of 3", "3 of 3", "2 of 3"]
    alike = [{**made[0], "model": "d"}, made[0]]
    assert entry.place(alike[0], alike, "direction, robot") == "1 to 2 of 2"


def test_chance_of_a_miss_is_that_of_drawing_without_putting_back():
    assert entry.chance_of_a_miss(10, 2, 0.3) == pytest.approx(7 / 10 * 6 / 9)
    assert entry.chance_of_a_miss(10, 10, 0.1) == 0.0


def test_forged_rows_are_found_by_a_sample_of_any_seed():
    """Of 540 trials 162 are forged; 54 are done again."""
    there, parts = responses(), tasks.plans("hybrid")
    known = [(name, trial.index) for name, plan in parts.items() for trial in plan.trials]
    true = table([{**there.row(i % there.height, named=True), "task": name.split("/")[1], "trial": index}
                  for i, (name, index) in enumerate(known)], ROWS)  # fmt: skip
    for seed in range(20):
        false = set(np.random.default_rng(seed).choice(len(known), round(0.3 * len(known)), replace=False).tolist())
        off = np.isin(np.arange(len(known)), list(false)) * 0.01
        forged = true.with_columns(pl.col("looming") + pl.Series(off))
        again = entry.drawn(parts, 0.1, seed)
        keys = {(name.split("/")[1], trial.index) for name, plan in again.items() for trial in plan.trials}
        here = table([row for row in true.to_dicts() if (row["task"], row["trial"]) in keys], ROWS)
        assert len(keys) == math.ceil(0.1 * len(known))
        assert entry.compared(forged, here, exact=True), seed
        assert not entry.compared(true, here, exact=True)


def test_another_machine_is_compared_within_margins():
    true = responses()
    near = true.with_columns(pl.col("looming") + 0.001, alarms=pl.col("alarms") + 1)
    assert entry.compared(near, true, exact=True) and not entry.compared(near, true, exact=False)
    assert entry.compared(true.with_columns(pl.col("looming") * 1.1), true, exact=False)
    assert entry.compared(true.with_columns(right=~pl.col("right")), true, exact=False)


def test_a_figure_has_each_score_and_its_interval_in_the_row_that_names_its_model():
    """Every measure is lacking in one of three models, whose row stays blank there and keeps its place."""
    scores = {}
    for row, model in enumerate(("first", "second", "third")):
        values = [0.1 + 0.2 * row + 0.01 * place for place in range(len(LABELS))]
        found = [None if (row + place) % 3 == 0 else [value, value - 0.03, value + 0.05, 5 + row]
                 for place, value in enumerate(values)]  # fmt: skip
        scores[model] = dict(zip(LABELS, found, strict=True))
    given = scoreboard.tabulate(scores)
    figure = scoreboard.draw(given, LABELS, entry.CHANCE, "", "")
    rows = {tick.get_position()[1]: tick.get_text() for tick in figure.axes[0].get_yticklabels()}
    drawn = {" ".join(axes.get_title("left").split()[1:]): axes for axes in figure.axes if axes.lines}
    assert drawn.keys() == set(LABELS.values())
    for name, label in LABELS.items():
        (dots,) = [line for line in drawn[label].lines if line.get_marker() == "o"]
        (whiskers,) = drawn[label].collections
        chance = {line.get_xdata()[0] for line in drawn[label].lines if line.get_linestyle() == ":"}
        assert chance == {level for start, level in entry.CHANCE.items() if name.startswith(start)}
        known = given.select("model", name, f"{name}_low", f"{name}_high").drop_nulls().rows()
        assert [rows[y] for y in dots.get_ydata()] == [model for model, *_ in known], name
        ends = [segment[:, 0] for segment in whiskers.get_segments()]
        np.testing.assert_allclose(np.column_stack([dots.get_xdata(), ends]), [one[1:] for one in known], err_msg=name)


@pytest.fixture
def few(monkeypatch):
    """Tasks of two trials with the robot, and of a few clips."""
    robot, clutter, looming = (tasks.TASKS[name] for name in ("robot", "clutter", "looming"))
    listed, first = Listed(robot.declared.conditions()[2:14:11]), {"controls": True}
    kept = {
        "robot": dataclasses.replace(robot, options=first, declared=dataclasses.replace(
            robot.declared, design=listed, repeats=1)),
        "clutter": dataclasses.replace(clutter, declared=dataclasses.replace(
            clutter.declared, clips=clutter.declared.clips[:2], repeats=6)),
        "looming": dataclasses.replace(looming, declared=dataclasses.replace(
            looming.declared, clips=looming.declared.clips[::4])),
    }  # fmt: skip
    monkeypatch.setattr(tasks, "TASKS", kept)
    monkeypatch.setattr(entry, "TASKS", kept)
    entry.digest.cache_clear()
    yield
    entry.digest.cache_clear()


def entered(folder, model, *options):
    """The folder of a new entry."""
    assert main.command(["benchmark", str(model), *options, "--out", str(folder), "--workers", "0"]) == 0
    return folder


def test_a_tuned_model_of_a_file_shows_its_gap_and_is_verified(tmp_path, few, capsys):
    (tmp_path / "tuned.py").write_text(TUNED)
    (tmp_path / "tuned.npz").touch()
    (tmp_path / "tuned.runs").mkdir()
    folder = entered(tmp_path / "entry", tmp_path / "tuned.py", "--round", "5D3F1A0C")
    made = entry.read(folder)
    scores = {seeds: made["scores"][seeds]["direction, clutter"][0] for seeds in ("public", "round")}
    gap = made["scores"][entry.GAP]["direction, clutter"]
    assert scores["public"] == 1.0 > scores["round"] and gap[1] > 0.0
    assert (folder / "model" / "tuned.py").read_text() == TUNED and (folder / "model" / "tuned.npz").is_file()
    shutil.move(folder, tmp_path / "sent")
    (tmp_path / "tuned.py").unlink()
    check = ["benchmark", "--verify", str(tmp_path / "sent"), "--sample", "0.1", "--workers", "0"]
    assert main.command(check) == 0 and "to the bit" in capsys.readouterr().out.replace("\n", " ")


def test_every_forged_score_and_every_missing_row_is_found(tmp_path, few):
    folder = entered(tmp_path / "entry", "lgmd1")
    assert entry.forged(folder) == []
    (folder / "model").mkdir()
    (folder / "model" / "weights.pt").touch()
    assert entry.forged(folder) == ["model/weights.pt was not entered"]
    true, kept = entry.read(folder), pl.read_parquet(folder / "trials.parquet")
    for name, numbers in true["scores"]["public"].items():
        for i in range(4) if numbers else ():
            false = json.loads(json.dumps(true))
            false["scores"]["public"][name][i] = 0.123
            (folder / "entry.json").write_text(json.dumps(false))
            assert any(name in line for line in entry.forged(folder)), (name, i)
    (folder / "entry.json").write_text(json.dumps({**true, "digest": "0"}))
    with pytest.raises(UsageError, match="CB-1"):
        entry.forged(folder)
    parts = tasks.plans("lgmd1")
    assert entry.missing(kept, parts) == [] != entry.missing(kept[:-1], parts)
    assert entry.missing(pl.concat([kept, kept[:1]]), parts)
    (folder / "entry.json").write_text(json.dumps(true))
    kept[:-1].write_parquet(folder / "trials.parquet")
    assert any("trials.parquet" in line for line in entry.forged(folder))

"""A robot's log as a run: what is checked of it, what it becomes, and that a run's own log comes back equal."""

from __future__ import annotations

import csv
import json
import math
import shlex

import numpy as np
import polars as pl
import pytest
import rerun as rr

import experiments
from experiments.bench.cli import main
from experiments.bench.measured.log import POSES
from experiments.bench.run.errors import UsageError
from experiments.bench.sources.robot import forget_simulations
from experiments.bench.store.pictures import pictures

UNKNOWN = {"achieved_speed_cm_s", "path_error_mm", "drift_mm", "drive", "darkest", "brightest", "wall_s"}
"""What a robot's log does not know."""
TRACKED = {
    "closest_cm", "seconds_in_view", "spikes_in_view", "rate_in_view_hz", "mean_hs_in_view", "mean_hs_near_axis",
    "spikes_in_window", "spikes_in_inner_window",
}  # fmt: skip
"""What takes a tracker."""
FRAMES = 30


def colias(*arguments) -> int:
    return main.command([str(argument) for argument in arguments])


def written(folder, speeds=(20, 30), repeats=2, name="log.csv", lines=None):
    """A log of crossings whose HS goes up and down, and whose spikes rise with the speed. These numbers are made up."""
    columns = ["trial", "speed_cm_s", "time_s", "hs", "hs_spikes"]
    rows = [
        [trial, speed, (i + 1) / 30, math.sin(math.pi * i / FRAMES) * 0.9, int(i < speed - trial)]
        for trial, speed in enumerate(speeds * repeats) for i in range(FRAMES)
    ]  # fmt: skip
    table = [columns, *rows]
    for line, cells in (lines or {}).items():
        table[line - 1 : line] = [cells] if cells is not None else []
    path = folder / name
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(table)
    return path


def taken(log, out, *more):
    """The run of a log."""
    fast = "--set", "experiment.speeds_cm_s=20,30"
    assert colias("import", log, "--out", out, *fast, "--quiet", *more) == 0
    return experiments.load(out)


OWN = """
from experiments import Experiment, Translation

EXPERIMENT = Experiment("fast", "fast crossings", Translation((25,), (6,), "both"), varies="direction", claims=("C14",))
"""


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Crossings each way, of an experiment of one's own, with as many trials as its claim takes."""
    folder = tmp_path_factory.mktemp("simulated")
    (folder / "fast.py").write_text(OWN)
    try:
        yield experiments.run(
            folder / "fast.py", settings={"dsnn.n_con": 6}, repeats=5, recordings=False, quiet=True, workers=0,
            out=folder / "run",
        )  # fmt: skip
    finally:
        forget_simulations()


@pytest.fixture(scope="module")
def pictured(tmp_path_factory):
    """Two crossings with their recordings."""
    folder = tmp_path_factory.mktemp("pictured") / "speed"
    settings = {"experiment.speeds_cm_s": [20, 30]}
    try:
        yield experiments.run("speed", settings=settings, repeats=1, quiet=True, workers=0, out=folder)
    finally:
        forget_simulations()


@pytest.mark.parametrize("tracked", [False, True])
def test_a_simulated_run_comes_back_equal(simulated, tmp_path, capsys, tracked):
    """Spikes, HS to the last bit, statistics and verdicts: where it comes from is all that differs."""
    options = ["--tracked"] if tracked else []
    assert colias("firmware", "log", simulated.folder, "--out", tmp_path / "log", *options) == 0
    _, _, printed = " ".join(capsys.readouterr().out.split()).partition("import by ")
    assert printed.startswith("colias import ") and "--set dsnn.n_con=6" in printed and "fast.py" in printed
    assert colias(*shlex.split(printed)[1:], "--out", tmp_path / "back", "--quiet", "--no-recordings") == 0
    back = experiments.load(tmp_path / "back")
    lost = UNKNOWN if tracked else UNKNOWN | TRACKED
    for before, after in zip(simulated.trials.to_dicts(), back.trials.to_dicts(), strict=True):
        assert after.pop("provenance") == "log of a simulated run"
        assert all(after[name] is None for name in lost)
        assert after == {name: None if name in lost else value for name, value in before.items()}
    columns = [name for name in simulated.frames.columns if tracked or name not in POSES]
    assert back.frames.select(columns).equals(simulated.frames.select(columns))
    summaries = [[row for row in run.summary.to_dicts() if row["quantity"] not in lost] for run in (simulated, back)]
    assert summaries[0] == summaries[1] and summaries[0]
    verdicts = [run.claims.to_dicts() for run in (simulated, back)]
    assert {row["provenance"] for row in verdicts[1]} == {"log of a simulated run"}
    for before, after in zip(*verdicts, strict=True):
        assert {**after, "provenance": before["provenance"]} == before
    assert {row["outcome"] for row in verdicts[0]} <= {"holds", "fails"} and verdicts[0]


def test_frames_of_a_camera_alone_are_shown_to_a_model(pictured, tmp_path):
    """What the network made of the frames in the simulation it makes of them again, from PGM and from raw files."""
    export = ["firmware", "log", pictured.folder, "--out", tmp_path / "log", "--quiet"]
    assert colias(*export) == 0
    with (tmp_path / "log" / "log.csv").open() as file:
        rows = [{name: row[name] for name in ("trial", "speed_cm_s", "time_s")} for row in csv.DictReader(file)]
    log = tmp_path / "camera.csv"
    with log.open("w", newline="") as file:
        lines = csv.DictWriter(file, list(rows[0]))
        lines.writeheader()
        lines.writerows(rows)
    with pytest.raises(UsageError, match=r"no column hs or looming.*--model dsnn"):
        taken(log, tmp_path / "none")
    # The whole log has the answers too: the robot's own and the model's on its frames stand side by side.
    whole = tmp_path / "log" / "log.csv", tmp_path / "both", "--frames", tmp_path / "log" / "frames", "--model", "dsnn"
    both = taken(*whole, "--no-recordings")
    assert both.models == ["dsnn", "dsnn@frames"]
    assert set(both.trials["provenance"].to_list()) == {
        "log of a simulated run", "frames from the log of a simulated run"
    }  # fmt: skip
    answers = [both.frames.filter(model=name)["hs"] for name in both.models]
    assert answers[0].equals(answers[1])
    first, second = (tmp_path / "log" / "frames" / f"trial-000{i}" for i in (0, 1))
    seen = pictures(pictured.recordings[1])["camera"]
    for path in second.iterdir():
        path.unlink()
    second.rmdir()
    second.with_suffix(".raw").write_bytes(seen.tobytes())
    run = taken(log, tmp_path / "camera", "--frames", first.parent, "--model", "dsnn")
    assert run.provenance == "frames measured, network simulated"
    for name in ("hs", "vs", "hs_spikes"):
        assert run.frames[name].equals(pictured.frames[name])
    assert run.trials["spikes"].equals(pictured.trials["spikes"]) and run.trials["seed"].null_count() == 2
    np.testing.assert_array_equal(pictures(run.recordings[1])["camera"], seen)
    (first / "000003.pgm").unlink()
    with pytest.raises(UsageError, match=r"frame 000003\.pgm is missing"):
        taken(log, tmp_path / "gap", "--frames", first.parent, "--model", "dsnn")
    second.with_suffix(".raw").write_bytes(seen.tobytes()[:-1])
    assert not (tmp_path / "gap").exists()


def test_frames_that_are_not_the_log_s(tmp_path):
    log, frames = written(tmp_path), tmp_path / "frames"
    with pytest.raises(UsageError, match="no such folder of frames"):
        taken(log, tmp_path / "run", "--frames", frames)
    frames.mkdir()
    with pytest.raises(UsageError, match=r"trial-0000: no frames of trial 0 there, which .*log.csv has in line 2"):
        taken(log, tmp_path / "run", "--frames", frames)
    for trial in range(5):
        (frames / f"trial-{trial:04d}.raw").write_bytes(bytes(72 * 99 * FRAMES))
    with pytest.raises(UsageError, match=r"trial-0004.raw: .*log.csv has no such trial"):
        taken(log, tmp_path / "run", "--frames", frames)
    (frames / "trial-0004.raw").unlink()
    (frames / "trial-0003.raw").write_bytes(bytes(72 * 99 * (FRAMES - 1)))
    with pytest.raises(UsageError, match=rf"trial-0003.raw: 29 frames, .*log.csv, line {2 + 3 * FRAMES}, begins"):
        taken(log, tmp_path / "run", "--frames", frames)
    (frames / "trial-0003.raw").write_bytes(bytes(72 * 99 * FRAMES - 1))
    with pytest.raises(UsageError, match=r"no number of frames of 99x72 = 7128 bytes"):
        taken(log, tmp_path / "run", "--frames", frames)
    assert not list(tmp_path.glob("run*"))


HEAD = ["trial", "speed_cm_s", "time_s", "hs", "hs_spikes"]
ELSEWHERE = {line: [0, 25, line / 30, 0.1, 0] for line in range(2, 2 + FRAMES)}
WRONG = {
    "an unknown column": ({1: [*HEAD[:3], "HS", "hs_spikes"]}, "line 1: unknown column 'HS'"),
    "a missing column": ({1: [*HEAD[:4], "azimuth"]}, "line 1: column hs_spikes is missing"),
    "a missing condition": ({1: ["trial", "direction", *HEAD[2:]]}, "line 1: column speed_cm_s is missing"),
    "a part of a tracker's": ({1: [*HEAD[:3], "azimuth", "observer_x_cm"]}, "line 1: column .* is missing"),
    "a time that runs back": ({4: [0, 20, 0.01, 0.1, 0]}, "line 4: time_s=0.01 of trial 0 is not later"),
    "a time that stands": ({3: [0, 20, 1 / 30, 0.1, 0]}, "line 3: time_s"),
    "not a number": ({4: [0, 20, 0.1, "nan", 0]}, "line 4: hs must be a number between -1 and 1, got 'nan'"),
    "a word": ({4: [0, 20, 0.1, "high", 0]}, "line 4: hs must be a number between"),
    "half a spike": ({4: [0, 20, 0.1, 0.1, 0.5]}, "line 4: hs_spikes must be a whole number between"),
    "a potential out of range": ({4: [0, 20, 0.1, 1.5, 0]}, "line 4: hs must be a number between -1 and 1, got '1.5'"),
    "a blank time": ({4: [0, 20, "", 0.1, 0]}, "line 4: time_s is blank"),
    "a blank potential": ({4: [0, 20, 0.1, "", 0]}, "line 4: hs is blank in some frames"),
    "a blank count": ({4: [0, 20, 0.1, 0.1, ""]}, "line 4: hs_spikes is None"),
    "another condition": ({2: [0, 25, 1 / 30, 0.1, 0]}, "line 3: speed_cm_s is 20.0, but trial 0 began"),
    "no such condition": (ELSEWHERE, r"line 2: no condition of speed has speed_cm_s=25.0"),
    "a spike of the other sign": ({4: [0, 20, 0.1, -0.1, 1]}, "line 4: hs_spikes is 1, and hs is -0.1"),
}


@pytest.mark.parametrize("what", WRONG)
def test_each_fault_is_one_line_and_nothing_is_written(what, tmp_path):
    lines, message = WRONG[what]
    log = written(tmp_path, lines=lines)
    with pytest.raises(UsageError, match=message) as refused:
        taken(log, tmp_path / "run")
    assert "\n" not in str(refused.value) and str(refused.value).startswith(f"{log}, line ")
    assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


def test_a_pose_beyond_any_arena_is_a_damaged_line(tmp_path):
    """It would be drawn, and Matplotlib ends in a traceback."""
    columns = [*HEAD, *POSES]
    lines = [[0, 20, (i + 1) / 30, 0.1, 0, *[0.0] * 6, 1e308 if i == 5 else 0.0] for i in range(FRAMES)]
    log = written(tmp_path, lines={1: columns, **{i: line for i, line in enumerate(lines, 2)}})
    with pytest.raises(UsageError, match=rf"line 7: {POSES[-1]} must be a number between -10000 and 10000"):
        taken(log, tmp_path / "run")


def test_a_bearing_is_right_positive_as_its_poses_say(tmp_path):
    """A log of version 0.3, in which left was positive, is not taken for its mirror image."""
    columns = [*HEAD, *POSES]
    for sign in (-1, 1):
        left = [sign * 45.0, 8.0, 8.0, 0.0, 0.0, 0.0, 0.0]
        lines = [[0, 20, (i + 1) / 30, 0.1, 0, *left] for i in range(FRAMES)]
        log = written(tmp_path, (20,), 1, lines={1: columns, **{i: line for i, line in enumerate(lines, 2)}})
        if sign < 0:
            assert set(taken(log, tmp_path / "run").frames[POSES[0]].to_list()) == {-45.0}
        else:
            with pytest.raises(UsageError, match=r"line 2: stimulus_bearing_deg is 45"):
                taken(log, tmp_path / "other")


def test_a_looming_detector_s_spikes_are_none_below_0(tmp_path):
    head = [*HEAD[:3], "looming", "looming_spikes", "model"]
    log = written(tmp_path, lines={1: head, 2: [0, 20, 1 / 30, 0.5, -1, "lgmd1"]})
    with pytest.raises(UsageError, match="line 2: looming_spikes must be a whole number between 0 and 1000"):
        taken(log, tmp_path / "run")


NUMBERS = ("0_1", "0x1", "inf", "-inf", "1e400", "\u0660.\u0665", "1,5", "0.1.", "e1", "--1", "True", "\u00bd")
WHOLE = ("1_0", "1.0", "\uff11", "1e0", "0b1", "True", "9" * 50)


@pytest.mark.parametrize("cell", [*NUMBERS, *WHOLE], ids=lambda cell: ascii(cell)[:20])
def test_a_number_is_spelt_as_tables_spell_it(cell, tmp_path):
    """Python reads 1_0 as 10, and the digits of every script; what else a cell may mean is asked of its writer."""
    name, row = ("hs", [0, 20, 0.1, cell, 0]) if cell in NUMBERS else ("hs_spikes", [0, 20, 0.1, 0.1, cell])
    with pytest.raises(UsageError, match=rf"line 4: {name} must be "):
        taken(written(tmp_path, lines={4: row}), tmp_path / "run")


@pytest.mark.parametrize("cell", ["0.1", " .1 ", "+1E-1", "1.e-1", "-0.0", "1e-400"])
def test_what_numbers_look_like_otherwise(cell, tmp_path):
    run = taken(written(tmp_path, lines={4: [0, 20, 0.1, cell, "+1"]}), tmp_path / "run", "--no-recordings")
    assert run.frames["hs"][2] == float(cell) and run.frames["hs_spikes"][2] == 1


@pytest.mark.parametrize("separator", [";", "\t"])
def test_another_separator_is_refused(separator, tmp_path):
    """As spreadsheets write it where the decimal point is a comma."""
    log = written(tmp_path)
    log.write_text(log.read_text().replace(",", separator))
    with pytest.raises(UsageError, match="line 1: unknown column"):
        taken(log, tmp_path / "run")


@pytest.mark.parametrize(
    ("factor", "message"),
    [(1e3, "is time_s in milliseconds"), (1e6, "is time_s in microseconds"), (30, "the number of the frame"),
     (1 / 60, "legal are seconds"), (10.5, "legal are seconds")],
)  # fmt: skip
def test_times_in_another_unit_are_asked_about(factor, message, tmp_path):
    log = timed(written(tmp_path), factor)
    with pytest.raises(
        UsageError, match=rf"^{log}, line 2: .* come at .* per second.*camera.fps is 30.*{message}"
    ) as refused:
        taken(log, tmp_path / "run")
    assert "\n" not in str(refused.value) and "--set camera.fps" in str(refused.value)
    assert not (tmp_path / "run").exists()


def timed(log, factor):
    """The log with times that many times as long."""
    head, *lines = log.read_text().splitlines()
    cells = [line.split(",") for line in lines]
    log.write_text("\n".join([head, *(",".join([*c[:2], repr(float(c[2]) * factor), *c[3:]]) for c in cells)]))
    return log


def test_one_trial_in_another_unit_is_asked_about(tmp_path):
    lines = {2 + FRAMES + i: [1, 30, 1000 * (i + 1) / 30, 0.1, 0] for i in range(FRAMES)}
    with pytest.raises(UsageError, match=f"line {2 + FRAMES}: the frames of trial 1 .*milliseconds"):
        taken(written(tmp_path, lines=lines), tmp_path / "run")


def test_a_measured_run_says_so_everywhere(tmp_path, capsys):
    """HS alone, no tracker, one repeat more of one condition: what nobody knows is null, and all readers cope."""
    log = written(tmp_path, speeds=(20, 30, 20), repeats=1)
    assert colias("import", log, "--set", "experiment.speeds_cm_s=20,30", "--out", tmp_path / "runs" / "first") == 0
    printed = capsys.readouterr().out
    assert "measured: imported from a log" in printed and "[measured]" in printed
    run = experiments.load(tmp_path / "runs" / "first")
    described = json.loads((run.folder / "run.json").read_text())
    assert described["measured"]["provenance"] == run.provenance == "measured"
    assert set(run.trials["provenance"].to_list()) == set(run.claims["provenance"].to_list()) == {"measured"}
    assert set(run.claims["outcome"].to_list()) == {"not shown"}
    assert "needs rightward translations" in run.claims["measured"][0]
    assert all(run.trials[name].null_count() == 3 for name in (UNKNOWN | TRACKED | {"peak_vs", "vs_spikes", "seed"}))
    assert run.frames["vs"].null_count() == run.frames.height and not run.frames["hs"].null_count()
    assert {"peak_vs", "achieved_speed_cm_s"}.isdisjoint(run.summary["quantity"].to_list())
    caption = run.figure().get_supxlabel()
    assert "measured" in caption and "arena" not in caption and "n = 1 to 2" in caption
    entities = {str(chunk.entity_path) for chunk in rr.chunk.RrdReader(run.recordings[0]).stream().to_chunks()}
    assert "/models/dsnn/hs" in entities and "/models/dsnn/vs" not in entities
    assert colias("list", "runs", tmp_path / "runs") == 0
    assert "measured" in capsys.readouterr().out
    with pytest.raises(FileExistsError, match="is there already"):
        taken(log, run.folder)


def test_a_figure_of_mechanism_takes_a_tracker(tmp_path):
    """Without poses there is no time in view to draw: the run has the figure of counts and potentials instead."""
    log = tmp_path / "log.csv"
    with log.open("w", newline="") as file:
        lines = csv.writer(file)
        lines.writerow(["trial", "distance_cm", "time_s", "hs", "hs_spikes"])
        for trial, distance in enumerate((5, 10, 15)):
            lines.writerows([trial, distance, (i + 1) / 30, 0.5, int(i > distance)] for i in range(FRAMES))
    assert (
        colias("import", log, "--experiment", "distance-mechanism", "--out", tmp_path / "run", "--no-recordings") == 0
    )
    counts, potentials = experiments.load(tmp_path / "run").figure().axes
    (line,) = (line for line in counts.lines if line.get_label() == "spikes")
    assert (
        list(line.get_ydata()) == [FRAMES - 6, FRAMES - 11, FRAMES - 16]
        and potentials.lines[2].get_label() == "15\N{NO-BREAK SPACE}cm"
    )


def test_claims_are_judged_by_the_same_bounds_where_the_conditions_are_there(tmp_path):
    """Made-up spikes of 4 trials of each speed: one model has most at 6 cm/s (C15), the other no more than at 4."""
    log, spikes_by_model = tmp_path / "log.csv", {"dsnn": (3, 9, 20, 12), "dsn2017": (3, 9, 9, 12)}
    with log.open("w", newline="") as file:
        lines = csv.writer(file)
        lines.writerow(["trial", "model", "speed_cm_s", "time_s", "hs", "hs_spikes"])
        for trial in range(16):
            for model, spikes in spikes_by_model.items():
                here = trial, model, (2, 4, 6, 10)[trial % 4]
                lines.writerows([*here, (i + 1) / 30, 0.5, int(i < spikes[trial % 4])] for i in range(FRAMES))
    assert colias("import", log, "--out", tmp_path / "run", "--quiet", "--no-recordings") == 0
    claims = {(row["id"], row["model"]): row for row in experiments.load(tmp_path / "run").claims.to_dicts()}
    assert claims["C15", "dsnn"]["outcome"] == "holds" and claims["C15", "dsn2017"]["outcome"] == "fails"
    for row in claims.values():
        assert row["provenance"] == "measured"
        if row["id"] == "C29":
            assert row["outcome"] == "not shown" and "spikes_in_window" in row["measured"]


def test_two_robots_compare_as_independent_samples(tmp_path, capsys):
    one = taken(written(tmp_path, repeats=6), tmp_path / "one", "--no-recordings")
    slow = written(tmp_path, repeats=6, name="other.csv")
    text = slow.read_text().splitlines()
    slow.write_text("\n".join(line if i % 2 else line[: line.rindex(",")] + ",0" for i, line in enumerate(text[1:])))
    slow.write_text("\n".join([text[0], *slow.read_text().splitlines()]))
    other = taken(slow, tmp_path / "other", "--no-recordings")
    comparison = experiments.compare(one, other)
    rows = comparison.results.to_dicts()
    assert len(rows) == 2 and all(row["test"].startswith("Mann-Whitney") for row in rows)
    assert "seed" not in capsys.readouterr().out
    assert all(row["rank_biserial"] > 0.5 and row["mean_difference"] > 0 and row["n"] == 6 for row in rows)
    assert not experiments.compare(one, one).results["mean_difference"].to_list()[0]


def test_two_models_of_one_log_are_paired(tmp_path):
    """Each trial has the rows of both; the second model answers with one spike less."""
    log = written(tmp_path, repeats=3)
    head, *lines = log.read_text().splitlines()
    by_trial = [lines[i : i + FRAMES] for i in range(0, len(lines), FRAMES)]
    other = [f"{line[: line.rindex(',')]},0" for line in lines]
    log.write_text("\n".join([
        f"model,{head}",
        *(f"{name},{line}" for i, rows in enumerate(by_trial)
          for name, part in (("dsnn", rows), ("dsn2017", other[i * FRAMES : (i + 1) * FRAMES])) for line in part),
    ]))  # fmt: skip
    run = taken(log, tmp_path / "run", "--no-recordings")
    assert run.models == ["dsnn", "dsn2017"]
    comparisons = (run.folder / "comparisons.csv").read_text()
    assert comparisons.count("Wilcoxon") == 2 and "dsn2017" in comparisons
    log.write_text(log.read_text().replace("dsn2017", "nobody"))
    with pytest.raises(UsageError, match=r"nobody.*the models of .*log.csv are dsnn, nobody; --ran"):
        taken(log, tmp_path / "again")


def test_a_log_without_the_channel_that_counts(tmp_path):
    with pytest.raises(UsageError, match=r"line 2: trial 0 has no looming of lgmd1, whose spikes count"):
        taken(written(tmp_path), tmp_path / "run", "--ran", "lgmd1")


def test_a_robot_s_own_frame_rate(tmp_path):
    """25 frames a second: the firing rate goes by the log's times, not by the camera's setting."""
    rows = taken(timed(written(tmp_path), 30 / 25), tmp_path / "run", "--no-recordings").trials.to_dicts()
    assert all(row["firing_rate_hz"] == pytest.approx(row["spikes"] / (FRAMES / 25)) for row in rows)
    assert pl.read_parquet(tmp_path / "run" / "frames.parquet")["sim_time_s"][FRAMES - 1] == pytest.approx(1.2)

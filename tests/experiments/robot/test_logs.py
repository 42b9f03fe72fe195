"""A robot's log as a run: a run's own log comes back equal, and what is wrong in a log is named by its line."""

import csv
import math
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import experiments
from experiments.base.errors import UsageError
from experiments.cli import main
from experiments.robot.log_trial import UNKNOWN, pictures_in, rate_and_steps
from experiments.robot.logs import POSES, read
from tests.helpers.recordings import columns

CASES = Path(__file__).parents[2] / "data" / "cases"

SPEEDS = "--set", "experiment.speeds_cm_s=20,30"
FRAMES = 30
HEAD = ["trial", "speed_cm_s", "time_s", "hs", "hs_spikes"]
NOT_OF_LOGS = {"seed", "provenance", "wall_s"}


def colias(*arguments) -> int:
    return main.command([str(argument) for argument in arguments])


def written(path, speeds=(20, 30, 20, 30), lines=None, rate=30.0):
    """A log of crossings whose HS goes up and down, and whose spikes rise with the speed. These numbers are made up."""
    rows = [
        [trial, speed, (i + 1) / rate, math.sin(math.pi * i / FRAMES) * 0.9, int(i < speed - trial)]
        for trial, speed in enumerate(speeds) for i in range(FRAMES)
    ]  # fmt: skip
    table = [HEAD, *rows]
    for line, cells in (lines or {}).items():
        table[line - 1] = cells
    with path.open("w", newline="", errors="surrogateescape") as file:
        csv.writer(file).writerows(table)
    return path


def imported(log, out, *options):
    """The run of a log."""
    assert colias("import", log, "--out", out, *SPEEDS, "--quiet", *options) == 0
    return experiments.load(out)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Two crossings with their recordings, under a parameter that is not at its default."""
    folder = tmp_path_factory.mktemp("simulated") / "speed"
    settings = {"experiment.speeds_cm_s": [20, 30], "dsnn.n_con": 6}
    return experiments.run("speed", settings=settings, repeats=1, quiet=True, workers=0, out=folder)


def test_a_simulated_run_comes_back_equal(simulated, tmp_path):
    """Spikes, HS to the last bit, measures in view and statistics: where it comes from is all that differs."""
    assert colias("firmware", "log", simulated.folder, "--out", tmp_path / "robot") == 0
    frames = tmp_path / "robot" / "frames"
    back = imported(tmp_path / "robot" / "log.csv", tmp_path / "back", "--frames", frames, "--set", "dsnn.n_con=6")
    assert "dsnn.n_con" in back.trials.columns
    lost = {*UNKNOWN} - {"closest_cm", "seconds_in_view"}
    assert all(back.trials[name].null_count() == back.trials.height for name in lost)
    same = [name for name in simulated.trials.columns if name not in lost | NOT_OF_LOGS]
    assert back.trials.select(same).equals(simulated.trials.select(same))
    bearing = "stimulus_bearing_deg"
    assert back.frames.drop(bearing).equals(simulated.frames.drop(bearing))
    np.testing.assert_allclose(back.frames[bearing], simulated.frames[bearing], atol=1e-9)
    assert set(back.trials["provenance"]) == {"log of a simulated run"} == {back.provenance}


def test_a_log_of_both_eyes_has_the_robot_s_one_eye(tmp_path):
    settings = {"experiment.speeds_cm_s": [30], "experiment.direction": "rightward"}
    run = experiments.run("speed", settings=settings, repeats=1, eyes="both", quiet=True, workers=0, out=tmp_path / "a")
    assert colias("firmware", "log", run.folder, "--out", tmp_path / "robot") == 0
    assert set(pl.read_csv(tmp_path / "robot" / "log.csv")["model"]) == {"dsnn"} < set(run.models)


def test_frames_of_a_camera_alone_are_shown_to_a_model(simulated, tmp_path):
    """What the network made of the frames in the simulation it makes of them again."""
    assert colias("firmware", "log", simulated.folder, "--out", tmp_path / "robot") == 0
    frames, log = tmp_path / "robot" / "frames", tmp_path / "camera.csv"
    whole = pl.read_csv(tmp_path / "robot" / "log.csv")
    whole.select("trial", "speed_cm_s", "time_s").write_csv(log)
    options = "--frames", frames, "--model", "dsnn", "--set", "dsnn.n_con=6"
    run = imported(log, tmp_path / "camera", *options)
    assert run.frames["hs", "hs_spikes"].equals(simulated.frames["hs", "hs_spikes"])
    assert run.provenance == "frames measured, network simulated"
    both = imported(tmp_path / "robot" / "log.csv", tmp_path / "both", *options)
    assert both.models == ["dsnn", "dsnn@frames"]
    assert both.trials.filter(model="dsnn")["spikes"].equals(both.trials.filter(model="dsnn@frames")["spikes"])
    (frames / "trial-0001" / "000003.pgm").unlink()
    with pytest.raises(UsageError, match=r"trial-0001 must have \d+ pictures"):
        imported(log, tmp_path / "none", *options)
    begin = whole.filter(pl.col("trial") < 1).height
    whole.filter(pl.int_range(pl.len()) != begin + 3).write_csv(log)  # its line of the log goes with it
    assert imported(log, tmp_path / "shorter", *options).frames.height == 2 * (whole.height - 1)


def test_pictures_are_in_the_order_of_their_numbers(tmp_path):
    for name in ("10.png", "2.PNG", "1.pgm", "notes.txt"):
        (tmp_path / name).touch()
    assert [path.name for path in pictures_in(tmp_path)] == ["1.pgm", "2.PNG", "10.png"]


WRONG = {
    "an unknown column": ({1: [*HEAD[:3], "HS", "hs_spikes"]}, 1, "HS"),
    "a missing column": ({1: [*HEAD[:4], "azimuth"]}, 1, "hs_spikes"),
    "a part of a tracker's": ({1: [*HEAD[:3], "azimuth", "observer_x_cm"]}, 1, "stimulus_x_cm"),
    "no such condition": ({line: [0, 25, line / 30, 0.1, 0] for line in range(2, 2 + FRAMES)}, 2, "speed_cm_s=25"),
    "another condition": ({2: [0, 25, 1 / 30, 0.1, 0]}, 3, "trial 0"),
    "a time that stands": ({3: [0, 20, 1 / 30, 0.1, 0]}, 3, "0.0333"),
    "not a number": ({4: [0, 20, 0.1, "nan", 0]}, 4, "hs"),
    "bytes of a disturbed link": ({4: [0, 20, "0.\udcfe", 0.1, 0]}, 4, "time_s"),
    "half a spike": ({4: [0, 20, 0.1, 0.1, 0.5]}, 4, "hs_spikes"),
    "a potential out of range": ({4: [0, 20, 0.1, 1.5, 0]}, 4, "1.5"),
    "a blank time": ({4: [0, 20, "", 0.1, 0]}, 4, "time_s"),
    "a model that is not there": ({1: ["trial", "model", *HEAD[2:]]}, 2, "'20'"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_is_named_by_its_line_and_nothing_is_written(what, tmp_path):
    lines, number, cell = WRONG[what]
    log = written(tmp_path / "log.csv", lines=lines)
    with pytest.raises(UsageError) as refused:
        imported(log, tmp_path / "run")
    assert str(refused.value).startswith(f"{log}, line {number}: ") and cell in str(refused.value)
    assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


def test_a_log_knows_its_own_rate_and_its_unit_of_time(tmp_path):
    """At 25 frames/s firing rates go by the log's times; milliseconds are not taken for seconds."""
    rows = imported(written(tmp_path / "log.csv", rate=25.0), tmp_path / "run").trials.to_dicts()
    assert all(row["firing_rate_hz"] == pytest.approx(row["spikes"] / (FRAMES / 25)) for row in rows)
    with pytest.raises(UsageError, match="time_s must be in seconds"):
        imported(written(tmp_path / "log.csv", rate=0.03), tmp_path / "other")


def test_rows_that_were_removed_are_noticed(tmp_path):
    """Each inside a trial is; a whole log is not, whatever its rate, nor one whose time stamps come late."""
    whole = pl.read_csv(written(tmp_path / "log.csv", rate=25.0))
    late = whole.with_columns(pl.col("time_s") + pl.when(pl.int_range(pl.len()) % 10 == 3).then(0.03).otherwise(0.0))
    inside = pl.int_range(pl.len()).is_in([5, 9, 10, 11, 2 * FRAMES + 7])
    for name, log, number in (("whole", whole, 0), ("late", late, 0), ("shorter", whole.filter(~inside), 5)):
        log.write_csv(tmp_path / f"{name}.csv")
        run = imported(tmp_path / f"{name}.csv", tmp_path / name)
        assert run.description["measured"]["lacking_frames"] == number


@pytest.mark.parametrize("rate", [25.0, 30.0, 60.0])
@pytest.mark.parametrize("tick", [1e-6, 0.001, 0.005, 0.01, 0.015625, 0.02, 0.025])
def test_no_tick_of_a_clock_moves_a_rate_or_hides_a_lost_frame(rate, tick):
    """The camera's rate is known; of another rate up to half a frame's time."""
    if tick * rate > 0.95:
        return
    rng = np.random.default_rng(0)
    for lost in (0, 1, 5):
        kept = np.delete(np.arange(150), rng.permutation(np.arange(1, 149))[:lost])
        times = np.floor((kept + 0.3) / rate / tick) * tick
        for nominal in (rate, 40.0) if tick * rate < 0.5 else (rate,):
            measured, steps = rate_and_steps(times, nominal)
            assert measured == pytest.approx(rate, rel=0.01) and steps.sum() - len(steps) == lost


def test_a_log_by_a_clock_of_10_ms_has_the_rates_of_the_exact_one(tmp_path):
    exact, ticks = (imported(CASES / f"{name}.csv", tmp_path / name).trials for name in ("exact", "tick-10ms"))
    assert ticks["spikes"].equals(exact["spikes"])
    for name in ("firing_rate_hz", "seconds_in_view", "rate_in_view_hz"):
        np.testing.assert_allclose(ticks[name], exact[name], rtol=0.01)


def test_spikes_that_are_no_signed_counts_of_frames_are_refused(tmp_path):
    """Of a byte, without sign, and summed up, signed or not; the log itself is read."""
    left, spikes = pl.read_csv(CASES / "left.csv"), pl.col("hs_spikes")
    assert read(CASES / "left.csv")["hs_spikes"].abs().sum() == 38
    with pytest.raises(UsageError, match=r"u8\.csv, line 15: .*-0\.22775 .*255"):
        read(CASES / "u8.csv")
    right = left.with_columns(-pl.col("hs", "hs_spikes"))
    for log in (left.with_columns(spikes.abs()), *(one.with_columns(spikes.cum_sum()) for one in (left, right)),
                *(one.with_columns(spikes.cum_sum().over("trial")) for one in (left, right))):  # fmt: skip
        log.write_csv(tmp_path / "log.csv")
        with pytest.raises(UsageError, match=r"log\.csv, line \d+: .*hs_spikes"):
            read(tmp_path / "log.csv")


def test_tables_of_other_programs_are_read_or_named(tmp_path):
    """UTF-16 and blank rows are read; a sentence names another mark between cells, a workbook and decimal commas."""
    text, path = (CASES / "left.csv").read_text(), tmp_path / "log.csv"
    first, *rows = text.splitlines()
    blank = "\r\n".join([first, *rows[:5], "", ",,,,", " , ,,,", *rows[5:], "", ""])
    for data in (text.encode("utf-16"), b"\xfe\xff" + text.encode("utf-16-be"), blank.encode()):
        path.write_bytes(data)
        assert read(path).drop("line").equals(read(CASES / "left.csv").drop("line"))
    path.write_bytes(blank.replace(rows[20], "0,20,x,0,0").encode())
    with pytest.raises(UsageError, match="line 25: time_s"):
        read(path)
    others = [text.replace(",", mark) for mark in ";\t|"]
    wrong = [(CASES / "semicolon.csv").read_bytes(), b"PK\x03\x04\x14", b"sep=,\n1,2,3", others[1].encode("utf-16")]
    for data in (*wrong, *map(str.encode, others)):
        path.write_bytes(data)
        with pytest.raises(UsageError, match=r"log\.csv must have commas .* decimal points: save it as"):
            read(path)


def test_time_in_view_goes_by_the_log_s_own_times(simulated, tmp_path):
    assert colias("firmware", "log", simulated.folder, "--out", tmp_path / "robot") == 0
    log = pl.read_csv(tmp_path / "robot" / "log.csv").with_columns(pl.col("time_s") * 2)
    log.write_csv(tmp_path / "slow.csv")
    slow = imported(tmp_path / "slow.csv", tmp_path / "slow")
    np.testing.assert_allclose(slow.trials["seconds_in_view"], 2 * simulated.trials["seconds_in_view"])
    np.testing.assert_allclose(slow.trials["rate_in_view_hz"], simulated.trials["rate_in_view_hz"] / 2)


def test_what_nobody_knows_is_null_and_the_run_says_that_it_is_measured(tmp_path):
    """HS alone, no tracker, and conditions of unequal numbers of trials."""
    run = imported(written(tmp_path / "log.csv", speeds=(20, 30, 20)), tmp_path / "run")
    assert {"measured"} == {run.provenance} == set(run.trials["provenance"]) == set(run.claims["provenance"])
    unknown = ("peak_vs", "vs_spikes", "seed", "spikes_in_view", "mean_hs_near_axis", *UNKNOWN)
    assert all(run.trials[name].null_count() == 3 for name in unknown)
    assert all(run.frames[name].null_count() == run.frames.height for name in ("vs", "vs_spikes", *POSES))
    assert run.trials["repeat"].to_list() == [0, 0, 1], "of each condition"
    assert run.trials["spikes"].to_list() == [20, 29, 18] and not run.frames["hs"].null_count()
    entities = columns(run.recordings[0]).keys()
    assert "/models/dsnn/hs" in entities and "/models/dsnn/vs" not in entities


def test_claims_are_judged_by_the_same_bounds(tmp_path):
    """Made-up spikes of 4 trials of each speed: one model has most at 6 cm/s (C15), the other no more than at 4."""
    spikes_by_model = {"dsnn": (3, 9, 20, 12), "dsn2017": (3, 9, 9, 12)}
    rows = [
        [trial, model, (2, 4, 6, 10)[trial % 4], (i + 1) / 30, 0.5, int(i < spikes[trial % 4])]
        for trial in range(16) for model, spikes in spikes_by_model.items() for i in range(FRAMES)
    ]  # fmt: skip
    with (tmp_path / "log.csv").open("w", newline="") as file:
        csv.writer(file).writerows([["trial", "model", *HEAD[1:]], *rows])
    assert colias("import", tmp_path / "log.csv", "--out", tmp_path / "run", "--quiet") == 0
    run = experiments.load(tmp_path / "run")
    claims = {(row["id"], row["model"]): row["outcome"] for row in run.claims.to_dicts()}
    assert claims["C15", "dsnn"] == "holds" and claims["C15", "dsn2017"] == "fails"
    assert claims["C29", "dsnn"] == "not shown"  # which takes a tracker
    assert "Wilcoxon" in (run.folder / "comparisons.csv").read_text()  # both models saw the same trials

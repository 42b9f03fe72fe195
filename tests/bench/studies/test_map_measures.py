"""Maps of measured numbers, and maps of clips."""

from __future__ import annotations

import csv
import dataclasses

import numpy as np
import polars as pl
import pytest

from dsnn import DSNN
from dsnn.stimuli import stimulus
from experiments.bench.cli import main
from experiments.bench.run.models import choose
from experiments.bench.studies import figure
from experiments.bench.studies.counts import Counts, reaches
from experiments.bench.studies.measures import MEASURES
from tests.bench.studies.test_map import planned

RENDERED = True

POTENTIAL, COUNT, PEAK = (MEASURES[name] for name in ("peak-speed-potential", "peak-speed-count", "peak-hs"))


def table(folder):
    with (folder / "counts.csv").open() as file:
        return list(csv.DictReader(file))


# --- a measure against tables made by hand ----------------------------------------------------------------------------


def crossings(potentials, counts, repeats=2):
    """Rows of rightward crossings: speed -> the mean of its trials."""
    spread = np.linspace(-0.01, 0.01, repeats)
    return [
        {
            "motion": "translation", "direction": "rightward", "speed_cm_s": speed, "achieved_speed_cm_s": speed,
            "path_error_mm": 0.0, "trial": 100 * place + repeat, "spikes": counts[speed] + repeat,
            "mean_hs_near_axis": potentials[speed] + spread[repeat],
        }
        for place, speed in enumerate(potentials)
        for repeat in range(repeats)
    ]  # fmt: skip


SPEEDS = (2.0, 6.0, 15.0, 30.0)


def rows_of(potentials, counts=(0, 0, 0, 0)):
    return crossings(*(dict(zip(SPEEDS, values, strict=True)) for values in (potentials, counts)))


@pytest.mark.parametrize(
    ("potentials", "value", "mark"),
    [
        ((0.1, 0.5, 0.8, 0.7), 15.0, ""),
        ((0.1, 0.5, 0.7, 0.8), 30.0, "at the end of the range"),
        ((0.9, 0.5, 0.8, 0.7), 2.0, "at the end of the range"),
        ((0.1, 0.8, 0.8, 0.7), 6.0, ""),  # of equal ones the lowest speed
    ],
)
def test_the_peak_of_the_potential_is_where_its_mean_is_largest(potentials, value, mark):
    peak = POTENTIAL.of(rows_of(potentials), 0.2)
    assert (peak.value, peak.mark) == (value, mark)
    assert POTENTIAL.of(rows_of(potentials)[::-1], 0.2) == peak  # in any order of the rows


def test_the_count_has_a_peak_of_its_own():
    rows = rows_of((0.1, 0.5, 0.8, 0.7), (0, 60, 30, 15))
    assert COUNT.of(rows, 0.2).value == 6.0
    one = max(rows, key=lambda row: row["spikes"])  # a single trial with many spikes is not the mean
    assert COUNT.of([*rows, {**one, "speed_cm_s": 2.0, "achieved_speed_cm_s": 2.0, "trial": 999}], 0.2).value == 6.0


def test_what_has_no_peak_has_no_value():
    assert COUNT.of([{**row, "spikes": 0} for row in rows_of((0.1, 0.5, 0.8, 0.7))], 0.2).value is None
    assert POTENTIAL.of(rows_of((-0.1, -0.5, -0.8, -0.7)), 0.2).value is None
    off = [{**row, "achieved_speed_cm_s": 1.5 * row["speed_cm_s"]} for row in rows_of((0.1, 0.5, 0.8, 0.7))]
    peak = POTENTIAL.of(off, 0.2)
    assert peak.value is None and "off the commanded speed" in peak.words
    leftward = [{**row, "direction": "leftward"} for row in rows_of((0.1, 0.5, 0.8, 0.7))]
    assert POTENTIAL.of(leftward, 0.2).value is None


def test_c30_and_the_measure_have_one_peak():
    from experiments.bench.sources.conditions import Condition
    from experiments.bench.sources.robot_claims import find

    speeds, rng = (2.0, 4.0, 6.0, 10.0, 15.0, 30.0), np.random.default_rng(0)
    rows = [
        {
            **dataclasses.asdict(Condition("translation", "rightward", speed, 8.0)), "achieved_speed_cm_s": speed,
            "path_error_mm": 0.0, "model": model, "trial": trial, "mean_hs_near_axis": float(rng.random()), "spikes": 1,
        }
        for model in sorted(find("C30").models)
        for trial, speed in enumerate(speeds)
    ]  # fmt: skip
    measured = find("C30").judge(rows, 0.2).measured
    for name, model in {"d = 1, N_con = 8": "dsnn", "d = 2": "dsnn:d=2", "N_con = 1": "dsnn:n_con=1"}.items():
        peak_speed = POTENTIAL.of([row for row in rows if row["model"] == model], 0.2).value
        assert f"{name}: largest at {peak_speed:g} cm/s" in measured


def test_a_crossing_that_stays_below_the_threshold_is_marked():
    row = {"motion": "rightward", "object": "present", "clip": "a", "seed": 0, "trough_hs": 0.0, "peak_vs": 0.0,
           "trough_vs": 0.0}  # fmt: skip
    rows = [{**row, "peak_hs": 0.3}, {**row, "clip": "b", "peak_hs": 0.2}]
    assert (PEAK.of(rows, 0.16).value, PEAK.of(rows, 0.16).mark) == (0.2, "")
    assert PEAK.of(rows, 0.2).mark == "below T"  # past it, not on it
    alone = {**row, "object": "absent", "peak_hs": 0.01}
    assert PEAK.of([*rows, alone], 0.16).value == 0.2


def test_numbers_are_of_all_replicates_with_the_spread_of_each():
    map_plan = planned(["ensembles"], "dsnn.d=1,2", measures=["peak-speed-potential"], replicates=2, repeats=5)
    flat = {"path_error_mm": 0.0, "spikes": 1}

    def potential(spec, label):
        best = {"dsnn.d=1": (6.0, 10.0), "dsnn.d=2": (30.0, 30.0)}[label][spec.repeat // 5]
        return 1.0 - abs(spec.condition.speed_cm_s - best) / (40.0 if spec.repeat < 5 else 400.0)

    rows = [
        {
            **dataclasses.asdict(spec.condition), **flat, "achieved_speed_cm_s": spec.condition.speed_cm_s,
            "trial": spec.index, "experiment": spec.experiment, "model": model.label,
            "mean_hs_near_axis": potential(spec, model.label),
        }
        for spec in map_plan.specs
        for model in spec.settings.models
    ]  # fmt: skip
    one, two = Counts(map_plan, rows).numbers
    assert (one.value, one.lowest, one.highest, one.mark) == (6.0, 6.0, 10.0, "")  # the first replicate's is steeper
    assert (two.value, two.lowest, two.highest, two.mark) == (30.0, 30.0, 30.0, "at the end of the range")
    assert reaches([one, two]) == ["peak-speed-potential is 6 to 30 cm/s; at the end of the range at 1 of 2 points"]
    lost = [row for row in rows if (row["trial"], row["model"]) != (map_plan.specs[-1].index, "dsnn.d=1")]
    one, two = Counts(map_plan, lost).numbers
    assert (one.unmeasured, one.lowest, one.highest) == (1, 6.0, 6.0) and "1 of 50 trials have no rows" in one.words
    assert two.unmeasured == 0
    figure.draw(Counts(map_plan, lost))


# --- maps of clips ----------------------------------------------------------------------------------------------------

SMALL = {"rows": 60, "columns": 80, "width": 14.0, "height": 40.0, "speed": 60.0, "rest_s": 0.2}
FILE = f"""
from experiments import Check, Clip, ClipClaim, Experiment, OfflineExperiment, Outcome, decide


def judge(clips, threshold):
    peak = clips["peak_hs"].min()
    holds, decided = decide([Check(f"{{peak}}", peak, threshold)])
    return Outcome("holds" if holds else "fails", decided, decided=decided)


CLAIM = ClipClaim(id="passes", says="it passes T", judge=judge, models=frozenset({{"dsnn", "dsn2017"}}))
EXPERIMENT = OfflineExperiment(
    "crossing", "dark and light before leaves",
    [Clip(name, "cluttered", {{**{SMALL!r}, "grey": grey}}) for name, grey in (("dark", 0.0), ("light", 255.0))],
    ("dsnn", "dsn2017"), claims=(CLAIM,),
)
"""
OVER = ("--over", "cluttered.grey=0,120", "--over", "cluttered.start=10,700")
BOTH = ("--claims", "passes", "--measure", "peak-hs", "-q")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A map of two greys at two places, made by two workers."""
    folder = tmp_path_factory.mktemp("clips")
    (folder / "crossing.py").write_text(FILE)
    arguments = ["map", str(folder / "crossing.py"), *OVER, *BOTH]
    assert main.command([*arguments, "--workers", "2", "--out", str(folder / "out")]) == 0
    return folder / "out", arguments


def test_a_map_of_clips_has_the_network_s_own_answers(whole):
    folder, _ = whole
    network = choose("dsnn", "offline").network
    by_point = {
        kind: {(float(row["cluttered.grey"]), float(row["cluttered.start"])): row for row in table(folder) if row[kind]}
        for kind in ("claim", "measure")
    }
    measure_rows = by_point["measure"]
    assert len(measure_rows) == 4
    for (grey, start), row in measure_rows.items():
        clip = stimulus("cluttered", 5, grey=grey, start=start, **SMALL)  # whatever the seed
        model = DSNN(clip.shape, network)
        peak = max(model.step(frame.luma).hs for frame in clip)
        assert float(row["value"]) == pytest.approx(peak, abs=1e-6)
        assert (row["mark"] == "below T") == (peak <= network.t_sp)
        claim = by_point["claim"][grey, start]
        assert claim["holds"] == str(int(peak > network.t_sp)), (
            "the claim's rows are both models', under their own names"
        )
    assert len({row["value"] for row in measure_rows.values()}) == 4
    rows = pl.read_parquet(folder / "trials.parquet").to_dicts()
    assert len({row["trial"] for row in rows}) == 4, "dark and light become one clip where the axis sets their grey"
    assert len(rows) == 8 and (folder / "map.png").read_bytes()[:4] == b"\x89PNG"


def test_a_map_of_clips_is_the_same_without_workers_and_goes_on(whole, tmp_path):
    folder, arguments = whole
    assert main.command([*arguments, "--workers", "0", "--out", str(tmp_path / "again")]) == 0
    assert (tmp_path / "again" / "counts.csv").read_bytes() == (folder / "counts.csv").read_bytes()
    rows, cut = pl.read_parquet(folder / "trials.parquet"), tmp_path / "cut"
    cut.mkdir()
    (cut / "run.json").write_bytes((folder / "run.json").read_bytes())
    rows.slice(0, 2).write_parquet(cut / "trials.parquet")  # a clip of two models
    pl.read_parquet(folder / "frames.parquet").write_parquet(cut / "frames.parquet")
    assert main.command([*arguments, "--workers", "0", "--out", str(cut)]) == 0
    assert (cut / "counts.csv").read_bytes() == (folder / "counts.csv").read_bytes()
    assert pl.read_parquet(cut / "trials.parquet").drop(["wall_s"]).equals(rows.drop(["wall_s"]))


def test_points_of_the_network_share_their_clips(whole):
    file = whole[1][1]
    map_plan = planned([file], "dsnn.n_con=4,8", "cluttered.start=0,540", claims=["passes"], replicates=2, seed=3)
    assert len(map_plan.specs) == 2 * 2 * 2  # two clips at two places, twice
    assert {(spec.repeat, spec.seed) for spec in map_plan.specs} == {(0, 3), (1, 4)}
    for spec in map_plan.specs:
        assert len(spec.models) == 3  # two networks, and the 2017 model, which is not moved, once
        assert sorted(model.network.n_con for model in spec.models if model.source == "dsnn") == [4, 8]
    share = map_plan.shares[map_plan.points[0], "dsnn", "crossing", 0]
    assert [watcher.name for watcher in share.watchers] == ["dsnn", "dsn2017"]


def test_the_paper_s_claim_is_judged_at_each_grey_and_place():
    over = ("cluttered.grey=0,255", "cluttered.start=0,270,540")
    map_plan = planned(["clutter-translation"], *over, claims=["C6"], measures=["peak-hs"])
    assert len(map_plan.specs) == 6 and all(len(spec.models) == 2 for spec in map_plan.specs)
    assert {dict(spec.condition.changes)["start"] for spec in map_plan.specs} == {0.0, 270.0, 540.0}
    grey, start = map_plan.axes
    assert (grey.default, start.default, start.unit) == (None, None, "px")


# --- a robot's crossings ----------------------------------------------------------------------------------------------


def test_a_robot_s_peak_speed_is_that_of_its_trials(tmp_path):
    arguments = ["map", "ensembles", "--over", "dsnn.n_con=1,8", "--set", "experiment.speeds_cm_s=6,10,20", "-q"]
    measures = ["--measure", "peak-speed-count,peak-speed-potential", "--repeats", "1", "--workers", "0"]
    assert main.command([*arguments, *measures, "--out", str(tmp_path / "out")]) == 0
    rows = pl.read_parquet(tmp_path / "out" / "trials.parquet").to_dicts()
    assert len({row["trial"] for row in rows}) == 3
    for measure_row in table(tmp_path / "out"):
        point_rows = [row for row in rows if row["dsnn.n_con"] == float(measure_row["dsnn.n_con"])]
        column = {"peak-speed-count": "spikes", "peak-speed-potential": "mean_hs_near_axis"}[measure_row["measure"]]
        best = max(point_rows, key=lambda row: row[column])
        assert measure_row["value"] == (str(best["speed_cm_s"]) if best[column] > 0 else "")
    assert any(row["value"] for row in table(tmp_path / "out"))


# --- wrong uses -------------------------------------------------------------------------------------------------------

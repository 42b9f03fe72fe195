"""Maps: claims over a grid of whole replicates."""

from __future__ import annotations

import csv
import dataclasses
import json
from itertools import product

import numpy as np
import polars as pl
import pytest
import typer

import experiments
from experiments.bench import registry
from experiments.bench.cli import main
from experiments.bench.run.errors import UsageError
from experiments.bench.sources.judging import DEPTH
from experiments.bench.stats.checks import MARGIN
from experiments.bench.stats.count import REASONS
from experiments.bench.studies import figure, run
from experiments.bench.studies.counts import TOGETHER, Counts, regions
from experiments.bench.studies.study import Axis, Level, Study
from tests.helpers.chapters import CHAPTERS, blocks

BOTH = ("general", "angular-recession")
FEW = ("--repeats", "5", "--workers", "0", "-q")


def planned(names, *over, seed=0, **more):
    study = {"repeats": None, "replicates": 1, "every_trial": False, **more}
    return run.planned(Study("map", "a map", experiments=tuple(names), over=over, **study), seed)


def cells(map_plan, rows):
    return Counts(map_plan, rows).cells


def table(folder):
    with (folder / "counts.csv").open() as file:
        return list(csv.DictReader(file))


def trials(folder):
    return pl.read_parquet(folder / "trials.parquet").to_dicts()


# --- as a user runs it ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A map of two claims, judged on two experiments, over a threshold that few and that all potentials pass."""
    from tests.conftest import Colias

    colias = Colias(tmp_path_factory.mktemp("map"))
    arguments = ("map", ",".join(BOTH), "--over", "dsnn.t_sp=0.2,0.01", "--claims", "C13,C19", "--repeats", "5")
    done = colias(*arguments, "--out", "out")
    assert done.returncode == 0, done.stderr
    return colias.folder / "out", done.stdout


def test_a_maps_summary_is_its_table(whole):
    """The kind of a map named a table that no map leaves."""
    folder, _ = whole
    assert [row["claim"] for row in experiments.load(folder).summary.to_dicts()] == [
        row["claim"] for row in table(folder)
    ]


def test_counts_are_those_of_judging_by_hand(whole):
    folder, _ = whole
    rows, map_rows = trials(folder), table(folder)
    assert [(row["dsnn.t_sp"], row["claim"]) for row in map_rows] == list(
        product(["0.01", "0.2"], ["C13", "C19", TOGETHER])
    )
    for level in (0.2, 0.01):
        held = {row["claim"]: row["holds"] for row in map_rows if float(row["dsnn.t_sp"]) == level}
        level_rows = [row for row in rows if row["dsnn.t_sp"] == level]
        straight = [row["spikes"] for row in level_rows if row["motion"] in DEPTH and row["angle_deg"] == 0.0]
        assert len(straight) == 15, "of both experiments"
        mean = {
            angle: np.mean(
                [r["spikes"] for r in level_rows if r["experiment"] == "angular-recession" and r["angle_deg"] == angle]
            )
            for angle in (-30.0, -15.0, 0.0, 15.0, 30.0)
        }
        silent = not any(straight)
        more = MARGIN["spikes"]
        fewest = mean[0.0] + more <= min(v for a, v in mean.items() if a)
        wider = mean[-30.0] >= mean[-15.0] + more and mean[30.0] >= mean[15.0] + more
        by_hand = {"C13": silent, "C19": fewest and wider, TOGETHER: silent and fewest and wider}
        assert held == {claim: str(int(holds)) for claim, holds in by_hand.items()}
    assert {row["holds"] for row in map_rows} == {"0", "1"}  # the thresholds tell the points apart


def test_the_deciding_number_is_that_of_the_trials(whole):
    folder, _ = whole
    rows = [r for r in trials(folder) if r["angle_deg"] == 0.0 and r["dsnn.t_sp"] == 0.01]
    straight = {kind: [r["spikes"] > 0 for r in rows if r["motion"] == kind] for kind in DEPTH}
    (row,) = [r for r in table(folder) if r["claim"] == "C13" and r["dsnn.t_sp"] == "0.01"]
    texts = [f"{kind}: spikes in {sum(fired)} of {len(fired)} trials" for kind, fired in straight.items()]
    assert any(text in row["decided"] for text in texts)
    assert all(text in row["measured"] for text in texts)


def test_a_map_goes_on_where_it_was_cut_short(whole, tmp_path, monkeypatch):
    folder, _ = whole
    monkeypatch.chdir(tmp_path)
    arguments = ["map", ",".join(BOTH), "--over", "dsnn.t_sp=0.2,0.01", "--claims", "C13,C19", *FEW]
    rows = pl.read_parquet(folder / "trials.parquet")
    cut = tmp_path / "cut"
    cut.mkdir()
    (cut / "run.json").write_bytes((folder / "run.json").read_bytes())
    rows.slice(0, 40).write_parquet(cut / "trials.parquet")  # 20 trials of two rows
    pl.read_parquet(folder / "frames.parquet").write_parquet(cut / "frames.parquet")
    with pytest.raises(UsageError, match=r"--over dsnn\.t_sp is 0\.01, 0\.2 there and 0\.02, 0\.2 now"):
        main.command([*arguments[:3], "dsnn.t_sp=0.2,0.02", *arguments[4:], "--out", "cut"])
    assert main.command([*arguments, "--out", "cut"]) == 0
    assert (cut / "counts.csv").read_bytes() == (folder / "counts.csv").read_bytes()
    aside = ["wall_s"]
    assert pl.read_parquet(cut / "trials.parquet").drop(aside).equals(rows.drop(aside))


def test_points_of_the_network_have_the_rows_of_separate_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    over = ["--over", "dsnn.n_con=4,8", "--over", "dsnn.tau_s.first=10,100"]
    arguments = ["map", "general", *over, "--claims", "C14", "--replicates", "2", "--out", "map", *FEW]
    assert main.command(arguments) == 0
    rows = trials(tmp_path / "map")
    assert len({row["trial"] for row in rows}) == 20 and len(rows) == 20 * 4  # four points share each rendering
    columns = ("motion", "direction", "spikes", "vs_spikes", "peak_hs", "trough_hs", "peak_vs", "frames")
    for replicate, seed in enumerate((0, 1)):
        alone = ["--set", "dsnn.n_con=4", "--set", "dsnn.tau_s=100,200", "--no-recordings", "--seed", str(seed)]
        assert main.command(["run", "general", *alone, "--out", f"alone{seed}", *FEW]) == 0
        by_seed = {row["seed"]: row for row in trials(tmp_path / f"alone{seed}")}
        point_rows = [
            r for r in rows if (r["dsnn.n_con"], r["dsnn.tau_s.first"], r["repeat"] // 5) == (4, 100, replicate)
        ]
        assert len(point_rows) == 10
        for row in point_rows:
            assert [row[name] for name in columns] == [by_seed[row["seed"]][name] for name in columns]


# --- counting ---------------------------------------------------------------------------------------------------------


def rows_of(map_plan, spikes):
    """Rows as trials would leave them, where ``spikes`` says of a spec and a label how many there are."""
    flat = {"hs_spikes": 0, "path_error_mm": 0.0}
    return [
        {
            **dataclasses.asdict(spec.condition), **flat, "achieved_speed_cm_s": spec.condition.speed_cm_s,
            "experiment": spec.experiment, "trial": spec.index,
            "model": model.label, "spikes": count, "peak_hs": 0.1 + (count > 0) * 0.4 * _sign(spec),
            "trough_hs": -0.1 + (count > 0) * 0.4 * min(_sign(spec), 0),
        }
        for spec in map_plan.specs
        for model in spec.settings.models
        for count in [spikes(spec, model.label)]
    ]  # fmt: skip


def _sign(spec):
    return {"rightward": 1, "leftward": -1, "straight": 1}[spec.condition.direction]


def test_all_together_is_counted_by_replicate():
    """A claim that breaks in the first replicate and another that breaks in the second leave none that is whole."""
    map_plan = planned(["general"], "dsnn.t_sp=0.2,0.3", claims=("C13", "C14"), replicates=2, repeats=5)

    def spikes(spec, label):
        replicate, depth = spec.repeat // 5, spec.condition.motion != "translation"
        if label == "dsnn.t_sp=0.3":
            return int(not depth)  # as the paper has it
        return 1 if replicate == 0 else int(spec.condition.direction == "rightward")  # in depth too; then none leftward

    map_cells = cells(map_plan, rows_of(map_plan, spikes))
    counts = {(cell.point.values[0][1], cell.claim): cell.count.holds for cell in map_cells}
    assert counts[("0.2", "C13")] == 1
    assert counts[("0.2", "C14")] == 1
    assert counts[("0.2", TOGETHER)] == 0
    assert counts[("0.3", "C13")] == counts[("0.3", "C14")] == counts[("0.3", TOGETHER)] == 2
    lines = regions(map_cells)
    assert "C13 holds in 2 of 2 replicates at 1 of 2 points (50%)" in lines
    assert "all claims together hold in 2 of 2 replicates at 1 of 2 points (50%)" in lines


def test_silence_everywhere_does_not_count_as_holding():
    map_plan = planned(["general"], "dsnn.t_sp=0.2,0.3", claims=("C13", "C14"), repeats=5)
    map_cells = {
        (cell.point.values[0][1], cell.claim): cell for cell in cells(map_plan, rows_of(map_plan, lambda *_: 0))
    }
    c13 = map_cells["0.2", "C13"]
    assert (c13.count.holds, dict(c13.count.unjudged)) == (0, {"silent model": 1})
    assert map_cells["0.2", TOGETHER].count.fails == 1, "C14 fails"
    lines = [line for line in regions(list(map_cells.values())) if line.startswith("C13 holds")]
    assert lines[0].endswith("; kept by a silent model in a replicate at 2")


def test_lost_trials_leave_a_claim_unjudged():
    map_plan = planned(["general"], "dsnn.t_sp=0.2,0.3", claims=("C13",), replicates=2)
    rows = [row for row in rows_of(map_plan, lambda *_: 0) if (row["trial"], row["model"]) != (3, "dsnn.t_sp=0.3")]
    map_cells = {cell.point.values[0][1]: cell for cell in cells(map_plan, rows)}
    assert (map_cells["0.2"].count.holds, map_cells["0.2"].unjudged) == (2, ())
    assert (map_cells["0.3"].count.holds, map_cells["0.3"].unjudged) == (1, ("not shown",))
    assert not map_cells["0.3"].holds and "1 trials of general failed" in map_cells["0.3"].outcomes[0].measured
    (legend,) = figure.draw(Counts(map_plan, rows)).legends
    keys = [text.get_text() for text in legend.get_texts()]
    assert f"some replicate could not be judged: {REASONS['not shown']}" in keys


# --- the plan ---------------------------------------------------------------------------------------------------------


def test_a_replicate_has_the_trials_of_a_run_with_its_seed():
    from experiments.bench.trials import plan as robot_plan

    map_plan = planned(["general"], "camera.read_noise=0,0.64", claims=("C13",), replicates=3, seed=4)
    runs = [robot_plan(registry.load("general"), ["dsnn"], (), None, 4 + k).specs() for k in range(3)]
    seeds = [spec.seed for run in runs for _ in range(2) for spec in run if spec.condition.motion != "translation"]
    assert [spec.seed for spec in map_plan.specs] == seeds
    assert [spec.index for spec in map_plan.specs] == list(range(3 * 2 * 20))


def test_an_experiment_that_an_axis_cannot_move_is_run_once():
    map_plan = planned(
        ["general", "distance"], "experiment.acceleration_cm_s2=10,17,50", claims=("C13", "C16"), repeats=5
    )
    counts = {name: sum(spec.experiment == name for spec in map_plan.specs) for name in ("general", "distance")}
    assert counts == {"general": 3 * 2 * 5, "distance": len(registry.load("distance").conditions()) * 5}
    assert len({map_plan.shares[point, "dsnn", "distance", 0] for point in map_plan.points}) == 1
    assert len({map_plan.shares[point, "dsnn", "general", 0] for point in map_plan.points}) == 3


def test_the_order_of_values_changes_nothing():
    one, other = (planned(["general"], f"camera.read_noise={values}", "dsnn.d=2,1") for values in ("0.64,0", "0,0.64"))
    assert dataclasses.replace(one, study=other.study) == other


def test_keys_that_move_together_and_ends_of_pairs():
    together = "experiment.pose_sd_mm+experiment.heading_sd_deg=0,0.5"
    map_plan = planned(["general"], together, "dsnn.tau_s.last=100,300", claims=("C14",))
    spreads = {(spec.settings.pose_sd_mm, spec.settings.heading_sd_deg) for spec in map_plan.specs}
    assert spreads == {(0.0, 0.0), (0.5, 0.5)}
    for spec in map_plan.specs:
        assert [model.network.tau_s for model in spec.settings.models] == [(10.0, 100.0), (10.0, 300.0)]
    spread, delay = map_plan.axes
    assert (spread.default, spread.unit) == (1.0, "mm, degrees")
    assert (delay.default, delay.unit) == (200.0, "ms")


def test_a_claim_is_judged_on_the_first_experiment_that_declares_it():
    judged = {claim.id: name for claim, name in planned(BOTH, "dsnn.d=1,2").claims}
    assert judged == {"C13": "general", "C14": "general", "C19": "angular-recession", "C20": "angular-recession"}
    assert dict((c.id, n) for c, n in planned(BOTH[::-1], "dsnn.d=1,2").claims)["C13"] == "angular-recession"


def documented():
    """The maps of docs/maps.md that its test does not run."""
    (page,) = [page for page in CHAPTERS if page.name == "maps.md"]
    return [words[1:] for block in blocks(page) if block.skipped for words in block.commands()]


@pytest.mark.parametrize("words", documented(), ids=" ".join)
def test_the_documented_maps_can_be_made(words):
    group = typer.main.get_command(main.app)
    name, command, rest = group.resolve_command(group.make_context("colias", list(words)), list(words))
    given = command.make_context(name, rest).params
    asked = {name: (given[option] or "").split(",") for name, option in (("claims", "claims"), ("measures", "measure"))}
    asked = {name: list(filter(None, values)) for name, values in asked.items()}
    more = {"assignments": given["assignments"] or (), "replicates": given["replicates"]}
    map_plan = planned(given["experiment"].split(","), *given["over"], **asked, **more)
    assert len(map_plan.axes) == 2 and [claim.id for claim, _ in map_plan.claims] == asked["claims"]
    assert [measure.name for measure, _ in map_plan.measures] == asked["measures"]
    assert all(figure.place(axis) is not None for axis in map_plan.axes if axis.default is not None)  # it is on the map
    assert map_plan.things == "clips" or all(axis.default is not None for axis in map_plan.axes)


def test_the_page_s_counts_at_the_default_are_those_that_were_measured():
    (page,) = [page for page in CHAPTERS if page.name == "maps.md"]
    claims = json.loads((page.parent / "results.json").read_text())["claims"]
    counts = {claim["id"]: claim["count"] for claim in claims}
    eight = {f"C{number}": counts[f"C{number}"]["holds"] for number in range(13, 21)}
    (of,) = {counts[claim]["holds"] + counts[claim]["fails"] for claim in eight}
    sometimes = {claim: holds for claim, holds in eight.items() if holds < of}
    c13, c17, c19 = sometimes["C13"], sometimes["C17"], sometimes["C19"]
    assert len(sometimes) == 3
    text = page.read_text()
    assert f"C14, C15, C16, C18 and C20 in all {of}, C13 in {c13}, C17 in {c17} and C19 in {c19}" in text
    assert f"at most {min(c13, c17, c19)} of these {of}" in text
    assert f"without C19 in at least {c13 + c17 - of} and at most {min(c13, c17)}" in text
    c6 = counts["C6"]
    (unjudged,) = c6["unjudged"].values()
    replicates = c6["holds"] + c6["fails"] + unjudged
    assert (
        f"C6 holds in {c6['holds']} of {replicates} replicates: it fails in {c6['fails']}, and {unjudged} cannot"
        in text
    )


@pytest.mark.parametrize(
    ("default", "levels", "where"),
    [
        (17.0, "10,17,50", 1.0),
        (17.0, "10,20", 0.7),
        (17.0, "20,50", None),
        (None, "1,2", None),
        ("bright", "dim,bright", 1.0),
        ("bright", "dim,plain", None),
        ("true", "false,true", 1.0),
    ],
)
def test_the_place_of_the_default_is_between_its_neighbours(default, levels, where):
    place = figure.place(Axis("x", tuple(map(Level, levels.split(","))), default))
    assert place == (where if where is None else pytest.approx(where))


OWN = """
from experiments import Check, Claim, Experiment, Outcome, Translation, decide


def judge(rows, threshold):
    most = max(row["spikes"] for row in rows)
    holds, decided = decide([Check(f"{most} spikes", most, 0)])
    return Outcome("holds" if holds else "fails", decided, decided=decided)


CLAIM = Claim(id="fires-NAME", says="it fires", judge=judge)
EXPERIMENT = Experiment("NAME", "crossings", Translation((20,), (6,)), "speed_cm_s", repeats=5, claims=(CLAIM,))
"""


def test_experiments_and_claims_of_a_users_own(tmp_path):
    files = [tmp_path / f"{name}.py" for name in ("alpha", "beta")]
    for file in files:
        file.write_text(OWN.replace("NAME", file.stem))
    map_plan = planned(map(str, files), "dsnn.t_sp=0.1,0.2")
    assert [(claim.id, name) for claim, name in map_plan.claims] == [("fires-alpha", "alpha"), ("fires-beta", "beta")]
    assert {str(file) for file in files} <= map_plan.description["files"].keys()  # going on notices a change of either
    map_cells = cells(
        map_plan, rows_of(map_plan, lambda spec, label: int(spec.experiment == "alpha" or label.endswith("0.1")))
    )
    held = {(cell.point.values[0][1], cell.claim): cell.count.holds for cell in map_cells}
    assert held["0.1", "fires-beta"] == held["0.2", "fires-alpha"] == held["0.1", TOGETHER] == 1
    assert held["0.2", "fires-beta"] == held["0.2", TOGETHER] == 0


# --- wrong uses -------------------------------------------------------------------------------------------------------

OVER = ("--over", "dsnn.n_con=4,8")


def test_a_folder_that_holds_a_map_is_not_written_over(whole, colias):
    folder, _ = whole
    before = (folder / "counts.csv").read_bytes()
    done = colias("map", "general", *OVER, "--claims", "C14", "--out", str(folder))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert (folder / "counts.csv").read_bytes() == before

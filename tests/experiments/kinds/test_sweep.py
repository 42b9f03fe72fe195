"""Sweeps: claims and numbers over a grid, in replicates."""

import dataclasses
import itertools
import json
import math
import re
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import experiments
from dsnn import DSNN
from dsnn.stimuli import stimulus
from experiments import Study
from experiments.base.errors import UsageError
from experiments.cli import main
from experiments.declare.study import TOGETHER
from experiments.draw.sweep import draw, finding
from experiments.judge.sweep import read
from experiments.judge.verdict import Count, count_of
from experiments.kinds import registry, sweep_plan
from experiments.kinds.registry import typed
from experiments.settings.grid import levels_of, points_of
from experiments.settings.models import choose
from tests.experiments.judge.test_replicates import rows_of as answers_of
from tests.helpers.clip_rows import row as clip_row
from tests.helpers.plans import planned as planned_run


def planned(names, *over, seed=0, **more):
    study = {"repeats": None, "replicates": 1, **more}
    return sweep_plan.sweep_of(Study("sweep", "a sweep", experiments=tuple(names), over=over, **study), seed)


# --- counting ---------------------------------------------------------------------------------------------------------


def judged(plan, spikes):
    """A sweep whose rows have the spikes that ``spikes`` says of a trial and a label."""
    sign = {"rightward": 1, "leftward": -1, "straight": 1}
    specs = {spec.index: spec for spec in plan.specs}
    rows = []
    for row in answers_of(plan.specs):
        spec = specs[row["trial"]]
        count, way = spikes(spec, row["model"]), sign[spec.condition.direction]
        high, low = 0.1 + (count > 0) * 0.4 * way, -0.1 + (count > 0) * 0.4 * min(way, 0)
        rows.append(row | {"spikes": count, "hs_spikes": 0, "peak_hs": high, "trough_hs": low})
    return read(plan, rows)


def counts_of(result):
    return {(row["dsnn.t_sp"], row["claim"]): row for row in result.counts.iter_rows(named=True)}


def test_all_together_is_counted_by_replicate():
    """A claim that breaks in the first replicate and another that breaks in the second leave none that is whole."""
    plan = planned(["general"], "dsnn.t_sp=0.2,0.3", claims=("C13", "C14"), seed=7, replicates=2, repeats=5)

    def spikes(spec, label):
        replicate, depth = spec.repeat // 5, spec.condition.motion != "translation"
        if label == "dsnn.t_sp=0.3":
            return int(not depth)  # as the paper has it
        return 1 if replicate == 0 else int(spec.condition.direction == "rightward")  # in depth too; then none leftward

    result = judged(plan, spikes)
    assert set(result.table.select("replicate", "seed").rows()) == {(0, 7), (1, 8)}
    counts = counts_of(result)
    assert [counts[0.2, claim]["holds"] for claim in ("C13", "C14", TOGETHER)] == [1, 1, 0]
    assert [counts[0.3, claim]["holds"] for claim in ("C13", "C14", TOGETHER)] == [2, 2, 2]
    assert counts[0.3, "C13"]["low"] == pytest.approx(0.05**0.5 / 2**0.5, abs=0.01)  # Clopper-Pearson, 2 of 2


def test_silence_does_not_count_as_holding_and_lost_trials_leave_a_claim_unjudged():
    plan = planned(["general"], "dsnn.t_sp=0.2,0.3", claims=("C13", "C14"), repeats=5)
    silent = counts_of(judged(plan, lambda *_: 0))
    assert (silent[0.2, "C13"]["holds"], silent[0.2, "C13"]["silent model"]) == (0, 1)
    assert silent[0.2, TOGETHER]["fails"] == 1, "C14 fails"
    plan = planned(["general"], "dsnn.t_sp=0.2,0.3", claims=("C13",), replicates=2)
    lost = read(plan, [row for row in answers_of(plan.specs) if (row["trial"], row["model"]) != (3, "dsnn.t_sp=0.3")])
    assert [row["not shown"] for row in counts_of(lost).values()] == [0, 1]
    assert draw(lost.described()).axes


def test_numbers_are_of_all_replicates_with_the_spread_of_each():
    plan = planned(["ensembles"], "dsnn.d=1,2", measures=["peak-speed-potential"], replicates=2, repeats=5)

    def potential(spec, label):
        best = {"dsnn.d=1": (6.0, 10.0), "dsnn.d=2": (30.0, 30.0)}[label][spec.repeat // 5]
        return 1.0 - abs(spec.condition.speed_cm_s - best) / (40.0 if spec.repeat < 5 else 400.0)

    specs = {spec.index: spec for spec in plan.specs}
    rows = [row | {"mean_hs_near_axis": potential(specs[row["trial"]], row["model"])} for row in answers_of(plan.specs)]
    one, two = read(plan, rows).numbers.to_dicts()
    names = ("value", "lowest", "highest", "not shown")
    assert [one[name] for name in names] == [6.0, 6.0, 10.0, 0], "the first replicate's peak is steeper"
    assert [two[name] for name in names[:3]] == [30.0, 30.0, 30.0]
    lost = [row for row in rows if (row["trial"], row["model"]) != (plan.specs[-1].index, "dsnn.d=1")]
    one, two = read(plan, lost).numbers.to_dicts()
    assert [one[name] for name in names[1:]] == [6.0, 6.0, 1] and two["not shown"] == 0


def test_a_mean_count_at_a_point_is_that_of_its_condition_in_its_experiment():
    plan = planned(["speed", "distance"], "dsnn.d=1,2", measures=["spikes"], replicates=2, repeats=2)

    def spikes(experiment, speed_cm_s, distance_cm, **_):
        return round(100 * (experiment == "distance") + 10 * speed_cm_s + distance_cm)

    rows = [row | {"spikes": spikes(**row)} for row in answers_of(plan.specs)]
    numbers = read(plan, rows).numbers.to_dicts()
    assert len({number["value"] for number in numbers}) == len(numbers) / 2 > 4, "equal at both points alone"
    for number in numbers:
        assert [number[name] for name in ("value", "lowest", "highest")] == [spikes(**number)] * 3 and number["n"] == 4


@pytest.mark.parametrize("kind", ["ranges", "means", "map", "named"])
def test_a_figure_has_the_table_s_numbers_at_the_levels_that_its_ticks_name(kind):
    """Curves have the interval of a share or a mean, other numbers their range; maps how often a claim holds.

    A panel for each claim and measure of each model; with named levels one, of points and claims.
    """
    rng, counts, numbers, expected = np.random.default_rng(0), [], [], {}
    flat = kind in ("map", "named")
    for x, y, model in itertools.product((0.2, 0.3, 0.4), (1.0, 2.0) if flat else (None,), ("dsnn", "emd")):
        point = {"dsnn.t_sp": x, "model": model, **({"dsnn.d": y} if flat else {})}
        level = f"{y:g}" if flat else ""
        for claim in ("C13", "C14"):  # C14 hangs on constants that are not known, and is shown by its half
            held = int(rng.integers(1, 6)) * (x > 0.2 or not flat)
            row = {"claim": claim, "holds": held, "fails": 0, "unknown constants": 0, "not shown": 5 - held}
            row |= {"low": held / 10, "high": held / 10 + 0.5}
            counts.append(point | row | ({"holds": 0, "unknown constants": held} if claim == "C14" else {}))
            at = (f"- ({claim}), {model}", f"{x:g}", level)
            if kind == "named":
                at = ("", f"- ({claim})", f"{x:g}, {y:g}, {model}")
            text = f"{held}/5{'h' * (claim == 'C14')}" if held else "-"
            expected[at] = held / 5 if held else math.nan, text if flat else pytest.approx((row["low"], row["high"]))
        for measure in () if kind == "named" else ("peak: dark", "peak: light"):
            value = float(rng.normal())
            row = {"measure": measure, "value": value, "lowest": value - 1, "highest": value + 2}
            low, high = row["lowest"], row["highest"]
            if kind == "means":
                row |= {"ci_low": (low := value - 0.1), "ci_high": (high := value + 0.3)}
            numbers.append(point | row)
            expected[f"{measure}, {model}", f"{x:g}", level] = value, None if flat else pytest.approx((low, high))
    axes = levels_of(("dsnn.t_sp=0.2,0.3,0.4", "dsnn.d=1,2")[: 1 + flat])
    figure = draw({
        "axes": {name: list(levels) for name, levels in axes.items()}, "named": kind == "named", "summary": "",
        "replicates": 5, "seed": 0, "titles": {"C13": "-", "C14": "-"}, "counts": counts, "numbers": numbers,
    })  # fmt: skip
    values, found = [row["value"] for row in numbers], {}
    for panel in (panel for panel in figure.axes if panel.images or panel.lines):
        title = panel.get_title("left").replace("\n", " ")
        across, up = panel.xaxis.get_major_formatter(), panel.yaxis.get_major_formatter()
        if not flat:
            whiskers = panel.collections[0].get_segments()
            for (x, value), segment in zip(panel.lines[0].get_xydata(), whiskers, strict=True):
                found[title, across(x), ""] = value, tuple(segment[:, 1])
            continue
        texts = {text.xy: text.get_text() for text in panel.texts}
        for (j, i), value in np.ndenumerate(panel.images[0].get_array().filled(math.nan)):
            found[title, across(i), up(j)] = value, texts.get((i, j))
        assert panel.images[0].get_clim() == ((0.0, 1.0) if texts else (min(values), max(values)))
    assert found == {at: (pytest.approx(value, nan_ok=True), more) for at, (value, more) in expected.items()}


# --- the plan ---------------------------------------------------------------------------------------------------------


def test_a_point_has_the_trials_of_a_run_with_its_settings_and_points_of_the_network_share_them():
    plan = planned(["general"], "camera.read_noise=0,0.64", "dsnn.n_con=4,8", claims=("C14",), replicates=2, seed=4,
                   assignments=("dsnn.d=2",))  # fmt: skip
    assert [spec.index for spec in plan.specs] == list(range(2 * 2 * len(registry.load("general").conditions()) * 10))
    for point in points_of(plan.axes):
        for replicate in (0, 1):
            settings = [f"{key}={value}" for key, value in point]
            alone = planned_run("general", ["dsnn"], ["dsnn.d=2", *settings], seed=4 + replicate)
            share = plan.shares[point, "dsnn", "general", replicate]
            for spec, ours in zip(alone.trials, (plan.specs[number] for number in share[0]), strict=True):
                assert (spec.seed, spec.condition) == (ours.seed, ours.condition)
                assert dataclasses.replace(spec.settings, models=()) == dataclasses.replace(ours.settings, models=())
                (label,) = (model.label for model in share[1].values())
                networks = {model.label: model.network for model in ours.models}
                assert networks[label] == spec.models[0].network and len(networks) == 2


def test_an_experiment_that_an_axis_cannot_move_is_run_once():
    plan = planned(("general", "distance"), "experiment.acceleration_cm_s2=10,17,50", claims=("C13", "C16"), repeats=5)
    counts = {name: sum(spec.experiment == name for spec in plan.specs) for name in ("general", "distance")}
    whole = {name: len(registry.load(name).conditions()) * 5 for name in counts}
    assert counts == {"general": 3 * whole["general"], "distance": whole["distance"]}
    assert len({plan.shares[point, "dsnn", "distance", 0][0] for point in points_of(plan.axes)}) == 1


def test_a_model_that_a_point_does_not_move_is_shown_once_in_each_rendering_and_counts_at_every_point():
    more = {"models": ("dsnn", "emd"), "measures": ("spikes",), "repeats": 1}
    plan = planned(["speed"], "dsnn.n_con=4,6", "camera.read_noise=0,0.64", **more)
    assert len(plan.specs) == 2 * len(registry.load("speed").conditions())
    assert {len(spec.models) for spec in plan.specs} == {2 + 1}
    points = [(point, model) for point, model, *_ in plan.shares]
    assert sorted(points) == sorted((point, model) for point in points_of(plan.axes) for model in ("dsnn", "emd"))


def test_keys_that_move_together_and_ends_of_pairs():
    together = "experiment.pose_sd_mm+experiment.heading_sd_deg=0,0.5"
    plan = planned(["general"], together, "dsnn.tau_s.last=100,300", claims=("C14",))
    assert {(spec.settings.pose_sd_mm, spec.settings.heading_sd_deg) for spec in plan.specs} == {(0, 0), (0.5, 0.5)}
    for spec in plan.specs:
        assert [model.network.tau_s for model in spec.models] == [(10.0, 100.0), (10.0, 300.0)]


@pytest.mark.parametrize(
    ("names", "over", "more"),
    [
        (["general"], ["dsnn.nonsense=1,2"], {}),
        (["general"], ["dsnn.d=1,2", "dsnn.n_con=4,8", "dsnn.w_i=0,1"], {}),
        (["general"], ["dsnn.d=1,2"], {"assignments": ("dsnn.d=3",)}),
        (["general"], ["dsnn.d=1,2"], {"models": ("dsnn:d=3",)}),
        (["general"], ["dsnn.d.first=1,2"], {}),
        (["general"], ["dsnn.d=1,2"], {"claims": ("C1",)}),
        (["general", "clean"], ["dsnn.d=1,2"], {}),
        (["clean"], ["dsnn.d=1,2"], {"measures": ("spikes",)}),
        (["clean"], ["dsnn.d=1,2"], {"claims": ("C2",), "repeats": 7}),
    ],
)
def test_what_cannot_be_swept_is_refused(names, over, more):
    with pytest.raises(UsageError):
        planned(names, *over, **more)


def test_repeats_of_clips_that_are_asked_for_are_refused_whatever_their_number():
    with pytest.raises(UsageError, match="repeats"):
        sweep_plan.sweep_of(Study("s", "", experiments=("clean",), over=("dsnn.d=1,2",), claims=("C2",)), repeats=10)


# --- clips ------------------------------------------------------------------------------------------------------------

SMALL = {"rows": 60, "columns": 80, "width": 14.0, "height": 40.0, "speed": 60.0, "rest_s": 0.2}
FILE = f"""
from experiments import Check, Claim, Clip, OfflineExperiment


def judge(clips, threshold):
    peak = min(row["peak_hs"] for row in clips)
    return [Check(f"{{peak}}", peak, threshold)]


CLAIM = Claim(on="clips", id="passes", says="it passes T", judge=judge, models=frozenset({{"dsnn", "dsn2017"}}))
EXPERIMENT = OfflineExperiment(
    "crossing", "dark and light before leaves",
    [Clip(name, "cluttered", {{**{SMALL!r}, "grey": grey}}) for name, grey in (("dark", 0.0), ("light", 255.0))],
    ("dsnn", "dsn2017"), claims=(CLAIM,),
)
"""


def test_clips_have_the_network_s_own_responses_and_share_what_no_point_changes(tmp_path):
    (tmp_path / "crossing.py").write_text(FILE)
    file, out = str(tmp_path / "crossing.py"), tmp_path / "out"
    over = ("cluttered.grey=0,120", "cluttered.start=10,700")
    arguments = ["--claims", "passes", "--measure", "peak-hs", "--workers", "0", "-q", "--out", str(out)]
    assert main.command(["sweep", file, "--over", over[0], "--over", over[1], *arguments]) == 0
    counts = pl.read_csv(out / "counts.csv")
    network = choose("dsnn", "offline").network
    for row in counts.filter(pl.col("measure") == "peak-hs").iter_rows(named=True):
        grey, start = row["cluttered.grey"], row["cluttered.start"]
        clip = stimulus("cluttered", 5, grey=grey, start=start, **SMALL)  # whatever the seed
        model = DSNN(clip.shape, network)
        peak = max(model.step(frame.luma).hs for frame in clip)
        assert row["value"] == pytest.approx(peak, abs=1e-6)
        (claim,) = counts.filter(pl.col("claim") == "passes", pl.col("cluttered.grey") == grey,
                                 pl.col("cluttered.start") == start)["holds"]  # fmt: skip
        assert claim == (peak > network.t_sp), "the claim's rows are both models', under their own names"
    claims = counts.filter(pl.col("claim") == "passes")
    held = pl.read_csv(out / "outcomes.csv")["verdict"] == "holds"
    assert held.cast(int).to_list() == claims["holds"].to_list() and {*claims["holds"]} == {0, 1}
    assert experiments.load(out).summary["claim"].to_list() == counts["claim"].to_list()


# --- a user's own files, and Python -----------------------------------------------------------------------------------

OWN = """
from experiments import Experiment, Translation

EXPERIMENT = Experiment("alpha", "crossings", Translation((20,), (6,)), "speed_cm_s", repeats=5, claims=("C14",))
"""
LIGHT = """
from experiments import Study

LIGHT = {"as it is": (), "dim": ("scene.light=0.7",)}
STUDY = Study("light", "in less light", experiments=("alpha.py",), axes={"light": LIGHT}, repeats=1, replicates=1)
"""


def test_a_user_s_study_resumes_with_more_replicates(tmp_path, monkeypatch):
    """Its first replicates are not run again, and it comes to what the larger number comes to at once."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "light.py").write_text(LIGHT)
    (tmp_path / "alpha.py").write_text(OWN)
    arguments = ["sweep", "light.py", "--workers", "0", "-q"]
    assert main.command([*arguments, "--out", "out"]) == 0
    first = pl.read_parquet("out/trials.parquet")
    assert main.command([*arguments, "--replicates", "2", "--out", "out"]) == 0
    assert main.command([*arguments, "--replicates", "2", "--out", "at-once"]) == 0
    longer, at_once = (pl.read_parquet(f"{name}/trials.parquet") for name in ("out", "at-once"))
    assert longer.drop("wall_s").equals(at_once.drop("wall_s")) and longer.head(first.height).equals(first)
    assert (tmp_path / "out/counts.csv").read_bytes() == (tmp_path / "at-once/counts.csv").read_bytes()
    assert set(pl.read_csv("out/counts.csv")["light"]) == {"as it is", "dim"}
    assert json.loads((tmp_path / "out/light.json").read_text())["counts"]


@pytest.mark.parametrize(("together", "numbers"), [([1.0, 0.5, 0.0, math.nan], [1, 4, 1]), ([], [4, 8, 2])])
def test_a_title_counts_the_cells_in_which_all_claims_hold(together, numbers):
    """Of a grid with several claims these are points; otherwise a cell is a claim at a point."""
    shares = {"C13": [1.0, 1.0, 0.0, math.nan], "C14": [1.0, 0.5, 1.0, math.nan], TOGETHER: together}
    rows = [(what, True, "dsnn", share) for what, column in shares.items() for share in column]
    cells = pl.DataFrame(rows, ["what", "judged", "model", "value"], orient="row")
    assert [int(number) for number in re.findall(r"\d+", finding(cells))] == numbers


def test_a_map_is_cut_at_a_level():
    held = {("off", "30"): (0, 5), ("off", "15"): (4, 5), ("on", "30"): (5, 3), ("on", "15"): (5, 5)}
    counts = [
        {"gamma": gamma, "steps": float(steps), "model": "dsnn", "claim": claim, "low": 0.0, "high": 1.0,
         "holds": k, "fails": 5 - k}
        for (gamma, steps), each in held.items() for claim, k in zip(("C15", "C16"), each, strict=True)
    ]  # fmt: skip
    figure = draw({"axes": {"gamma": ["off", "on"], "steps": ["30", "15"]}, "named": True, "summary": "", "seed": 0,
                   "replicates": 5, "titles": {}, "counts": counts, "numbers": []}, at={"gamma": "on"})  # fmt: skip
    (panel,) = figure.axes
    rows = [label.get_text() for label in panel.get_yticklabels()]
    shown = {(rows[y], x): text.get_text() for text in panel.texts for x, y in (text.xy,)}
    assert shown == {("30", 0): "5/5", ("30", 1): "3/5", ("15", 0): "5/5", ("15", 1): "5/5"}


def test_a_sweep_of_measures_alone_has_no_outcomes(tmp_path):
    run = experiments.sweep("clean", measures=("peak-hs",), out=tmp_path / "out", workers=0, quiet=True)
    assert run.outcomes.is_empty() and run.summary.height == 1


def test_what_python_gives_a_sweep_is_what_texts_say(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "alpha.py").write_text(OWN)
    alpha = registry.find("alpha.py")
    texts, other = ("dsnn.t_sp=0.1,0.2",), planned(["alpha.py"], "dsnn.t_sp=0.1,0.2", assignments=("dsnn.n_con=6",))
    once = {"replicates": 1, "repeats": None}
    same = [
        typed(Path("alpha.py"), (over for over in texts), assignments=["dsnn.n_con=6"]),
        typed(alpha, {"dsnn.t_sp": (0.1, 0.2)}, assignments=["dsnn.n_con=6"]),
        Study("s", "s", experiments=(alpha,), over=texts, assignments={"dsnn": {"n_con": 6}}, **once),
        Study("s", "s", experiments=(Path("alpha.py"),), assignments=("dsnn.n_con=6",), **once,
              axes={"dsnn.t_sp": {"0.1": (text for text in ("dsnn.t_sp=0.1",)), "0.2": {"dsnn.t_sp": 0.2}}}),
    ]  # fmt: skip
    for study in same:
        plan = sweep_plan.sweep_of(study)
        assert plan.axes == other.axes and len(plan.specs) == len(other.specs)
        for one, two in zip(plan.specs, other.specs, strict=True):
            assert (one.seed, one.condition) == (two.seed, two.condition)
            assert [model.network for model in one.models] == [model.network for model in two.models]
    for wrong in (["speed"], 3, None):
        with pytest.raises(UsageError):
            experiments.sweep(wrong, texts)


def test_a_sweep_begun_from_python_is_repeated_or_says_why_not(tmp_path, monkeypatch, colias):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "crossing.py").write_text(FILE)
    given = {"seeds": range(2, 4), "workers": 0, "quiet": True}
    over = ("dsnn.t_sp=0.1,0.2",)
    claim = registry.find("crossing.py").claims[0]
    first = experiments.sweep(Path("crossing.py"), {"dsnn.t_sp": (0.1, 0.2)}, ["dsnn"], claims=iter(["passes"]),
                              out="named", **given)  # fmt: skip
    repeated = colias("run", "--again", "named", "--out", "again", "--workers", "0", "-q")
    assert (repeated.returncode, repeated.stdout.split(":")[0]) == (0, "equal"), repeated.stderr
    rows = [(level, "passes", seed) for level in (0.1, 0.2) for seed in (2, 3)]
    for table in (pl.read_csv("again/outcomes.csv"), first.outcomes):
        assert table.select("dsnn.t_sp", "claim", "seed").rows() == rows
    experiments.sweep(registry.find("crossing.py"), over, claims=("passes",), out="object", **given)
    experiments.sweep("crossing.py", over, claims=(claim,), out="claim", **given)
    for name in ("object", "claim"):
        refused = colias("run", "--again", name, "--out", "other", "--workers", "0", "-q")
        assert refused.returncode == 2 and "run the script" in refused.stderr and not (tmp_path / "other").exists()


@pytest.mark.parametrize(
    "over", [("a.b.first=2,3", "a.b=4,6"), ("a.b=4,6", "a.b.last=2,3"), ("a.b=1,2", "a.b=3,4"), ("a.b=0.1,0.10",)]
)
def test_no_two_axes_move_one_parameter_and_one_value_is_one_point(over):
    with pytest.raises(UsageError):
        levels_of(over)
    assert list(levels_of(("a.b.first=2,3", "a.b.last=8,9"))) == ["a.b.first", "a.b.last"], "its two ends are two"
    assert list(levels_of(("a.b.first=2,3",), ("a.b=1,9",))) == ["a.b.first"], "the other end is as --set has it"


# --- where nothing is random ------------------------------------------------------------------------------------------

STILL = ("experiment.pose_sd_mm=0", "experiment.heading_sd_deg=0", "scene.turn_wall=false", "camera.preset=ideal")
COUNTED = ("holds", "fails", "replicates", "low", "high", "word")


def test_trials_without_any_spread_are_one_replicate_at_their_point(tmp_path):
    plan = planned(["general"], "scene.light_sd=0,0.1", claims=("C13",), assignments=STILL, replicates=3, repeats=5)
    trials = len(registry.load("general").conditions()) * 5
    assert len(plan.specs) == (1 + 3) * trials
    result = judged(plan, lambda spec, _: int(spec.condition.motion == "translation"))
    assert [tuple(row[name] for name in COUNTED) for row in result.counts.to_dicts()] == [
        (1, 0, 1, None, None, "holds"), (3, 0, 3, pytest.approx(0.292, abs=1e-3), 1.0, ""),
    ]  # fmt: skip
    assert [result.rows(*key).height for key in plan.judged] == [trials, 3 * trials]
    assert count_of(result.counts.row(0, named=True)) == Count(1, random=False)
    settings = dict(text.split("=") for text in STILL) | {"experiment.speeds_cm_s": 30, "scene.light_sd": 0}
    given = {"repeats": 1, "recordings": False, "settings": settings, "workers": 0, "quiet": True}
    one, other = (experiments.run("speed", seed=seed, out=tmp_path / str(seed), **given) for seed in (0, 9))
    assert one.frames.drop("wall_s", strict=False).equals(other.frames.drop("wall_s", strict=False)), "it is so"
    assert one.trials.drop("seed", "wall_s").equals(other.trials.drop("seed", "wall_s"))
    assert {text.partition("(")[0] for text in one.claims["count"]} and one.claims["word"].null_count() == 0


@pytest.mark.parametrize("key", ["experiment.pose_sd_mm", "experiment.heading_sd_deg", "scene.light_sd",
                                 "camera.shot_noise", "camera.read_noise", "camera.jitter_ms",
                                 "camera.drop_probability"])  # fmt: skip
def test_any_spread_of_a_trial_makes_replicates_differ(key):
    settings = [text for text in (*STILL, "scene.light_sd=0") if not text.startswith(key)]
    plan = planned(["general"], f"{key}=0,0.5", claims=("C13",), assignments=settings, replicates=2, repeats=5)
    assert plan.fixed == {(((key, "0"),), "general")}


def test_clips_that_tremble_are_counted_beside_equal_ones(tmp_path):
    """Claims together are counted over all replicates, the claim on equal clips as it comes out in the one of them."""
    claims = {"still": (FILE.replace('"cluttered"', '"plain"'), '"passes"'),
              "leaves": (FILE.replace("passes", "stays"), '"stays"')}  # fmt: skip
    for name, (text, _) in claims.items():
        (tmp_path / f"{name}.py").write_text(text.replace('"crossing"', f'"{name}"'))
    plan = planned([str(tmp_path / f"{name}.py") for name in claims], "dsnn.t_sp=0.1,0.2", claims=("passes", "stays"),
                   replicates=3)  # fmt: skip
    assert len(plan.specs) == 2 + 3 * 2
    peak = {spec.index: 0.15 + 0.1 * (spec.repeat != 1) for spec in plan.specs}
    rows = [clip_row(spec.condition.name, model.label, trial=spec.index, experiment=spec.experiment,
                     peak_hs=peak[spec.index]) for spec in plan.specs for model in spec.models]  # fmt: skip
    counts = counts_of(read(plan, rows))
    found = {key: (row["holds"], row["replicates"]) for key, row in counts.items()}
    assert found == {(0.1, "passes"): (1, 1), (0.1, "stays"): (3, 3), (0.1, TOGETHER): (3, 3),
                     (0.2, "passes"): (1, 1), (0.2, "stays"): (2, 3), (0.2, TOGETHER): (2, 3)}  # fmt: skip

"""Runs of behaviours: what is planned, the folder that is left, any number of workers, a run that goes on."""

import pytest

from colias_sim.envs import ENVS, RETURN
from experiments import UsageError, load, score
from experiments.declare.behaviour import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.kinds import episodes as behave
from experiments.kinds.episodes import env_options
from experiments.kinds.result import perform
from experiments.paper import reproduce
from experiments.paper.behaviours import GROUPS
from experiments.store.asked import Asked
from experiments.store.workers import Workers


def planned(*behaviours, episodes=None, seed=0, values=None, **options):
    """The plan of episodes; ``values`` are arguments of the env."""
    return behave.plan(Asked(kind="episodes", what=behaviours, values=values or {}, repeats=episodes, seed=seed,
                             options=options))  # fmt: skip


def test_a_plan_has_the_baselines_of_its_env():
    plan = planned("optomotor", episodes=2, values={"robots": "3", "arena": "bright"}, env="Avoidance")
    assert plan.declared == ("optomotor", *ENVS[AVOIDANCE].baselines)
    assert plan.document()["options"] == {"robots": 3, "arena": "bright"} and plan.resolved["reference"] == "optomotor"


def test_a_group_is_played_at_the_same_seeds_with_what_it_is_compared_with():
    plan = planned("escape", episodes=2, seed=7)
    played_by = plan.declared
    assert played_by == (*GROUPS["escape"], "hybrid", "straight") and plan.resolved["reference"] == "hybrid"
    seeds = [tuple(trial.seed for trial in plan.trials if trial.condition == name) for name in played_by]
    assert set(seeds) == {(7, 8)}
    assert planned("escape", baselines=False).declared == GROUPS["escape"]
    pilot = planned("hybrid", "lgmd", episodes=3, seed=1000, baselines=False)
    assert pilot.declared == ("hybrid", "lgmd")
    assert sorted(trial.index for trial in pilot.trials) == list(range(6))


def test_options_are_typed_whole_or_entry_by_entry_over_a_policys_own():
    typed = {"camera": "ov7670", "camera.ae_steps": "5", "noise": "0.5"}
    options = env_options(OPTOMOTOR, typed, {"robot": "colias4", "noise": 2.0})
    assert options == {"robot": "colias4", "camera": {"preset": "ov7670", "ae_steps": 5}, "noise": 0.5}


@pytest.mark.parametrize("typed", ["robots=none", "rubots=3", "model=dsnn", "observation=state", "noise.sd=1"])
def test_wrong_options_are_refused(typed):
    with pytest.raises(UsageError, match="--set"):
        env_options(AVOIDANCE, dict([typed.split("=")]))


def test_a_reproduction_plays_behaviours_at_equal_seeds():
    whole = reproduce.plan(Asked(kind="reproduction", options={"scale": "quick"}, seed=7))
    parts = [part for name, part in whole.parts.items() if name.startswith("behave-")]
    assert {trial.seed for part in parts for trial in part.trials} == {7}


def test_episodes_that_are_scored_have_seeds_of_their_own(monkeypatch):
    seeds = []
    whole = behave.play
    monkeypatch.setattr(behave, "play", lambda *given: whole(*given[:3], seeds.append(given[3]) or given[3], 2))
    assert score("still", episodes=3, seed=5, quiet=True)[RETURN].n == 3 and seeds == [5, 6, 7]


def short(seed=0, **options):
    """Two behaviours, two episodes each, of a few frames."""
    return planned("optomotor", "still", episodes=2, seed=seed, values=options, baselines=False, steps=12,
                   recordings=True)  # fmt: skip


def played(plan, folder, workers=0):
    return perform(plan, folder, Workers(workers, quiet=True))


def test_a_run_is_a_folder_like_every_run_and_goes_on_where_it_was(tmp_path):
    report = played(short(), tmp_path / "run")
    trials = report.trials
    assert trials["model"].to_list() == ["optomotor"] * 2 + ["still"] * 2 and trials["seed"].to_list() == [0, 1, 0, 1]
    assert trials["frames"].to_list() == [12] * 4 and report.failures.is_empty()
    assert all((tmp_path / "run" / f"figure.{ending}").is_file() for ending in ("svg", "png"))
    recordings = {path.name for path in (tmp_path / "run" / "recordings").iterdir()}
    assert recordings == {"trial-0000.rrd", "trial-0001.rrd"}, "of the first behaviour"
    loaded = load(tmp_path / "run")
    assert loaded.trials.equals(trials) and loaded.frames.height == 48 and loaded.summary.height == 6
    assert set(loaded.summary["measure"]) == {*ENVS[OPTOMOTOR].measures, RETURN}
    assert loaded.figure().get_suptitle() and loaded.claims.is_empty()

    trials[1:2].write_parquet(tmp_path / "run" / "trials.parquet")  # as if one episode alone were played
    assert played(short(), tmp_path / "run", workers=2).trials.equals(trials)
    for other in (short(seed=1), short(noise=0.5)):
        with pytest.raises(UsageError, match="choose another"):
            played(other, tmp_path / "run")


def test_claims_are_judged_where_their_behaviours_play_in_the_env_as_it_is(tmp_path):

    def of_pair(**values):
        return planned("fixation-pi", "still", episodes=1, values=values, baselines=False, steps=3)

    (verdict,) = played(of_pair(), tmp_path / "b4").verdicts
    assert (verdict.id, verdict.experiment, verdict.outcome.verdict) == ("B4", FIXATION, "not shown")
    assert not played(of_pair(noise=0.5), tmp_path / "other").verdicts

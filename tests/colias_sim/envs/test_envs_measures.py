"""What the envs declare of their baselines, measures and episodes' columns."""

from __future__ import annotations

from colias_sim.envs import ENVS, RETURN
from tests.helpers.envs import bare, episode, every_env, options_type

EVERY_EPISODE = {"seconds", "driven_m", "reward", "touched"}
"""Columns of every episode that measures are made of."""


@every_env
def test_a_measure_is_of_a_column_of_the_envs_episodes(name):
    entry = ENVS[name]
    assert entry.all_measures == (*entry.measures, RETURN)
    assert len({measure.name for measure in entry.all_measures}) == len(entry.all_measures)
    columns = {column.name for column in entry.columns} | EVERY_EPISODE
    assert {measure.column for measure in entry.all_measures} <= columns
    for measure in entry.all_measures:
        assert measure.kind in ("mean", "collision_rate", "free_distance")
        assert measure.per == 1.0 or measure.kind == "collision_rate"
        assert measure.kind == "mean" or measure.column in ("seconds", "driven_m")


@every_env
def test_a_column_is_of_the_envs_info_and_arguments(name):
    env = bare(name, observation="state")
    *_, info = episode(env, seed=0)[1]
    env.close()
    for column in ENVS[name].columns:
        assert column.info in info
        if column.kind == "mean_abs_error":
            assert column.target in options_type(name).__pydantic_fields__
        else:
            assert column.target == "" or column.target in info
            assert (column.target != "") == (column.kind == "optomotor_gain")


@every_env
def test_there_are_baselines_of_chance_and_of_the_truth(name):
    *others, oracle = ENVS[name].baselines
    assert oracle.startswith("oracle-") and not any(other.startswith("oracle-") for other in others)
    assert others == ["random-walk", "straight"]
    assert ENVS[name].note.endswith(".")


def test_names_of_measures_mean_the_same_in_every_env():
    known: dict[str, object] = {}
    for entry in ENVS.values():
        for declared in (*entry.measures, *entry.columns):
            assert known.setdefault(f"{type(declared).__name__} {declared.name}", declared) == declared


def test_the_envs_whose_paths_are_drawn_are_those_with_robots_to_meet():
    drawn = {name for name, entry in ENVS.items() if entry.draws_paths}
    assert drawn == {"colias_sim/Avoidance-v0", "colias_sim/Pursuit-v0"}

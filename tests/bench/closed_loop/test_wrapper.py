"""`experiments.RecordRerun` records an env's episodes and changes nothing of them."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest
import rerun as rr

import colias_sim  # noqa: F401  (registers the envs)
import experiments

STEPS = 6


def env(**options):
    return gym.make("colias_sim/Pursuit-v0", observation="neural", model="dsnn", max_episode_steps=STEPS, **options)


def played(played_env, episodes: int = 1, steps: int = STEPS):
    """Everything that an agent sees of episodes."""
    seen = []
    for episode in range(episodes):
        observation, info = played_env.reset(seed=episode)
        seen.append((np.copy(observation), info))
        for step in range(steps):
            taken = played_env.step(np.array([0.3, 0.1 * step], np.float32))
            seen.append((np.copy(taken[0]), *taken[1:]))
            if taken[2] or taken[3]:
                break
    return seen


def scalars(path, entity: str) -> list[list[float]]:
    chunks = rr.chunk.RrdReader(path).stream().filter(content=entity, is_static=False).to_chunks()
    return [values for chunk in chunks for values in chunk.to_record_batch()["Scalars:scalars"].to_pylist()]


def test_a_recorded_env_is_the_same_env(tmp_path):
    plain, recorded = env(), experiments.RecordRerun(env(), tmp_path / "episode.rrd")
    for one, other in zip(played(plain), played(recorded), strict=True):
        np.testing.assert_array_equal(one[0], other[0])
        assert one[1:] == other[1:]
    plain.close()
    recorded.close()
    assert recorded.recorded == [tmp_path / "episode.rrd"]


def test_the_recording_holds_what_the_episode_was(tmp_path):
    wrapped = experiments.RecordRerun(env(), tmp_path / "new" / "episode.rrd")
    taken = played(wrapped)[1:]
    (path,) = wrapped.recorded  # written at the episode's end, not when the env is closed
    np.testing.assert_allclose(
        scalars(path, "/world/observer/wheels"), [[0.3, 0.1 * step] for step in range(STEPS)], atol=1e-6
    )
    terms = [name for name in taken[0][4] if name.startswith("reward_")]
    assert terms
    assert scalars(path, "/reward") == [[info[name] for name in terms] for *_, info in taken]
    entities = {str(chunk.entity_path) for chunk in rr.chunk.RrdReader(path).stream()}
    assert {"/world/observer/camera/image", "/world/observer", "/models/dsnn/hs", "/models/dsnn/threshold"} <= entities
    wrapped.close()


def test_which_episodes_are_recorded(tmp_path):
    first = experiments.RecordRerun(env(), str(tmp_path / "one.rrd"))
    played(first, episodes=3)
    first.close()
    assert [path.name for path in first.recorded] == ["one.rrd"]
    all_episodes = experiments.RecordRerun(env(), str(tmp_path / "{episode:02d}.rrd"))
    played(all_episodes, episodes=2)
    all_episodes.close()
    assert [path.name for path in all_episodes.recorded] == ["00.rrd", "01.rrd"]
    odd = experiments.RecordRerun(env(), str(tmp_path / "odd-{episode}.rrd"), lambda episode: episode % 2 == 1)
    played(odd, episodes=4)
    odd.close()
    assert [path.name for path in odd.recorded] == ["odd-1.rrd", "odd-3.rrd"]
    assert not [*tmp_path.glob("*.part")]


def test_an_episode_that_does_not_end_is_written_as_far_as_it_got(tmp_path):
    wrapped = experiments.RecordRerun(env(), str(tmp_path / "{episode}.rrd"))
    played(wrapped, episodes=2, steps=2)
    wrapped.close()
    assert [len(scalars(path, "/world/observer/wheels")) for path in wrapped.recorded] == [2, 2]


def outcome(path) -> dict:
    """What a recording says of its episode."""
    (properties,) = rr.chunk.RrdReader(path).stream().filter(content="/__properties/episode").to_chunks()
    columns = properties.to_record_batch().to_pydict()
    return {name: value for name, (value,) in columns.items()}


@pytest.mark.parametrize(
    ("given", "recorded"), [((7, None, None), ("7", "none", "none")), ((None, 2**70, 0), ("none", f"{2**70}", "0"))]
)
def test_an_episode_has_the_seed_that_it_was_given(given, recorded, tmp_path):
    wrapped = experiments.RecordRerun(env(), str(tmp_path / "{episode}.rrd"))
    for seed in given:
        wrapped.reset(seed=seed)
        wrapped.step(np.zeros(2, np.float32))
    wrapped.close()
    assert [outcome(path)["reset seed"] for path in wrapped.recorded] == [[seed] for seed in recorded]


def test_a_recording_says_how_its_episode_ended(tmp_path):
    """It is left by a reset or by closing the env, or it ends by its time, or by touching the wall."""
    wrapped = experiments.RecordRerun(env(), str(tmp_path / "{episode}.rrd"))
    played(wrapped)
    played(wrapped, steps=1)
    played(wrapped, steps=1)
    wrapped.close()
    avoidance = gym.make("colias_sim/Avoidance-v0", observation="state")
    crash = experiments.RecordRerun(avoidance, str(tmp_path / "crash.rrd"))
    crash.reset(seed=0)
    while not crash.step(np.ones(2, np.float32))[2]:
        pass
    crash.close()
    ends = [outcome(path)["ended by"] for path in (*wrapped.recorded, *crash.recorded)]
    assert ends == [["time"], ["left"], ["left"], ["touched something"]]


@pytest.mark.parametrize("path", ["episode.mp4", 7, "{step}.rrd", "{}.rrd", "{episode.rrd", "{episode:q}.rrd"])
def test_paths_that_are_refused(path):
    pursuit = env()
    with pytest.raises(experiments.UsageError, match=r"legal is a path that ends in \.rrd") as refused:
        experiments.RecordRerun(pursuit, path)
    assert "\n" not in str(refused.value)
    pursuit.close()


def test_envs_that_are_refused(tmp_path):
    other = gym.make("CartPole-v1")
    with pytest.raises(experiments.UsageError, match="CartPoleEnv is no env of colias_sim"):
        experiments.RecordRerun(other, tmp_path / "episode.rrd")
    other.close()

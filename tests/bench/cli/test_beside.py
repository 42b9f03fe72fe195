"""`colias view A B`: equal trials of two runs as one recording, and what is refused in a line."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import rerun as rr

import experiments
from experiments.bench.cli.beside import conditions, side_by_side
from experiments.bench.run.models import choose
from experiments.bench.sources.episodes import record as record_episode
from tests.bench.robot.test_trial import spec
from tests.helpers.episodes import episode
from tests.helpers.played import Played


def write(path: Path, *models: str, **changes) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    asked = spec(models=tuple(map(choose, models or ("dsnn",))), **changes)
    path.write_bytes(Played(asked, maps=True).recording)
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> Path:
    """Folder of two runs that have seeds 2 and 3 in common, under other numbers and models."""
    folder = tmp_path_factory.mktemp("runs")
    for index, seed in enumerate((1, 2, 3)):
        write(folder / "usual" / "recordings" / f"trial-{index:04d}.rrd", seed=seed, index=index)
    for index, seed in enumerate((2, 3)):
        write(folder / "a.b" / "recordings" / f"trial-{index:04d}.rrd", "emd", "hybrid", seed=seed, index=index)
    return folder


def of(path: Path, entity: str) -> tuple[list, np.ndarray]:
    (chunk,) = rr.chunk.RrdReader(path).stream().filter(content=entity, is_static=False).to_chunks()
    batch = chunk.to_record_batch()
    return batch["time"].cast("int64").to_pylist(), np.ravel(batch["Scalars:scalars"].to_pylist())


def test_the_equal_trial_is_found_and_both_are_whole_on_one_timeline(runs, tmp_path):
    title, data = side_by_side(runs / "usual", runs / "a.b", 2)
    assert "usual" in title and "a.b" in title and "trial-0002" in title
    (tmp_path / "both.rrd").write_bytes(data)
    one, other = runs / "usual/recordings/trial-0002.rrd", runs / "a.b/recordings/trial-0001.rrd"
    assert conditions(one) == conditions(other) and conditions(one)["seed"] == 3
    for entity, path in (("/usual/models/dsnn/hs", one), (r"/a\.b/models/emd/hs", other)):
        times, values = of(tmp_path / "both.rrd", entity)
        there = of(path, f"/models{entity.partition('/models')[2]}")
        assert times == there[0]
        np.testing.assert_array_equal(values, there[1])
    reader = rr.chunk.RrdReader(tmp_path / "both.rrd")
    (layout,) = reader.blueprints()
    batches = [chunk.to_record_batch() for chunk in reader.stream(store=layout).to_chunks()]
    origins = {origin.replace("\\", "") for batch in batches if "ViewBlueprint:space_origin" in batch.schema.names
               for (origin,) in batch["ViewBlueprint:space_origin"].to_pylist()}  # fmt: skip
    names = {name for batch in batches if "ViewBlueprint:display_name" in batch.schema.names
             for (name,) in batch["ViewBlueprint:display_name"].to_pylist()}  # fmt: skip
    for run, models in (("usual", ("dsnn",)), ("a.b", ("emd", "hybrid"))):
        assert {
            f"/{run}/world",
            f"/{run}/world/observer/camera",
            *(f"/{run}/models/{model}" for model in models),
        } <= origins
    assert any(name.startswith("usual: dsnn") and "threshold ±0.2" in name for name in names)
    assert any(name.startswith("a.b: hybrid") and "threshold 0.78 of looming" in name for name in names)


def test_without_a_number_it_is_the_first_recorded_trial(runs, tmp_path):
    shutil.copytree(runs / "usual", tmp_path / "copy")
    assert "trial-0000" in side_by_side(runs / "usual", tmp_path / "copy", None)[0]


def refusal(*arguments) -> str:
    with pytest.raises(experiments.UsageError) as refused:
        side_by_side(*arguments)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_trials_of_other_conditions_or_seeds_are_refused_and_it_says_what_differs(runs, tmp_path):
    told = refusal(runs / "usual", runs / "a.b", 0)
    assert "seed is 1 and 2" in told and "a.b" in told
    faster = write(tmp_path / "faster.rrd", speed=20.0, seed=2)
    assert "speed_cm_s is 10.0 and 20.0" in refusal(runs / "usual", faster, 1)


def test_episodes_are_paired_by_the_seed_of_their_reset_and_not_by_their_number(tmp_path):
    for run, seeds in {"a": (4, 5), "b": (5, 4, None)}.items():
        (tmp_path / run / "recordings").mkdir(parents=True)
        for number, seed in enumerate(seeds):
            data = record_episode(episode("colias_sim/Fixation-v0", seed, (seed or 0) / 10))
            (tmp_path / run / "recordings" / f"trial-{number:04d}.rrd").write_bytes(data)
    for number in range(2):
        (tmp_path / "both.rrd").write_bytes(side_by_side(tmp_path / "a", tmp_path / "b", number)[1])
        one, other = (of(tmp_path / "both.rrd", f"/{run}/world/observer/wheels")[1] for run in "ab")
        np.testing.assert_array_equal(one, other)
    for number, why in ((0, "reset seed is 5 and 4"), (2, "has no equal one")):
        (tmp_path / "a" / "recordings" / "trial-0001.rrd").unlink(missing_ok=True)
        assert why in refusal(tmp_path / "b", tmp_path / "a", number)

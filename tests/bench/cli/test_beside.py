"""`colias view A B`: trials of two runs as one recording."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import rerun as rr

from experiments.bench.cli.beside import side_by_side
from experiments.bench.run.models import choose
from tests.bench.robot.test_trial import spec
from tests.helpers.played import Played


def write(path: Path, *models: str, **changes) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    asked = spec(models=tuple(map(choose, models or ("dsnn",))), **changes)
    path.write_bytes(Played(asked, maps=True).recording)
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> Path:
    """Folder of two runs with other models."""
    folder = tmp_path_factory.mktemp("runs")
    for index, seed in enumerate((1, 2)):
        write(folder / "usual" / "recordings" / f"trial-{index:04d}.rrd", seed=seed, index=index)
        write(folder / "a.b" / "recordings" / f"trial-{index:04d}.rrd", "emd", "hybrid", seed=seed, index=index)
    return folder


def of(path: Path, entity: str) -> tuple[list, np.ndarray]:
    (chunk,) = rr.chunk.RrdReader(path).stream().filter(content=entity, is_static=False).to_chunks()
    batch = chunk.to_record_batch()
    return batch["time"].cast("int64").to_pylist(), np.ravel(batch["Scalars:scalars"].to_pylist())


def test_both_trials_are_whole_on_one_timeline(runs, tmp_path):
    title, data = side_by_side(runs / "usual", runs / "a.b", 1)
    assert "usual" in title and "a.b" in title and "trial-0001" in title
    (tmp_path / "both.rrd").write_bytes(data)
    one, other = (runs / run / "recordings" / "trial-0001.rrd" for run in ("usual", "a.b"))
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

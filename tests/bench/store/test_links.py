"""A folder that was handed over may hold links: nothing is written through one to a place outside of it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest

import experiments
from experiments.bench.cli import main
from experiments.bench.engine.errors import UsageError
from experiments.bench.store.pictures import pictures

CLIPS = """
from experiments.bench.clips.experiment import Clip, OfflineExperiment

SMALL = (("rows", 48), ("columns", 64), ("width", 12.0), ("height", 20.0), ("speed", 240.0))
EXPERIMENT = OfflineExperiment(
    name="clips", summary="a crossing each way", models=("emd",),
    clips=tuple(Clip(motion, "plain", (*SMALL, ("motion", motion))) for motion in ("rightward", "leftward")),
)
"""
QUICK = {"repeats": 1, "quiet": True, "workers": 0}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A whole run with recordings."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "clips.py").write_text(CLIPS)
    return experiments.run(folder / "clips.py", out=folder / "run", **QUICK).folder


@pytest.fixture
def handed(whole, tmp_path):
    """A copy of the run from which the second clip is missing, and a place outside of it."""
    folder, outside = tmp_path / "run", tmp_path / "outside"
    shutil.copytree(whole, folder)
    for name in ("trials.parquet", "frames.parquet"):
        table = pq.read_table(folder / name)
        pq.write_table(table.filter([trial == 0 for trial in table["trial"].to_pylist()]), folder / name)
    (folder / "recordings" / "trial-0001.rrd").unlink()
    outside.mkdir()
    (outside / "victim").write_text("mine")
    return folder, outside


def go_on(whole: Path, folder: Path) -> experiments.Run:
    return experiments.run(whole.parent / "clips.py", out=folder, **QUICK)


def state(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text(errors="replace") for path in folder.iterdir()}


@pytest.mark.parametrize("to", ["victim", "new"], ids=["a file", "nothing"])
def test_no_file_is_written_through_a_link(whole, handed, to):
    """Every file of a run is written beside its place first: there a link may lie, to a file or to where none is."""
    folder, outside = handed
    places = [path for path in whole.rglob("*") if path.is_file() and path.name != ".lock"]
    assert len(places) >= 8
    for path in places:
        place = folder / path.relative_to(whole)
        place.with_name(f"{place.name}.part").symlink_to(outside / to)
    run = go_on(whole, folder)
    assert state(outside) == {"victim": "mine"}
    assert run.done == 2 and not [path for path in places if (folder / path.relative_to(whole)).is_symlink()]
    assert (folder / "recordings" / "trial-0001.rrd").stat().st_size > 1000


@pytest.mark.parametrize("name", ["recordings", "parts", ".lock"])
@pytest.mark.parametrize("begun", [True, False], ids=["begun", "new"])
def test_a_link_in_the_place_of_what_is_kept_is_refused(whole, handed, name, begun):
    folder, outside = handed
    if not begun:
        shutil.rmtree(folder)
        folder.mkdir()
    place = folder / name
    if place.is_dir():
        shutil.rmtree(place)
    place.unlink(missing_ok=True)
    place.symlink_to(outside / "victim" if name == ".lock" else outside)
    (outside / "victim").rename(outside / "victim.part")  # a folder of leftovers passes for an empty one
    if name == ".lock":
        (outside / "victim.part").rename(outside / "victim")
    before = state(outside)
    with pytest.raises(UsageError, match=rf"^{place}: is a link.*legal is") as refused:
        experiments.run(whole.parent / "clips.py", out=folder, **QUICK)
    assert "\n" not in str(refused.value) and state(outside) == before


def test_a_part_of_a_larger_run_is_no_link(whole, tmp_path):
    """A part of the models' claims, and all folders that commands make inside of theirs."""
    (tmp_path / "outside").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "even").symlink_to(tmp_path / "outside")
    words = ["study", "model-claims", "--model", "lplc2"]
    with pytest.raises(UsageError, match=r"even: is a link"):
        main.command([*words, "--workers", "0", "-q", "--out", str(tmp_path / "out")])
    assert not list((tmp_path / "outside").iterdir())


def test_the_folder_that_a_person_names_may_be_a_link(whole, handed, tmp_path):
    folder, _ = handed
    (tmp_path / "disk").symlink_to(folder)
    assert go_on(whole, tmp_path / "disk").done == 2


@pytest.mark.parametrize(
    "name", ["experiment.json", "trials.parquet", "frames.parquet", "claims.json", "recordings/trial-0000.rrd"]
)
def test_a_device_in_the_place_of_a_file_is_not_read(handed, whole, name):
    """Nobody comes to the end of ``/dev/zero``, nor to the beginning of a pipe that nobody writes."""
    folder, _ = handed
    (folder / name).unlink()
    (folder / name).symlink_to("/dev/null")
    with pytest.raises(UsageError, match="a pipe or a device, not a file"):
        if name.endswith(".rrd"):
            pictures(folder / name)
        elif name == "claims.json":
            str(experiments.load(folder).claims)
        else:
            go_on(whole, folder)
    if name == "experiment.json":
        assert "a pipe or a device" in experiments.runs(folder.parent)["trouble"][0].as_py()
    elif name.endswith(".rrd"):
        with pytest.raises(UsageError, match="a pipe or a device, not a file"):
            go_on(whole, folder)

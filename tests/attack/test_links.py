"""Folders with links to places outside of them: going on there, or writing anything there, changes nothing outside."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from experiments.bench.store.kinds import LEADERBOARD, REPRODUCTION, WHOLE
from experiments.bench.store.record import begin_whole
from tests.attack.commands import CLIPS, EXPERIMENT, film
from tests.attack.folders import KINDS, copied, go_on, state
from tests.attack.judging import expect_none, refusal
from tests.attack.processes import Ended, colias

pytestmark = pytest.mark.attack
RunOf = Callable[[str], tuple[Path, dict[str, Any]]]


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    """A place that no command is told of."""
    place = tmp_path / "outside"
    (place / "inner").mkdir(parents=True)
    (place / "victim").write_text("mine")
    (place / "inner" / "trial-0000.rrd").write_bytes(b"mine")
    return place


def untouched(outside: Path) -> list[str]:
    """What is not there as it was."""
    contents = {str(path.relative_to(outside)): path.read_bytes() for path in outside.rglob("*") if path.is_file()}
    whole = {"victim": b"mine", "inner/trial-0000.rrd": b"mine"}
    return [f"outside, {name} is changed" for name in {*contents, *whole} if contents.get(name) != whole.get(name)]


def unfinish(out: Path) -> None:
    """Take the last trial away, with its recording."""
    table = pq.read_table(out / "trials.parquet")
    last = max(table["trial"].to_pylist())
    for name in ("trials.parquet", "frames.parquet"):
        whole = pq.read_table(out / name)
        pq.write_table(whole.filter([trial != last for trial in whole["trial"].to_pylist()]), out / name)
    (out / "recordings" / f"trial-{last:04d}.rrd").unlink(missing_ok=True)


@pytest.mark.parametrize("to", ["victim", "new", "inner"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_run_that_is_gone_on_with_writes_through_no_link(kind: str, to: str, run_of: RunOf, outside: Path, tmp_path):
    """At the name that each file has before it is whole: to a file, to where none is, to a folder."""
    folder, whole = run_of(kind)
    copied(folder, tmp_path / "work")
    out = tmp_path / "work" / "out"
    files = [path for path in (folder / "out").rglob("*") if path.is_file() and path.name != ".lock"]
    unfinish(out)
    for path in files:
        place = out / path.relative_to(folder / "out")
        for name in (f"{place.name}.part", f".{place.name}.part", f"{place.name}.{1}.part"):
            place.with_name(name).symlink_to(outside / to)
    ended = go_on(tmp_path / "work", kind)
    faults = [f"exit status {ended.status}: {ended.err}"] if ended.status != 0 else []
    rows = pq.read_table(out / "trials.parquet").num_rows
    if rows != len(whole["trials.parquet"]):
        faults.append(f"{rows} rows of {len(whole['trials.parquet'])}")
    faults += [f"{path} is a link" for path in files if (out / path.relative_to(folder / "out")).is_symlink()]
    expect_none([*faults, *untouched(outside)])


@pytest.mark.parametrize("name", ["recordings", ".lock"])
@pytest.mark.parametrize("begun", [True, False], ids=["begun", "empty"])
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_written_into_is_no_link(kind: str, begun: bool, name: str, run_of: RunOf, outside: Path, tmp_path):
    folder, _ = run_of(kind)
    copied(folder, tmp_path / "work")
    out = tmp_path / "work" / "out"
    if begun:
        unfinish(out)
    else:
        shutil.rmtree(out)
        out.mkdir()
    place = out / name
    if place.is_dir():
        shutil.rmtree(place)
    place.unlink(missing_ok=True)
    (outside / "empty").mkdir()
    place.symlink_to(outside / ("empty" if name == "recordings" else "victim"))
    before = state(out)
    ended = go_on(tmp_path / "work", kind) if begun else _anew(tmp_path / "work", kind)
    faults = refusal(ended) + untouched(outside)
    if state(out) != before:
        faults.append("the folder was changed")
    if "is a link" not in ended.err:
        faults.append(f"does not say why: {ended.err}")
    expect_none([*faults, *(f"wrote {path}" for path in (outside / "empty").iterdir())])


def _anew(folder: Path, kind: str) -> Ended:
    return colias(folder, [*KINDS[kind].words, "--out", "out"])


INNER = {
    "leaderboard": (("leaderboard", "--only", "--model", "emd", "--repeats", "1"), "robot", LEADERBOARD),
    "atlas": (("leaderboard", "--atlas", "--only", "--model", "emd"), "atlas", LEADERBOARD),
    "reproduce": (("reproduce", "--quick", "--robot-only"), "general", REPRODUCTION),
    "models": (("study", "model-claims", "--model", "lplc2"), "even", WHOLE),
}
"""Words, its first part, and what a folder says that it was begun in."""
REFUSED_FOR_ITS_FILES = ("leaderboard", "atlas")
"""Those that a folder in which nothing was begun is refused for what it holds, link or not."""


@pytest.mark.parametrize("begun", [True, False], ids=["begun", "empty"])
@pytest.mark.parametrize("name", INNER)
def test_a_folder_inside_of_a_larger_one_is_no_link(name: str, begun: bool, folder: Path, outside: Path):
    """Its first part is refused before anything is computed."""
    words, inner, kind = INNER[name]
    (folder / "out").mkdir()
    if begun:
        begin_whole(folder / "out", kind)
    (outside / "empty").mkdir()
    (folder / "out" / inner).symlink_to(outside / "empty")
    ended = colias(folder, [*words, "--workers", "0", "-q", "--out", "out"])
    faults = refusal(ended) + untouched(outside)
    for_files = not begun and name in REFUSED_FOR_ITS_FILES
    if ("--out out: holds other files" if for_files else f"out/{inner}: is a link") not in ended.err:
        faults.append(f"does not say why: {ended.err}")
    expect_none([*faults, *(f"wrote {path}" for path in (outside / "empty").iterdir())])


FILES = {
    "watch": ("watch", "film.avi", "--no-view", "--table", "seen.parquet", "--record", "seen.rrd"),
    "play": ("play", "plain", "--no-view", "--record", "seen.rrd"),
    "stimulus": ("stimulus", "plain", "--out", "seen.avi"),
    "still": ("video", "made/out", "--out", "seen.png"),
    "video": ("video", "made/out", "--out", "seen.gif"),
    "csv": ("export", "made/out", "--to", "csv", "--out", "seen", "-q"),
    "log": ("export", "made/out", "--to", "log", "--out", "seen", "-q"),
    "import": ("import", "log.csv", "--experiment", "tiny.py", "--out", "seen", "-q"),
}
PARTS = (
    "seen.part", "seen.parquet.part", "seen.rrd.part", "seen.csv.part", "seen.part.avi", ".seen.part.png",
    ".seen.part.gif", "seen.gif.part", "seen.png.part",
)  # fmt: skip


@pytest.mark.parametrize("to", ["victim", "new", "inner"])
@pytest.mark.parametrize("name", FILES)
def test_no_file_is_written_through_a_link_beside_it(name: str, to: str, run_of: RunOf, folder: Path, outside: Path):
    shutil.copytree(run_of("robot")[0], folder / "made")
    (folder / "tiny.py").write_text(EXPERIMENT.format(repeats=1, speeds="(25,)"))
    (folder / "clips.py").write_text(CLIPS)
    rows = "".join(f"0,25,{(number + 1) / 30},0.1,0\n" for number in range(5))
    (folder / "log.csv").write_text(f"trial,speed_cm_s,time_s,hs,hs_spikes\n{rows}")
    film(folder / "film.avi", 30)
    for part in PARTS:
        (folder / part).symlink_to(outside / to)
    ended = colias(folder, FILES[name])
    faults = untouched(outside) + [f"says {word!r}: {ended.err}" for word in ended.crashes()]
    if ended.status not in (0, 2):
        faults.append(f"exit status {ended.status}: {ended.err}")
    faults += [f"{path} is a link" for path in folder.glob("seen*") if path.is_symlink() and path.name not in PARTS]
    expect_none(faults)


def test_what_is_outside_is_looked_at(outside: Path):
    """That the tests above can fail."""
    digest = hashlib.sha256(b"mine").hexdigest()
    assert untouched(outside) == [] and state(outside)["victim"] == digest
    (outside / "new").write_text("x")
    (outside / "victim").write_text("x")
    assert len(untouched(outside)) == 2

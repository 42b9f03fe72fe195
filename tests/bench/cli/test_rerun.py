"""`colias rerun` repeats a run from its folder alone, executes nothing that is not listed, and finds accidents."""

import json
import os
import re
import shutil
import tomllib
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import experiments
from experiments.bench.cli import cite
from experiments.bench.store import copies
from experiments.bench.store.record import Record
from tests.conftest import Colias, ColiasHere

ROOT = Path(__file__).parents[3]
CANARY = "open({ran!r}, 'a').close()\n"
HELPER = "from far import OFFSET\nGAIN = 0.03 + OFFSET\n"
MODEL = """
from dataclasses import dataclass
from dsnn import ModelEntry, Response
from helper import GAIN

@dataclass(frozen=True)
class Parameters:
    gain: float = 1.0

class Mean:
    def __init__(self, shape, parameters):
        self.gain = GAIN * parameters.gain
    def reset(self):
        pass
    def step(self, frame, *, channels="grey", maps=False):
        return Response(self.gain * float(frame.mean() % 1), 0.0, 0, 0)

MODEL = ModelEntry("mean", "mean brightness", Mean, Parameters())
"""
EXPERIMENT = """
from experiments import Check, Clip, ClipClaim, OfflineExperiment, Outcome

def dark(rows, threshold):
    return Outcome.of([Check("frames", len(rows), 0)])

EXPERIMENT = OfflineExperiment(
    name="mine", summary="a crossing", models=["../models/mean.py:gain=2.0"],
    clips=[Clip("crossing", "plain", {"rows": 20, "columns": 32})],
    claims=(ClipClaim(id="mine", says="there are frames", judge=dark),),
)
"""


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    """The folder of a run of own model, helpers, experiment and judge, moved; the originals are gone."""
    folder = tmp_path_factory.mktemp("original")
    ran = str(folder / "ran")
    sources = {"far/far.py": "OFFSET = 0.01\n", "mine/models/helper.py": HELPER, "mine/models/mean.py": MODEL,
               "mine/experiments/mine.py": EXPERIMENT}  # fmt: skip
    for name, text in sources.items():
        place = folder / "work" / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(CANARY.format(ran=ran) + text)
    colias = Colias(folder / "work")
    done = colias(
        "run", "mine/experiments/mine.py", "--model=mine/models/mean.py:gain=3.0", "--out", "run", "-q", "--seed", "5",
        PYTHONPATH=str(folder / "work" / "far"),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    moved = shutil.move(folder / "work" / "run", folder / "moved")
    shutil.rmtree(folder / "work")
    assert (folder / "ran").exists()
    (folder / "ran").unlink()
    return Path(moved)


@pytest.fixture
def run(original, tmp_path):
    """A copy of it; ``ran`` beside the first shows that one of its files was executed."""
    (original.parent / "ran").unlink(missing_ok=True)
    return Path(shutil.copytree(original, tmp_path / "run"))


def described(folder: Path) -> dict:
    return json.loads((folder / "experiment.json").read_text())


def executed(original: Path) -> bool:
    return (original.parent / "ran").exists()


def test_a_run_is_repeated_from_its_folder_alone(original, run, colias):
    assert {path.name for path in (run / "files").rglob("*.py")} == {"far.py", "helper.py", "mean.py", "mine.py"}
    refused = colias("rerun", "run", "--out", "again")
    assert (refused.returncode, refused.stderr.count("\n"), executed(original)) == (2, 1, False)
    assert "--trust" in refused.stderr and "4 copies" in refused.stderr
    assert all(f"/{name}.py  sha256 " in refused.stdout for name in ("far", "helper", "mean", "mine"))
    again = colias("rerun", "run", "--trust", "--out", "again", "--workers", "1")
    assert (again.returncode, executed(original)) == (0, True), again.stderr
    assert "equal: every row of run, bit for bit" in again.stdout
    first, second = (pq.read_table(folder / "frames.parquet") for folder in (run, colias.folder / "again"))
    assert first.num_rows and first.equals(second)
    assert not [*run.rglob("*.pyc")], "nothing is written beside the copies"
    twice = colias("rerun", "again", "--trust", "--out", "twice", "-q")
    assert (twice.returncode, twice.stdout.split(":")[0]) == (0, "equal"), twice.stderr


def test_rows_that_differ_are_named(run, colias):
    table = pq.read_table(run / "frames.parquet")
    hs = table["hs"].to_pylist()
    hs[7] += 1e-15
    place = table.schema.get_field_index("hs")
    pq.write_table(table.set_column(place, table.schema.field(place), pa.array(hs)), run / "frames.parquet")
    again = colias("rerun", "run", "--trust", "--out", "again", "-q")
    assert again.returncode == 1
    assert re.fullmatch(
        r"differs: frames.parquet: row 7 \(trial 0, model .+\): hs is .+ there and .+ here\n", again.stdout
    )


def changed_byte(run: Path) -> str:
    place = next(run.glob("files/**/helper.py"))
    place.write_bytes(place.read_bytes().replace(b"0.03", b"0.04"))
    return str(place.relative_to(run.parent))


def additional(run: Path) -> str:
    place = next(run.glob("files/**/helper.py")).with_name("numpy.py")
    place.write_text("")
    return str(place.relative_to(run.parent))


def lost(run: Path) -> str:
    place = next(run.glob("files/**/mean.py"))
    place.unlink()
    return str(place.relative_to(run.parent))


def linked(run: Path) -> str:
    place = next(run.glob("files/**/mean.py"))
    place.rename(run / "elsewhere.py")
    place.symlink_to(run / "elsewhere.py")
    return str(place.relative_to(run.parent))


def edited(run: Path, **entries: object) -> None:
    (run / "experiment.json").write_text(json.dumps(described(run) | entries))


def without(run: Path, name: str) -> None:
    there = described(run)
    del there[name]
    (run / "experiment.json").write_text(json.dumps(there))


def outside(run: Path) -> str:
    note = described(run)["copies"]
    note["copied"] = dict.fromkeys(note["copied"], "../../evil.py")
    edited(run, copies=note)
    return "../../evil.py"


def another_file(run: Path) -> str:
    evil = run.parent / "evil.py"
    evil.write_text(f"open({str(run.parent / 'ran')!r}, 'w')\n")
    edited(run, command=described(run)["command"] | {"line": ["run", str(evil)]})
    return str(evil)


def another_command(run: Path) -> str:
    edited(run, command=described(run)["command"] | {"line": ["train", "Optomotor"]})
    return "train"


def older_command(run: Path) -> str:
    without(run, "command")
    return "the command"


def older_copies(run: Path) -> str:
    without(run, "copies")
    return "no copies"


def unfinished(run: Path) -> str:
    without(run, "ended")
    edited(run, trials=3)
    return "not finished"


def other_code(run: Path) -> str:
    edited(run, resumed_with=[{"code": "0123456789ab"}])
    return "--other-code"


@pytest.mark.parametrize(
    "spoil",
    [changed_byte, additional, lost, linked, outside, another_file, another_command, older_command, older_copies,
     unfinished, other_code],
)  # fmt: skip
def test_what_cannot_be_repeated_is_refused_in_a_line_and_nothing_is_executed(original, run, colias_here, spoil):
    name = spoil(run)
    refused = colias_here("rerun", "run", "--trust", "--out", "again")
    assert (refused.returncode, refused.stderr.count("\n")) == (2, 1), refused.stderr
    assert name in refused.stderr
    assert not executed(original) and not (run.parent / "ran").exists()


def test_a_published_digest_is_compared_first(original, run, colias_here):
    told = colias_here("cite", "run")
    digest = re.search(r"^digest +([0-9a-f]{64})$", told.stdout, re.MULTILINE)[1]
    assert told.returncode == 0 and f"digest of the run {digest}" in told.stdout
    assert "colias run mine/experiments/mine.py --model=mine/models/mean.py:gain=3.0" in told.stdout
    equal = colias_here("rerun", "run", "--digest", digest)
    assert "--trust" in equal.stderr
    edited(run, seed=6)
    other = colias_here("rerun", "run", "--trust", "--digest", digest)
    assert (other.returncode, other.stderr.count("\n"), executed(original)) == (2, 1, False)
    assert "digest" in other.stderr
    assert "64" in colias_here("rerun", "run", "--trust", "--digest", "0123").stderr


def test_rows_count_in_the_digest(run):
    first = Record.read(run).digest()
    table = pq.read_table(run / "frames.parquet")
    pq.write_table(table.slice(1), run / "frames.parquet")
    assert Record.read(run).digest() != first
    assert Record.read(shutil.copytree(run, run.parent / "copy")).digest() == Record.read(run).digest()


def test_where_the_originals_are_here_no_trust_is_needed(tmp_path):
    (tmp_path / "a.py").write_text("A = 1\n")
    digest = copies.sha256(tmp_path / "a.py")
    assert copies.made_here({str(tmp_path / "a.py"): digest})
    assert not copies.made_here({str(tmp_path / "a.py"): "0" * 64})
    assert not copies.made_here({str(tmp_path / "gone.py"): digest})
    assert not copies.made_here({os.__file__: copies.sha256(Path(os.__file__))}), "Python's own is not the user's"


def test_what_is_too_large_is_not_copied_and_is_named(tmp_path):
    large, small = tmp_path / "policy.npz", tmp_path / "model.py"
    with large.open("wb") as file:
        file.truncate(copies.MOST_BYTES + 1)
    small.write_text("A = 1\n")
    files = {str(large): "0" * 64, str(small): copies.sha256(small)}
    note = copies.plan(files)
    copies.write(tmp_path / "run", files, note)
    assert [path.name for path in (tmp_path / "run").rglob("*") if path.is_file()] == ["model.py"]
    (told,) = copies.left_out_notes(note)
    assert str(large) in told and "64 MB" in told
    with pytest.raises(experiments.UsageError, match=r"no copy of .*policy\.npz"):
        copies.check(tmp_path / "run", files, note)


def test_a_call_from_python_is_repeated_where_it_was_made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(EXPERIMENT.replace("../models/mean.py:gain=2.0", "dsnn"))
    experiments.run("mine.py", seed=2, settings={"dsnn.n_con": 6}, out="first", workers=0, quiet=True)
    note = described(tmp_path / "first")
    assert (note["command"]["call"], note["command"]["arguments"]["seed"]) == ("experiments.run", 2)
    assert note["begun"] <= note["ended"]
    again = ColiasHere(tmp_path)("rerun", "first", "--out", "again", "--workers", "0", "-q")
    assert (again.returncode, again.stdout.split(":")[0]) == (0, "equal"), again.stderr


def test_citations_are_those_of_the_project():
    cited = (ROOT / "CITATION.cff").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert f'title: "{cite.TITLE}"' in cited and f"- name: {cite.AUTHORS}" in cited
    assert project["authors"] == [{"name": cite.AUTHORS}]
    families = re.findall(r"family-names: (\S+)", cited)
    assert all(family in cite.PAPER for family in families) and families
    assert re.search(r"arXiv:(\S+?)\"", cited)[1] in cite.PAPER

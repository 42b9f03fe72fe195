"""Models, parameters and trials that break: what is lost is named, what is not goes on."""

import json

import polars as pl
import pytest

from experiments.base.templates import render
from experiments.declare.clip import Clip
from experiments.kinds.clips import play_clip
from experiments.settings.models import choose
from experiments.show.clips import ClipTrial
from experiments.show.play import play
from tests.experiments.show.test_trial import spec
from tests.helpers import user_files
from tests.helpers.envs import end_after

QUICK = ("--set", "experiment.speeds_cm_s=20,30", "--repeats", "2", "--no-recordings")


SEEN = ("--no-view", "--out", "seen")
USERS_FILES = {
    "model": ("model", "import absent_module", ("run", "speed", "--model", "mine.py")),
    "model at work": ("model", "        down, right", ("run", "speed", *QUICK, "--only", "--model", "mine.py")),
    "model of clips": ("model", "        down, right", ("watch", "plain", *SEEN, "--model", "mine.py")),
    "model on trial": ("model", "        down, right", ("check", "mine.py")),
    "experiment": ("experiment", "EXPERIMENT =", ("run", "mine.py")),
    "claim": ("experiment", "    peaks =", ("run", "mine.py", "--repeats", "1", "--no-recordings")),
    "stimulus": ("stimulus", "        rows, columns", ("watch", "mine.py", *SEEN)),
    "claim about clips": ("stimulus", "    right, left =", ("run", "mine.py")),
    "behaviour": ("behaviour", "        self.mean +=", ("behave", "mine.py", "--episodes", "1")),
    "arena": ("arena", "    pillars =", ("run", "speed", "--set", "scene.arena=mine.py")),
}  # fmt: skip


@pytest.mark.parametrize("kind", USERS_FILES)
def test_a_user_s_file_that_raises_shows_its_traceback_once(kind, colias, monkeypatch):
    end_after(30, monkeypatch)
    template, at, command = USERS_FILES[kind]
    text = render(f"cli/new/{template}.py.j2", name="odd", stem="mine")
    if at in text:
        inserted = f"{' ' * (len(at) - len(at.lstrip()))}raise ValueError('odd')"
        text, raised = text.replace(at, f"{inserted}\n{at}", 1), "ValueError: odd"
    else:
        inserted, raised = at, "Error: "
        text = f"{at}\n{text}"
    (colias.folder / "mine.py").write_text(text)
    workers = ("--workers", "0") if command[0] in ("run", "behave") else ()
    done = colias(*command, *workers)
    told = done.stdout + done.stderr
    line = text.splitlines().index(inserted) + 1
    assert done.returncode in (1, 2) and told.count(f'mine.py", line {line}') == 1 and raised in told, told
    failures = colias.folder / "runs"
    for path in failures.rglob("failures.json"):
        assert all(f'mine.py", line {line}' in failure["reason"] for failure in json.loads(path.read_text()))


def write_model(folder, instead: str) -> None:
    """The model of docs/how-to/add-a-model.md, with ``instead`` before it takes its gradients."""
    text = user_files.MODEL.replace("        down, right", f"        {instead}\n        down, right")
    (folder / "my_model.py").write_text(text)


def trial_of(models):
    return play(spec(35.0, models=models))


def clip_of(models):
    return play_clip(ClipTrial("test", 0, 0, 7, Clip("small", "plain", (("rows", 24), ("columns", 32))), models))


RUNS = {"trial": trial_of, "clip": clip_of}


def rows_of(record, model):
    """Rows of one model in both tables, without wall times."""
    rows = [{**row, "wall_s": 0.0} for row in record.rows if row["model"] == model]
    return rows, [row for row in record.frames.to_dicts() if row["model"] == model]


RAISES = "self.seen = getattr(self, 'seen', -1) + 1\n        if self.seen == 5: {}"
BREAKS = {
    "raises": "raise ValueError('odd')",
    "exits": "exit()",
    "writes into the frame": "frame[0, 0] = 0",
    "returns nothing": "return None",
    "returns no number": "return Response(float('nan'), 0.0, 0, 0)",
}


@pytest.mark.parametrize("run", RUNS)
@pytest.mark.parametrize("kind", BREAKS)
def test_a_model_that_breaks_in_frame_5_loses_its_own_rows_alone(run, kind, tmp_path):
    write_model(tmp_path, RAISES.format(BREAKS[kind]))
    path = tmp_path / "my_model.py"
    record = RUNS[run]((choose(str(path)), choose("dsnn")))
    assert rows_of(record, "dsnn") == rows_of(RUNS[run]((choose("dsnn"),)), "dsnn")
    assert {row["model"] for row in record.rows} == {"dsnn"}
    (trouble,) = record.troubles.values()
    assert [*record.troubles] == ["gradient"]
    line = next(n for n, text in enumerate(path.read_text().splitlines(), 1) if BREAKS[kind] in text)
    where = f'File "{path}", line {line}, in step' if not BREAKS[kind].startswith("return") else "in frame 5, "
    assert where in trouble


def test_trials_without_a_working_model_fail_and_resume(colias):
    write_model(colias.folder, "if frame[0, 0] >= 0: raise ValueError('odd')")
    arguments = ("run", "speed", *QUICK, "--only", "--model", "my_model.py", "--workers", "0")
    done = colias(*arguments, "--out", "out")
    assert done.returncode == 1 and "3 more" in done.stderr
    assert "figure.png" not in done.stdout, "there is none to name"
    assert pl.read_parquet(colias.folder / "out" / "trials.parquet").height == 0
    again = colias(*arguments, "--out", "out")
    assert again.returncode == 1 and again.stderr.count("ValueError: odd") == 1, "once for all four"
    assert len(json.loads((colias.folder / "out" / "failures.json").read_text())) == 4


def test_a_claim_says_how_many_trials_it_lost(colias):
    write_model(colias.folder, "if now.std() > 0 and int(now.sum()) % 5 == 0: raise ValueError('five')")
    flags = ("--model", "dsnn", "--model", "my_model.py", "--workers", "0")
    colias("run", "speed", *QUICK, *flags, "--out", "out")
    failures = json.loads((colias.folder / "out" / "failures.json").read_text())
    seeds = dict(pl.read_parquet(colias.folder / "out" / "trials.parquet").select("trial", "seed").iter_rows())
    assert all(failure["seed"] == seeds[failure["trial"]] for failure in failures)
    failed = len(failures)
    claims = json.loads((colias.folder / "out" / "claims.json").read_text())["claims"]
    assert failed > 0
    for claim in claims:
        assert (f"{failed} trials of the run failed" in claim["outcome"]["measured"]) == (claim["model"] == "gradient")

"""A model, an experiment, clips, a claim, a behaviour of one's own: one short file each, found by its path, and run.

Each imports from `experiments`, `dsnn` and `colias_sim` alone. (Envs: tests/colias_sim/envs/test_envs_own.py.)
"""

import ast
import json

import polars as pl
import pytest

import experiments
from tests.helpers.envs import end_after

MODEL = """
from pydantic import Field
from pydantic.dataclasses import dataclass

from dsnn import ModelEntry, Response


@dataclass(frozen=True)
class Params:
    gain: float = Field(default=1.0, ge=0.0, le=9.0, description="gain on the mean")
    t_sp: float = 0.2


class Mean:
    def __init__(self, shape, params):
        self.params = params

    def step(self, frame):
        return Response(hs=self.params.gain * float(frame.mean()) / 2550)

    def reset(self):
        pass


MODEL = ModelEntry("mean", "the mean of the frame", Mean, Params(), channels=("hs",))
"""

ROBOT = """
from dataclasses import dataclass

from experiments import Check, Claim, Condition, Experiment, Outcome


@dataclass(frozen=True)
class Crossings:
    speed: float = 30.0
    pose_sd_mm: float = 0.0
    heading_sd_deg: float = 0.0

    def conditions(self):
        return [Condition("translation", way, self.speed, 8.0) for way in ("rightward", "leftward")]


def spikes_both_ways(rows, threshold):
    fewest = min(row["spikes"] for row in rows)
    return Outcome.of([Check(f"{fewest} spikes", fewest, 0)], f"{fewest} spikes or more")


EXPERIMENT = Experiment(
    name="mine",
    summary="fast crossings both ways",
    design=Crossings(),
    varies="direction",
    repeats=1,
    claims=("C14", Claim(id="both-ways", says="it spikes both ways", source="me", judge=spikes_both_ways, least=1)),
)
"""

CLIPS = """
from experiments import Check, Clip, ClipClaim, OfflineExperiment

SMALL = (("rows", 40), ("columns", 60), ("width", 9), ("height", 20), ("speed", 240.0))


def sees(clips, threshold):
    peak = clips["peak_hs"].max()
    return [Check(f"HS up to {peak:.2f}", peak, threshold)]


EXPERIMENT = OfflineExperiment(
    name="clips",
    summary="a small crossing",
    clips=[Clip("right", "plain", SMALL)],
    models=["dsnn"],
    claims=("C2", ClipClaim(id="sees", says="HS passes T", judge=sees, conditions={"motion": ("rightward",)})),
)
"""

BEHAVIOUR = """
from experiments import Behaviour


def balance(seen):
    return 0.25 - 0.1 * seen.hs, 0.25 + 0.1 * seen.hs


BEHAVIOUR = Behaviour.reflex("balance", "balances the flow", "Avoidance", balance)
"""

FILES = {"my_model.py": MODEL, "mine.py": ROBOT, "clips.py": CLIPS, "my_reflex.py": BEHAVIOUR}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", FILES)
def test_nothing_of_the_bench_is_needed(name):
    modules = [node.module for node in ast.walk(ast.parse(FILES[name])) if isinstance(node, ast.ImportFrom)]
    assert {module.split(".")[0] for module in modules} <= {"dataclasses", "pydantic", "dsnn", "experiments"}
    assert all("bench" not in module for module in modules)


def test_a_model_in_an_experiment_with_a_claim(folder):
    run = experiments.run(
        "mine.py", models=["my_model.py"], settings={"mean.gain": 2}, workers=0, recordings=False, quiet=True, out="out"
    )
    assert run.models == ["dsnn", "mean"]
    verdicts = {(row["id"], row["model"]): row["outcome"] for row in run.claims.to_dicts()}
    assert verdicts[("both-ways", "dsnn")] == "holds"
    assert {claim for claim, _ in verdicts} == {"C14", "both-ways"}
    rows = pl.read_parquet(folder / "out" / "trials.parquet").to_dicts()
    assert {(row["model"], row["mean.gain"]) for row in rows} == {("dsnn", None), ("mean", 2.0)}
    document = json.loads((folder / "out" / "run.json").read_text())
    user_claim = {"id": "both-ways", "says": "it spikes both ways", "source": "me"}
    assert document["experiment"]["claims"] == ["C14", user_claim]
    assert sorted(document["files"]) == sorted(str(folder / name) for name in ("mine.py", "my_model.py"))


def test_the_command_line_judges_a_claim_and_goes_on(colias):
    (colias.folder / "mine.py").write_text(ROBOT)
    quick = ("--workers", "0", "--no-recordings")
    done = colias("run", "mine.py", *quick, "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "both-ways held: it spikes both ways" in " ".join(done.stdout.split())
    before = pl.read_parquet(colias.folder / "out" / "trials.parquet")
    again = colias("run", "mine.py", *quick, "--out", "out")
    assert again.returncode == 0 and "2 of them done already" in again.stderr, again.stderr
    assert pl.read_parquet(colias.folder / "out" / "trials.parquet").equals(before)


def test_clips_with_a_claim(folder):
    run = experiments.run("clips.py", models=["my_model.py"], workers=0, recordings=False, quiet=True)
    assert run.folder.parent.name == "runs" and run.kind == "clips"
    claims = {row["id"]: row for row in run.claims.to_dicts()}
    assert set(claims) == {"C2", "sees"} and claims["sees"]["outcome"] in ("holds", "fails")
    assert claims["sees"]["holds"] + claims["sees"]["fails"] == 1 and claims["sees"]["n"] == 1


def test_a_behaviour(folder, monkeypatch):
    end_after(30, monkeypatch)
    scores = experiments.score("my_reflex.py", episodes=1)
    assert scores and all(isinstance(score, experiments.Score | None) for score in scores.values())

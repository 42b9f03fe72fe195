"""Bad models inside envs: what is observed are numbers in the space, or something is raised; nothing hangs or stays."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.attack import models
from tests.attack.judging import expect_none
from tests.attack.model_files import Case
from tests.attack.processes import Ended, python
from tests.attack.scale import some

pytestmark = pytest.mark.attack

ENVS = Path(__file__).with_name("through_envs.py")


@pytest.mark.parametrize("how", some(["path", "factory"], 1))
def test_envs_pass_on_numbers_or_raise(how, folder):
    cases = [case for case in (*models.RAISING, *models.WRONG, *models.ODD, *models.MUTATING, *models.MEDDLING)
             if case.name not in ("starts-a-program", "keeps-300-mb")]  # fmt: skip
    answers = _through_envs(folder, how, [models.TWIN, *cases])
    honest, faults = answers["twin"], []
    assert honest["raised"] == "", honest
    for case in cases:
        answer = answers[case.name]
        if answer["raised"]:
            faults += [f"{case.name}: raised {answer['raised']}"] if models.LOST not in case.may else []
        elif models.WORKS not in case.may and case.name != "raises-in-reset":
            faults.append(f"{case.name}: passes as if it answered: {answer['neural'][-1]}")
        elif (
            case.twin == "twin"
            and not case.close
            and case.name != "direction-that-looms"
            and answer["neural"] != honest["neural"]
        ):
            faults.append(f"{case.name}: observes {answer['neural'][-1]} where its twin has {honest['neural'][-1]}")
        if answer["outside"]:
            faults.append(f"{case.name}: observes {answer['outside']}, which is not in the space")
        if answer["pixels"] != honest["pixels"][: len(answer["pixels"])]:
            faults.append(f"{case.name}: changes what the camera sees")
    expect_none(faults)


def _other(answer: dict, honest: dict) -> bool:
    return answer["neural"] != honest["neural"]


def _through_envs(folder: Path, how: str, cases: Sequence[Case]) -> dict[str, dict]:
    written = [case.write(folder) for case in cases]
    ended = python(folder, [str(ENVS), how, *written], environment={"ATTACK_LAST": "9"}, timeout_s=600.0)
    assert ended.status == 0 and ended.left == (), _tail(ended)
    return json.loads((folder / "answers.json").read_text())


def _tail(ended: Ended) -> tuple[int | None, str, tuple[str, ...]]:
    return ended.status, ended.err[-2000:], ended.left


VECTOR = """
import sys
import gymnasium as gym, numpy as np
import colias_sim
if __name__ == "__main__":
    envs = gym.make_vec("colias_sim/Fixation-v0", num_envs=2, observation="neural", model=sys.argv[1])
    try:
        envs.reset(seed=0)
        for _ in range(12):
            seen = envs.step(np.zeros(envs.action_space.shape, np.float32))[0]
            assert np.isfinite(seen).all(), seen
    finally:
        envs.close()
"""


@pytest.mark.parametrize("name", ["twin", "raises-at-5", "raises-system-exit", "answers-none", "exits-anyhow"])
def test_many_envs_end_with_a_bad_model(name, folder: Path):
    """Nothing hangs, and no process stays."""
    cases = {case.name: case for case in (models.TWIN, *models.TOGETHER)}
    cases["exits-anyhow"] = models.case("exits-anyhow", models.KILLS, step="if n == 5: os._exit(3)")
    (folder / "many.py").write_text(VECTOR)
    ended = python(folder, ["many.py", cases[name].write(folder)], timeout_s=60)
    assert ended.left == () and ended.status is not None, ended
    assert (ended.status == 0) == (name == "twin"), ended
    reason = {"twin": "", "exits-anyhow": "died, exit status 3"}  # of a process that is gone nobody can say why
    assert reason.get(name, "model") in ended.err, ended

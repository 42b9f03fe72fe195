"""The law of what was asked: for every kind, the plan of what was stored gives equal trials in a fresh process."""

import importlib.util
import inspect
import json
import subprocess
import sys

from experiments.base.files import plain
from experiments.kinds.result import plan_of
from experiments.kinds.tables import KINDS
from experiments.store.asked import Asked
from tests.helpers.user_files import MODEL

LOG = "trial,time_s,hs,hs_spikes,speed_cm_s\n" + "".join(f"0,{i / 30:.6f},0.1,0,4.0\n" for i in range(1, 9))
SAVED = {"recordings": False}


def asked_of_every_kind(folder):
    """Something small of every kind, with a user's own model where a kind shows models."""
    model, log = folder / "mine.py", folder / "log.csv"
    model.write_text(MODEL, encoding="utf-8")
    log.write_text(LOG, encoding="utf-8")
    with_own = {"models": ("dsnn:n_con=6", str(model)), "only": True}
    return {
        "trials": Asked(kind="trials", what=("speed",), repeats=2, seed=3, **with_own,
                        options={"eyes": "both", "truth": True} | SAVED,
                        values={"experiment.speeds_cm_s": [4, 6.5], "camera.read_noise": 0}),
        "clips": Asked(kind="clips", what=("clean",), repeats=1, **with_own, options=SAVED),
        "episodes": Asked(kind="episodes", what=("fixation",), repeats=2, seed=5, values={"noise": 0.5}),
        "watch": Asked(kind="watch", what=("plain",), seed=2, values={"plain.speed": 60}, **with_own),
        "measured": Asked(kind="measured", what=(str(log),)),
        "tuning": Asked(kind="tuning", options={"curves": ["size"]}, **with_own),
        "sweep": Asked(kind="sweep", what=("general",), repeats=1, seed=1, options={"over": ["dsnn.t_sp=0.1,0.2"]}),
        "fit": Asked(kind="fit", what=("general",), options={"over": ["dsnn.t_sp=0.1..0.3"], "claims": ["C14"]}),
        "training": Asked(kind="training", what=("Fixation",), values={"robot": "colias4"}, options={"seeds": 2}),
        "benchmark": Asked(kind="benchmark", models=(str(model),), only=True, options={"round": "BEAC0"}),
        "leaderboard": Asked(kind="leaderboard", repeats=1, **with_own),
        "reproduction": Asked(kind="reproduction", seed=4, options={"scale": "quick", "robot_only": True}),
    }  # fmt: skip


def named(value):
    """What JSON has for a value; a function is its name, in any process."""
    return value.__qualname__ if inspect.isfunction(value) else plain(value)


def trials_of(plan):
    """All that a plan's numbers follow from, as JSON: its trials, ``run.json``, and the same of its parts.

    Of footage the source is in ``run.json``, of a log its digest; a fit has a box, and a training policies.
    """
    match plan.asked.kind:
        case "watch" | "measured":
            shown = None
        case "fit":
            shown = repr(plan.declared.box)
        case "training":
            shown = repr(plan.declared)
        case _:
            shown = plan.trials
    parts = {name: trials_of(part) for name, part in plan.parts.items()}
    document = {name: value for name, value in plan.document().items() if name != "code"}
    return json.loads(json.dumps([shown, document, parts], default=named))


FRESH = """
import json, sys
from experiments.kinds.result import plan_of
from experiments.store.asked import Asked
from tests.experiments.kinds.test_asked import trials_of
stored = json.load(sys.stdin)
print(json.dumps({kind: trials_of(plan_of(Asked.read(asked))) for kind, asked in stored.items()}))
"""


def test_the_plan_of_what_was_stored_gives_equal_trials_in_a_fresh_process(tmp_path):
    asked = asked_of_every_kind(tmp_path)
    assert set(asked) == set(KINDS), "a new kind has its own here"
    if importlib.util.find_spec("optuna") is None:
        del asked["fit"]
    stored = json.dumps({kind: one.stored() for kind, one in asked.items()})
    fresh = subprocess.run([sys.executable, "-c", FRESH], input=stored, capture_output=True, text=True, check=True)
    there = json.loads(fresh.stdout)
    for kind, one in asked.items():
        here = trials_of(plan_of(one))
        assert there[kind] == here, kind

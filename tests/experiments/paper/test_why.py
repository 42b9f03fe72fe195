"""The map over what nobody knows of the apparatus: its cells, their replicates and pairs, and a small part of it."""

import dataclasses

import pytest

from experiments.judge.judge import judge
from experiments.judge.sweep import read
from experiments.kinds import sweep
from experiments.kinds.registry import find_claim
from experiments.paper.studies import why
from experiments.store.asked import Asked
from tests.experiments.judge.test_judges import enough, rows
from tests.experiments.judge.test_replicates import rows_of

FEW = {"claims": ("C13", "C14", "C32"), "experiments": ("general",), "repeats": 1}


def planned(**changes):
    return sweep.plan(Asked(kind="sweep", declared=dataclasses.replace(why.STUDY, **changes), seed=1000))


def test_every_cell_has_its_apparatus_and_the_corners_their_replicates():
    plan = planned(**FEW).declared
    assert len(plan.judged) == 64 and sum(why.replicates(dict(point)) == 20 for point, _ in plan.judged) == len(
        why.CORNERS
    )
    rendered = {spec.settings.camera.ae_meter + str(spec.settings.camera.gamma) + str(spec.settings.scene.floor)
                for spec in plan.specs}  # fmt: skip
    assert len(rendered) == 6 and len(plan.specs) == 4 * (6 * why.OTHERS + 3 * (why.QUOTED - why.OTHERS))
    for point, model in plan.judged:
        levels = dict(point)
        assert plan.replicates_at(point) == why.replicates(levels) in (5, 20)
        numbers, seen = plan.shares[point, model, "general", 0]
        spec, (shown,) = plan.specs[numbers[0]], seen.values()
        assert (spec.settings.camera.gamma, spec.settings.scene.floor) == (
            levels["gamma"].startswith("on"), float(levels["floor"])
        )  # fmt: skip
        assert 30 / shown.processor.every == float(levels["steps a second"])
        assert (shown.network.lowpass == "two-tap-fdsr") == levels["low-pass"].startswith("two")
        assert (point, model, "general", 19) in plan.shares or why.replicates(levels) == 5


def test_c15_leftward_is_c15_of_the_mirrored_crossings():
    right = enough("C15", 4)
    left = [row | {"direction": "leftward"} for row in right]
    flat = rows({speed: [40] * 4 for speed in (2, 4, 6, 10)}, "speed_cm_s", "leftward")
    c15 = find_claim("C15", "robot")
    assert judge(why.C15_LEFT, left, 0.2).checks == judge(c15, right, 0.2).checks
    assert judge(why.C15_LEFT, left, 0.2).verdict == "holds" != judge(why.C15_LEFT, flat + right, 0.2).verdict


def test_cells_are_compared_in_pairs_of_replicates():
    """A corner in which every claim holds against one in which C14 fails in every replicate."""
    few = {"gamma": why.GAMMA, "steps a second": {"30": (), "15": why.STEPS["15"]}, "floor": {"0.81": ()},
           "low-pass": {"recursive": ()}}  # fmt: skip
    plan = planned(**FEW | {"repeats": 10, "axes": few}).declared
    silent = {model.label for point, model in ((p, next(iter(plan.shares[p, m, "general", 0][1].values())))
              for p, m in plan.judged) if dict(point)["gamma"] == "off"}  # fmt: skip

    def answer(row):
        weak = row["model"] in silent
        high, low = (0.1 if weak or row["direction"] == way else 0.5 for way in ("leftward", "rightward"))
        across = row["motion"] == "translation"
        values = {"spikes": int(across and not weak), "peak_hs": high if across else 0.0,
                  "trough_hs": -low if across else 0.0}  # fmt: skip
        return row | values

    result = read(plan, [answer(row) for row in rows_of(plan.specs)])
    (pair,) = [row for row in why.compared(result)["Cells in pairs"] if row["claim"] == "C14"
               and row["first"].startswith("off, 30") and row["second"].startswith("on, 15")]  # fmt: skip
    assert (pair["replicates"], pair["both"], pair["first only"], pair["second only"]) == (20, 0, 0, 20)
    assert pair["p"] == pytest.approx(2 / 2**20)

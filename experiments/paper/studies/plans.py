"""The studies that ship of which a `Study` does not say all: functions that plan them."""

from functools import partial
from typing import Any

from experiments.declare.study import Study
from experiments.kinds.sweep import plan_of
from experiments.paper.studies import clips, detectors, onboard, plausible, robot, why
from experiments.store.asked import Asked
from experiments.store.plan import Plan


def _plausible(study: Study, asked: Asked) -> Plan[Any]:
    return plan_of(plausible.study_of(plausible.both(asked.seed), study), asked, then=plausible.further)


def _pilot(study: Study, asked: Asked) -> Plan[Any]:
    points = plausible.sample(plausible.PAIRS, asked.seed + 3 * plausible.APART)
    return plan_of(plausible.study_of(points, study), asked, further=plausible.bound)


PLANS = {
    "fidelity": partial(plan_of, further=robot.driven),
    "detectors": partial(plan_of, probe=(detectors.columns, detectors.COLUMNS), further=detectors.tables),
    "onboard": partial(plan_of, probe=onboard.probe_of(*onboard.FORMATS), further=onboard.errors),
    "why": partial(plan_of, fewer=why.replicates, further=why.compared),
    "plausible": _plausible,
    "plausible-pilot": _pilot,
    "sensitivity": partial(plan_of, probe=robot.PROBE, only=robot.ONLY),
    "background": partial(plan_of, claim_at=clips.at_speed, further=clips.answered),
    "constants-2017": partial(plan_of, claim_at=clips.with_constants),
    "constants-emd": partial(plan_of, claim_at=clips.with_constants),
}
"""Study -> its plan, of the study and what was asked."""

"""The studies that ship of which a `Study` does not say all: functions that plan them."""

from functools import partial

from experiments.kinds.sweep import plan_of
from experiments.paper.studies import clips, detectors, onboard, plausible, robot, why

PLANS = {
    "fidelity": partial(plan_of, further=robot.driven),
    "detectors": partial(plan_of, probe=(detectors.columns, detectors.COLUMNS), further=detectors.tables),
    "onboard": partial(plan_of, probe=onboard.probe_of(*onboard.FORMATS), further=onboard.errors),
    "why": partial(plan_of, fewer=why.replicates, further=why.compared),
    "plausible": lambda study, asked: plan_of(plausible.sampled(study, asked.seed), asked, then=plausible.further),
    "plausible-pilot": lambda study, asked: plan_of(plausible.pilot(study, asked.seed), asked, further=plausible.bound),
    "sensitivity": partial(plan_of, probe=robot.PROBE, only=robot.ONLY),
    "background": partial(plan_of, claim_at=clips.at_speed, further=clips.answered),
    "constants-2017": partial(plan_of, claim_at=clips.with_constants),
    "constants-emd": partial(plan_of, claim_at=clips.with_constants),
}
"""Study -> its plan, of the study and what was asked."""

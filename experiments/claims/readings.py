"""The readings of the paper that were taken where it leaves room. Claims name those that they were used to choose."""

from __future__ import annotations

from experiments.bench.judging.claim import Reading

HALF_WAVE_RECTIFIED_F = Reading(
    id="half_wave_rectified_F",
    says=(
        '"in the FDSR mechanism, the delayed signal is subtracted to the original passed one" '
        "(fdsr-subtraction): no rectifier is named there."
    ),
    taken="F = max(LA - A, 0)",
    others=("F = LA - A, with its sign",),
    note=(
        "Not run: the network has no parameter for it. It was tried once, when the network was written: the "
        "trailing side of every edge then leaves a large negative F, whose products are positive, and HS and VS"
        " both saturate for motion of any direction. This report cannot compare the two."
    ),
    of_all=True,
)
TAU_S_RISES_WITH_SPACING = Reading(
    id="tau_s_rises_with_spacing",
    says=(
        '"the delays vary in each directional combination [...] depending on different spacings and obey a '
        'linearly decaying function" (dsn, its part c): which way is not in the text.'
    ),
    taken="rising with spacing, 10 to 200 ms",
    others=("falling with spacing, 200 to 10 ms",),
    note=(
        "Read plainly, the words make the delay fall with spacing. Under the other reading the claim is judged "
        "on the experiment ensembles, whose trials at the paper's four speeds are of the same design."
    ),
)
SPEEDS_IN_PX_PER_SECOND = Reading(
    id="speeds_in_px_per_second",
    says='"40, 80, 120 (pixels per frame)", "Vb = -8 (pixels per frame)" (simu-nature-trans, simu-sys-speed).',
    taken="pixels per second",
    others=("pixels per frame",),
    note=(
        "The paper's own words are pixels per frame. At 120 px a frame an object is across the image within 5 "
        "frames, and farther in one frame than the widest pair of detectors in the paper's table spans. At -8 "
        "px/s the background moves 0.27 px a frame."
    ),
)
START_ACCELERATION = Reading(
    id="start_acceleration",
    says='Nothing: "approaching" and "receding" trials are described without how they set off and stop.',
    taken="17 cm/s2",
    others=(
        "sudden starts, 100 cm/s2",
        "soft starts, 10 cm/s2",
    ),
    note=(
        "A compromise: sharp starts make straight recession fire, which C13 forbids, and soft ones silence "
        "recession at 15 degrees, which C19 wants to fire."
    ),
)
WHOLE_CROSSING = Reading(
    id="whole_crossing",
    says=(
        '"We accumulated the elicited spikes of the HS system during each translation process [...], which were'
        ' all with a nearly identical translating time window" (robot-sys-trans).'
    ),
    taken="spikes of the whole crossing",
    others=("spikes in one time window for all speeds",),
    note=(
        "No claim was used to choose this one: C15 is judged by the whole crossing, and C29 says the same of "
        "one window. The verdict under the other reading is that of C29."
    ),
    used=False,
)

READINGS = (
    HALF_WAVE_RECTIFIED_F,
    TAU_S_RISES_WITH_SPACING,
    SPEEDS_IN_PX_PER_SECOND,
    START_ACCELERATION,
    WHOLE_CROSSING,
)
"""All of them, in the order in which the report tells them."""

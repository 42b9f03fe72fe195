"""The readings of the paper that were taken where it leaves room, with the claims that each was chosen for."""

from __future__ import annotations

from dataclasses import dataclass

from experiments.bench.stats.claim import PAPER, claim_ids


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A reading of the paper that was taken where it leaves room.

    Parameters
    ----------
    id
        Its name, with underscores between words.
    says
        The paper's words.
    taken, others
        The reading taken, and the others, one or more.
    note
        What a reader has to know of them.
    claims
        Ids of the claims that it was chosen for; empty: all of them together.
    used
        Whether it was chosen because these claims favoured it. Otherwise they tell the readings apart.
    """

    id: str
    says: str
    taken: str
    others: tuple[str, ...]
    note: str
    claims: tuple[str, ...] = ()
    used: bool = True

    @property
    def name(self) -> str:
        """The id in words, with spaces for underscores."""
        return self.id.replace("_", " ")

    @property
    def of_all(self) -> bool:
        """Return whether it was chosen for all claims together."""
        return not self.claims


HALF_WAVE_RECTIFIED_F = Reading(
    id="half_wave_rectified_F",
    says=(
        '"in the FDSR mechanism, the delayed signal is subtracted to the original passed one" '
        "(Eq. 7): no rectifier is named there."
    ),
    taken="F = max(LA - A, 0)",
    others=("F not rectified",),
    note=(
        "With its sign, F = LA - A is large and negative on the trailing side of every edge. The products of two "
        "such values are positive, and HS and VS both saturate for motion of any direction."
    ),
)
EXACT_LOWPASS_WOULD_BE_SILENT = Reading(
    id="exact_lowpass_would_be_silent",
    says=(
        "A low-pass is a differential equation with a time constant (Eq. 6): how it is made discrete is not in "
        "the text."
    ),
    taken="backward Euler, alpha = dt / (dt + tau)",
    others=("exact low-pass",),
    note=(
        "The exact gain is 1 - exp(-dt / tau). At 30 frames a second and tau = 1 ms it leaves exp(-33) of a rise, and "
        "the network is silent; backward Euler leaves 1 / 34 of it, which is what F then is."
    ),
)
LA_ZERO_WHERE_SIGNS_DIFFER = Reading(
    id="la_zero_where_signs_differ",
    says="LA is given where both Gaussians have one sign (Eq. 4), and not where their signs differ.",
    taken="LA = 0 where they differ",
    others=("LA by the centre's sign",),
    note="The plain difference P_e - P_i has the sign of the centre where they differ.",
)
TAU_S_RISES_WITH_SPACING = Reading(
    id="tau_s_rises_with_spacing",
    says=(
        '"the delays vary in each directional combination [...] depending on different spacings and obey a '
        'linearly decaying function" (Fig. 3, its part c): which way is not in the text.'
    ),
    taken="rising with spacing, 10 to 200 ms",
    others=("falling with spacing, 200 to 10 ms",),
    note=(
        "Read plainly, the words make the delay fall with spacing. Under the other reading the claim is judged "
        "on the experiment ensembles, whose trials at the paper's four speeds are of the same design."
    ),
    claims=("C15",),
)
SPEEDS_IN_PX_PER_SECOND = Reading(
    id="speeds_in_px_per_second",
    says='"40, 80, 120 (pixels per frame)", "Vb = -8 (pixels per frame)" (Fig. 9, Fig. 10).',
    taken="pixels per second",
    others=("pixels per frame",),
    note=(
        "The paper's own words are pixels per frame. At 120 px a frame an object is across the image within 5 "
        "frames, and farther in one frame than the widest pair of detectors in the paper's table spans. At -8 "
        "px/s the background moves 0.27 px a frame."
    ),
    claims=("C5", "C6", "C7", "C8", "C9", "C10", "C11", "C24", "C26", "C27"),
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
    claims=("C13", "C19"),
)
K_SP_OF_ONE_ON_THE_ROBOT = Reading(
    id="k_sp_of_one_on_the_robot",
    says='"K_sp", "1 ~ 3" (tableParams): which value the robot ran with is not in the text.',
    taken="K_sp = 1 on the robot, 2 off-line",
    others=("K_sp = 2", "K_sp = 3"),
    note="It scales how many spikes a frame has above the threshold, and moves no potential.",
    claims=("C15", "C16", "C17", "C19", "C20", "C29"),
)
WHOLE_CROSSING = Reading(
    id="whole_crossing",
    says=(
        '"We accumulated the elicited spikes of the HS system during each translation process [...], which were'
        ' all with a nearly identical translating time window" (Fig. 16).'
    ),
    taken="spikes of the whole crossing",
    others=("spikes in one time window for all speeds",),
    note=(
        "No claim was used to choose this one: C15 is judged by the whole crossing, and C29 says the same of "
        "one window. The verdict under the other reading is that of C29."
    ),
    claims=("C15",),
    used=False,
)

READINGS = (
    HALF_WAVE_RECTIFIED_F,
    EXACT_LOWPASS_WOULD_BE_SILENT,
    LA_ZERO_WHERE_SIGNS_DIFFER,
    TAU_S_RISES_WITH_SPACING,
    SPEEDS_IN_PX_PER_SECOND,
    START_ACCELERATION,
    K_SP_OF_ONE_ON_THE_ROBOT,
    WHOLE_CROSSING,
)
"""All of them, in the order in which the report tells them."""


def bears_on(reading: Reading) -> tuple[str, ...]:
    """Return the ids of the claims that a reading was chosen for."""
    return reading.claims or claim_ids(PAPER)


def used_to_choose(claim: str) -> tuple[Reading, ...]:
    """Return the readings that were chosen because a claim favoured them, those chosen for all claims too."""
    return tuple(reading for reading in READINGS if reading.used and claim in bears_on(reading))

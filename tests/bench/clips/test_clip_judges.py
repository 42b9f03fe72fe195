"""The judges of clips and of footage: what they test, what they need, what decided."""

import numpy as np
import pytest

from experiments.bench.clips.claims import POTENTIALS, judge, paper_claims
from experiments.bench.footage import claims as footage_claims
from experiments.bench.footage.watch import LEAST_FRAMES
from experiments.bench.stats import claims
from experiments.claims.c12_real_footage import LEAST_FLOW
from tests.bench.clips.test_clip_mechanisms import alone, edges, ensembles, speed_responses, strokes
from tests.bench.clips.test_offline import SIGNED, T, blocked, both_shades, depth, greys, grid, row, translations

C12 = claims.find(footage_claims.CLAIM, footage_claims.FootageClaim)

CLAIMS = paper_claims()

T_SP = T["dsnn"]


def over(background, motions, **peaks):
    return [
        row(f"{motion} {behind}", model, motion=motion, background_speed=behind, **peak)
        for behind in background
        for motion in motions
        for model, peak in peaks.items()
    ]


def enough(claim):
    """Rows of clips on which a claim holds."""
    wavering = grid("dsn2017", lambda s, b: s / 400 - b / 20)
    valley = greys(lambda g, s: (abs(g - 128) + 10) * s / 1e5)
    ground = [row("alone", model, object="absent", peak_hs=hs) for model, hs in (("emd", 0.35), ("dsnn", 0.0))]
    return {
        "C1": translations(), "C2": translations(), "C3": depth(), "C4": blocked(0.1, 0.1),
        "C5": over((8.0,), ("looming", "receding"), dsnn={"peak_hs": 0.1}, dsn2017={"trough_vs": -0.9}),
        "C6": both_shades(over((-8.0,), ("rightward",), dsnn={"peak_hs": 0.2}, dsn2017={"peak_vs": 0.9})),
        "C7": grid("dsnn", lambda s, b: s / 400 - b / 1000) + wavering,
        "C8": grid("dsnn", lambda s, b: s / 400),
        "C9": valley, "C10": valley,
        "C11": [*ground, *valley, *({**clip_row, "model": "emd"} for clip_row in valley)],
        "C28": street(),
        "C22": edges(), "C23": strokes(), "C24": ensembles(), "C26": speed_responses(), "C27": alone(),
    }[claim]  # fmt: skip


def street(alone=None, **changed):
    """Rows of a street in which everyone is answered; ``changed`` ones replace a clip's numbers."""
    rows = [row("alone", object="absent", movers="one", foliage="windblown", **{"peak_hs": 0.05, **(alone or {})})]
    for movers in ("one", "opposite", "group"):
        for motion in ("rightward", "leftward"):
            name = f"{movers}_{motion}"
            ways = ("rightward", "leftward") if movers == "opposite" else (motion,)
            hs = {f"hs_{way}": 0.3 * SIGNED[way][1] for way in ways}
            more = {"movers": movers, "motion": motion, "foliage": "windblown", "hs_against": 0.1, "peak_vs": 0.1}
            rows.append(row(name, **{**more, **hs, **changed.get(name, {})}))
    return rows


def at_best(claim):
    """What a claim comes to of which everything is as it says: one about unknown constants cannot be judged."""
    return "unknown constants" if CLAIMS[claim].of_dsnn else "holds"


def without(rows, **values):
    """Those that have other values."""
    return [clip_row for clip_row in rows if any(clip_row[name] != value for name, value in values.items())]


@pytest.mark.parametrize("claim", CLAIMS)
def test_what_holds_says_what_decided(claim):
    outcome = judge(claim, enough(claim), T)
    assert outcome.verdict == at_best(claim) and "(needs" in outcome.decided and outcome.n > 0


@pytest.mark.parametrize("claim", CLAIMS)
def test_a_model_that_failed_in_one_clip_leaves_the_claim_unjudged(claim):
    rows = enough(claim)
    for model in CLAIMS[claim].models:
        lost = next(clip_row["clip"] for clip_row in rows if clip_row["model"] == model)
        if len(CLAIMS[claim].models) > 1:
            outcome = judge(claim, without(rows, model=model, clip=lost), T)
            assert (outcome.verdict, outcome.measured) == ("not shown", f"of the clips {lost} has no answer of {model}")
        assert judge(claim, without(rows, model=model), T).verdict == "not shown"


@pytest.mark.parametrize("claim", CLAIMS)
@pytest.mark.parametrize("nothing", [None, float("nan")])
def test_a_clip_without_a_number_is_not_judged(claim, nothing):
    for column in POTENTIALS:
        rows = enough(claim)
        rows[-1] = {**rows[-1], column: nothing}
        outcome = judge(claim, rows, T)
        assert outcome.verdict == "not shown" and f"no number in {column}" in outcome.measured


LACKING = {
    "C1": ({"motion": "upward", "grey": 255.0}, "needs clips of upward light"),
    "C2": ({"grey": 0.0}, "needs clips of rightward dark and 3 more"),
    "C3": ({"motion": "receding", "grey": 0.0}, "needs clips of receding dark"),
    "C4": ({"motion": "upward"}, "needs clips of upward"),
    "C5": ({"motion": "looming"}, "needs clips of looming before 8 px/s"),
    "C7": ({"speed": 80.0, "background_speed": -6.0}, "needs clips of rightward at 80 px/s before -6 px/s of grey 0"),
    "C8": ({"speed": 120.0, "background_speed": -2.0, "grey": 255.0},
           "needs clips of rightward at 120 px/s before -2 px/s light"),
    "C9": ({"speed": 100.0, "grey": 64.0}, "needs clips of rightward before -8 px/s at 100 px/s of grey 64"),
    "C10": ({"grey": 64.0}, "needs at least 5 grey levels (has 4)"),
    "C11": ({"object": "absent"}, "needs clips of the background alone"),
    "C28": ({"object": "absent"}, "needs clips of the foliage alone"),
    "C22": ({"polarity": "on", "motion": "leftward"}, "needs clips of edge leftward on"),
    "C23": ({"polarity": "off-on"}, "needs clips of apparent rightward off-on and 1 more"),
    "C24": ({"grey": 64.0}, "needs at least 5 grey levels (has 4)"),
    "C26": ({"speed": 100.0, "grey": 64.0}, "needs clips of rightward before -8 px/s at 100 px/s of grey 64"),
    "C27": ({"background_speed": -6.0}, "needs clips of absent before -6 px/s"),
}  # fmt: skip


@pytest.mark.parametrize("claim", LACKING)
def test_a_claim_needs_every_clip_that_its_words_name(claim):
    values, says = LACKING[claim]
    outcome = judge(claim, without(enough(claim), **values), T)
    assert outcome.verdict == "not shown" and outcome.measured.startswith(says)


def test_c11_asks_the_emd_about_slow_objects_and_the_dsnn_about_all():
    rows = [
        {**clip_row, "peak_hs": clip_row["speed"] / 1000} if clip_row["speed"] else clip_row
        for clip_row in enough("C11")
    ]
    measured = judge("C11", rows, T).measured
    assert "emd: 0.040 to 0.060 with an object" in measured and "dsnn: 0.040 to 0.120 with an object" in measured


@pytest.mark.parametrize("claim", ["C5", "C6", "C7", "C8", "C9", "C10", "C11", "C24", "C26", "C27"])
def test_clips_that_the_words_are_not_about_do_not_count(claim):
    """Before a background that shifts otherwise, whatever is answered there."""
    rows = enough(claim)
    elsewhere = [
        {**clip_row, "clip": f"else {clip_row['clip']}", "background_speed": -33.0, "peak_vs": 0.9, "peak_hs": 0.01}
        for clip_row in rows
    ]
    outcome = judge(claim, rows + elsewhere, T)
    assert (outcome.verdict, outcome.n) == (at_best(claim), judge(claim, rows, T).n)
    assert judge(claim, elsewhere, T).verdict == "not shown"


@pytest.mark.parametrize("claim", ["C5", "C6", "C7", "C8", "C9", "C10", "C11", "C24", "C26", "C27"])
def test_a_background_s_speed_is_told_in_px_a_frame(claim):
    """-8 px/s reads as fast, and is a background that hardly moves."""
    slow = {"C7": "0.067 to 0.33", "C8": "0.067 to 0.33", "C27": "0.067 to 0.33"}.get(claim, "0.27")
    rows = enough(claim)

    def measured(rows):
        return judge(claim, rows, T).measured.partition("; not checked against translation")[0]

    assert measured(rows).endswith(f"the background shifts {slow} px a frame, hardly moving")
    frames = [{**clip_row, "speed_unit": "px/frame"} for clip_row in rows]
    fast = {"C7": "2 to 10", "C8": "2 to 10", "C27": "2 to 10"}.get(claim, "8")
    assert measured(frames).endswith(f"the background shifts {fast} px a frame")


def test_nothing_is_said_of_a_background_that_no_claim_names():
    assert "background" not in judge("C1", enough("C1"), T).measured


@pytest.mark.parametrize("end", ["peak_vs", "trough_vs"])
def test_c8_is_of_vs_to_either_side(end):
    rows = enough("C8")
    for size, verdict in ((0.155, "holds"), (T_SP, "fails"), (0.3, "fails")):
        rows[7] = {**rows[7], end: size if end == "peak_vs" else -size}
        outcome = judge("C8", rows, T)
        assert outcome.verdict == verdict
        assert outcome.decided == f"{rows[7]['clip']}: |VS| up to {size:.3f} (needs below T = {T_SP:g})"


def test_one_clip_refutes_a_claim_about_every_clip():
    rows = [clip_row for clip_row in translations(right=0.1) if clip_row["clip"] == "dark right"]
    outcome = judge("C1", rows, T)
    assert outcome.verdict == "fails" and outcome.decided == "dark right +0.100 (needs to pass +0.16)"


def test_a_blocked_pathway_of_nothing_is_no_half():
    assert judge("C4", blocked(0.0, 0.0, whole=0.0), T).verdict == "fails"
    odd = [row("wall", model, motion="looming") for model in ("dsnn", "dsnn-on-blocked", "dsnn-off-blocked")]
    assert judge("C4", blocked(0.1, 0.1) + odd, T).verdict == "holds", "of translations alone"
    assert set(SIGNED) == {"rightward", "leftward", "downward", "upward"}


def test_c4_tells_the_shares_of_every_clip():
    outcome = judge("C4", blocked(0.1, 0.1), T)
    assert outcome.measured.count("ON blocked 50%, OFF blocked 50%") == 4 and outcome.effect == "4 of 4 clips"


def test_what_failed_is_what_decided():
    shares = judge("C4", blocked(0.0696, 0.13), T)
    assert shares.verdict == "fails" and "ON blocked leaves 34.8% (needs 40% to 60%)" in shares.decided
    flat = grid("dsn2017", lambda s, b: 1.0)
    varied = judge("C7", grid("dsnn", lambda s, b: s / 400 - b / 1000) + flat, T)
    assert varied.verdict == "unknown constants"
    assert "with those assumed fails: over background speeds dsn2017's peak HS varies by 0.0000" in varied.decided


def test_c7_means_the_variation_over_objects_and_speeds():
    """One series that varies much among many that hardly do is less than a little of each."""
    steady = {(80.0, -10.0): 0.09}
    rows = grid("dsnn", lambda s, b: s / 400 + steady.get((s, b), 0.0)) + grid("dsn2017", lambda s, b: -b / 200)
    outcome = judge("C7", rows, T)
    assert "with those assumed holds" in outcome.decided and "varies by 0.0300, dsn2017's by 0.0400" in outcome.measured


# The street.


@pytest.mark.parametrize(
    ("clip", "numbers", "decided"),
    [
        ("one_rightward", {"hs_rightward": 0.15}, "HS +0.150 while one moves rightward (needs to pass +0.16)"),
        ("one_leftward", {"hs_leftward": -0.16}, "HS -0.160 while one moves leftward (needs to pass -0.16)"),
        ("one_leftward", {"hs_leftward": 0.3}, "HS +0.300 while one moves leftward (needs to pass -0.16)"),
        ("opposite_rightward", {"hs_leftward": -0.1}, "HS -0.100 while one moves leftward (needs to pass -0.16)"),
        ("opposite_leftward", {"hs_rightward": 0.0}, "HS +0.000 while one moves rightward (needs to pass +0.16)"),
        ("group_rightward", {"hs_against": 0.2}, "HS up to 0.200 against who moves (needs to stay inside T = 0.16)"),
        ("group_leftward", {"trough_vs": -0.17}, "|VS| up to 0.170 (needs to stay inside T = 0.16)"),
        ("alone", {"trough_hs": -0.17}, "|HS| up to 0.170 (needs to stay inside T = 0.16)"),
        ("alone", {"peak_vs": 0.2}, "|VS| up to 0.200 (needs to stay inside T = 0.16)"),
    ],
)
def test_c28_fails_by_any_part_of_its_words(clip, numbers, decided):
    outcome = judge("C28", street(**{clip: numbers}), T)
    assert (outcome.verdict, outcome.decided) == ("fails", f"{clip}: {decided}")
    assert outcome.effect == "6 of 7 clips" and outcome.n == 7


def test_c28_holds_on_the_bounds_of_what_is_to_stay_inside():
    on = {"hs_against": T_SP, "peak_vs": T_SP, "trough_vs": -T_SP}
    assert judge("C28", street(alone={"peak_hs": T_SP}, group_rightward=on), T).verdict == "holds"


@pytest.mark.parametrize("movers", ["one", "opposite", "group"])
@pytest.mark.parametrize("motion", ["rightward", "leftward"])
def test_c28_needs_every_kind_of_clip_each_way(movers, motion):
    outcome = judge("C28", without(street(), movers=movers, motion=motion), T)
    assert outcome.verdict == "not shown"
    refuted = street(group_rightward={"peak_vs": 0.3}, one_leftward={"peak_vs": 0.3})
    assert judge("C28", without(refuted, movers=movers, motion=motion), T).verdict == "fails", "by those that are there"


def test_c28_is_about_windblown_foliage():
    still = [
        {**clip_row, "clip": f"still {clip_row['clip']}", "foliage": "none", "peak_vs": 0.9} for clip_row in street()
    ]
    assert judge("C28", [*street(), *still], T).verdict == "holds"
    assert judge("C28", still, T).verdict == "not shown"


def test_c28_of_a_clip_without_a_number_is_not_judged():
    for nothing in (None, float("nan")):
        outcome = judge("C28", street(opposite_leftward={"hs_rightward": nothing}), T)
        assert (
            outcome.verdict == "not shown"
            and "opposite_leftward: 1 of 1 have no number in hs_rightward" in outcome.measured
        )


# Footage.


def film(frames=794, moving=((0, 794),), rate=30.0):
    """Flow and an HS that follows it over T in the ``moving`` stretches of frames, and a small VS."""
    rng = np.random.default_rng(0)
    flow = np.where(np.arange(frames) // 60 % 2, 1.0, -1.0)
    hs = np.zeros(frames)
    for start, end in moving:
        hs[start:end] = 0.3 * flow[start:end]
    return flow, hs + 1e-3 * rng.standard_normal(frames), 0.001 * rng.standard_normal(frames), T_SP, rate


def test_a_few_frames_over_the_threshold_do_not_decide_c12():
    """2 of 794 agree, which by chance alone is as likely as not to be so."""
    for moving, seconds in ([((400, 402),), 1], [((10, 20), (300, 310)), 2], [((0, 119),), 4], [(), 0]):
        outcome = C12.judge(*film(moving=moving))
        assert outcome.verdict == "not shown" and outcome.decided == ""
        assert (
            f"at least {footage_claims.LEAST_SECONDS} separate seconds of footage (has {seconds})" in outcome.measured
        )
        assert f"{sum(b - a for a, b in moving)} of 794 frames" in outcome.measured


def test_a_share_of_all_is_no_certainty():
    outcome = C12.judge(*film(moving=[(start, start + 3) for start in range(0, 600, 60)]))
    low, high = outcome.measured.split("same sign over T 1.00 [")[1].split("]")[0].split(", ")
    assert (float(low), float(high)) == (pytest.approx(0.025 ** (1 / 10), abs=0.006), 1.0)
    assert "in 10 separate seconds" in outcome.measured


def test_c12_says_what_decided():
    holds = C12.judge(*film())
    assert holds.verdict == "holds" and "(needs " in holds.decided
    flow, hs, _, *rest = film()
    fails = C12.judge(flow, hs, 2 * hs, *rest)
    assert fails.verdict == "fails" and fails.decided.startswith("mean |VS| / |HS| 2.00")
    assert fails.decided.endswith("(needs below 1)")


@pytest.mark.parametrize("which", [0, 1, 2])
def test_footage_with_an_answer_that_is_no_number_is_not_judged(which):
    columns = list(film())
    columns[which] = columns[which].copy()
    columns[which][5] = np.nan
    outcome = C12.judge(*columns)
    assert outcome.verdict == "not shown" and "1 of 794 frames have no number" in outcome.measured


def test_long_silence_has_an_interval():
    """Resamples of silent stretches alone have no ratio; they raise nothing."""
    flow, hs, vs, *rest = film(frames=3000, moving=[(i, i + 2) for i in range(0, 300, 40)])
    hs[300:] = vs[300:] = 0.0
    assert C12.judge(flow, hs, vs, *rest).verdict in ("holds", "fails")


# The paper's stronger words about footage.


def busy(seconds, frames=LEAST_FRAMES, vs=0.0, flow=0.0, whole=12, rate=30):
    """HS over T in the first ``frames`` frames of so many seconds, a VS in them, and an even flow throughout."""
    hs, across = np.zeros(whole * rate), np.zeros(whole * rate)
    for second in range(seconds):
        hs[second * rate : second * rate + frames] = 0.3
        across[second * rate : (second + 1) * rate] = vs
    return np.full(whole * rate, float(flow)), hs, across, T_SP, float(rate)


@pytest.mark.parametrize(
    ("footage", "verdict"),
    [
        (busy(5), "holds"),
        (busy(5, vs=-0.3), "fails"),  # VS over T throughout
        (busy(4), "not shown"),  # too little over T, and too little to see
        (busy(4, flow=0.2), "fails"),  # too little over T, though the flow has translation in every second
        (busy(4, flow=-0.2), "fails"),
        (busy(4, flow=0.04), "not shown"),
        (busy(12, frames=LEAST_FRAMES - 1, flow=0.2), "fails"),  # flashes of two frames are no motion
        (busy(0, whole=0), "not shown"),
    ],
)
def test_the_paper_s_stronger_words(footage, verdict):
    outcome = C12.stronger(*footage)
    assert outcome.verdict == verdict
    assert bool(outcome.decided) == (verdict != "not shown")


def test_at_a_bound_nothing_is_over_it():
    """HS that equals T does not pass it, and a flow of `LEAST_FLOW` is no translation."""
    flow, hs, *rest = busy(12)
    assert C12.stronger(flow, np.where(hs > 0, T_SP, 0.0), *rest).verdict == "not shown"
    for least, verdict in ((LEAST_FLOW, "not shown"), (np.nextafter(LEAST_FLOW, 1), "fails")):
        even = np.full(1, least)  # a block of one frame: a mean over several might be rounded
        assert C12.stronger(np.repeat(even, 12), np.zeros(12), np.zeros(12), T_SP, 1.0).verdict == verdict


@pytest.mark.parametrize(("over", "verdict"), [(7, "holds"), (8, "fails")])
def test_vs_may_pass_in_one_frame_of_twenty(over, verdict):
    """Of the 150 frames of the seconds with HS over T; quiet footage beside them does not count."""
    for whole in (6, 60):
        flow, hs, vs, *rest = busy(5, whole=whole)
        vs[:over] = 0.2
        outcome = C12.stronger(flow, hs, vs, *rest)
        assert outcome.verdict == verdict and "of the 150 frames" in outcome.measured


def test_a_sway_is_no_translation():
    flow = np.sin(2 * np.pi * np.arange(360) / 30)
    _, hs, vs, *rest = busy(0)
    assert C12.stronger(flow, hs, vs, *rest).verdict == "not shown"


@pytest.mark.parametrize("which", [0, 1, 2])
def test_the_stronger_words_need_numbers_too(which):
    columns = list(busy(5))
    columns[which][5] = np.nan
    assert C12.stronger(*columns).verdict == "not shown"

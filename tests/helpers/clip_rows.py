"""Made-up rows of clips on which each of the paper's claims holds, and its broken variants."""

from experiments.declare.claim import POTENTIALS
from experiments.judge import judge as judging
from experiments.judge.judge import SIGNED
from experiments.kinds.registry import find_claim
from experiments.show.clips import TRIALS

BLOCKED, FEWER = ("dsnn-on-blocked", "dsnn-off-blocked"), ("dsnn:n_con=1", "dsnn:n_con=2")
WITHOUT = ("dsnn:dog=false", "dsnn:fdsr=false")
T = {"emd": None, **dict.fromkeys(("dsnn", "dsn2017", *BLOCKED, *FEWER, *WITHOUT), 0.16)}
"""Thresholds of the models."""
DIRECTIONS, DEPTH = ("rightward", "leftward"), ("looming", "receding")
PAIRS = ("on-on", "off-off", "on-off", "off-on")


def row(clip="a", model="dsnn", **changes):
    base = {
        "clip": clip, "model": model, "motion": "rightward", "grey": 0.0, "speed": 40.0, "background_speed": -8.0,
        "stimulus": "cluttered", "speed_unit": "px/s", "fps": 30.0, "object": "present", "background_mean": 128.0,
        **dict.fromkeys((*POTENTIALS, "peak_looming"), 0.0),
    }  # fmt: skip
    return {**dict.fromkeys(TRIALS), **base, **changes}


def both_shades(rows):
    return [{**clip_row, "clip": f"{shade} {clip_row['clip']}", "grey": grey} for shade, grey in
            (("dark", 0.0), ("light", 255.0)) for clip_row in rows]  # fmt: skip


def translations():
    rows = []
    for motion, (column, sign) in SIGNED.items():
        aside = "peak_vs" if column.endswith("hs") else "peak_hs"
        rows.append(row(motion, motion=motion, **{column: 0.2 * sign, aside: 0.05}))
    return both_shades(rows)


def blocked(on, off, whole=0.2):
    peaks = {"dsnn": whole, "dsnn-on-blocked": on, "dsnn-off-blocked": off}
    return [
        row(motion, model, motion=motion, **{column: sign * peak})
        for motion, (column, sign) in SIGNED.items()
        for model, peak in peaks.items()
    ]


def grid(model, peak):
    return [
        row(f"{g} {s} {b}", model, grey=g, speed=s, background_speed=b, peak_hs=peak(s, b))
        for g in (0.0, 255.0)
        for b in (-2.0, -4.0, -6.0, -8.0, -10.0)
        for s in (40.0, 80.0, 120.0)
    ]


def greys(peak):
    return [
        row(f"{g} {s}", grey=g, speed=s, peak_hs=peak(g, s), background_mean=120.0)
        for g in (0.0, 64.0, 128.0, 191.0, 255.0)
        for s in (40.0, 60.0, 80.0, 100.0, 120.0)
    ]


def signed(motion, hs):
    """HS that goes the way of the motion."""
    return {"peak_hs": hs} if motion == "rightward" else {"trough_hs": -hs}


def edges(driven=0.0, other=0.2, whole=0.2):
    """One edge of either polarity both ways, with the pathway that it drives blocked, and with the other."""
    drives = {"on": BLOCKED, "off": BLOCKED[::-1]}
    return [
        row(f"{polarity} {motion}", model, stimulus="edge", polarity=polarity, motion=motion, **signed(motion, hs))
        for polarity, (driven_blocked, beside) in drives.items()
        for motion in DIRECTIONS
        for model, hs in (("dsnn", whole), (driven_blocked, driven), (beside, other))
    ]


def strokes(same=0.2, opposite=0.01, **changed):
    """Two steps of every pair both ways; ``changed`` has the answers of one clip, by its name with underscores."""
    rows = []
    for polarity in PAIRS:
        for motion in DIRECTIONS:
            hs = signed(motion, same) if polarity in PAIRS[:2] else {"peak_hs": opposite}
            hs = changed.get(f"{polarity}_{motion}".replace("-", "_"), hs)
            rows.append(row(f"{polarity} {motion}", stimulus="apparent", polarity=polarity, motion=motion, **hs))
    return rows


def ensembles(fewer=0.1):
    """Peaks of 0.16 and more in some clips, and a share of them with fewer connected cells."""
    whole = greys(lambda g, s: (abs(g - 128) + 10) * s / 6e4)
    return whole + [
        {**clip_row, "model": model, "peak_hs": fewer * clip_row["peak_hs"]} for model in FEWER for clip_row in whole
    ]


def speed_responses(middle=lambda s: 0.3, ends=lambda s: 0.3 + s / 1e4):
    """The EMD answers the background by HS to the left; only with a black or a white object does |HS| rise."""
    dsnn_rows = greys(lambda g, s: s / 1e3)
    answers = {grey: ends if grey in (0.0, 255.0) else middle for grey in (0.0, 64.0, 128.0, 191.0, 255.0)}
    other = {"model": "emd", "peak_hs": 0.0}
    return dsnn_rows + [
        {**clip_row, **other, "trough_hs": -answers[clip_row["grey"]](clip_row["speed"])} for clip_row in dsnn_rows
    ]


def alone(factor=2.5):
    """The background alone at the paper's five speeds."""
    return [
        row(f"alone {behind}", model, object="absent", background_speed=behind, peak_hs=0.001 * times,
            trough_vs=-0.002 * times)
        for behind in (-2.0, -4.0, -6.0, -8.0, -10.0)
        for model, times in (("dsnn", 1.0), *((model, factor) for model in WITHOUT))
    ]  # fmt: skip


def over(behind, motions, **peaks):
    return [
        row(motion, model, motion=motion, background_speed=behind, **peak)
        for motion in motions
        for model, peak in peaks.items()
    ]


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


def enough(claim):
    """Rows of clips on which a claim holds."""
    wavering = grid("dsn2017", lambda s, b: s / 400 - b / 20)
    valley = greys(lambda g, s: (abs(g - 128) + 10) * s / 1e5)
    ground = [row("alone", model, object="absent", peak_hs=hs) for model, hs in (("emd", 0.35), ("dsnn", 0.0))]
    return {
        "C1": translations(), "C2": translations(),
        "C3": both_shades(over(-8.0, DEPTH, dsnn={"peak_hs": 0.15, "trough_vs": -0.15})),
        "C4": blocked(0.1, 0.1),
        "C5": over(8.0, DEPTH, dsnn={"peak_hs": 0.1}, dsn2017={"trough_vs": -0.9}),
        "C6": both_shades(over(-8.0, ("rightward",), dsnn={"peak_hs": 0.2}, dsn2017={"peak_vs": 0.9})),
        "C7": grid("dsnn", lambda s, b: s / 400 - b / 1000) + wavering,
        "C8": grid("dsnn", lambda s, b: s / 400),
        "C9": valley, "C10": valley,
        "C11": [*ground, *valley, *({**clip_row, "model": "emd"} for clip_row in valley)],
        "C28": street(),
        "C22": edges(), "C23": strokes(), "C24": ensembles(), "C26": speed_responses(), "C27": alone(),
    }[claim]  # fmt: skip


def judge(claim, rows, thresholds, all_rows=None):
    """Judge a claim on clips, by the threshold of its own model."""
    asked = find_claim(claim, "clips")
    return judging.judge(asked, rows, thresholds.get(asked.spiking), all_rows)

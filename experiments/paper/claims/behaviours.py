"""Our own claims about behaviours, B1 to B4. Their words are in ``claims.toml``."""

from dataclasses import replace

import polars as pl

from colias_sim.envs import ENVS
from experiments.declare.behaviour import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.declare.claim import shipped as claim
from experiments.declare.outcome import Check, Outcome
from experiments.judge import scores as episodes
from experiments.judge.scores import held, mean_difference, rate_ratio

TIMES = 5.0
"""How many times less often B1 asks a collision to be, in collisions a metre."""
LGMD_RATIO = 1.0
"""B2's bound: LGMD alone over the hybrid, in collisions a metre."""
LGMD_EPISODES = 33
"""Episodes of each behaviour that B2 takes for a power of 80 %.

In 120 whole episodes at seeds 1000 to 1119, which no reproduction judges, ``hybrid`` collided 14 times in 543.05 m, and
``lgmd`` 50 times in 394.73 m. The counts are Poisson, and B2 holds where the whole interval of `rate_ratio` does.
"""
FRAMES_A_SECOND = 30


@claim("B1", conditions={"env": (AVOIDANCE,)}, models={"hybrid", "straight"})
def b1(played: pl.DataFrame) -> Outcome:
    """Judge the ratio of both rates."""
    return rarer(played, "straight", TIMES)


@claim("B2", conditions={"env": (AVOIDANCE,)}, models={"hybrid", "lgmd"})
def b2(played: pl.DataFrame) -> Outcome:
    """Judge the ratio of both rates, and report what the hybrid without direction does."""
    outcome = rarer(played, "lgmd", LGMD_RATIO)
    if not outcome.checks:
        return outcome
    outcome = replace(outcome, decided=outcome.decided + underpowered_text(played))
    blind = played.filter(model="lgmd-hybrid")
    if blind.is_empty():
        return outcome
    ratio = rate_ratio(blind, played.filter(model="hybrid"))
    blinded = f"the hybrid without direction, a side by chance, {collisions_text(blind)}: {ratio} times"
    return replace(outcome, measured=f"{outcome.measured}; {blinded}")


@claim("B3", conditions={"env": (OPTOMOTOR,)}, models={"optomotor-pi", "still"})
def b3(played: pl.DataFrame) -> Outcome:
    """Judge the PI reflex, and report what the plain reflex and the privileged one do.

    The gain is a signed mean, so a reflex that swings to and fro may have much of it.
    """
    others = ("optomotor", "oracle-heading")
    return better_than_still(played, "optomotor-pi", "optomotor_gain", 0.5, "rms_slip_deg_s", *others)


@claim("B4", conditions={"env": (FIXATION,)}, models={"fixation-pi", "still"})
def b4(played: pl.DataFrame) -> Outcome:
    """Judge the PI reflex, and report what the plain reflex and the privileged one do."""
    return better_than_still(played, "fixation-pi", "in_view", 0.8, "rms_off_axis_deg", "fixation", "oracle-target")


def rarer(played: pl.DataFrame, against: str, times: float) -> Outcome:
    """Judge whether ``hybrid`` collides less often per metre than ``against``, by more than ``times``."""
    hybrid, other = played.filter(model="hybrid"), played.filter(model=against)
    ratio = rate_ratio(other, hybrid)
    measured = (
        f"hybrid {episodes.rate(hybrid, 'driven_m')} collisions a metre ({collisions_text(hybrid)}), "
        f"{against} {episodes.rate(other, 'driven_m')} ({collisions_text(other)}): {ratio} times"
    )
    asked = Check(f"lower end of the 95 % interval {ratio.low:.3g}", ratio.low, times)
    return held(measured, [(ratio, asked)], {"hybrid": hybrid, against: other})


def underpowered_text(played: pl.DataFrame) -> str:
    """Return what is to be said of B2 where its episodes are too few, or too short, for a power of 80 %.

    Episodes that are cut short are worth as many whole ones as they are long together.
    """
    sides = [played.filter(model=name) for name in ("hybrid", "lgmd")]
    whole = ENVS[AVOIDANCE].max_episode_steps / FRAMES_A_SECOND
    longest = max(max(side["seconds"]) for side in sides)  # some episode goes on to the end
    there, needed = min(side.height for side in sides), LGMD_EPISODES
    if there * min(longest / whole, 1.0) >= needed:
        return ""
    short = f", of {longest:.0f} s in place of {whole:.0f}" if longest < whole else ""
    return f"; underpowered: {there} of {needed} episodes{short}"


def collisions_text(rows: pl.DataFrame) -> str:
    """Return how many episodes collided in how many metres, in words."""
    return f"{episodes.collisions(rows)} in {sum(rows['driven_m']):.1f} m"


def better_than_still(played: pl.DataFrame, name: str, column: str, bound: float, rms: str, *others: str) -> Outcome:
    """Judge whether a behaviour has a ``column`` above a bound, a smaller RMS than a still robot, and a higher return.

    Each of the three holds where its whole 95 % interval does. The last two are of differences at equal seeds, so in
    equal worlds.

    Parameters
    ----------
    played
        The episodes in one env, those of ``still`` among them.
    name
        The behaviour that is judged.
    column, bound
        What is to be above the bound, in the mean over episodes.
    rms
        Column of a root mean square, the less the better.
    *others
        Behaviours of which the same numbers are reported.
    """
    env = played["env"][0]
    sides = {other: played.filter(pl.col(column).is_not_null(), model=other) for other in (name, "still")}
    seeds = set.intersection(*(set(rows["seed"]) for rows in sides.values()))
    sides = {other: rows.filter(pl.col("seed").is_in(seeds)) for other, rows in sides.items()}
    level = episodes.mean(sides[name], column)
    smaller = mean_difference(sides["still"], sides[name], rms)
    more = mean_difference(sides[name], sides["still"], "reward")
    if level is None or smaller is None or more is None:
        return Outcome.unjudged(f"needs episodes of {name} and still at equal seeds")
    reported = [other for other in (name, *others, "still") if other in set(played["model"])]
    names = {column: measure for measure, column in ENVS[env].measures.items()}
    asked = (
        (names[column], level, bound),
        (f"{names[rms]} below that of still", smaller, 0.0),
        ("return above that of still", more, 0.0),
    )
    checks = [
        # Their units differ: each slack is a share of its own mean.
        (score, Check(f"{what}: lower end of the 95 % interval {score.low:.3g}", score.low, least,
                      scale=abs(score.value) or 1.0))
        for what, score, least in asked
    ]  # fmt: skip
    return held("; ".join(_measured(played, other, rms) for other in reported), checks, sides)


def _measured(played: pl.DataFrame, name: str, rms: str) -> str:
    """Return the scores of a behaviour in words, and by how much it is better than a still robot at equal seeds."""
    rows, still = played.filter(model=name), played.filter(model="still")
    numbers = ", ".join(f"{measure} {score}" for measure, score in episodes.scores(rows, played["env"][0]).items())
    if name == "still":
        return f"{name}: {numbers}"
    smaller, more = mean_difference(still, rows, rms), mean_difference(rows, still, "reward")
    return f"{name}: {numbers} (RMS below still's by {smaller}, return above it by {more})"

"""Controls as a figure: what each model responds to trials as they were, and to their controls."""

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from experiments.base import palette
from experiments.draw import style
from experiments.judge.controls import MEANS
from experiments.judge.tests import Floats

ACROSS, HEIGHT = 3, 1.9
"""Panels side by side, and the height of one, inches."""
MEASURES = {"direction": "mean potential along the true motion", "looming": "largest looming potential"}


def draw(found: Mapping[tuple[str, str], Floats], words: Sequence[str]) -> Figure:
    """Draw a panel for each model and kind of response.

    Parameters
    ----------
    found
        As of `experiments.judge.controls.measured`; at least one, each of at least one trial.
    words
        The word on each.
    """
    across = min(ACROSS, len(found))
    with style.look():
        figure = Figure((style.WIDTH, HEIGHT * -(-len(found) // across) + 0.9), layout="constrained")
        panels = style.grid(figure, len(found), across)
        for axes, ((model, kind), values), word in zip(panels, found.items(), words, strict=True):
            places = range(len(MEANS))
            style.means(axes, places, values.T.tolist(), palette.CHANNELS.get(kind, palette.INK), line="none", gap=1.0)
            axes.axhline(0.5 if kind == "looming" else 0.0, color=palette.GREY, ls=":", lw=0.8, zorder=1)
            axes.set_xticks(places, MEANS, rotation=35, ha="right")
            axes.set_ylabel(style.wrapped(MEASURES[kind], HEIGHT - 0.5, style.SMALL), fontsize=style.SMALL)
            axes.set_xlabel(f"n = {len(values)}", fontsize=style.SMALL)
            style.finding(axes, f"{model}: {word}")
        named = {word: [model for (model, _), one in zip(found, words, strict=True) if one == word] for word in words}
        style.headline(figure, "; ".join(f"{word}: {', '.join(models)}" for word, models in named.items()))
        note = "Open dots: trials; full dots: means with 95 % intervals; n: trials, each paired with its controls."
        style.caption(figure, f"{note} shown: the trial as it was. shuffled is not judged. Dotted: rest.")
    return figure

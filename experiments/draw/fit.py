"""Fits as figures and on the terminal: the least slack over each parameter, and the best settings judged again."""

from typing import Any

import polars as pl
from matplotlib.figure import Figure

from experiments.base import console, palette
from experiments.draw import style


def draw(run: Any) -> Figure:
    """Draw a fit, an `experiments.Run`: a panel for each parameter, and one for the settings judged again."""
    shares, settings = run.fitted["importance"], run.summary
    keys = sorted(run.fitted["winner"], key=lambda key: -shares.get(key, 0.0))[:5]
    anew = run.anew.filter(name=run.anew["name"][0]).reverse().with_row_index("place")
    anew = anew.with_columns(value=pl.col("satisfied") / pl.col("replicates"))
    with style.look():
        figure = Figure((style.WIDTH, 2.2 * (1 + len(keys) // 3) + 0.9), layout="constrained")
        *panels, again = style.grid(figure, len(keys) + 1, 3)
        for panel, key in zip(panels, keys, strict=True):
            texts = settings[key].cast(pl.String)
            numbers = texts.cast(pl.Float64, strict=False)
            for of, mark, tint in (("search", "o", palette.INK), ("sample", "s", palette.OTHERS["pink"])):
                own = settings["of"] == of
                x = (texts if numbers.null_count() else numbers).filter(own).to_list()
                panel.plot(x, settings["least slack"].filter(own), mark, ms=2.5, alpha=0.6, label=of, color=tint)
            best = settings.filter(of="search").sort("least slack", descending=True, nulls_last=True)[key][0]
            panel.plot([best if numbers.null_count() else float(best)], [settings["least slack"].max()], "*", ms=9,
                       color=palette.INK, label="winner")  # fmt: skip
            panel.axhspan(0.0, max(panel.get_ylim()[1], 0.05), color=palette.VERDICTS["holds"][1], alpha=0.4, lw=0)
            panel.set_title(f"winner: {best}", fontsize=style.SMALL)
            panel.set_xlabel(f"{key} ({shares.get(key, 0.0):.0%})")
        panels[0].set_ylabel("least slack")
        style.intervals(again, anew, anew["place"], ("value", "low", "high"), ms=4, color=palette.INK)
        again.set_yticks(anew["place"], [f"no. {number}" for number in anew["number"]])
        again.set_xlim(-0.02, 1.02)
        again.set_xlabel("share that keeps every claim")
        found = run.fitted["sentences"][0].partition(";")[0]
        style.headline(figure, style.title(found, f"{run.fitted['word']}: the least slack of every setting"))
        style.legend(figure, panels[:1])
        style.caption(figure, "Shaded: every claim holds; star: the winner. In brackets: a parameter's share of the"
                              " slack.", "Last panel: fresh seeds, 95 % intervals.")  # fmt: skip
    return figure


def show(run: Any) -> None:
    """Print the result, the settings judged again, and where everything is."""
    for line in run.fitted["sentences"]:
        console.out_console.print(line)
    console.show(run.anew.filter(name=run.anew["name"][0]), "judged again (anew.csv has each claim)")
    files = {"figure": "fit.png", "settings": "fit.csv", "anew": "anew.csv"}
    console.show_places({name: run.folder / file for name, file in files.items()})

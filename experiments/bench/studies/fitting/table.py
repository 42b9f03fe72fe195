"""Write a fit into its folder, and print it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.table import Table

from experiments.bench.engine.terminal import out_console, show_line, show_places, show_table
from experiments.bench.report.sweep import cell_text
from experiments.bench.store.files import Files, tables_of
from experiments.bench.store.kinds import FIT
from experiments.bench.studies.fitting.fitted import Fitted
from experiments.bench.studies.fitting.optimum import Optimum

ANEW = "anew.csv"
SHOWN = 5
"""Settings judged anew that are printed; `ANEW` has all."""


def write(fitted: Fitted | Optimum, folder: Path) -> None:
    """Write ``fit.csv``, ``anew.csv``, ``fit.json``, ``fit.svg``, ``fit.png`` and ``fit.html``."""
    from experiments.bench.engine.templates import render  # not before: workers do without
    from experiments.bench.figures import plotting
    from experiments.bench.studies.fitting import figure

    files = Files(folder)
    files.write_rows(FIT.summary, fitted.rows())
    files.write_rows(ANEW, fitted.anew_rows())
    files.write_json("fit.json", fitted.described())
    plotting.save(figure.draw(fitted), folder, "fit", tables_of(folder))
    svg = (folder / "fit.svg").read_text(encoding="utf-8")
    header, rows = _anew(fitted, len(fitted.best))
    study = fitted.fit.study
    page = render(
        "studies/fitting/fit.html.j2", name=study.name, summary=study.summary, sentences=fitted.sentences(),
        figure=svg[svg.index("<svg") :], header=header, rows=rows, replicates=fitted.fit.held_out,
        settled=study.assignments, claims=isinstance(fitted, Fitted), failures=len(fitted.failures),
    )  # fmt: skip
    files.write_text("fit.html", page)


def show(fitted: Fitted | Optimum, folder: Path) -> None:
    """Print the answer, the settings judged anew, and where everything is."""
    for line in fitted.sentences():
        show_line(line, 4)
    of = f"in {fitted.fit.held_out} replicates anew"
    title = f"kept in k of {fitted.fit.held_out} replicates anew" if isinstance(fitted, Fitted) else of
    header, rows = _anew(fitted, SHOWN)
    table = Table(box=None, header_style="bold", pad_edge=False, title=title)
    for name in header:
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(*row)
    show_table(table)
    out_console.print()
    places: dict[str, object] = {
        "page": folder / "fit.html", "figure": folder / "fit.png", "settings": folder / FIT.summary,
        "anew": folder / ANEW,
    }  # fmt: skip
    if fitted.failures:
        places["failures"] = folder
    show_places(places)


def _anew(fitted: Fitted | Optimum, most: int) -> tuple[list[str], list[list[str]]]:
    """Return the header and the rows of the table of settings judged anew, the best ``most`` of them."""
    keys = [part.key for part in fitted.box.ranges]
    rows = fitted.anew_rows()
    by_number: dict[Any, list[dict[str, Any]]] = {}
    for row in rows:
        by_number.setdefault(row["number"], []).append(row)
    numbers = list(by_number)
    if isinstance(fitted, Fitted):
        claims = [row["claim"] for row in by_number[numbers[0]]]
        header = ["number", *keys, *claims, "slack in the search", "slack anew"]
        body = [
            [str(number), *(str(chosen[0][key]) for key in keys), *(str(row["kept"]) for row in chosen),
             cell_text(chosen[0]["slack in the search"]), cell_text(chosen[0]["slack anew"])]
            for number, chosen in by_number.items()
        ]  # fmt: skip
        return header, body[:most]
    header = ["number", *keys]
    for goal in fitted.goals:
        header += [f"{goal.name}, search", f"{goal.name}, anew", "95 %"]
    body = []
    for number, chosen in by_number.items():
        cells = ["-" if number is None else str(number), *(str(chosen[0][key]) for key in keys)]
        for row in chosen:
            cells += [cell_text(row["in the search"]), cell_text(row["anew"]), _interval(row)]
        body.append(cells)
    return header, [*body[:-1][:most], body[-1]]


def _interval(row: dict[str, Any]) -> str:
    return "-" if row["low"] is None else f"{cell_text(row['low'])} .. {cell_text(row['high'])}"

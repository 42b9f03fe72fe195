"""Tables of an off-line run on the terminal: potentials of its clips, the verdicts, where everything is."""

from __future__ import annotations

from rich.table import Table

from experiments.bench.clips.summary import OfflineReport
from experiments.bench.engine.terminal import out_console, show_files, show_table, show_verdict


def show(report: OfflineReport, recorded: bool) -> None:
    """Print the peaks of every clip at the first seed, the verdicts, and where everything is."""
    table = Table(title="potentials of each clip, first seed", title_justify="left", box=None, header_style="bold",
                  pad_edge=False)  # fmt: skip
    for name in ("clip", "model", "HS", "VS", "looming", "spikes"):
        table.add_column(name, justify="left" if name in ("clip", "model") else "right", no_wrap=True)
    for row in (row for row in report.rows if row["repeat"] == 0):
        ranges = (f"{row[f'trough_{system}']:+z.3f} .. {row[f'peak_{system}']:+z.3f}" for system in ("hs", "vs"))
        spikes = "-" if row["spikes"] is None else f"{row['spikes']}"
        table.add_row(row["clip"], row["model"], *ranges, f"{row['peak_looming']:.2f}", spikes)
    show_table(table)
    out_console.print()
    for verdict in report.verdicts:
        show_verdict(verdict, model=False)
    names = [*(["figure.png"] if report.rows else []), "trials.parquet", *(["claims.json"] if report.verdicts else [])]
    show_files(report.folder, names, bool(recorded and report.rows))

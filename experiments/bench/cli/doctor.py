"""The command ``colias doctor``. Heavy imports happen when it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli.options import EXIT_FAILED

if TYPE_CHECKING:
    from experiments.bench.doctor.finding import Finding

COLOURS = {"ok": "green", "optional": "dim", "notice": "yellow", "fails": "red"}


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Say whether this machine has what the bench needs, and what to do if not.")(doctor)


def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object, for a report or a script.")] = False,
) -> int:
    """Say whether this machine has what the bench needs: Python, packages, what draws, the network's forms, the viewer.

    A reference frame is drawn and compared with the known ones. One that is not known is a notice: pixels, and so
    numbers, may differ from the documented ones. The exit status is 1 if anything fails; each failure has its remedy.
    """
    from experiments.bench.doctor.run import examine

    findings: list[Finding] = []
    for finding in examine():
        findings.append(finding)
        if not as_json:
            _show(finding)
    failed = sum(finding.status == "fails" for finding in findings)
    if as_json:
        import json
        from dataclasses import asdict

        typer.echo(json.dumps({"ok": not failed, "findings": list(map(asdict, findings))}, indent=2))
    elif failed:
        typer.echo(f"\n{failed} of {len(findings)} fail")
    return EXIT_FAILED if failed else 0


def _show(finding: Finding) -> None:
    from rich.text import Text

    from experiments.bench.engine.terminal import show_line

    sign = Text(f"{finding.status:<8}", COLOURS[finding.status])
    show_line(Text.assemble(sign, f"  {finding.name:<24}{finding.message}"), 34)
    if finding.remedy:
        show_line(f"{'':<34}-> {finding.remedy}", 37)

"""Why C21 does not hold for a detector, in words, from the numbers of its row and of the moving edge."""

from __future__ import annotations

from dataclasses import replace

from experiments.bench.reproduction.detectors.rows import AWAY, DetectorRow, EdgeRow

EVERY_FRAME = 0.9
"""Share of a trial's frames with spikes, from which a count of spikes is the trial's length."""
CEILING = 0.99
"""Potential from which there is nothing above."""
PERIMETER = 40
"""Cells of moving edge in a frame: about the outline of the robot where an approach begins, 20 cm away."""
MOST = 0.9
"""Share of replicates in which a claim that is robust holds."""


def explained(row: DetectorRow, edge: EdgeRow) -> DetectorRow:
    """Return the row with its cause."""
    return replace(row, cause="" if row.held == row.replicates else "; ".join(_parts(row, edge)))


def _parts(row: DetectorRow, edge: EdgeRow) -> list[str]:
    if not any(row.spikes):
        silent = f"silent at every angle: its potential peaks at {max(row.peak):.3f}, below {row.threshold:g}"
        return [silent, *_threshold(row)]
    if all(count >= EVERY_FRAME * frames for count, frames in zip(row.spikes, row.frames, strict=True)):
        return ["spikes in nearly every frame, so that the count is how long the trial lasts", *_threshold(row)]
    return [_more(row, edge), *_ceiling(row), *_threshold(row)]


def _more(row: DetectorRow, edge: EdgeRow) -> str:
    """Which angle it answers more than straight ahead, and how much more edge moves there."""
    most = max(range(1, len(AWAY)), key=lambda index: row.spikes[index])
    cells = edge.cells[most] / edge.cells[0] - 1.0
    frames = edge.frames[PERIMETER][most] - edge.frames[PERIMETER][0]
    return (
        f"{row.spikes[most]:.1f} spikes at {AWAY[most]:g} degrees, {row.spikes[0]:.1f} straight ahead; moving edge "
        f"there {cells:+.1%}, {frames:+.1f} frames with {PERIMETER} cells or more"
    )


def _ceiling(row: DetectorRow) -> list[str]:
    return ["its potential reaches its ceiling at every angle"] if min(row.peak) >= CEILING else []


def _threshold(row: DetectorRow) -> list[str]:
    """Whether a constant of another camera decides."""
    at = f"{row.held_at_best} of {row.replicates} replicates at {row.best_threshold:g}"
    if row.held_at_best >= MOST * row.replicates:
        return [f"the threshold decides: counting frames, it would hold in {at}"]
    if not row.held_at_best:
        return ["counting frames, no threshold from 0.52 to 0.98 would make it hold"]
    return [f"counting frames, no threshold would make it hold in most replicates (at best in {at})"]

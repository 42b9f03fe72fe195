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
        return [
            f"silent at every angle: its potential peaks at {max(row.peak):.3f} on average, below {row.threshold:g}"
        ]
    if all(count >= EVERY_FRAME * frames for count, frames in zip(row.spikes, row.frames, strict=True)):
        return ["spikes in nearly every frame, so that the count is how long the trial lasts", *_threshold(row)]
    return [_order(row), _edge(edge), *_ceiling(row), *_threshold(row)]


def _order(row: DetectorRow) -> str:
    """Which angle it answers more than straight ahead."""
    most = max(range(1, len(AWAY)), key=lambda index: row.spikes[index])
    return f"{row.spikes[most]:.1f} spikes at {AWAY[most]:g} degrees, {row.spikes[0]:.1f} straight ahead"


def _edge(edge: EdgeRow) -> str:
    """How the moving edge differs from that straight ahead."""
    cells = [f"{edge.cells[index] / edge.cells[0] - 1.0:+.1%} at {AWAY[index]:g}" for index in range(1, len(AWAY))]
    frames = edge.frames[PERIMETER]
    more = [f"{frames[index] - frames[0]:+.1f}" for index in range(1, len(AWAY))]
    return (
        f"moving edge against straight ahead: {', '.join(cells)} degrees, {' and '.join(more)} frames with at least "
        f"{PERIMETER} cells of it"
    )


def _ceiling(row: DetectorRow) -> list[str]:
    return ["its potential reaches its ceiling at every angle"] if min(row.peak) >= CEILING else []


def _threshold(row: DetectorRow) -> list[str]:
    """Whether a constant of another camera decides."""
    at = f"{row.held_at_best} of {row.replicates} replicates at {row.best_threshold:g}"
    if row.held_at_best >= MOST * row.replicates:
        return [f"the threshold decides: counting frames it would hold in {at}"]
    if not row.held_at_best:
        return ["no threshold from 0.52 to 0.98 would make it hold"]
    return [f"no threshold would make it hold in most replicates (at best {at})"]

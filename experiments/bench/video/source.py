"""Choice of the recording that a video is made of: a file, or one of a run's folder."""

from __future__ import annotations

import re
from pathlib import Path

from experiments.bench.run.errors import UsageError
from experiments.bench.store.record import part_folders, recordings_in


def recording(source: Path, trial: int | None) -> Path:
    """Find the recording that is meant.

    Parameters
    ----------
    source
        An .rrd file, or the folder of a run.
    trial
        The number of a trial or episode; ``None`` for a file, and for the first one that a folder has.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    UsageError
        If there is none, in one line that says which there are.
    """
    if source.is_file():
        if trial is not None:
            raise UsageError(f"--trial {trial}: {source} is one recording; a run's folder has several")
        return source
    if not source.is_dir():
        raise UsageError(f"{source}: no such file or folder")
    recordings = {_number(path): path for path in recordings_in(source)}
    if not recordings:
        names = ", ".join(part.name for part in part_folders(source))
        parts = f"; its parts are: {names}" if names else ""
        raise UsageError(f"{source}: no .rrd recordings in it; runs make them unless told --no-recordings{parts}")
    if trial is None:
        return next(iter(recordings.values()))
    if trial not in recordings:
        numbers = [number for number in recordings if isinstance(number, int)]
        legal = f"{min(numbers)} .. {max(numbers)}, {len(numbers)} of them" if numbers else "none: they have no numbers"
        raise UsageError(f"--trial {trial}: {source} has no recording of it (recorded: {legal})")
    return recordings[trial]


def _number(path: Path) -> int | str:
    """Return the number in a recording's name; its whole name where there is none."""
    digits = re.fullmatch(r"\D*(\d+)", path.stem)
    return int(digits[1]) if digits else path.stem

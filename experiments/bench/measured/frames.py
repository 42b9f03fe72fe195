"""The frames of a robot's trials: a folder of PGM files, or one raw file, for each trial."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dsnn.pictures import read_picture
from experiments.bench.measured.log import Log, LoggedTrial
from experiments.bench.run.errors import UsageError
from experiments.bench.store.pictures import Images

PGM, RAW = ".pgm", ".raw"


def trial_name(trial: int) -> str:
    """Return the name of a trial's folder, or of its raw file without the ending."""
    return f"trial-{trial:04d}"


@dataclass(frozen=True, slots=True)
class FrameFolder:
    """A folder of trials' frames.

    Parameters
    ----------
    folder
        It holds ``trial-0003/000000.pgm`` and so on, or ``trial-0003.raw``: T frames of R x C bytes, row by row.
    shape
        (R, C) of the frames.
    """

    folder: Path
    shape: tuple[int, int]

    def check(self, log: Log) -> None:
        """Raise `UsageError` where the frames are not those of the log's trials, a file for each line."""
        if not self.folder.is_dir():
            raise UsageError(f"{self.folder}: no such folder of frames")
        known = {trial_name(trial.index) for trial in log.trials}
        for path in sorted(self.folder.iterdir()):
            stem = path.stem if path.suffix == RAW else path.name
            if re.fullmatch(r"trial-\d+", stem) and stem not in known:
                raise UsageError(f"{path}: {log.path} has no such trial")
        for trial in log.trials:
            count, where = self._count(trial, log.path)
            if count != len(trial.time_s):
                problem = f"{count} frames, {log.path}, line {trial.line}, begins a trial of {len(trial.time_s)}"
                raise UsageError(f"{where}: {problem}")

    def read(self, trial: int) -> Images:
        """Read the frames of a trial, (T, R, C); `UsageError` for a file that is none, or has another size."""
        folder, raw = self.folder / trial_name(trial), self.folder / f"{trial_name(trial)}{RAW}"
        if raw.is_file():
            return np.frombuffer(raw.read_bytes(), np.uint8).reshape(-1, *self.shape)
        frames = [self._picture(path) for path in _numbered(folder)]
        return np.stack(frames)

    def _count(self, trial: LoggedTrial, log: Path) -> tuple[int, Path]:
        folder, raw = self.folder / trial_name(trial.index), self.folder / f"{trial_name(trial.index)}{RAW}"
        if raw.is_file() and folder.is_dir():
            raise UsageError(f"{raw}: there is a folder {folder.name} too: which are the trial's frames?")
        if raw.is_file():
            rows, columns = self.shape
            size, one = raw.stat().st_size, rows * columns
            if size % one:
                raise UsageError(f"{raw}: {size} bytes, which is no number of frames of {columns}x{rows} = {one} bytes")
            return size // one, raw
        if not folder.is_dir():
            raise UsageError(f"{folder}: no frames of trial {trial.index} there, which {log} has in line {trial.line}")
        return len(_numbered(folder)), folder

    def _picture(self, path: Path) -> Images:
        picture = read_frame(path)
        if picture.shape != self.shape:
            (rows, columns), (own_rows, own_columns) = self.shape, picture.shape
            problem = (
                f"{own_columns}x{own_rows} px, the camera has {columns}x{rows} (--set camera.width, camera.height)"
            )
            raise UsageError(f"{path}: {problem}")
        return picture


def read_frame(path: Path) -> Images:
    """Read a picture as a camera measured it: 8-bit grey, (R, C); `UsageError` in one line for anything else."""
    try:
        return read_picture(path, raw=True)
    except ValueError as error:
        raise UsageError(str(error)) from None


def _numbered(folder: Path) -> Sequence[Path]:
    """Return the PGM files of a folder, which are numbered from 0 up without a gap."""
    files: dict[int, Path] = {}
    for path in sorted(folder.glob(f"*{PGM}")):
        if path.stem.isdecimal():
            before = files.setdefault(int(path.stem), path)
            if before != path:
                raise UsageError(f"{path}: {before.name} has that number too: which is frame {int(path.stem)}?")
    missing = next((number for number in range(len(files)) if number not in files), None)
    if missing is not None:
        raise UsageError(f"{folder}: frame {missing:06d}{PGM} is missing (it has {len(files)}, to {max(files):06d})")
    return [files[number] for number in range(len(files))]

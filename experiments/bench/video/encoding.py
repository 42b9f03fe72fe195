"""Files of moving pictures, written frame by frame: H.264 in MP4, and GIF."""

from __future__ import annotations

import importlib.util
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from experiments.bench.core.errors import UsageError
from experiments.bench.core.store.places import fresh
from experiments.bench.video.pictures import Picture

Colour = tuple[int, int, int]
EXTRA = "the extra [video] (imageio-ffmpeg is not installed): pip install 'colias-sim[video]'"
QUALITY = "20"
"""x264's constant rate factor: lower is better and larger; 18 to 23 look alike to most."""
COLOURS = 256


def require_encoder(asked: str) -> None:
    """Raise `UsageError` in one line that begins with what was ``asked`` for if the encoder is not installed."""
    if importlib.util.find_spec("imageio_ffmpeg") is None:
        raise UsageError(f"{asked} needs {EXTRA}")


@contextmanager
def writer(
    out: Path,
    size: tuple[int, int],
    rate: float,
    samples: Callable[[], Iterable[Picture]],
    colours: Collection[Colour] = (),
) -> Iterator[Callable[[Picture], None]]:
    """Open a file of moving pictures; yields what takes its frames one after the other.

    Frames go to the encoder at once, so that none is kept. The file has its name once it is whole; until then, and
    after an error, there is none of that name.

    Parameters
    ----------
    out
        ``.mp4`` (H.264, yuv420p, which every browser plays) or ``.gif``.
    size
        Width and height, in pixels; even for ``.mp4``.
    rate
        Frames a second.
    samples
        Makes some of the frames, whose colours a GIF is to have.
    colours
        RGB colours that a GIF has exactly, even if few pixels have them.

    Yields
    ------
    callable
        Takes a frame, (H, W, 3) uint8, RGB.
    """
    import imageio_ffmpeg

    partial = fresh(out.with_name(f".{out.stem}.part{out.suffix}"))
    with tempfile.TemporaryDirectory(prefix="colias-") as folder:
        if out.suffix == ".gif":
            palette = Path(folder) / "palette.png"
            _write_palette(palette, samples(), colours)
            graph = f"movie={palette}[p];[0:v][p]paletteuse=dither=none:diff_mode=rectangle"
            settings: dict[str, Any] = {"codec": "gif", "pix_fmt_out": "pal8", "output_params": ["-lavfi", graph]}
        else:
            shown = ["-crf", QUALITY, "-preset", "medium", "-movflags", "+faststart"]
            settings = {"codec": "libx264", "pix_fmt_out": "yuv420p", "output_params": shown}
        sink = imageio_ffmpeg.write_frames(
            str(partial), size, fps=rate, quality=None, macro_block_size=1, ffmpeg_log_level="error", **settings
        )
        try:
            sink.send(None)

            def take(frame: Picture) -> None:
                sink.send(np.ascontiguousarray(frame))

            yield take
            sink.close()
            partial.replace(out)
        finally:
            sink.close()
            partial.unlink(missing_ok=True)


def _write_palette(path: Path, samples: Iterable[Picture], exact: Collection[Colour]) -> None:
    """Write the 256 colours that some frames need most, as ffmpeg wants them: a picture of 16 by 16."""
    stacked = Image.fromarray(np.vstack([frame[::2, ::2] for frame in samples]))
    fixed = [value for colour in sorted(set(exact)) for value in colour]
    colours = stacked.quantize(COLOURS - len(fixed) // 3, method=Image.Quantize.MEDIANCUT).getpalette() or []
    colours = [*fixed, *colours][: 3 * COLOURS]
    full = np.zeros(3 * COLOURS, np.uint8)
    full[: len(colours)] = colours
    Image.fromarray(full.reshape(16, 16, 3)).save(path)

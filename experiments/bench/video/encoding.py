"""Files of moving pictures, written frame by frame: H.264 in MP4, GIF, and WebP."""

from __future__ import annotations

import contextlib
import errno
import importlib.util
import io
import os
import subprocess
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import IO

import numpy as np
from PIL import Image

from experiments.bench.run.errors import UsageError
from experiments.bench.run.record import Colour
from experiments.bench.store.places import replacing
from experiments.bench.video.pictures import Picture

EXTRA = "the extra [video] (imageio-ffmpeg is not installed): pip install 'colias-sim[video]'"
QUALITY = "20"
"""x264's constant rate factor: lower is better and larger; 18 to 23 look alike to most."""
COLOURS = 256


def require_encoder(asked: str) -> None:
    """Raise `UsageError` in one line that begins with what was ``asked`` for if it cannot be encoded here."""
    if importlib.util.find_spec("imageio_ffmpeg") is None:
        raise UsageError(f"{asked} needs {EXTRA}")


@contextmanager
def writer(
    out: Path,
    size: tuple[int, int],
    rate: float,
    samples: Callable[[], Iterable[Picture]],
    colours: Collection[Colour],
) -> Iterator[Callable[[Picture], None]]:
    """Open a file of moving pictures; yields what takes its frames one after the other.

    Frames go to the encoder at once, so that none is kept. The file has its name once it is whole; until then, and
    after an error, there is none of that name.

    Parameters
    ----------
    out
        ``.mp4`` (H.264, yuv420p, which every browser plays), ``.gif``, or ``.webp``, which plays for ever as a picture.
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

    Raises
    ------
    OSError
        The file cannot be written.
    """
    palette = b""
    with replacing(out) as partial:
        if out.suffix == ".gif":
            palette = _palette(samples(), colours)
            graph = "[0:v][1:v]paletteuse=dither=none:diff_mode=rectangle"
            coding = ["-lavfi", graph, "-c:v", "gif", "-pix_fmt", "pal8", "-f", "gif"]
        elif out.suffix == ".webp":
            coding = ["-c:v", "libwebp_anim", "-pix_fmt", "yuv420p", "-quality", "75", "-loop", "0", "-f", "webp"]
        else:
            coding = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", QUALITY, "-preset", "medium"]
            coding += ["-movflags", "+faststart", "-f", "mp4"]
        process, pipe = _ffmpeg(size, rate, palette, coding, partial)

        def take(frame: Picture) -> None:
            try:
                pipe.write(np.ascontiguousarray(frame).data)
            except BrokenPipeError:
                raise _error(process.wait(), out) from None

        try:
            yield take
            with contextlib.suppress(BrokenPipeError):  # its status says why
                pipe.close()
            if status := process.wait():
                raise _error(status, out)
        except BaseException:
            process.kill()
            with contextlib.suppress(OSError):
                pipe.close()
            process.wait()
            raise


def _error(status: int, out: Path) -> OSError:
    """Return that ffmpeg ended without having written the whole file."""
    return OSError(errno.EIO, f"ffmpeg ended with status {status}", str(out))


def _ffmpeg(
    size: tuple[int, int], rate: float, palette: bytes, coding: Sequence[str], out: Path
) -> tuple[subprocess.Popen[bytes], IO[bytes]]:
    """Start ffmpeg with a ``palette`` (a PNG file, or empty); return it, and the pipe from which it reads frames.

    Ctrl-C is not for it. It ignores the signals that Python ignores, so that too large a file is an error.
    """
    import imageio_ffmpeg

    read, write = os.pipe()
    os.write(write, palette)  # less than a pipe holds
    os.close(write)
    frames = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}"]
    frames += ["-r", f"{Fraction(rate).limit_denominator()}", "-i", "-"]
    colours = ["-f", "png_pipe", "-i", f"pipe:{read}"] if palette else []
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", *frames, *colours, "-an", *coding, "-v", "fatal", f"{out}"]
    try:
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, pass_fds=[read],
            restore_signals=False, process_group=0,
        )  # fmt: skip
    finally:
        os.close(read)
    assert process.stdin is not None
    return process, process.stdin


def _palette(samples: Iterable[Picture], exact: Collection[Colour]) -> bytes:
    """Return the 256 colours that some frames need most, as ffmpeg wants them: a PNG file of 16 by 16 pixels."""
    stacked = Image.fromarray(np.vstack([frame[::2, ::2] for frame in samples]))
    fixed = [value for colour in sorted(set(exact)) for value in colour]
    colours = stacked.quantize(COLOURS - len(fixed) // 3, method=Image.Quantize.MEDIANCUT).getpalette() or []
    colours = [*fixed, *colours][: 3 * COLOURS]
    full = np.zeros(3 * COLOURS, np.uint8)
    full[: len(colours)] = colours
    file = io.BytesIO()
    Image.fromarray(full.reshape(16, 16, 3)).save(file, format="PNG")
    return file.getvalue()

"""A picture file reads as its 8-bit form does, or is refused: whatever its depth, its colours and its turn."""

import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from dsnn.pictures import read_picture

GREY = np.tile(np.linspace(0, 255, 64).round().astype(np.uint8), (48, 1))
DEEP = GREY.astype(np.uint16) * 257
COLOURS = np.dstack([GREY, GREY, GREY])


def tiff(path: Path, bits: int, data: bytes, white: int = 1) -> None:
    """A TIFF of one strip; ``white`` is 0 where 0 is white."""
    tags = ((256, 64), (257, 48), (258, bits), (259, 1), (262, white), (273, 8), (277, 1), (278, 48), (279, len(data)))
    directory = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags)
    path.write_bytes(b"II*\0" + struct.pack("<I", 8 + len(data)) + data + struct.pack("<H", 9) + directory + bytes(4))


def pnm(kind: bytes, white: int, levels: np.ndarray, path: Path) -> None:
    kind_of_number = ">u2" if white > 255 else "u1"
    path.write_bytes(b"%s\n# by hand\n64 48\n%d\n" % (kind, white) + levels.astype(kind_of_number).tobytes())


def pam(white: int, levels: np.ndarray, path: Path) -> None:
    depth = levels.shape[2] if levels.ndim == 3 else 1
    kind = {1: b"GRAYSCALE", 2: b"GRAYSCALE_ALPHA", 3: b"RGB"}[depth]
    header = b"P7\nWIDTH 64\nHEIGHT 48\nDEPTH %d\nMAXVAL %d\nTUPLTYPE %s\nENDHDR\n" % (depth, white, kind)
    path.write_bytes(header + levels.astype(">u2" if white > 255 else "u1").tobytes())


def ascii_pgm(white: int, path: Path) -> None:
    levels = " ".join(str(level) for level in (GREY.astype(int) * white // 255).ravel())
    path.write_text(f"P2\n64 48\n{white}\n{levels}\n")


def packed(bits: int, path: Path) -> None:
    """A TIFF of as many bits a level, one beside the other."""
    levels = GREY.astype(np.uint16) << (bits - 8)
    tiff(path, bits, np.packbits(levels[..., np.newaxis] >> np.arange(bits - 1, -1, -1) & 1).tobytes())


def png(image: np.ndarray, kind: bytes, data: bytes, path: Path) -> None:
    """A PNG with one chunk more after its header."""
    chunk = struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    whole = cv2.imencode(".png", image)[1].tobytes()
    path.write_bytes(whole[:33] + chunk + whole[33:])


def stack(path: Path, **options) -> None:
    pages = [Image.fromarray(np.roll(GREY, shift, axis=1)) for shift in range(3)]
    pages[0].save(path, save_all=True, append_images=pages[1:], **options)


def pillow(image: np.ndarray, path: Path, mode: str = "", **options) -> None:
    made = Image.fromarray(image)
    (made.convert(mode) if mode else made).save(path, **options)


def turned(path: Path) -> None:
    """A picture that is stored with its left side up, and says so."""
    exif = Image.Exif()
    exif[0x112] = 6
    pillow(np.rot90(GREY), path, exif=exif)


OPAQUE = np.dstack([COLOURS, np.full_like(GREY, 255)])
READ = {
    "8.png": lambda path: cv2.imwrite(str(path), GREY),
    "16.png": lambda path: cv2.imwrite(str(path), DEEP),
    "16.tif": lambda path: cv2.imwrite(str(path), DEEP),
    "16-white-is-0.tif": lambda path: tiff(path, 16, (65535 - DEEP).tobytes(), white=0),
    "4.pgm": lambda path: pnm(b"P5", 15, GREY // 17, path),
    "12.pgm": lambda path: pnm(b"P5", 4095, GREY.astype(int) * 4095 // 255, path),
    "10.ppm": lambda path: pnm(b"P6", 1023, COLOURS.astype(int) * 1023 // 255, path),
    "15.pam": lambda path: pam(15, GREY // 17, path),
    "100.pam": lambda path: pam(100, COLOURS.astype(int) * 100 // 255, path),
    "4095.pam": lambda path: pam(4095, GREY.astype(int) * 4095 // 255, path),
    "30000.pam": lambda path: pam(30000, GREY.astype(int) * 30000 // 255, path),
    "4095.pgm": lambda path: ascii_pgm(4095, path),
    "10.tif": lambda path: packed(10, path),
    "12.tif": lambda path: packed(12, path),
    "screen.png": lambda path: png(COLOURS, b"gAMA", struct.pack(">I", 45455), path),
    "palette.png": lambda path: pillow(GREY, path, "P"),
    "cmyk.jpg": lambda path: pillow(COLOURS, path, "CMYK", quality=95),
    "exif.jpg": lambda path: turned(path),
    "opaque.png": lambda path: cv2.imwrite(str(path), OPAQUE),
    "black-16.png": lambda path: cv2.imwrite(str(path), np.zeros_like(DEEP)),
}
COARSE = {"4.pgm": 17, "15.pam": 17, "100.pam": 4, "exif.jpg": 4, "cmyk.jpg": 4}
"""How many grey levels a file may be off: its own steps, or what its compression loses."""


@pytest.mark.parametrize("name", READ)
def test_a_picture_reads_as_its_form_of_8_bits(tmp_path, name):
    READ[name](tmp_path / name)
    expected = np.zeros_like(GREY) if name.startswith("black") else GREY
    picture = read_picture(tmp_path / name)
    assert picture.dtype == np.uint8 and picture.shape == expected.shape
    assert np.abs(picture.astype(int) - expected).max() <= COARSE.get(name, 1)


REFUSED = {
    "12-in-16.png": lambda path: cv2.imwrite(str(path), GREY.astype(np.uint16) * 16),
    "14-in-16.tif": lambda path: cv2.imwrite(str(path), GREY.astype(np.uint16) * 64),
    "float.tif": lambda path: cv2.imwrite(str(path), (GREY / 255).astype(np.float32)),
    "32.tif": lambda path: pillow(GREY.astype(np.int32) * 257, path),
    "alpha.png": lambda path: cv2.imwrite(str(path), np.dstack([COLOURS, GREY])),
    "palette.png": lambda path: pillow(GREY, path, "P", transparency=0),
    "grey-and-key.png": lambda path: pillow(GREY, path, transparency=0),
    "grey-and-alpha.png": lambda path: pillow(np.dstack([GREY, GREY]), path),
    "linear.png": lambda path: png(COLOURS, b"gAMA", struct.pack(">I", 100000), path),
    "pq.png": lambda path: png(COLOURS, b"cICP", bytes([9, 16, 0, 1]), path),
    "hlg.png": lambda path: png(np.dstack([DEEP] * 3), b"cICP", bytes([9, 18, 0, 1]), path),
    "log.png": lambda path: png(COLOURS, b"cICP", bytes([1, 9, 0, 1]), path),
    "pages.tif": lambda path: stack(path),
    "pages.gif": lambda path: stack(path),
    "pages.webp": lambda path: stack(path),
    "alpha.pam": lambda path: pam(255, np.dstack([GREY, GREY]), path),
    "empty.png": lambda path: path.write_bytes(b""),
    "absent.png": lambda path: None,
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_does_not_say_its_greys_is_refused(tmp_path, name):
    REFUSED[name](tmp_path / name)
    with pytest.raises(ValueError, match=name):
        read_picture(tmp_path / name)


def test_a_camera_s_own_levels_are_8_bit_greys_and_no_others(tmp_path):
    for name, image in (("grey", GREY), ("colours", COLOURS), ("deep", DEEP)):
        cv2.imwrite(str(tmp_path / f"{name}.png"), image)
    np.testing.assert_array_equal(read_picture(tmp_path / "grey.png", raw=True), GREY)
    for name in ("colours", "deep"):
        with pytest.raises(ValueError, match="8 bits"):
            read_picture(tmp_path / f"{name}.png", raw=True)

"""Video files are read as they are shown: each has one thing that it says of itself, and its right answer."""

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from av.stream import Disposition

from dsnn import read_video
from dsnn.video import Video

CASES = Path(__file__).parents[1] / "data" / "cases"
SHAPE = (48, 64)
ARROW = np.full(SHAPE, 40, np.uint8)
"""A picture that no mirror and no quarter turn leaves as it is: a bright top, a brighter left half of it."""
ARROW[:16] = 130
ARROW[:16, :32] = 220
ONE = 1 << 16
MATRICES = {
    "upright": (ONE, 0, 0, ONE, lambda image: image),
    "mirrored": (-ONE, 0, 0, ONE, np.fliplr),
    "upside down": (ONE, 0, 0, -ONE, np.flipud),
    "half turn": (-ONE, 0, 0, -ONE, lambda image: np.rot90(image, 2)),
    "quarter turn clockwise": (0, ONE, -ONE, 0, lambda image: np.rot90(image, -1)),
    "quarter turn counter-clockwise": (0, -ONE, ONE, 0, np.rot90),
    "transposed": (0, ONE, ONE, 0, np.transpose),
    "transposed along the other diagonal": (0, -ONE, -ONE, 0, lambda image: np.rot90(image, 2).T),
}


def written(path: Path, images, codec="ffv1", pix_fmt="gray", form="gray", rate=30, times=None, **more) -> str:
    """Write a film; ``more`` has its display matrix, the aspect of its pixels, its range, tags and options."""
    with av.open(str(path), "w", options=more.get("container", {})) as box:
        stream = box.add_stream(codec, rate=rate, options=more.get("options", {}))
        rows, stream.width = images[0].shape[:2]
        stream.height = rows * 2 // 3 if form.startswith("yuv420p") else rows
        stream.pix_fmt = pix_fmt
        stream.codec_context.time_base = Fraction(1, 1000 if times else rate)
        stream.codec_context.sample_aspect_ratio = more.get("aspect", Fraction(1))
        stream.codec_context.color_range = more.get("color_range", 0)
        stream.codec_context.color_trc = more.get("transfer", 2)
        stream.metadata.update(more.get("stream", {}))
        if "matrix" in more:
            a, b, c, d = more["matrix"]
            stream.set_display_matrix([a, b, 0, c, d, 0, 0, 0, 1 << 30])
        packets = []
        for index, image in enumerate(images):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format=form)
            frame.time_base = stream.codec_context.time_base
            frame.pts = times[index] if times else index
            packets += stream.encode(frame)
        for packet in [*packets, *stream.encode()]:
            shift = round(more.get("left_out_s", 0) / packet.time_base)
            packet.pts, packet.dts = packet.pts - shift, packet.dts - shift
            box.mux(packet)
    return str(path)


def read(source) -> tuple[Video, np.ndarray, list[float]]:
    """Read a whole film: itself, its pictures (T, R, C) and their times in seconds."""
    film = read_video(source)
    times, pictures = zip(*film, strict=True)
    return film, np.stack(pictures).astype(int), list(times)


@pytest.mark.parametrize("name", MATRICES)
def test_a_display_matrix_is_obeyed(tmp_path, name):
    *matrix, shown = MATRICES[name]
    source = written(tmp_path / "film.mp4", [ARROW] * 3, "libx264", "yuvj420p", options={"qp": "0"}, matrix=matrix)
    film, pictures, _ = read(source)
    assert film.size == shown(ARROW).shape[::-1] and film.shape == shown(ARROW).shape
    assert np.abs(pictures[1] - shown(ARROW)).max() <= 2


def test_pixels_that_are_not_square_are_shown_as_wide_as_they_are(tmp_path):
    turn = MATRICES["quarter turn clockwise"][:4]
    for matrix, size in ((MATRICES["upright"][:4], (128, 48)), (turn, (48, 64 * 2))):
        path = tmp_path / f"{size[0]}.mov"
        film = read_video(written(path, [ARROW] * 3, "libx264", "yuv420p", matrix=matrix, aspect=Fraction(2)))
        assert film.size[0] / film.size[1] == pytest.approx(size[0] / size[1], rel=0.02), film.size


def combing(pictures: np.ndarray) -> np.ndarray:
    """How far every other row is off its two neighbours, in grey levels, (T,)."""
    return np.abs(pictures[:, 1:-1:2] - (pictures[:, :-2:2] + pictures[:, 2::2]) / 2).mean((1, 2))


def test_two_fields_become_one_picture():
    film, fields, _ = read(CASES / "interlaced.mpg")
    assert combing(fields).max() < combing(read(CASES / "right.mp4")[1]).min()  # as they are stored: 7.5 and 5.6
    assert film.interlaced == len(fields)


RAMP = np.tile(np.linspace(0, 255, 64).round().astype(np.uint8), (48, 1))
LIMITED = np.rint(16 + RAMP * (219 / 255)).astype(np.uint8)
MPEG, JPEG = 1, 2


def with_colours(luma: np.ndarray) -> np.ndarray:
    """The planes of a picture with neutral colours, as a film stores them: luma, and two of a quarter of its size."""
    return np.concatenate([luma, np.full_like(luma, 128)[: len(luma) // 2]])


KINDS = {
    "grey without a range": (RAMP, "ffv1", "gray", 0),
    "grey of full range": (RAMP, "ffv1", "gray", JPEG),
    "grey of limited range": (LIMITED, "ffv1", "gray", MPEG),
    "monochrome HEVC": (LIMITED, "libx265", "gray", MPEG),
    "full range": (with_colours(RAMP), "ffv1", "yuv420p", JPEG),
    "limited range": (with_colours(LIMITED), "ffv1", "yuv420p", MPEG),
    "no range": (with_colours(LIMITED), "mpeg2video", "yuv420p", 0),
    "12 bits": (RAMP.astype(np.uint16) << 4, "ffv1", "gray12le", JPEG),
    "10 bits": (with_colours(LIMITED).astype(np.uint16) << 2, "ffv1", "yuv420p10le", MPEG),
    "AV1": (with_colours(LIMITED), "libsvtav1", "yuv420p", MPEG),
}
OPTIONS = {
    "libx265": {"x265-params": "lossless=1:log-level=none"}, "libsvtav1": {"crf": "1"},
    "mpeg2video": {"qmin": "1", "q": "1"},
}  # fmt: skip


@pytest.mark.parametrize("name", KINDS)
def test_grey_levels_are_those_of_the_range_that_a_film_says(tmp_path, name):
    image, codec, form, color_range = KINDS[name]
    options = OPTIONS.get(codec, {})
    source = written(tmp_path / "film.mkv", [image] * 3, codec, form, form, color_range=color_range, options=options)
    pictures = read(source)[1]
    assert len(pictures) == 3 and np.abs(pictures[0] - RAMP).max() <= (1 if codec in ("ffv1", "libx265") else 4)


@pytest.mark.parametrize("transfer", [1, 2, 4, 5, 6, 13, 14, 15])
def test_a_transfer_function_of_a_screen_changes_nothing(tmp_path, transfer):
    pictures = read(written(tmp_path / "film.mkv", [RAMP] * 2, color_range=JPEG, transfer=transfer))[1]
    np.testing.assert_array_equal(pictures[0], RAMP)


@pytest.mark.parametrize(("transfer", "name"), {8: "linear", 9: "log", 10: "log", 16: "PQ", 18: "HLG"}.items())
def test_a_film_with_another_white_than_a_screen_s_is_refused_by_name(tmp_path, transfer, name):
    with pytest.raises(ValueError, match=name):
        read_video(written(tmp_path / "film.mkv", [ARROW] * 2, transfer=transfer))


def test_levels_of_16_bits_are_known_by_the_brightest_picture_of_a_film(tmp_path):
    deep = ARROW.astype(np.uint16) * 257
    fading = [deep // 20, deep // 5, deep]
    pictures = read(written(tmp_path / "fading.mkv", fading, "ffv1", "gray16le", "gray16le"))[1]
    np.testing.assert_allclose(pictures.max((1, 2)), [11, 44, 220], atol=1)
    for bits in (10, 12, 14):
        for form in ("gray16le", "rgb48le"):
            image = ARROW.astype(np.uint16) << (bits - 8)
            image = np.dstack([image] * 3) if form == "rgb48le" else image
            source = tmp_path / f"{bits}-{form}.mkv"
            written(source, [image] * 3, "ffv1", "gbrp16le" if form == "rgb48le" else form, form)
            with pytest.raises(ValueError, match="fewer bits"):
                read_video(source)
    limited = np.dstack([ARROW.astype(np.uint16) << 4, *np.full((2, 48, 64), 1 << 11, np.uint16)])  # all below black
    with pytest.raises(ValueError, match="fewer bits"):
        read_video(written(tmp_path / "colours.mkv", [limited] * 3, "ffv1", "yuv444p16le", "yuv444p16le"))


def test_exif_beside_a_picture_is_passed_over():
    film, pictures, _ = read(CASES / "exif.avi")
    assert len(pictures) == 12 and film.size == (96, 64)


@pytest.mark.parametrize(("disposition", "tracks"), [(Disposition.default, 2), (Disposition.attached_pic, 1)])
def test_the_films_in_one_file_are_counted_without_covers(tmp_path, disposition, tracks):
    colours = with_colours(ARROW)
    with av.open(str(tmp_path / "film.mp4"), "w") as box:
        streams = [box.add_stream(codec, rate=30) for codec in ("libx264", "mjpeg")]
        for stream, form in zip(streams, ("yuv420p", "yuvj420p"), strict=True):
            stream.width, stream.height, stream.pix_fmt = 64, 48, form
        streams[1].disposition = disposition
        packets = [
            packet
            for stream, count in zip(streams, (3, 1 if disposition == Disposition.attached_pic else 3), strict=True)
            for image in [*[colours] * count, None]
            for packet in stream.encode(None if image is None else av.VideoFrame.from_ndarray(image, stream.pix_fmt))
        ]
        for packet in packets:
            box.mux(packet)
    assert read_video(tmp_path / "film.mp4").tracks == tracks


def test_an_aspect_that_changes_in_the_middle_is_followed(tmp_path):
    for name, aspect in (("one", Fraction(1)), ("two", Fraction(4, 3))):
        written(tmp_path / f"{name}.h264", [ARROW] * 8, "libx264", "yuv420p", aspect=aspect)
    (tmp_path / "both.h264").write_bytes(b"".join((tmp_path / f"{name}.h264").read_bytes() for name in ("one", "two")))
    film = read_video(tmp_path / "both.h264")
    sizes = [film.size for _ in film]
    assert (sizes[0], sizes[-1]) == ((64, 48), (85, 48))


@pytest.mark.parametrize(
    ("codec", "form", "name"), [("qtrle", "argb", "film.mov"), ("libvpx-vp9", "yuva420p", "film.webm")]
)
def test_a_transparent_film_is_refused_and_an_opaque_one_is_read(tmp_path, codec, form, name):
    image = np.dstack([ARROW, ARROW, ARROW, np.full(SHAPE, 255, np.uint8)])
    if codec == "qtrle":
        pictures = read(written(tmp_path / f"opaque {name}", [image] * 2, codec, form, "rgba"))[1]
        assert np.abs(pictures - ARROW).max() <= 1
    image[5, 5, 3] = 0
    with pytest.raises(ValueError, match="transparent"):
        read(written(tmp_path / name, [image] * 2, codec, form, "rgba"))


def test_two_views_and_turns_by_any_angle_are_refused(tmp_path):
    both = written(tmp_path / "both.mkv", [ARROW] * 2, stream={"stereo_mode": "left_right"})
    slanted = written(tmp_path / "slanted.mp4", [ARROW] * 2, "libx264", "yuv420p", matrix=(ONE, ONE, -ONE, ONE))
    for source, problem in ((both, "each eye"), (slanted, "display matrix")):
        with pytest.raises(ValueError, match=problem):
            read_video(source)


def test_what_an_edit_list_leaves_out_is_not_shown(tmp_path):
    images = [np.full(SHAPE, 60 + 2 * i, np.uint8) for i in range(60)]
    container = {"use_editlist": "1", "avoid_negative_ts": "disabled"}
    source = written(tmp_path / "cut.mp4", images, "libx264", "yuvj420p", container=container, left_out_s=20 / 30,
                     options={"qp": "1", "bf": "0"})  # fmt: skip
    film, pictures, times = read(source)
    assert film.length_s == pytest.approx(40 / 30, abs=1e-3)
    np.testing.assert_allclose(pictures.mean((1, 2)), [60 + 2 * i for i in range(20, 60)], atol=1)
    np.testing.assert_allclose(times, np.arange(40) / 30, atol=1e-3)


def test_frames_have_the_times_of_the_film_and_without_time_stamps_those_of_its_rate(tmp_path):
    stamps = [round(1000 / 30 * i) + (20 if i > 10 else 0) for i in range(20)]
    times = read(written(tmp_path / "film.mkv", [ARROW] * 20, times=stamps))[2]
    np.testing.assert_allclose(times, np.array(stamps) / 1000, atol=1e-6)
    film, _, times = read(written(tmp_path / "film.m4v", [ARROW] * 5, "mpeg4", "yuv420p", rate=20))
    np.testing.assert_allclose(times, np.arange(5) / film.fps)


def test_a_frame_that_cannot_be_decoded_is_counted(tmp_path):
    source = Path(written(tmp_path / "film.avi", [ARROW] * 10, "mjpeg", "yuvj420p"))
    data = bytearray(source.read_bytes())
    chunks = [i for i in range(len(data)) if data[i : i + 4] == b"00dc"]
    data[chunks[4] + 8 : chunks[5]] = bytes(chunks[5] - chunks[4] - 8)
    source.write_bytes(data)
    film, pictures, _ = read(source)
    assert (len(pictures), film.damaged) == (9, 1)

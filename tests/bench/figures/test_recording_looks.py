"""What a recording looks like, read back from disk: colours, names of thresholds, wheels, arrows, timelines."""

from __future__ import annotations

import itertools
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import rerun as rr

from colias_sim.envs import ENVS
from dsnn import MODELS, Response, ResponseSeries
from experiments.bench.closed_loop import recording as closed_loop_recording
from experiments.bench.closed_loop.episode import Episode
from experiments.bench.figures.palette import marks
from experiments.bench.figures.series import ends, heading, levels, lines, rgb
from experiments.bench.footage.recording import LONGEST_ARROW_AT, LiveLog, arrow_lengths
from experiments.bench.footage.video import Picture
from experiments.bench.recording import TIMELINE, lanes, page, potentials, recorded
from experiments.bench.run.models import choose

COUNT = 5
LABELS = ("dsnn", "emd", "lgmd1", "hybrid", "t4t5", "lplc2", "mine")


def series() -> ResponseSeries:
    return ResponseSeries.from_responses([Response(0.1, 0.2, 1, 0, None, 0.6, 1, 0.5)] * COUNT)


def static(path: Path) -> dict[str, dict[str, list]]:
    """Entity -> column without its archetype -> values, of what is logged once."""
    entities: dict[str, dict[str, list]] = {}
    for chunk in rr.chunk.RrdReader(path).stream().filter(is_static=True).to_chunks():
        columns = chunk.to_record_batch().to_pydict()
        entities.setdefault(str(chunk.entity_path), {}).update(
            {name.rpartition(":")[2]: values[0] for name, values in columns.items() if ":" in name}
        )
    return entities


def timelines_of(path: Path) -> set[str]:
    chunks = rr.chunk.RrdReader(path).stream().filter(is_static=False).to_chunks()
    return {name for chunk in chunks for name in chunk.to_record_batch().schema.names
            if name in ("time", "sim_time", "frame")}  # fmt: skip


def colour(columns: dict[str, list]) -> tuple[int, ...]:
    """Rerun has colours as one number, the red first."""
    (packed,) = columns["colors"]
    return tuple(packed >> shift & 255 for shift in (24, 16, 8))


def written(path: Path, models=LABELS) -> Path:
    channels = {"lgmd1": ("looming",), "hybrid": ("hs", "vs", "looming", "azimuth")}
    thresholds = {"dsnn": 0.16, "mine": 0.3}
    answers = [
        SimpleNamespace(model=model, channels=channels.get(model, ("hs", "vs")), series=series(),
                        thresholds={"hs": thresholds.get(model, 0.2), "vs": thresholds.get(model, 0.2)})
        for model in models
    ]  # fmt: skip

    def write(recording):
        potentials(recording, answers, np.arange(COUNT) / 30.0)

    path.write_bytes(recorded(write, page(lanes(answers), shares=[1]), "looks"))
    return path


def test_a_model_has_the_colour_of_the_figures_in_all_its_plots(tmp_path):
    held = static(written(tmp_path / "looks.rrd"))
    for model, mark in marks(LABELS).items():
        first = "looming" if model == "lgmd1" else "hs"
        assert {colour(held[f"/{plot}/{model}/{first}"]) for plot in ("potential", "raster")} == {rgb(mark.colour)}
    assert colour(held["/azimuth/hybrid"]) == colour(held["/potential/hybrid/hs"])
    lighter, plain, darker = (sum(colour(held[f"/potential/hybrid/{name}"])) for name in ("vs", "hs", "looming"))
    assert lighter > plain > darker, "other channels are dots in shades of it"


def saturation(rgb_colour: tuple[int, ...]) -> float:
    return max(rgb_colour) - min(rgb_colour)


def test_a_threshold_is_its_model_s_and_has_its_colour_lighter(tmp_path):
    held = static(written(tmp_path / "looks.rrd"))
    names = {columns["names"][0] for entity, columns in held.items() if entity.startswith("/threshold/")}
    assert {
        "threshold 0.16 of dsnn (HS, VS)",
        "threshold -0.16 of dsnn (HS, VS)",
        "threshold 0.3 of mine (HS, VS)",
    } <= names
    for model, mark in marks(LABELS).items():
        tint = rgb(mark.colour)
        for columns in (columns for entity, columns in held.items() if entity.startswith(f"/threshold/{model}/")):
            assert saturation(tint) > 0 and sum(colour(columns)) > sum(tint)
            assert np.argmax(colour(columns)) == np.argmax(tint) and np.argmin(colour(columns)) == np.argmin(tint)
    apart = levels({"hybrid": {"hs": 0.16, "vs": 0.16, "looming": 0.78}})
    assert [(level.value, level.channels) for level in apart] == [
        (-0.16, ("hs", "vs")), (0.16, ("hs", "vs")), (0.78, ("looming",))
    ]  # fmt: skip


def rows_of(path: Path, entity: str) -> dict[str, list]:
    chunks = rr.chunk.RrdReader(path).stream().filter(content=entity, is_static=False).to_chunks()
    columns = [chunk.to_record_batch().select(["frame", "Scalars:scalars"]).to_pydict() for chunk in chunks]
    return {"frame": [frame for batch in columns for frame in batch["frame"]],
            "value": [value for batch in columns for (value,) in batch["Scalars:scalars"]]}  # fmt: skip


def test_spikes_are_marks_where_there_are_some_beyond_every_potential(tmp_path):
    counts = np.array([0, 2, 0, -1, 0])
    given = ResponseSeries.from_responses([Response(1.0, -1.0, int(count), 0) for count in counts])
    answer = SimpleNamespace(model="dsnn", channels=("hs", "vs"), series=given, thresholds={"hs": 0.2, "vs": 0.2})
    path = tmp_path / "spikes.rrd"
    path.write_bytes(
        recorded(
            lambda stream: potentials(stream, [answer], np.arange(COUNT) / 30), page(lanes([answer]), shares=[1]), ""
        )
    )
    marked = rows_of(path, "/raster/dsnn/hs")
    assert marked["frame"] == np.flatnonzero(counts).tolist()
    lowest, highest = ends(answer.channels)
    above, below = marked["value"]
    assert lowest < below < given.vs.min() and given.hs.max() < above < highest
    assert rows_of(path, "/raster/dsnn/vs")["frame"] == []
    assert rows_of(path, "/spikes/dsnn/hs")["value"] == counts.tolist(), "the counts themselves are there to be read"


def test_the_heading_of_a_lane_does_the_work_of_a_legend():
    assert heading("dsnn", ("hs", "vs"), {"hs": 0.2, "vs": 0.2}).startswith(
        "dsnn: HS (line), VS (dots); threshold ±0.2; "
    )
    hybrid = heading("hybrid", ("hs", "looming", "azimuth"), {"hs": 0.2, "looming": 0.7})
    assert "threshold ±0.2 of HS" in hybrid and "threshold 0.7 of looming" in hybrid and "looming (triangles)" in hybrid
    assert heading("emd", ("hs",), {"hs": None}) == "emd: HS (line)"
    narrow = heading("hybrid", ("hs", "looming"), {"hs": 0.2, "looming": 0.7}, narrow=True)
    assert narrow == "hybrid: threshold ±0.2 of HS; threshold 0.7 of looming"
    assert heading("emd", ("hs",), {"hs": None}, narrow=True) == "emd"


@pytest.mark.parametrize("own", [0, 3, 30])
def test_no_two_lines_of_a_lane_look_alike_and_every_lane_is_drawn_alike(own):
    """A model of a later round of hues is not drawn wider: its dots would hide its line."""
    models = [*MODELS, *(f"mine{i}" for i in range(own))]
    for model in models:
        drawn = [line for line in lines(model, ("hs", "vs", "looming"), models) if line.entity.startswith("potential/")]
        assert len({(line.colour, line.dots) for line in drawn}) == len(drawn) == 3
        assert {line.entity.split("/")[1] for line in drawn} == {rr.escape_entity_path_part(model)}
    styles = [line.style() for model in models for line in lines(model, ("hs",), models) if not line.dots]
    assert len({tuple(style.widths.as_arrow_array().to_pylist()) for style in styles}) == 1


def episode(env: str) -> Episode:
    path = np.column_stack([np.arange(COUNT), np.zeros(COUNT), np.zeros(COUNT)]).astype(float)
    nothing = np.zeros((0, 72, 99), np.uint8)
    return Episode("mine", env, SimpleNamespace(), 0, False, np.arange(1, COUNT + 1) / 30.0, {"observer": path},
                   np.full((COUNT, 2), 0.3, np.float32), "dsnn", ("hs", "vs"), series(), np.ones(COUNT),
                   {"reward_ahead": np.ones(COUNT), "reward_touch": np.zeros(COUNT)}, nothing)  # fmt: skip


def test_wheels_and_the_terms_of_the_reward_differ_in_colour(tmp_path):
    (tmp_path / "episode.rrd").write_bytes(closed_loop_recording.record(episode(next(iter(ENVS)))))
    held = static(tmp_path / "episode.rrd")
    for pair in (("wheels/left", "wheels/right"), ("reward/reward_ahead", "reward/reward_touch")):
        one, other = (colour(held[f"/{entity}"]) for entity in pair)
        assert one != other


def test_every_kind_of_recording_has_the_same_timelines(tmp_path):
    (tmp_path / "episode.rrd").write_bytes(closed_loop_recording.record(episode(next(iter(ENVS)))))
    watched = watch(tmp_path / "watched.rrd")
    for path in (written(tmp_path / "looks.rrd"), tmp_path / "episode.rrd", watched):
        assert timelines_of(path) == {TIMELINE, "frame"}


def watch(path: Path) -> Path:
    models = [choose("dsnn"), choose("emd")]
    log = LiveLog.to_file(path, models, (320, 180))
    answer = Response(0.4, -0.1, 1, 0)
    for frame in range(COUNT):
        log.add(Picture(frame, frame / 30.0, np.zeros((180, 320), np.uint8), 0.0, 0.0), [answer, answer])
    log.close()
    return path


def test_arrows_are_wide_on_any_screen_and_no_model_s_lies_on_another_s(tmp_path):
    held = static(watch(tmp_path / "watched.rrd"))
    arrows = {model: held[f"/picture/direction/{model}"] for model in ("dsnn", "emd")}
    assert all(max(arrow["radii"]) <= -2.0 for arrow in arrows.values()), "below 0 are points of the screen"
    assert arrows["dsnn"]["origins"][0] != arrows["emd"]["origins"][0]
    assert colour({"colors": arrows["emd"]["colors"][:1]}) == rgb(marks(["dsnn", "emd"])["emd"].colour)


def test_an_arrow_is_as_long_as_its_potential_up_to_half_the_picture():
    potentials_xy = np.array([[LONGEST_ARROW_AT / 2, 0.0], [0.0, -LONGEST_ARROW_AT], [1.0, 0.0]])
    vectors = arrow_lengths(potentials_xy, (320, 180))
    assert vectors.tolist() == [[45.0, 0.0], [0.0, -90.0], [90.0, 0.0]]
    assert all((a >= b).all() for a, b in itertools.pairwise([np.abs(vectors[2]), np.abs(vectors[0])]))

"""The atlas: a page and a figure of whatever models there are."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from experiments.bench.cli.main import command
from experiments.bench.clips.plan import plan
from experiments.bench.clips.rows import SERIES_SCHEMA
from experiments.bench.leaderboard import atlas, atlas_figure

SVG = "{http://www.w3.org/2000/svg}"


def test_the_columns_are_clips_of_the_robot_s_size():
    assert len({clip.name for clip in atlas.CLIPS}) == len(atlas.CLIPS) == 12
    assert all(clip.build(0).shape == (72, 99) for clip in atlas.CLIPS)


def test_the_atlas_is_one_page_and_goes_on(tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["leaderboard", "--atlas", "--only", "--model", "emd", "--model", "lgmd1", "--workers", "0",
                 "--out", str(out)]  # fmt: skip
    assert command(arguments) == 0
    page = (out / "atlas.html").read_text()
    assert page.count("<tr>") == 2 + 2 + 12 and not re.search(r"(src|href)=\"(?!data:)", page), "self-contained"
    words = {text.text for text in ElementTree.parse(out / "atlas.svg").iter(f"{SVG}text")}
    assert {"emd", "lgmd1"} <= words and (out / "atlas.png").stat().st_size > 1000
    before = (out / "atlas.svg").read_bytes()
    capsys.readouterr()
    assert command(arguments) == 0
    assert "12 of them done already" in capsys.readouterr().err and (out / "atlas.svg").read_bytes() == before


@pytest.mark.parametrize("models", [["dsnn"], ["hybrid", "lplc2", "emd"]])
def test_a_figure_of_failed_models_says_so(models):
    run_plan = plan(atlas.experiment(models), (), (), None, 0)
    drawn = atlas_figure.draw(run_plan, SERIES_SCHEMA.empty_table())
    drawn.draw_without_rendering()
    assert len(drawn.axes) == 12 * (1 + len(models))
    labels = [text.get_text() for axes in drawn.axes for text in axes.texts]
    assert labels == ["failed"] * (12 * len(models))
    assert all(np.isfinite(axes.get_xlim()).all() for axes in drawn.axes)

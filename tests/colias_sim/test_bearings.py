"""Bearings are right positive wherever a user reads one: in tables and on the axes of figures, as HS and the image."""

import re

import pyarrow.parquet as pq

from tests.helpers.condition_figures import drawn


def test_a_figure_has_the_bearings_of_its_table():
    figure = drawn([("rightward", speed, 8.0) for speed in (2.0, 4.0)])
    _, traces = figure.axes
    bearings = [list(line.get_xdata()) for line in traces.get_lines() if len(line.get_xdata()) == 4]
    assert bearings == [[-20.0, -5.0, 5.0, 20.0]] * len(bearings) and bearings
    low, high = traces.get_xlim()
    assert low < -20 and high > 20, "the left is on the left, as in the image"


def test_a_crossing_to_the_right_goes_to_the_right_in_its_table_and_its_figure(colias):
    """It begins on the left, at negative bearings, and HS is positive."""
    quick = ("--set", "experiment.speeds_cm_s=30", "--set", "experiment.direction=rightward", "--repeats", "1")
    done = colias("run", "speed", *quick, "--no-recordings", "--workers", "0", "-q", "--out", "out")
    assert done.returncode == 0, done.stderr
    frames = pq.read_table(colias.folder / "out" / "frames.parquet")
    bearings, hs = (frames[name].to_numpy() for name in ("stimulus_bearing_deg", "hs"))
    assert bearings[0] < -30 and bearings[-1] > 30 and hs[abs(bearings) < 20].mean() > 0
    drawing = (colias.folder / "out" / "figure.svg").read_text(encoding="utf-8")
    # The axis's numbers, with where they stand from left to right.
    ticks = {t: float(x) for x, t in re.findall(r'<text[^>]* x="([\d.]+)"[^>]*>([^<\s]+)</text>', drawing)}
    assert ticks["\N{MINUS SIGN}20"] < ticks["20"], ticks

"""Tests of experiments/bench/video."""

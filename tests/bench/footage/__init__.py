"""Tests of experiments/bench/footage."""

"""Tests of experiments/bench/public."""

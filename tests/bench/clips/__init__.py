"""Tests of experiments/bench/clips."""

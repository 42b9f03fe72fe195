"""Tests of experiments/bench/cli."""

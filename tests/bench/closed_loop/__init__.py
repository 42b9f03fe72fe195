"""Tests of experiments/bench/closed_loop."""

"""Tests of experiments/bench/sources."""

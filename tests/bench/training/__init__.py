"""Tests of experiments/bench/training."""

"""Tests of experiments/bench/engine."""

"""Tests of experiments/bench/figures."""

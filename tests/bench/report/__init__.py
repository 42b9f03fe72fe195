"""Tests of experiments/bench/report."""

"""Tests of experiments/bench/studies/fitting."""

"""Tests of experiments/bench/check."""

"""Tests of experiments/bench/store."""

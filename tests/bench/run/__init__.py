"""Tests of experiments/bench/run."""

"""Tests of experiments/bench/studies."""

"""Tests of experiments/bench/stats."""

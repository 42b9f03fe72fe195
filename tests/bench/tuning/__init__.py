"""Tests of experiments/bench/tuning."""

"""Tests of experiments/bench/robot."""

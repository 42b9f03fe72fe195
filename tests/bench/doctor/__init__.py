"""Tests of experiments/bench/doctor."""

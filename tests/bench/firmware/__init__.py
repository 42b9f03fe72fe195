"""Tests of experiments/bench/firmware."""

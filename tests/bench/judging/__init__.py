"""Tests of experiments/bench/judging."""

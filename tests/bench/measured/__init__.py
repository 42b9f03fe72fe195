"""Tests of experiments/bench/measured."""

"""Tests of `experiments.declare`."""

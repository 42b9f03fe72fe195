"""Tests of `experiments.kinds`."""

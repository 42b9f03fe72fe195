"""Tests of `experiments.base`."""

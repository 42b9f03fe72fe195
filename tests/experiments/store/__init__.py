"""Tests of `experiments.store`."""

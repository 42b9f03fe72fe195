"""Tests of `experiments.show`."""

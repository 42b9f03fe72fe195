"""Tests of `experiments.draw`."""

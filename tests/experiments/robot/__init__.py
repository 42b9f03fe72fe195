"""Tests of `experiments.robot`."""

"""Tests of `experiments.settings`."""

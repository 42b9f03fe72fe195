"""Tests of `experiments.live`."""

"""Tests of `experiments.judge`."""

"""Tests of `experiments.paper`."""

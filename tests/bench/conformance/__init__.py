"""Tests of experiments/bench/conformance."""

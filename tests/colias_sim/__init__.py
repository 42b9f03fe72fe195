"""Tests of colias_sim."""

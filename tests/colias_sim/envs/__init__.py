"""Tests of colias_sim/envs."""

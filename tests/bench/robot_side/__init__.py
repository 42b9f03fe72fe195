"""Tests of experiments/bench/robot_side."""

"""Tests of experiments/bench/leaderboard."""

"""Trials with the robot."""

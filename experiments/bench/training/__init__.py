"""Policies by reinforcement learning."""

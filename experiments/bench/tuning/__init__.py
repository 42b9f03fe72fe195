"""Tuning curves."""

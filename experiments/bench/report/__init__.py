"""Figures over tables, one file a kind, in one style."""

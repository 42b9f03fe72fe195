"""Grids of parameters, run on the same stimuli."""

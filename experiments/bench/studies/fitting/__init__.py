"""Fit parameters to claims: studies whose points a sampler chooses."""

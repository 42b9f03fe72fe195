"""Checks of ``colias doctor`` on a machine."""

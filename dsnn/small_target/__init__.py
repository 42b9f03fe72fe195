"""Detectors of small targets, of a few pixels, that move."""

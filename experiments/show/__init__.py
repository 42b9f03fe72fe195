"""Frames of every kind shown to models, and the rows that they give."""

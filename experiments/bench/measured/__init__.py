"""Trials of a real robot: its log, its frames, and the run that they make."""

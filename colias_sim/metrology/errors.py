"""Errors about frames that lack something."""


class MetrologyError(ValueError):
    """Frames that do not show what is to be measured: what they lack, in one line."""

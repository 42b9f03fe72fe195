"""The version of colias-sim that is installed."""

from importlib.metadata import version

__version__ = version("colias-sim")

"""``python -m experiments.cli``: the command line, as ``colias`` is."""

from experiments.cli import entry

entry.main()

"""``python -m experiments.bench.cli``: the command line, as ``colias`` is."""

from experiments.bench.cli import entry

entry.main()

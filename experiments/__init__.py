"""Experiments with a simulated Colias and fly-inspired vision: run them, declare your own, read what came of them.

The paper's experiments and some beyond it are here, one declaration a file; what they share is in
`experiments.bench`. A file of your own needs this package, `dsnn` and `colias_sim`, never ``experiments.bench``.

A new experiment that ships is a file here that defines ``EXPERIMENT``, and its name in `NAMES` or `OFFLINE`.

Examples
--------
>>> import experiments
>>> run = experiments.run("speed", repeats=2, settings={"dsnn.n_con": 6})
>>> run.claims.to_pylist()
"""

import lazy_loader

NAMES = (
    "general",
    "speed",
    "distance",
    "angular-approach",
    "angular-recession",
    "contrast",
    "clutter",
    "egomotion",
    "ensembles",
    "distance-mechanism",
    "approach-mechanism",
    "recession-mechanism",
)
"""The experiments with the robot."""

OFFLINE = (
    "clean",
    "blocked",
    "clutter-depth",
    "clutter-translation",
    "clutter-speed",
    "clutter-frames",
    "clutter-contrast",
    "street",
    "edges",
    "apparent",
    "background-alone",
    "background",
    "constants-2017",
    "constants-emd",
)
"""The experiments with clips of stimuli."""

# The public names stand in __init__.pyi, which type checkers and editors read too, and are imported when they are first
# asked for: importing this package loads no simulator, no plotting and no recorder. Modules of the bench import this
# package for `NAMES`; an import back would be a circle (tests/package/test_imports.py reads imports alone).
__getattr__, _, _LAZY = lazy_loader.attach_stub(__name__, __file__)
__all__ = ["NAMES", "OFFLINE", *_LAZY]


def __dir__() -> list[str]:
    """List every public name, looked up already or not."""
    return sorted({*globals(), *__all__})

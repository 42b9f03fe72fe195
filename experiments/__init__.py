"""Experiments with a simulated Colias and fly-inspired vision: run them, declare your own, read what came of them.

The paper's experiments with the robot and some beyond it are here, one script a file; those with clips are declared in
`experiments.paper.clips`. What they share is in the folders here. A file of your own needs this package, `dsnn` and
`colias_sim`, never what is in these folders.

A new experiment that ships is a script here, or an entry of ``EXPERIMENTS`` there, and its name in `NAMES` or
`OFFLINE` of `experiments.kinds.tables`.

Examples
--------
>>> import experiments
>>> run = experiments.run("speed", repeats=2, settings={"dsnn.n_con": 6})
>>> run.claims
"""

# The public names stand in __init__.pyi, which type checkers and editors read too. The file is read, and a name
# imported, when one is first asked for. So importing this package loads no simulator, no plotting and no recorder, and
# takes no time before `experiments.cli.entry` sees to Ctrl-C.


def __getattr__(name: str) -> object:
    """Read the public names, put what finds them in this function's place, and import the one asked for."""
    import lazy_loader

    find, _, names = lazy_loader.attach_stub(__name__, __file__)
    globals().update(__getattr__=find, __all__=names)
    return globals()[name] if name == "__all__" else find(name)


def __dir__() -> list[str]:
    """List every public name, looked up already or not."""
    import sys

    return sorted({*globals(), *sys.modules[__name__].__all__})

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

# Names are looked up when they are first asked for, so that importing this package loads no simulator, no plotting and
# no recorder. They are texts, not imports: modules of the bench import this package for `NAMES`, and an import back
# would be a circle (tests/package/test_imports.py reads imports alone). Type checkers and editors read the .pyi file.
_PLACES = {
    "run": "public.run",
    "load": "public.result",
    "Run": "public.result",
    "runs": "public.listing",
    "compare": "public.comparison",
    "Comparison": "public.comparison",
    "watch": "public.footage",
    "Watched": "public.footage",
    "score": "public.episodes",
    "Score": "judging.scores",
    "Behaviour": "closed_loop.behaviour",
    "Wheels": "closed_loop.behaviour",
    "Experiment": "robot.experiment",
    "Condition": "robot.experiment",
    "Translation": "robot.designs",
    "Angular": "robot.designs",
    "General": "robot.designs",
    "Contrast": "robot.designs",
    "Clutter": "robot.designs",
    "Egomotion": "robot.designs",
    "OfflineExperiment": "clips.experiment",
    "Clip": "clips.experiment",
    "Figure": "clips.experiment",
    "Claim": "robot.claims.RobotClaim",
    "ClipClaim": "clips.claims",
    "Study": "studies.study",
    "Axis": "studies.study",
    "Level": "studies.study",
    "Outcome": "judging.verdict",
    "Check": "judging.checks",
    "Verdict": "judging.verdict",
    "decide": "judging.checks",
    "UsageError": "engine.errors",
}
"""Name -> its module below ``experiments.bench``; with the name that it has there where that is another."""

__all__ = [
    "NAMES",
    "OFFLINE",
    "Angular",
    "Axis",
    "Behaviour",
    "Check",
    "Claim",
    "Clip",
    "ClipClaim",
    "Clutter",
    "Comparison",
    "Condition",
    "Contrast",
    "Egomotion",
    "Experiment",
    "Figure",
    "General",
    "Level",
    "OfflineExperiment",
    "Outcome",
    "Run",
    "Score",
    "Study",
    "Translation",
    "UsageError",
    "Verdict",
    "Watched",
    "Wheels",
    "__version__",
    "compare",
    "decide",
    "load",
    "run",
    "runs",
    "score",
    "watch",
]


def __getattr__(name: str) -> object:
    """Look up a public name (PEP 562)."""
    if name == "__version__":
        from importlib.metadata import version

        return version("colias-sim")
    if name not in _PLACES:
        raise AttributeError(f"module 'experiments' has no attribute '{name}'")
    from importlib import import_module

    *module, last = _PLACES[name].split(".")
    if last[0].islower():  # a module, not another name in it
        module, last = [*module, last], name
    value = getattr(import_module(".".join(["experiments.bench", *module])), last)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Every public name, looked up already or not."""
    return sorted({*globals(), *__all__})

"""The plan of an experiment's run, as a call or a command has it."""

from collections.abc import Iterable, Mapping
from typing import Any

from experiments.base.values import by_key, key_values
from experiments.declare.clip import OfflineExperiment
from experiments.declare.experiment import Experiment
from experiments.kinds import registry, result
from experiments.store.asked import Asked
from experiments.store.plan import Plan


def planned(
    experiment: str | Experiment | OfflineExperiment,
    models: Iterable[str] = (),
    settings: Iterable[str] | Mapping[str, Any] = (),
    repeats: int | None = None,
    seed: int = 0,
    **options: Any,
) -> Plan[Any]:
    """Return the plan of an experiment, by its name or as it is; ``models``, where some are given, alone see it."""
    named, models = isinstance(experiment, str), tuple(models)
    declared = registry.find(experiment) if isinstance(experiment, str) else experiment
    values = by_key(settings) if isinstance(settings, Mapping) else key_values(settings)
    return result.plan_of(Asked(
        kind=declared.kind, what=(declared.file or declared.name,) if named else (), models=models, only=bool(models),
        values=values, repeats=repeats, seed=seed, options=options, declared=None if named else declared,
    ))  # fmt: skip

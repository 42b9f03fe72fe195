"""The claims of the models' own papers, as ``model_claims.toml`` has them: words, clips and bounds, without a judge."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Literal, get_args

Check = Literal["each", "none", "ratio", "share", "more", "way", "untested"]
Measure = Literal["spikes", "peak", "way"]
FILE = "model_claims.toml"


@dataclass(frozen=True, slots=True)
class ModelClaim:
    """A statement of a model's own paper that clips can test.

    Parameters
    ----------
    id, says, source
        Its name, its words, and the paper.
    model
        The model that it is about: a registered name, with settings where the claim names them.
    check, measure, bound
        What is asked of which number: see the head of ``model_claims.toml``.
    clips, against, beside
        Groups of clips: those judged, those they are compared with, and those that a silent model does not answer.
    than
        Of the check ``more``: the model that it is compared with.
    why
        Of the check ``untested``: why.

    Raises
    ------
    ValueError
        What it needs for its check is missing.
    """

    id: str
    says: str
    source: str
    model: str
    check: Check
    bound: float
    clips: tuple[str, ...]
    measure: Measure = "spikes"
    against: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    than: str = ""
    why: str = ""

    def __post_init__(self) -> None:
        for name, legal in (("check", get_args(Check)), ("measure", get_args(Measure))):
            if getattr(self, name) not in legal:
                raise ValueError(f"{FILE}: {self.id}: {name}={getattr(self, name)!r}: legal is {', '.join(legal)}")
        needed = {"ratio": "against", "share": "against", "more": "than", "untested": "why", "none": "beside"}
        missing = needed.get(self.check, "clips")
        if not getattr(self, missing):
            raise ValueError(f"{FILE}: {self.id}: {missing} is missing: the check '{self.check}' needs it")

    @property
    def groups(self) -> tuple[str, ...]:
        """All groups of clips that it needs."""
        return tuple(dict.fromkeys((*self.clips, *self.against, *self.beside)))


@cache
def model_claims() -> Mapping[str, tuple[ModelClaim, ...]]:
    """Registered model -> the claims of its own paper, in their order."""
    text = files("experiments.bench.judging").joinpath(FILE).read_text(encoding="utf-8")
    return {
        model: tuple(
            ModelClaim(**{"model": model, "source": room["source"], **_tuples(each)}) for each in room["claims"]
        )
        for model, room in tomllib.loads(text).items()
    }


def _tuples(table: Mapping[str, Any]) -> dict[str, Any]:
    return {name: tuple(value) if isinstance(value, list) else value for name, value in table.items()}

"""What ``--model`` and ``--only`` say, the same on every command: which models are shown, under which settings.

A command has models of its own. ``--model M`` shows M beside them; with ``--only`` the models of ``--model`` are all
that is shown. ``M:PARAM=VALUE,...`` is M with these parameters, under that text as its label: one model can be shown
under several settings at once. ``--set`` applies to a whole family of models; settings after the colon win over it.
"""

from __future__ import annotations

import dataclasses
import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from dsnn import MODELS
from experiments.bench.files import UsageError
from experiments.bench.models import Chosen, choose, family

LEFT_OUT = ("dsnn-reference",)
"""It answers as the DSNN does, slowly: to test against."""
COMPARED = tuple(name for name in MODELS if name not in LEFT_OUT)
"""The own models of the commands that compare models."""

FORM = "expected NAME:PARAM=VALUE or NAME:PARAM=VALUE,PARAM=VALUE, for example dsnn:w_i=1"
_PARAM = r"[A-Za-z_]\w*="


@dataclass(frozen=True, slots=True)
class Asked:
    """A model as it was typed: ``source``, a name or a path, and the text after the colon, empty without one."""

    text: str
    source: str
    settings: str
    own: Mapping[str, str]
    """The settings, name -> text."""


@dataclass(frozen=True, slots=True)
class Shown:
    """A model to show: with its default parameters, its section of ``--set``, and what was asked of it."""

    chosen: Chosen
    section: str
    asked: Asked


def shown_models(own: Sequence[str], given: Sequence[str] | None, only: bool) -> list[str]:
    """The texts of the models that a command shows, each once: its ``own``, unless ``only``, then those ``given``."""
    if only and not given:
        raise UsageError("--only: shows just the models of --model; name them by --model")
    return list(dict.fromkeys([*(() if only else own), *(given or ())]))


def ask(text: str) -> Asked:
    """Take a text of ``--model`` apart; `UsageError` for settings that are not of the form.

    A path ends at its ``.py``, so that it may have colons; a comma begins another setting only before ``NAME=``, so
    that a value may have commas.
    """
    source, colon, settings = _split(text)
    if not colon:
        return Asked(text, text, "", MappingProxyType({}))
    own: dict[str, str] = {}
    for part in re.split(rf",(?={_PARAM})", settings):
        name, _, value = part.partition("=")
        if not re.match(_PARAM, part) or not value:
            raise UsageError(f"--model {text}: {FORM}")
        if name in own:
            raise UsageError(f"--model {text}: {name} is there twice")
        own[name] = value
    return Asked(text, source, settings, MappingProxyType(own))


def _split(text: str) -> tuple[str, str, str]:
    """Source, colon and settings; a source alone has no colon."""
    if text.endswith(".py") and Path(text).is_file():
        return text, "", ""
    after = re.search(rf"\.py:(?={_PARAM})", text)
    if after is None and text.endswith(".py"):
        return text, "", ""
    end = after.start() if after else text.rfind(".py:")
    if end < 0:
        return text.partition(":")
    return text[: end + 3], ":", text[end + 4 :]


def look_up(texts: Sequence[str], tests: Literal["robot", "offline"] = "robot") -> list[Shown]:
    """The models called ``texts``, with their default parameters for these tests.

    The same model under the same settings is taken once. Raises `UsageError` for one that there is not, a parameter
    that it does not have, two models of one name, and a name that is a section of ``--set``.
    """
    found: dict[str, tuple[Chosen, Asked]] = {}
    for text in texts:
        asked = ask(text)
        chosen = choose(asked.source, tests)
        _check_names(asked, chosen)
        if asked.settings:
            chosen = dataclasses.replace(chosen, label=f"{chosen.label}:{asked.settings}")
        before = found.setdefault(chosen.label, (chosen, asked))[0]
        if (before.source, before.network) != (chosen.source, chosen.network):
            raise UsageError(f"--model {text}: another model shown is called {chosen.label} too; rename one of them")
    sections = _sections([chosen for chosen, _ in found.values()])
    return [Shown(chosen, section, asked) for (chosen, asked), section in zip(found.values(), sections, strict=True)]


def _check_names(asked: Asked, chosen: Chosen) -> None:
    known = [field.name for field in dataclasses.fields(chosen.network)]
    for name in asked.own:
        if name not in known:
            near = "".join(f"nearest: {each}; " for each in difflib.get_close_matches(name, known, n=1, cutoff=0.0))
            listed = f"{near}all: colias parameters --only --model {asked.source}"
            raise UsageError(f"--model {asked.text}: {chosen.label} has no parameter '{name}' ({listed})")


def _sections(chosen: Sequence[Chosen]) -> list[str]:
    """The section of each model: its family's name, or its own if another of the family has other parameters."""
    kinds: dict[str, type] = {}
    names = []
    for model in chosen:
        kind, name = type(model.network), family(model.label)
        if kinds.setdefault(name, kind) is not kind:
            name = model.label.partition(":")[0]
        if name in ("robot", "camera", "scene", "experiment"):
            raise UsageError(f"--model {model.label}: that name is a section of --set; give it another")
        names.append(name)
    return names

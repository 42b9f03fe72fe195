"""The models of a run: registered ones by name, a user's own by the path of the file that declares it."""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

from colias_sim.config import CameraConfig, EventConfig, ProcessorConfig
from dsnn import MODELS, ModelEntry, VisionModel, model_entry
from dsnn.model import SPIKING
from experiments.base.errors import UsageError, as_usage_error, check_known
from experiments.base.user_code import declared, is_file, named_file

EVERY_FRAME = ProcessorConfig()


@dataclass(frozen=True, slots=True)
class ConfiguredModel:
    """A model with its parameters, under the ``label`` that tables and figures show.

    It crosses to other processes as its source and the values of its parameters, so that a user's own file is
    found there too.
    """

    label: str
    source: str
    """A registered name, or the absolute path of a .py file."""
    network: Any
    """Parameters of the network, a frozen dataclass."""
    declared: ModelEntry = field(compare=False, repr=False)
    """Entry that the source declared when the model was chosen; its file may be edited since."""
    text: str = field(default="", compare=False, repr=False)
    """The model as typed after ``--model``, with its settings."""
    section: str = field(default="", compare=False, repr=False)
    """Its section of ``--set``."""
    processor: ProcessorConfig = EVERY_FRAME
    """The processor that it runs on, which may skip frames."""

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels it declares: of `dsnn.CHANNELS`."""
        return self.declared.channels

    @property
    def counted(self) -> str:
        """The channel whose spikes are those of a trial: ``hs``, or ``looming`` where no direction is declared."""
        return counted_channel(self.channels)

    @property
    def thresholds(self) -> dict[str, float | None]:
        """Each declared channel's spiking threshold on its potential; ``None`` where it has none."""
        entry = self.declared
        return {channel: entry.threshold(channel, self.network) for channel in entry.channels}

    @property
    def spiking(self) -> tuple[str, ...]:
        """The declared channels that have a spiking threshold: only their spikes are counted."""
        return tuple(channel for channel, threshold in self.thresholds.items() if threshold is not None)

    @property
    def threshold(self) -> float | None:
        """The spiking threshold of the `counted` channel; ``None`` where it has none."""
        return self.thresholds.get(self.counted)

    @property
    def fps(self) -> float | None:
        """The frame rate that its parameters assume; ``None`` where none of them is called ``fps``."""
        rate = getattr(self.network, "fps", None)
        return float(rate) if isinstance(rate, int | float) else None

    def build(self, shape: tuple[int, int]) -> VisionModel:
        """Return the model itself, for frames of ``shape`` (R, C)."""
        return self.declared.build(shape, self.network)

    def __reduce__(self) -> tuple[Any, ...]:
        fields = {
            field.name: getattr(self.network, field.name) for field in dataclasses.fields(self.network) if field.init
        }
        return rebuilt, (self.label, self.source, fields, self.processor)


EYE, CONTROL = "@", "~"
CONTROLS = ("frozen", "absent", "mirrored", "reversed", "shuffled")
"""How a model is shown a trial again: its first frame throughout; without what moves by itself; as in a mirror; last
frame first; in a drawn order."""


OF_CONTROL = f"{CONTROL}({'|'.join(CONTROLS)})$"
"""The end of a label that is a control's."""


def without_control(label: str) -> str:
    """Return the label of the model that a control is of; any other label as it is."""
    return re.sub(OF_CONTROL, "", label)


class Label(NamedTuple):
    """A label of tables, taken apart: ``dsnn@ov7670~frozen``. The eye is a camera preset; empty is the usual one."""

    model: str
    eye: str = ""
    control: str = ""

    def controlled(self, control: str) -> str:
        """Return the label of a control of the same model through the same eye."""
        return f"{self.model}{self.eye and EYE}{self.eye}{CONTROL}{control}"


def parse_label(label: str) -> Label:
    """Take a label of tables apart. Settings of the model, as in ``dsnn:w_i=1``, stay with it."""
    eyes, controls = "|".join(map(re.escape, CameraConfig.presets())), "|".join(CONTROLS)
    parts = re.fullmatch(f"(.*?)(?:{EYE}({eyes}))?(?:{CONTROL}({controls}))?", label, re.DOTALL)
    assert parts is not None, "every label is a model's"
    return Label(*(part or "" for part in parts.groups()))


def event_camera(models: Iterable[ConfiguredModel], config: EventConfig) -> EventConfig | None:
    """Return the settings of the event camera that these models need; ``None`` where all sense frames."""
    return config if any(model.declared.senses == "events" for model in models) else None


def counted_channel(channels: Collection[str]) -> str:
    """Return the channel whose spikes are those of a trial, of those that a model declares; empty if none spikes."""
    return next((channel for channel in SPIKING if channel in channels), "")


def rebuilt(label: str, source: str, fields: Mapping[str, Any], processor: ProcessorConfig) -> ConfiguredModel:
    """Return a model with the values of its parameters, as a worker receives them."""
    entry = load_model(source)
    return ConfiguredModel(label, source, dataclasses.replace(entry.robot, **fields), entry, processor=processor)


NO_SPIKES = "this model does not spike: it has no threshold called t_sp, nor one that ModelEntry.thresholds names"
"""Reason why a model has no count, and no verdict about counts. ``colias check`` finds a model that spikes anyway."""
RATE_TOLERANCE = 0.002
"""Relative difference of frame rates that needs no note: 29.97 frames/s pass for 30."""


def rate_notes(models: Iterable[tuple[ConfiguredModel, float]]) -> list[str]:
    """List the models that assume another frame rate than they receive.

    Parameters
    ----------
    models
        Models, each with a rate of the camera's frames, 1/s, of which its processor may skip some.

    Returns
    -------
    list of str
        A line for each pair of rates, with the first of the models that have it.
    """
    notes: dict[tuple[float, float], list[str]] = {}
    for model, frames_per_s in models:
        rate = frames_per_s / model.processor.every
        if model.fps is not None and abs(rate - model.fps) > RATE_TOLERANCE * model.fps:
            name = model.source if model.label.isdigit() else model.label  # a label is a setting's number in a fit
            notes.setdefault((model.fps, rate), []).append(name)
    lines = []
    for (fps, rate), names in notes.items():
        first, *others = dict.fromkeys(names)
        more = f" and {len(others)} more" if others else ""
        lines.append(f"{first}{more}: {fps:g} frames/s assumed, {rate:g} received")
    return lines


def load_model(source: str) -> ModelEntry:
    """Return the registered model called ``source``, or the one that the file ``source`` declares as ``MODEL``.

    Raises `UsageError` on an unknown name, and on a file that declares no `dsnn.ModelEntry`.
    """
    if not is_file(source):
        with as_usage_error(f"--model {source}: ", ", or a .py file"):
            return model_entry(source)
    return declared(Path(source), "MODEL", ModelEntry)


def choose(
    source: str, tests: Literal["robot", "offline"] = "robot", processor: ProcessorConfig = EVERY_FRAME
) -> ConfiguredModel:
    """Return the model ``source`` with its parameters for the robot's tests, or for the off-line ones."""
    entry = load_model(source)
    absolute = str(Path(source).resolve()) if is_file(source) else source
    return ConfiguredModel(entry.name, absolute, entry.preset(tests), entry, processor=processor)


def family(name: str, kind: type | None = None) -> str:
    """Return the section of ``--set`` that a model's parameters are under: ``dsnn-reference`` is one of the ``dsnn``.

    ``name`` may be a label with settings (``dsnn:w_i=1``), and ``kind`` is the class of its parameters, where that is
    known. A model is of the family of the registered one that its name begins with where both have parameters of one
    class. Any other is a family of its own: ``lplc2-gf`` does not belong to ``lplc2``.
    """
    name_itself = name.partition(":")[0]
    first = name_itself.split("-")[0]
    known = type(MODELS[first].robot) if first in MODELS else None
    if kind is None and name_itself in MODELS:
        kind = type(MODELS[name_itself].robot)
    return first if known is not None and kind in (None, known) else name_itself


COMPARED = tuple(name for name in MODELS if name != "dsnn-reference")
"""The models that commands show which compare models: all but the slow form of the DSNN, which is for tests."""

PRESET = "preset"
"""``SECTION.preset=NAME`` sets several parameters at once: to one of the ``presets()`` of their class."""

_PARAM = r"[A-Za-z_]\w*="
_FILE, _NAME = rf"(?P<file>.+?\.py)(?::(?={_PARAM})(?P<of_file>.*))?", r"(?P<name>[^:]*)(?::(?P<of_name>.*))?"
"""A model as it is typed, with or without settings: a file, whose path may have colons, or a name."""


def shown_models(declared: Sequence[str], given: Sequence[str] | None, only: bool) -> list[str]:
    """Return the models that a command shows, each once: those ``declared``, unless ``only``, then those ``given``."""
    if only and not given:
        raise UsageError("--only: shows just the models of --model; name them by --model")
    return list(dict.fromkeys([*(() if only else declared), *(given or ())]))


def parse_model(text: str) -> tuple[str, dict[str, str]]:
    """Take a text of ``--model`` apart: a name or a path, and the settings, name -> text.

    Raises `UsageError` for settings that are not of the form. A path ends at its ``.py``, so that it may have colons; a
    comma begins another setting only before ``NAME=``, so that a value may have commas.
    """
    parts = re.fullmatch(f"{_FILE}|{_NAME}", text, re.DOTALL)
    assert parts is not None, "the last alternative takes every text"
    source, settings = (parts["file"], parts["of_file"]) if parts["file"] else (parts["name"], parts["of_name"])
    assignments: dict[str, str] = {}
    if settings is None:
        return source, assignments
    for part in re.split(rf",(?={_PARAM})", settings):
        name, _, value = part.partition("=")
        if not re.match(_PARAM, part) or not value:
            raise UsageError(f"--model {text}: expected NAME:PARAM=VALUE,PARAM=VALUE, for example dsnn:w_i=1")
        if name in assignments:
            raise UsageError(f"--model {text}: {name} is there twice")
        assignments[name] = value
    return source, assignments


def named_model(declaring: Path, text: str, where: str) -> str:
    """Return a model named in a user's file, with a path relative to that file made absolute.

    Parameters
    ----------
    declaring
        The user's file.
    text
        A model, as after ``--model``.
    where
        What in the file has the text, for the message.

    Raises
    ------
    UsageError
        There is no such file.
    """
    source, _ = parse_model(text)
    return f"{named_file(declaring, source, where)}{text.removeprefix(source)}" if is_file(source) else text


def presets(value: Any) -> Mapping[str, Any]:
    """Return the presets of the class of some parameters, by name; empty where it has none."""
    named: Mapping[str, Any] = getattr(type(value), "presets", dict)()
    return named


def names(value: Any) -> Iterator[str]:
    """Yield the names of what ``--set`` can change of some parameters."""
    yield from (field.name for field in dataclasses.fields(value))
    if presets(value):
        yield PRESET


def look_up(texts: Sequence[str], tests: Literal["robot", "offline"] = "robot") -> list[ConfiguredModel]:
    """Return the models called ``texts``, with their default parameters for these tests.

    The same model under the same settings is taken once. Raises `UsageError` for one that there is not, a parameter
    that it does not have, two models of one name, and a name that is a section of ``--set``.
    """
    by_label: dict[str, ConfiguredModel] = {}
    for text in texts:
        source, values = parse_model(text)
        chosen = dataclasses.replace(choose(source, tests), text=text)
        known = list(names(chosen.network))
        for name in values:
            check_known(f"--model {text}: parameter", name, known)
        if values:
            chosen = dataclasses.replace(chosen, label=f"{chosen.label}:{text[len(source) + 1 :]}")
        before = by_label.setdefault(chosen.label, chosen)
        if before != chosen:
            raise UsageError(f"--model {text}: another model shown is called {chosen.label} too; rename one of them")
    models = list(by_label.values())
    return [
        dataclasses.replace(model, section=section) for model, section in zip(models, families(models), strict=True)
    ]


def families(chosen: Sequence[ConfiguredModel]) -> list[str]:
    """Return the section of each model: its family's name, or its own if another of the family has other parameters."""
    kinds: dict[str, type] = {}
    found = []
    for model in chosen:
        section = model.declared.name  # a sweep's labels do not begin with it
        kind = type(model.network)
        name = family(section, kind)
        if kinds.setdefault(name, kind) is not kind:
            name = section
        if name in ("robot", "camera", "events", "scene", "processor", "experiment"):
            raise UsageError(f"--model {model.label}: that name is a section of --set; give it another")
        found.append(name)
    return found


def model_texts(models: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> list[str]:
    """Return models, one or several names and paths, as ``--model`` takes them."""
    return [os.fspath(model) for model in ([models] if isinstance(models, str | os.PathLike) else models)]

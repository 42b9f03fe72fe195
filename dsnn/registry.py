"""Look up models by name. To add one, write a file with its class and a line in `_ENTRIES` below."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, Field, model_validator
from pydantic.dataclasses import dataclass

from dsnn.direction.emd import EMD, EMDParams
from dsnn.direction.emd_normalised import EMDNormalised, EMDNormalisedParams
from dsnn.direction.flow import Flow, FlowParams
from dsnn.direction.network import DSNN, ReferenceDSNN
from dsnn.direction.t4t5 import T4T5, T4T5Params
from dsnn.direction.three_arm import ThreeArm, ThreeArmParams
from dsnn.hybrid import Hybrid, HybridParams
from dsnn.looming.lgmd1 import LGMD1, LGMD1Params
from dsnn.looming.lgmd2 import LGMD2, LGMD2Params
from dsnn.looming.lplc2 import LPLC2, LPLC2Params
from dsnn.looming.lplc2_gf import LPLC2GF, LPLC2GFParams
from dsnn.looming.mlplc2 import MLPLC2, MLPLC2Params
from dsnn.looming.pon_lgmd import PONLGMD, PONLGMDParams
from dsnn.looming.si_lgmd1 import SILGMD1, SILGMD1Params
from dsnn.looming.si_lgmd2 import SILGMD2, SILGMD2Params
from dsnn.model import CHANNELS, SPIKING, VisionModel
from dsnn.onboard.model import OnboardDSNN
from dsnn.onboard.params import OnboardParams
from dsnn.params import DSNNParams
from dsnn.small_target.dstmd import DSTMD, DSTMDParams
from dsnn.small_target.estmd import ESTMD, ESTMDParams

Entry = TypeVar("Entry")
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,59}$")]
"""A name that fits tables, figures and folders."""
Channel = Annotated[str, Field(pattern=f"^({'|'.join(CHANNELS)})$")]
DIRECTION = ("hs", "vs")
LOOMING = ("looming",)
TARGET = ("target", "azimuth", "elevation")


def _frozen(value: Any) -> Any:
    """Refuse parameters that are not frozen: a model could change them for all later runs."""
    params = getattr(value, "__dataclass_params__", None)
    if isinstance(value, type) or params is None or not params.frozen:
        raise ValueError("must be an instance of a frozen dataclass")
    return value


Parameters = Annotated[Any, AfterValidator(_frozen)]
Build = Callable[[tuple[int, int], Any], VisionModel]
"""Makes a model from the shape of its frames and its parameters."""


@dataclass(frozen=True)
class ModelEntry:
    """A registered model: how to build it, its parameters and its channels.

    Parameters
    ----------
    name
        Up to 60 letters, digits, ``.``, ``-`` and ``_``.
    summary
        A line for ``colias list``.
    build
        Makes the model from the shape (R, C) of its frames and from parameters.
    robot
        Parameters for robot trials: a frozen, validated dataclass.
    channels
        Fields of a `Response` that the model fills in, of `dsnn.CHANNELS`. Others are ignored.
    offline
        Parameters for off-line clips; ``None`` for the robot's.
    thresholds
        Channel -> the name of the parameter that is its spike threshold, if it is not ``t_sp``.

    Raises
    ------
    pydantic.ValidationError
        The name has other characters, a channel is unknown, or a value has the wrong type.

    Examples
    --------
    >>> from dsnn import LGMD1, LGMD1Params, ModelEntry
    >>> entry = ModelEntry("mine", "LGMD1 that ignores weak groups", LGMD1, LGMD1Params(t_g=40.0), ("looming",))
    >>> entry.threshold("looming", entry.robot)
    0.78
    """

    name: Name
    summary: str
    build: Build
    robot: Parameters
    channels: Annotated[tuple[Channel, ...], Field(min_length=1)] = DIRECTION
    offline: Parameters | None = None
    thresholds: Mapping[str, str] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _consistent(self) -> ModelEntry:
        if len(set(self.channels)) < len(self.channels):
            raise ValueError(f"channels must be one or more, each once, got {self.channels}")
        for channel, name in self.thresholds.items():
            if channel not in SPIKING or channel not in self.channels or not hasattr(self.robot, name):
                raise ValueError(f"thresholds must name channels that spike and parameters, got {channel}: {name}")
        return self

    @property
    def senses(self) -> str:
        """What ``step`` receives, as ``build`` declares by an attribute of that name: ``frames`` or ``events``.

        Events are those of an event camera since the last step: a structured array (N,) in order of time, of ``t`` (s),
        ``x``, ``y`` (px) and ``polarity`` (1 ON, -1 OFF).
        """
        return getattr(self.build, "senses", "frames")

    def threshold(self, channel: str, params: Any) -> float | None:
        """Find the spike threshold of a channel.

        Parameters
        ----------
        channel
            One of `dsnn.CHANNELS`.
        params
            Parameters of this model.

        Returns
        -------
        float or None
            The threshold on the channel's potential; ``None`` if the channel does not spike.
        """
        if channel not in SPIKING:
            return None
        value = getattr(params, self.thresholds.get(channel, "t_sp"), None)
        return None if value is None else float(value)

    def preset(self, tests: Literal["robot", "offline"]) -> Any:
        """Return the parameters for robot trials or for off-line clips.

        Parameters
        ----------
        tests
            ``robot`` or ``offline``.

        Returns
        -------
        object
            The parameters. Without parameters for clips, both kinds use the robot's.
        """
        return self.robot if tests == "robot" or self.offline is None else self.offline


def _dsnn(name: str, summary: str, build: type[DSNN] = DSNN, **changes: Any) -> ModelEntry:
    """Make an entry of the DSNN's family, with ``changes`` to both presets."""
    return ModelEntry(name, summary, build, DSNNParams.robot(**changes), DIRECTION, DSNNParams.offline(**changes))


def _looming(name: str, summary: str, build: Build, params: Any) -> ModelEntry:
    """Make an entry of a looming detector, with the same parameters for trials and clips."""
    return ModelEntry(name, summary, build, params, LOOMING)


_ENTRIES = (
    _dsnn("dsnn", "directionally selective neural network (Fu et al. 2018)"),
    _dsnn("dsnn-on-blocked", "the DSNN with its ON pathway blocked", on=False),
    _dsnn("dsnn-off-blocked", "the DSNN with its OFF pathway blocked", off=False),
    _dsnn("dsn2017", "its forerunner (Fu and Yue 2017): no FDSR", fdsr=False),
    _dsnn("dsnn-reference", "the DSNN in plain float64 form, to test against", ReferenceDSNN),
    ModelEntry(
        "emd", "array of Hassenstein-Reichardt detectors, not split by polarity (after Iida 2000)", EMD, EMDParams()
    ),
    ModelEntry("flow", "mean dense optical flow, px per frame: the engineer's baseline", Flow, FlowParams()),
    _looming("lgmd1", "looming detector of the locust (Yue and Rind 2006)", LGMD1, LGMD1Params()),
    _looming("lgmd2", "looming detector of the locust, for dark objects (Fu, Hu and Yue 2018)", LGMD2, LGMD2Params()),
    ModelEntry("t4t5", "contrast-normalised T4 and T5 cells at several spacings (Liu and Fu 2025)", T4T5, T4T5Params()),
    ModelEntry(
        "emd-normalised", "detectors as emd's behind a normalisation by local contrast (Drews and others 2020)",
        EMDNormalised, EMDNormalisedParams(),
    ),
    ModelEntry(
        "three-arm", "T4 and T5 cells of three arms, two quadrants (Haag and others 2016)", ThreeArm, ThreeArmParams()
    ),
    ModelEntry("three-arm-4q", "the same with four quadrants: ON meets OFF too", ThreeArm, ThreeArmParams(quadrants=4)),
    _looming("lplc2", "the fly's looming detector for the centre of the view (Hua and others 2022)",
             LPLC2, LPLC2Params()),
    _looming("mlplc2", "the same about where the motion is, on T4 and T5 cells (Liu and Fu 2025)",
             MLPLC2, MLPLC2Params()),
    _looming(
        "lplc2-gf", "an array of LPLC2 cells and a giant fibre that fires (Zhao and others 2023)",
        LPLC2GF, LPLC2GFParams.robot(),
    ),
    _looming(
        "si-lgmd1", "LGMD1 with self-inhibition against translation; as on Colias by its preset firmware",
        SILGMD1, SILGMD1Params(),
    ),
    _looming("si-lgmd2", "LGMD2 with self-inhibition against translation, as on Colias", SILGMD2, SILGMD2Params()),
    _looming("pon-lgmd", "LGMD of motion harmonised with contrast (Fu and Li 2022)", PONLGMD, PONLGMDParams()),
    ModelEntry(
        "hybrid", "DSNN and LGMD1 together, looming gating direction (proposed by Fu et al. 2018)", Hybrid,
        HybridParams.robot(), (*DIRECTION, *LOOMING, "azimuth"), HybridParams.offline(), {"looming": "lgmd_t_sp"},
    ),
    ModelEntry(
        "dsnn-onboard", "the DSNN in whole numbers, as Colias's own processor could run it", OnboardDSNN,
        OnboardParams.robot(), DIRECTION, OnboardParams.offline(),
    ),
    ModelEntry("estmd", "where a dark target of a few pixels moves (Wiederman and others 2008)",
               ESTMD, ESTMDParams(), TARGET),
    ModelEntry("dstmd", "the same, and in which direction (Wang, Peng and Yue 2018)",
               DSTMD, DSTMDParams(), (*TARGET, "target_direction")),
)  # fmt: skip


MODELS: Mapping[str, ModelEntry] = {entry.name: entry for entry in _ENTRIES}
"""The built-in models: name -> `ModelEntry`."""


def model_entry(name: str) -> ModelEntry:
    """Look up a built-in model.

    Parameters
    ----------
    name
        Its name in `MODELS`.

    Returns
    -------
    ModelEntry
        Its entry.

    Raises
    ------
    ValueError
        The model is unknown; the message suggests the most similar name.

    Examples
    --------
    >>> from dsnn import model_entry
    >>> entry = model_entry("lgmd1")
    >>> entry.channels
    ('looming',)
    >>> model = entry.build((72, 99), entry.robot)
    """
    return look_up("model", name, MODELS)


def look_up(kind: str, name: str, known: Mapping[str, Entry]) -> Entry:
    """Return the entry of a name; for an unknown name, a ``ValueError`` that suggests the most similar one."""
    if name not in known:
        near = difflib.get_close_matches(name.lower(), known, 1)
        hint = f" (nearest: {near[0]})" if near else ""
        raise ValueError(f"unknown {kind} '{name}'{hint}: known are {', '.join(known)}")
    return known[name]

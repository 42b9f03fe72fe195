"""The models by name. A new one is a file with its class and a line in `_ENTRIES` below."""

from __future__ import annotations

import dataclasses
import difflib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

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

DIRECTION = ("hs", "vs")
LOOMING = ("looming",)
LONGEST_NAME = 60


@dataclass(frozen=True, slots=True)
class ModelEntry:
    """A registered model: how to build it for frames of shape (R, C), and its parameters on the robot.

    Parameters
    ----------
    name
        Up to 60 letters, digits, ``.``, ``-`` and ``_``.
    summary
        A line for ``colias list``.
    build
        Makes the model from the shape (R, C) of its frames and from parameters.
    robot
        The parameters of the on-board trials: a frozen, validated dataclass.
    source
        The literature that the model is written from.
    channels
        Fields of a `Response` that the model fills in, some of ``hs``, ``vs``, ``looming``, ``azimuth``. Others are
        ignored.
    offline
        The parameters of the off-line tests; None where they are those of the robot.
    thresholds
        Channel -> the name of the parameter that is its spiking threshold, where it is another than ``t_sp``.

    Raises
    ------
    ValueError
        Tables and figures cannot show the name, no `dsnn.Response` has the channels, or a value is of another kind.
    """

    name: str
    summary: str
    build: Callable[[tuple[int, int], Any], VisionModel]
    robot: Any
    source: str = ""
    channels: tuple[str, ...] = DIRECTION
    offline: Any = None
    thresholds: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]*", self.name):
            raise ValueError(f"ModelEntry: name={_short(self.name)}: legal are letters, digits, ., - and _")
        if len(self.name) > LONGEST_NAME:
            raise ValueError(f"ModelEntry: name={_short(self.name)}: legal are up to {LONGEST_NAME} characters")
        declared = self.channels
        if (
            not isinstance(declared, tuple)
            or not declared
            or len(set(declared)) < len(declared)
            or not set(declared) <= set(CHANNELS)
        ):
            raise ValueError(
                f"ModelEntry {self.name}: channels={_short(declared)}: "
                f"legal is a tuple of some of {CHANNELS}, each once"
            )
        if not isinstance(self.summary, str) or not callable(self.build):
            raise ValueError(f"ModelEntry {self.name}: legal are a text for summary and a callable for build")
        for name in ("robot", "offline"):
            value = getattr(self, name)
            if not _is_frozen(value) and (value is not None or name == "robot"):
                raise ValueError(f"ModelEntry {self.name}: {name}={_short(value)}: legal is a frozen dataclass")
        for channel, name in self.thresholds.items():
            if channel not in SPIKING or channel not in declared or not hasattr(self.robot, name):
                problem = (
                    f"thresholds={_short({channel: name})}: legal is a declared channel that spikes, and a parameter"
                )
                raise ValueError(f"ModelEntry {self.name}: {problem}")

    def threshold(self, channel: str, params: Any) -> float | None:
        """Find the spiking threshold of a channel.

        Parameters
        ----------
        channel
            One of `dsnn.CHANNELS`.
        params
            Parameters of this model.

        Returns
        -------
        float or None
            The threshold on the channel's potential; ``None`` where the channel does not spike.
        """
        if channel not in SPIKING:
            return None
        value = getattr(params, self.thresholds.get(channel, "t_sp"), None)
        return None if value is None else float(value)

    def preset(self, tests: Literal["robot", "offline"]) -> Any:
        """Return the parameters for a kind of tests.

        Parameters
        ----------
        tests
            Trials with the robot, or off-line clips.

        Returns
        -------
        object
            The parameters: ``robot``, or ``offline`` where the model has some for clips.

        Raises
        ------
        ValueError
            It is another word.
        """
        if tests not in ("robot", "offline"):
            raise ValueError(f"unknown preset '{tests}' of '{self.name}': known are robot, offline")
        return self.robot if tests == "robot" or self.offline is None else self.offline


def _is_frozen(value: Any) -> bool:
    """Tell whether it is an instance of a frozen dataclass: what a model changed in its parameters would last."""
    if isinstance(value, type) or not dataclasses.is_dataclass(value):
        return False
    return bool(getattr(type(value), "__dataclass_params__").frozen)  # noqa: B009 (mypy does not know it)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


_DSNN = "Fu, Bellotto and Yue 2018, arXiv 1808.07692"
_DSN2017 = "Fu and Yue 2017, IJCNN, as the paper of the DSNN tells of it"


def _dsnn(
    name: str, summary: str, source: str = _DSNN, build: type[DSNN | ReferenceDSNN] = DSNN, **changes: Any
) -> ModelEntry:
    """Return a member of the DSNN's family, ``changes`` made to both of its presets."""
    robot, offline = DSNNParams.robot(**changes), DSNNParams.offline(**changes)
    return ModelEntry(name, summary, build, robot, source, DIRECTION, offline)


_SELF_INHIBITION = (
    "Modeling self-inhibition in neural networks for collision perception against translating motion, public firmware"
)
_THREE_ARM = "Haag, Arenz, Serbe, Gabbiani and Borst 2016, eLife 5:e17421; Haag, Mishra and Borst 2017, eLife 6:e29044"


_ENTRIES = (
    _dsnn("dsnn", "directionally selective neural network (Fu et al. 2018)"),
    _dsnn("dsnn-on-blocked", "the DSNN with its ON pathway blocked", on=False),
    _dsnn("dsnn-off-blocked", "the DSNN with its OFF pathway blocked", off=False),
    _dsnn("dsn2017", "its forerunner (Fu and Yue 2017): no FDSR", _DSN2017, fdsr=False),
    _dsnn("dsnn-reference", "the DSNN in plain float64 form, to test against", build=ReferenceDSNN),
    ModelEntry(
        "emd",
        "array of Hassenstein-Reichardt detectors, not split by polarity (after Iida 2000)",
        EMD,
        EMDParams(),
        "Hassenstein and Reichardt 1956; Iida and Lambrinos 2000",
    ),
    ModelEntry(
        "flow",
        "mean dense optical flow, px per frame: the engineer's baseline",
        Flow,
        FlowParams(),
        "Kroeger, Timofte, Dai and Van Gool 2016, ECCV (DIS), as OpenCV has it",
    ),
    ModelEntry(
        "lgmd1",
        "looming detector of the locust (Yue and Rind 2006)",
        LGMD1,
        LGMD1Params(),
        "Yue and Rind 2006, IEEE Transactions on Neural Networks 17",
        LOOMING,
    ),
    ModelEntry(
        "lgmd2",
        "looming detector of the locust, for dark objects (Fu, Hu and Yue 2018)",
        LGMD2,
        LGMD2Params(),
        "Fu, Hu and Yue 2018, arXiv 1801.06452",
        LOOMING,
    ),
    ModelEntry(
        "t4t5",
        "contrast-normalised T4 and T5 cells at several spacings (Liu and Fu 2025)",
        T4T5,
        T4T5Params(),
        "Liu and Fu 2025, arXiv 2504.04477",
    ),
    ModelEntry(
        "emd-normalised",
        "detectors as emd's behind a normalisation by local contrast (Drews and others 2020)",
        EMDNormalised,
        EMDNormalisedParams(),
        "Drews and others 2020, Current Biology 30:209",
    ),
    ModelEntry(
        "three-arm",
        "T4 and T5 cells of three arms, two quadrants (Haag and others 2016)",
        ThreeArm,
        ThreeArmParams(),
        _THREE_ARM,
    ),
    ModelEntry(
        "three-arm-4q",
        "the same with four quadrants: ON meets OFF too",
        ThreeArm,
        ThreeArmParams(quadrants=4),
        _THREE_ARM,
    ),
    ModelEntry(
        "lplc2",
        "the fly's looming detector for the centre of the view (Hua and others 2022)",
        LPLC2,
        LPLC2Params(),
        "Hua, Fu, Peng, Yue and Luan 2022, IJCNN",
        LOOMING,
    ),
    ModelEntry(
        "mlplc2",
        "the same about where the motion is, on T4 and T5 cells (Liu and Fu 2025)",
        MLPLC2,
        MLPLC2Params(),
        "Liu and Fu 2025, arXiv 2504.04477",
        LOOMING,
    ),
    ModelEntry(
        "lplc2-gf",
        "an array of LPLC2 cells and a giant fibre that fires (Zhao and others 2023)",
        LPLC2GF,
        LPLC2GFParams.robot(),
        "Zhao, Xi, Li, Guo and Wu 2023, iScience 26:106337",
        LOOMING,
    ),
    ModelEntry(
        "si-lgmd1",
        "LGMD1 with self-inhibition against translation; as on Colias by its preset firmware",
        SILGMD1,
        SILGMD1Params(),
        _SELF_INHIBITION,
        LOOMING,
    ),
    ModelEntry(
        "si-lgmd2",
        "LGMD2 with self-inhibition against translation, as on Colias",
        SILGMD2,
        SILGMD2Params.firmware(),
        _SELF_INHIBITION,
        LOOMING,
    ),
    ModelEntry(
        "pon-lgmd",
        "LGMD of motion harmonised with contrast (Fu and Li 2022)",
        PONLGMD,
        PONLGMDParams(),
        "Fu and Li 2022, Harmonizing motion and contrast vision for robust looming detection",
        LOOMING,
    ),
    ModelEntry(
        "hybrid",
        "DSNN and LGMD1 together, looming gating direction (proposed by Fu et al. 2018)",
        Hybrid,
        HybridParams.robot(),
        f"{_DSNN}, discussion; Yue and Rind 2006",
        (*DIRECTION, *LOOMING, "azimuth"),
        HybridParams.offline(),
        {"looming": "lgmd_t_sp"},
    ),
    ModelEntry(
        "dsnn-onboard",
        "the DSNN in whole numbers, as Colias's own processor could run it",
        OnboardDSNN,
        OnboardParams.robot(),
        f"{_DSNN}; the formats are our own",
        DIRECTION,
        OnboardParams.offline(),
    ),
)


def _by_name(entries: tuple[ModelEntry, ...]) -> Mapping[str, ModelEntry]:
    table = {entry.name: entry for entry in entries}
    if len(table) != len(entries):
        raise ValueError(f"two models share a name in {[entry.name for entry in entries]}")
    return MappingProxyType(table)


MODELS = _by_name(_ENTRIES)
"""The models that ship: name -> `ModelEntry`."""


def model_entry(name: str) -> ModelEntry:
    """Look up a model that ships.

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
        There is no such model; the message has the nearest known name.
    """
    if name not in MODELS:
        near = difflib.get_close_matches(name.lower(), MODELS, 1)
        hint = f" (nearest: {near[0]})" if near else ""
        raise ValueError(f"unknown model '{name}'{hint}: known are {', '.join(MODELS)}")
    return MODELS[name]

"""Vision models: the DSNN of Fu, Bellotto and Yue (2018), the models it is compared with, and their common interface.

>>> from dsnn import DSNN, DSNNParams
>>> model = DSNN((72, 99), DSNNParams.robot())
>>> response = model.step(frame)          # frame: uint8 grey (72, 99)
>>> response.hs, response.hs_spikes
"""

from typing import TYPE_CHECKING, Any

from dsnn.direction.emd import EMD, EMDParams
from dsnn.direction.emd_normalised import EMDNormalised, EMDNormalisedParams
from dsnn.direction.flow import Flow, FlowParams
from dsnn.direction.network import DSNN, ReferenceDSNN
from dsnn.direction.t4t5 import T4T5, T4T5Params
from dsnn.direction.three_arm import ThreeArm, ThreeArmParams
from dsnn.frames import FrameError
from dsnn.hybrid import Hybrid, HybridParams
from dsnn.looming.lgmd1 import LGMD1, LGMD1Params
from dsnn.looming.lgmd2 import LGMD2, LGMD2Params
from dsnn.looming.lplc2 import LPLC2, LPLC2Params
from dsnn.looming.lplc2_gf import LPLC2GF, LPLC2GFParams
from dsnn.looming.mlplc2 import MLPLC2, MLPLC2Params
from dsnn.looming.pon_lgmd import PONLGMD, PONLGMDParams
from dsnn.looming.si_lgmd1 import SILGMD1, SILGMD1Params
from dsnn.looming.si_lgmd2 import SILGMD2, SILGMD2Params
from dsnn.model import CHANNELS, LayerMaps, Response, ResponseSeries, VisionModel
from dsnn.onboard.model import OnboardDSNN
from dsnn.onboard.params import OnboardParams
from dsnn.params import DSNNParams
from dsnn.registry import MODELS, ModelEntry, model_entry
from dsnn.responses import ResponseError, checked_response

if TYPE_CHECKING:
    from dsnn.video import read_video

__all__ = [
    "CHANNELS",
    "DSNN",
    "EMD",
    "LGMD1",
    "LGMD2",
    "LPLC2",
    "LPLC2GF",
    "MLPLC2",
    "MODELS",
    "PONLGMD",
    "SILGMD1",
    "SILGMD2",
    "T4T5",
    "DSNNParams",
    "EMDNormalised",
    "EMDNormalisedParams",
    "EMDParams",
    "Flow",
    "FlowParams",
    "FrameError",
    "Hybrid",
    "HybridParams",
    "LGMD1Params",
    "LGMD2Params",
    "LPLC2GFParams",
    "LPLC2Params",
    "LayerMaps",
    "MLPLC2Params",
    "ModelEntry",
    "OnboardDSNN",
    "OnboardParams",
    "PONLGMDParams",
    "ReferenceDSNN",
    "Response",
    "ResponseError",
    "ResponseSeries",
    "SILGMD1Params",
    "SILGMD2Params",
    "T4T5Params",
    "ThreeArm",
    "ThreeArmParams",
    "VisionModel",
    "checked_response",
    "model_entry",
    "read_video",
]


def __getattr__(name: str) -> Any:
    """Import the reader of videos at its first use: FFmpeg takes half as long to load as everything else."""
    if name == "read_video":
        from dsnn.video import read_video

        return read_video
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

"""The public names and where they are defined: read by ``__init__.py`` at run time, by type checkers and by editors."""

from .direction.emd import EMD as EMD, EMDParams as EMDParams
from .direction.emd_normalised import EMDNormalised as EMDNormalised, EMDNormalisedParams as EMDNormalisedParams
from .direction.flow import Flow as Flow, FlowParams as FlowParams
from .direction.network import DSNN as DSNN, ReferenceDSNN as ReferenceDSNN
from .direction.t4t5 import T4T5 as T4T5, T4T5Params as T4T5Params
from .direction.three_arm import ThreeArm as ThreeArm, ThreeArmParams as ThreeArmParams
from .frames import FrameError as FrameError
from .hybrid import Hybrid as Hybrid, HybridParams as HybridParams
from .looming.lgmd1 import LGMD1 as LGMD1, LGMD1Params as LGMD1Params
from .looming.lgmd2 import LGMD2 as LGMD2, LGMD2Params as LGMD2Params
from .looming.lplc2 import LPLC2 as LPLC2, LPLC2Params as LPLC2Params
from .looming.lplc2_gf import LPLC2GF as LPLC2GF, LPLC2GFParams as LPLC2GFParams
from .looming.mlplc2 import MLPLC2 as MLPLC2, MLPLC2Params as MLPLC2Params
from .looming.pon_lgmd import PONLGMD as PONLGMD, PONLGMDParams as PONLGMDParams
from .looming.si_lgmd1 import SILGMD1 as SILGMD1, SILGMD1Params as SILGMD1Params
from .looming.si_lgmd2 import SILGMD2 as SILGMD2, SILGMD2Params as SILGMD2Params
from .model import (
    CHANNELS as CHANNELS,
    LayerMaps as LayerMaps,
    Response as Response,
    ResponseSeries as ResponseSeries,
    VisionModel as VisionModel,
)
from .onboard.model import OnboardDSNN as OnboardDSNN
from .onboard.params import OnboardParams as OnboardParams
from .params import DSNNParams as DSNNParams
from .registry import MODELS as MODELS, ModelEntry as ModelEntry, model_entry as model_entry
from .responses import ResponseError as ResponseError, checked_response as checked_response
from .small_target.dstmd import DSTMD as DSTMD, DSTMDParams as DSTMDParams
from .small_target.estmd import ESTMD as ESTMD, ESTMDParams as ESTMDParams
from .video import read_video as read_video

__all__ = [
    "CHANNELS",
    "DSNN",
    "DSTMD",
    "EMD",
    "ESTMD",
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
    "DSTMDParams",
    "EMDNormalised",
    "EMDNormalisedParams",
    "EMDParams",
    "ESTMDParams",
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

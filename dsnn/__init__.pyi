"""The public names and where they are defined: read by ``__init__.py`` at run time, by type checkers and by editors."""

from .direction.emd import EMD as EMD
from .direction.emd import EMDParams as EMDParams
from .direction.emd_normalised import EMDNormalised as EMDNormalised
from .direction.emd_normalised import EMDNormalisedParams as EMDNormalisedParams
from .direction.flow import Flow as Flow
from .direction.flow import FlowParams as FlowParams
from .direction.network import DSNN as DSNN
from .direction.network import ReferenceDSNN as ReferenceDSNN
from .direction.t4t5 import T4T5 as T4T5
from .direction.t4t5 import T4T5Params as T4T5Params
from .direction.three_arm import ThreeArm as ThreeArm
from .direction.three_arm import ThreeArmParams as ThreeArmParams
from .frames import FrameError as FrameError
from .hybrid import Hybrid as Hybrid
from .hybrid import HybridParams as HybridParams
from .looming.lgmd1 import LGMD1 as LGMD1
from .looming.lgmd1 import LGMD1Params as LGMD1Params
from .looming.lgmd2 import LGMD2 as LGMD2
from .looming.lgmd2 import LGMD2Params as LGMD2Params
from .looming.lplc2 import LPLC2 as LPLC2
from .looming.lplc2 import LPLC2Params as LPLC2Params
from .looming.lplc2_gf import LPLC2GF as LPLC2GF
from .looming.lplc2_gf import LPLC2GFParams as LPLC2GFParams
from .looming.mlplc2 import MLPLC2 as MLPLC2
from .looming.mlplc2 import MLPLC2Params as MLPLC2Params
from .looming.pon_lgmd import PONLGMD as PONLGMD
from .looming.pon_lgmd import PONLGMDParams as PONLGMDParams
from .looming.si_lgmd1 import SILGMD1 as SILGMD1
from .looming.si_lgmd1 import SILGMD1Params as SILGMD1Params
from .looming.si_lgmd2 import SILGMD2 as SILGMD2
from .looming.si_lgmd2 import SILGMD2Params as SILGMD2Params
from .model import CHANNELS as CHANNELS
from .model import LayerMaps as LayerMaps
from .model import Response as Response
from .model import ResponseSeries as ResponseSeries
from .model import VisionModel as VisionModel
from .onboard.model import OnboardDSNN as OnboardDSNN
from .onboard.params import OnboardParams as OnboardParams
from .params import DSNNParams as DSNNParams
from .registry import MODELS as MODELS
from .registry import ModelEntry as ModelEntry
from .registry import model_entry as model_entry
from .responses import ResponseError as ResponseError
from .responses import checked_response as checked_response
from .small_target.dstmd import DSTMD as DSTMD
from .small_target.dstmd import DSTMDParams as DSTMDParams
from .small_target.estmd import ESTMD as ESTMD
from .small_target.estmd import ESTMDParams as ESTMDParams
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

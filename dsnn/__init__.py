"""Vision models: the DSNN of Fu, Bellotto and Yue (2018), its rivals, and what any model must offer beside them.

>>> from dsnn import DSNN, DSNNParams
>>> model = DSNN((72, 99), DSNNParams.robot())
>>> response = model.step(frame)          # frame: uint8 grey (72, 99)
>>> response.hs, response.hs_spikes
"""

from dsnn.answers import AnswerError, checked_answer
from dsnn.direction.emd import EMD, EMDParams
from dsnn.direction.flow import Flow, FlowParams
from dsnn.direction.network import DSNN
from dsnn.direction.reference import ReferenceDSNN
from dsnn.frames import FrameError
from dsnn.hybrid import Hybrid, HybridParams
from dsnn.looming.lgmd1 import LGMD1, LGMD1Params
from dsnn.looming.lgmd2 import LGMD2, LGMD2Params
from dsnn.model import CHANNELS, LayerMaps, Response, ResponseSeries, VisionModel
from dsnn.params import DSNNParams
from dsnn.registry import MODELS, ModelEntry, model_entry

__all__ = [
    "CHANNELS",
    "DSNN",
    "EMD",
    "LGMD1",
    "LGMD2",
    "MODELS",
    "AnswerError",
    "DSNNParams",
    "EMDParams",
    "Flow",
    "FlowParams",
    "FrameError",
    "Hybrid",
    "HybridParams",
    "LGMD1Params",
    "LGMD2Params",
    "LayerMaps",
    "ModelEntry",
    "ReferenceDSNN",
    "Response",
    "ResponseSeries",
    "VisionModel",
    "checked_answer",
    "model_entry",
]

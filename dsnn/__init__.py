"""Vision models: the DSNN of Fu, Bellotto and Yue (2018), its rivals, and what any model must offer beside them.

>>> from dsnn import DSNN, DSNNParams
>>> model = DSNN((72, 99), DSNNParams.robot())
>>> response = model.step(frame)          # frame: uint8 grey (72, 99)
>>> response.hs, response.hs_spikes
"""

from dsnn.emd import EMD, EMDParams
from dsnn.flow import Flow, FlowParams
from dsnn.frames import FrameError
from dsnn.lgmd1 import LGMD1, LGMD1Params
from dsnn.lgmd2 import LGMD2, LGMD2Params
from dsnn.model import LayerMaps, Response, ResponseSeries, VisionModel
from dsnn.network import DSNN
from dsnn.params import DSNNParams
from dsnn.reference import ReferenceDSNN
from dsnn.registry import MODELS, ModelEntry, model_entry

__all__ = [
    "DSNN",
    "EMD",
    "LGMD1",
    "LGMD2",
    "MODELS",
    "DSNNParams",
    "EMDParams",
    "Flow",
    "FlowParams",
    "FrameError",
    "LGMD1Params",
    "LGMD2Params",
    "LayerMaps",
    "ModelEntry",
    "ReferenceDSNN",
    "Response",
    "ResponseSeries",
    "VisionModel",
    "model_entry",
]

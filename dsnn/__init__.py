"""Vision models: the DSNN of Fu, Bellotto and Yue (2018), and what any model must offer to stand beside it.

>>> from dsnn import DSNN, DSNNParams
>>> model = DSNN((72, 99), DSNNParams.robot())
>>> response = model.step(frame)          # frame: uint8 grey (72, 99)
>>> response.hs, response.hs_spikes
"""

from dsnn.frames import FrameError
from dsnn.model import LayerMaps, Response, ResponseSeries, VisionModel
from dsnn.network import DSNN
from dsnn.params import DSNNParams
from dsnn.reference import ReferenceDSNN
from dsnn.registry import MODELS, ModelEntry, model_entry

__all__ = [
    "DSNN",
    "MODELS",
    "DSNNParams",
    "FrameError",
    "LayerMaps",
    "ModelEntry",
    "ReferenceDSNN",
    "Response",
    "ResponseSeries",
    "VisionModel",
    "model_entry",
]

"""Vision models: the DSNN of Fu, Bellotto and Yue (2018), the models it is compared with, and their common interface.

>>> from dsnn import DSNN, DSNNParams
>>> model = DSNN((72, 99), DSNNParams.robot())
>>> response = model.step(frame)          # frame: uint8 grey (72, 99)
>>> response.hs, response.hs_spikes
"""

import lazy_loader

# A name is imported when it is first asked for: a simulator that reads a picture by `dsnn.pictures` loads no model.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

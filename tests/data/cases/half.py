"""A model in half precision whose potential overflows at the tenth frame."""

from dataclasses import dataclass

import numpy as np

from dsnn import ModelEntry, Response


@dataclass(frozen=True)
class Parameters:
    t_sp: float = 0.1


class Half:
    def __init__(self, shape, parameters):
        self.reset()

    def reset(self):
        self.frames = 0

    def step(self, frame):
        self.frames += 1
        return Response(hs=np.float16("inf" if self.frames == 10 else 0.05))


MODEL = ModelEntry("half", "overflows", Half, Parameters())

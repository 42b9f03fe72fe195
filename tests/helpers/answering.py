"""Files of models that give a stated answer."""

from pathlib import Path

MODEL = """
import sys
from dataclasses import dataclass
import numpy as np
from dsnn import ModelEntry, Response
{imports}

@dataclass(frozen=True)
class Parameters:
    t_sp: float = 0.2

class Model:
    def __init__(self, shape, parameters):
        self.shape, self.frame = shape, 0
    def reset(self):
        self.frame = 0
    def step(self, frame):
        self.frame += 1
        return {answer}

MODEL = ModelEntry({name!r}, "a model of the tests", Model, Parameters(){more})
"""


def write_model(folder: Path, name: str, answer: str, more: str = "", imports: str = "") -> str:
    (folder / f"{name}.py").write_text(MODEL.format(name=name, answer=answer, more=more, imports=imports))
    return f"{name}.py"

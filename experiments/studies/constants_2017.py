"""C5, C6 and C7 along the sigmoid scale of the model of 2017, whose own constants are not known."""

from experiments.constants_2017 import VARIANTS
from experiments.studies.constants import along

STUDY = along("constants-2017", "C5, C6 and C7 with the model of 2017 at sigmoid scales over five decades",
              ("C5", "C6", "C7"), "dsn2017", VARIANTS)  # fmt: skip

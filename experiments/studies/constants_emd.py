"""C11 and C26 along the constants of Iida's EMD, which are not known: its delay, its spacing, its high-pass."""

from experiments.constants_emd import VARIANTS
from experiments.studies.constants import along

STUDY = along("constants-emd", "C11 and C26 with the EMD at 24 choices of spacing, delay and high-pass",
              ("C11", "C26"), "emd", VARIANTS)  # fmt: skip

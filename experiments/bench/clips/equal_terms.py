"""Rivals on equal terms: the gain of a model that the DSNN is compared with, matched before the comparison.

At 30 frames a second FDSR leaves about 1/34 of a rise, so that the DSNN without it has products some 1,180 times as
large for any stimulus whatever. A comparison of potentials then compares gains. So each rival is shown a second time,
with one gain that is set by one rule: its peak HS in one named plain crossing equals the DSNN's in the same crossing.

The crossing is the clip ``dark rightward`` of the experiment ``clean``: a dark object on an even ground, where nothing
is random and no background shifts. No claim that compares with a rival is about it. The gain of a model with a sigmoid
is that ahead of the sigmoid, its scale K_sig, as what is behind it cannot pass 1. The gain of the EMD is that of its
output. Nothing else of a rival is changed, and its answer to the crossing is all that the gain is found from.
"""

from __future__ import annotations

CROSSING = ("clean", "dark rightward")
"""The named plain crossing: the experiment, and its clip."""

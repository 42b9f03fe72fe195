"""The formats of numbers that the network is compared in, and the claims that are asked."""

from __future__ import annotations

from dataclasses import dataclass

CLAIMS = ("C13", "C14", "C15", "C16", "C17", "C18", "C19", "C20")
"""The claims about counts of spikes on the robot."""
FLOAT = "dsnn"


@dataclass(frozen=True, slots=True)
class Format:
    """A form of the network.

    Parameters
    ----------
    label
        What ``--model`` takes, and tables show.
    says
        What it computes with.
    fits
        Whether it fits into the robot's memory at 99x72 beside three frames of its camera and 16 kB of other use, as
        ``colias firmware budget`` measures it.
    """

    label: str
    says: str
    fits: bool


BEST = Format("dsnn-onboard", "8-bit delay states, companded, and 8-bit LA, rounded to nearest", True)
"""The best format that fits, of which alone a claim is said not to survive."""
OTHERS = (
    Format("dsnn-onboard:preset=lamina16", "16-bit LA, which fits beside two camera frames", False),
    Format("dsnn-onboard:preset=bits16", "16-bit delay states and LA", False),
    Format("dsnn-onboard:preset=truncated", "the best one, truncated at every step", True),
)
FORMATS = (Format(FLOAT, "float32", False), BEST, *OTHERS)
"""The float network, then the best format. All watch the same trials."""

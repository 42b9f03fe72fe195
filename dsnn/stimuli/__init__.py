"""Synthetic stimuli with ground truth: the paper's off-line clips, and standard stimuli of motion-vision laboratories.

>>> from dsnn.stimuli import stimulus
>>> clip = stimulus("plain", speed=120.0, motion="leftward")
>>> len(clip), clip.shape, clip.fps
(112, (180, 320), 30.0)
>>> clip[60].truth.velocity
(-120.0, 0.0)

A clip is painted while you iterate over it, any number of times, with equal frames. Pass ``(frame.luma for frame in
clip)`` to `DSNN.run`. Positions are fractions of a pixel, and every pixel is the mean of the light over its square.
Time runs in steps of one frame, without motion blur.
"""

from dsnn.stimuli.jitter import Jitter
from dsnn.stimuli.registry import STIMULI, StimulusEntry, stimulus, stimulus_entry
from dsnn.stimuli.scene_statistics import amplitude_spectrum, contrasts, spectrum_slope
from dsnn.stimuli.scenes import SCENES, scene
from dsnn.stimuli.stimulus import Box, ClipParams, Stimulus, StimulusFrame, TimedParams, Truth

__all__ = [
    "SCENES",
    "STIMULI",
    "Box",
    "ClipParams",
    "Jitter",
    "Stimulus",
    "StimulusEntry",
    "StimulusFrame",
    "TimedParams",
    "Truth",
    "amplitude_spectrum",
    "contrasts",
    "scene",
    "spectrum_slope",
    "stimulus",
    "stimulus_entry",
]

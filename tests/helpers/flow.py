"""The optical flow of images, by OpenCV: what moved, and which way."""

import itertools

import cv2
import numpy as np


def moved(images: np.ndarray) -> np.ndarray:
    """Sum over the images (T, R, C) the mean flow, rightward and downward in px, of the pixels that change much."""
    estimate = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    total = np.zeros(2)
    for before, after in itertools.pairwise(images):
        changed = cv2.absdiff(before, after) > 30
        if changed.any():
            total += estimate.calc(before, after, None)[changed].mean(axis=0)
    return total

"""Sums have equal bits wherever their array lies in memory, which differs from process to process."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

import colias_sim
import dsnn
from dsnn.filters import total


def at(values, offset):
    """A copy that begins ``offset`` bytes after a multiple of 64."""
    room = np.zeros(values.nbytes + 128, np.uint8)
    first = -room.ctypes.data % 64 + offset
    copy = room[first : first + values.nbytes].view(values.dtype).reshape(values.shape)
    copy[:] = values
    return copy


def test_a_total_is_that_of_its_values_alone():
    for seed in range(20):
        values = np.random.default_rng(seed).random((72, 99), np.float32) ** 8
        sums = {total(at(values, offset)) for offset in range(0, 64, 4)}
        assert len(sums) == 1
        np.testing.assert_allclose(sums.pop(), values.sum(dtype=np.longdouble), rtol=1e-14)


def test_nothing_is_summed_by_opencv():
    """OpenCV's sums of floats differ in their last bits with the place in memory; sums of whole numbers do not."""
    sums = {}
    for package in (dsnn, colias_sim):
        for file in Path(package.__file__).parent.rglob("*.py"):
            lines = re.findall(r"cv2\.(?:sumElems|mean|meanStdDev|norm)\(.*", file.read_text(encoding="utf-8"))
            sums |= {file.name: lines} if lines else {}
    assert sums == {"sensor.py": ["cv2.mean(self._grey)[0])"]}, "which is uint8"


def test_no_long_sum_is_left_to_blas():
    """The order in which BLAS adds depends on the processor, and of long sums on the threads that are free.

    The products that are there have some 100 terms or fewer in each sum.
    """
    products = {}
    for file in Path(dsnn.__file__).parent.rglob("*.py"):
        lines = [
            line.strip()
            for line in file.read_text(encoding="utf-8").splitlines()
            if re.search(r"\w\)?\]? @ [\w(]|np\.(?:dot|vdot|inner|matmul|tensordot)\(", line)
        ]
        products |= {file.name: len(lines)} if lines else {}
    assert products == {"foliage.py": 1, "self_inhibition.py": 1}

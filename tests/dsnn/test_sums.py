"""Sums have equal bits wherever their array lies in memory, which differs from process to process."""

import numpy as np

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

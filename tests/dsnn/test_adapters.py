"""Networks of others as models: their state, resets, channels and thresholds; the lattice of a fly's eye."""

import numpy as np
import pytest

from dsnn.adapters import AdapterParams, from_callable, from_onnx, from_torch, hexagons
from dsnn.stimuli import stimulus
from experiments.cli.check import MODELS, try_laws
from experiments.settings.models import ConfiguredModel

SHAPE = (24, 33)
CLIP = np.stack([frame.luma for frame in stimulus("plain", rows=24, columns=33, width=8, height=12, rest_s=0.1)])


class Change:
    """Twice the change of the mean, and no vertical response."""

    def __init__(self):
        self.last = None

    def __call__(self, frame):
        change = 0.0 if self.last is None else float(frame.mean() - self.last)
        self.last = frame.mean()
        return 2 * change, 0.0


def expected():
    mean = (CLIP.astype(np.float32) / 255).mean(axis=(1, 2))
    return 2 * np.diff(mean, prepend=mean[0])


def responses(entry, params=None):
    model = entry.build(SHAPE, params or entry.robot)
    first = model.run(CLIP)
    np.testing.assert_array_equal(model.run(CLIP).hs, first.hs)  # a run begins with a reset
    return first


def test_a_callable_keeps_its_state_until_a_reset_and_shares_it_with_no_other_model():
    network = Change()
    entry = from_callable("change", network, ("hs", "vs"))
    one, other = (entry.build(SHAPE, entry.robot) for _ in range(2))
    for place, frame in enumerate(CLIP):
        assert one.step(frame).hs == pytest.approx(expected()[place], abs=1e-6)
        if place % 2:
            other.step(frame)
    assert network.last is None
    responses(entry)


def test_gain_and_threshold_make_spikes():
    entry = from_callable("change", Change(), ("hs", "vs"))
    assert entry.threshold("hs", entry.robot) is None
    series = responses(entry, AdapterParams(gain=3.0, t_sp=0.02))
    np.testing.assert_allclose(series.hs, 3 * expected(), atol=1e-6)
    np.testing.assert_array_equal(series.hs_spikes, np.sign(series.hs) * (abs(series.hs) > 0.02))
    assert 0 < series.accumulated_spikes("hs") < len(CLIP)


def test_an_adapted_model_keeps_every_law():
    entry = from_callable("change", Change(), ("hs", "vs"))
    troubles = try_laws(MODELS, ConfiguredModel("change", "change", entry.robot, entry))
    assert not any(troubles.values())


def test_a_torch_module_gets_its_state_back():
    torch = pytest.importorskip("torch")

    class Module(torch.nn.Module):
        def forward(self, image, last=None):
            mean = image.mean()
            return 2 * (mean - (mean if last is None else last)), mean

    np.testing.assert_allclose(responses(from_torch("change", Module())).hs, expected(), atol=1e-6)
    plain = from_torch("mean", torch.nn.Sequential(torch.nn.Flatten(), torch.nn.Linear(24 * 33, 2)), ("hs", "vs"))
    assert np.ptp(responses(plain).vs) > 0.0


def field(number, kind, content):
    """A field of a protocol buffer: a whole number, or bytes with their length."""
    return bytes([number << 3 | kind]) + (bytes([content]) if kind == 0 else bytes([len(content)]) + content)


def node(kind, inputs, output):
    names = b"".join(field(1, 2, name) for name in inputs)
    return field(1, 2, names + field(2, 2, output) + field(4, 2, kind))


def tensor(number, name, sizes):
    shape = b"".join(field(1, 2, field(1, 0, size)) for size in sizes)
    return field(number, 2, field(1, 2, name) + field(2, 2, field(1, 2, field(1, 0, 1) + field(2, 2, shape))))


def test_an_onnx_file_gets_its_state_back(tmp_path):
    """Its response is the mean less that of the frame before, 0 at first."""
    pytest.importorskip("onnxruntime")
    path = tmp_path / "change.onnx"
    one = (1, 1, 1, 1)
    graph = (
        node(b"GlobalAveragePool", [b"image"], b"mean") + node(b"Sub", [b"mean", b"last"], b"change")
        + field(2, 2, b"g") + tensor(11, b"image", (1, 1, *SHAPE)) + tensor(11, b"last", one)
        + tensor(12, b"change", one) + tensor(12, b"mean", one)
    )  # fmt: skip
    long = bytes([7 << 3 | 2, len(graph) & 127 | 128, len(graph) >> 7]) + graph
    path.write_bytes(field(1, 0, 8) + long + field(8, 2, field(2, 0, 17)))
    mean = (CLIP.astype(np.float32) / 255).mean(axis=(1, 2))
    np.testing.assert_allclose(responses(from_onnx("change", path)).hs, np.diff(mean, prepend=0.0), atol=1e-5)


def test_columns_of_a_fly_s_eye_look_where_the_camera_s_angles_say():
    shape, hfov_deg = (72, 99), 70.0
    x, y = hexagons(shape, hfov_deg)
    assert x.size == 721
    middle = 360
    assert (x[middle], y[middle]) == (49.0, 35.5)
    assert x[middle + 1] > x[middle] and y[middle + 1] > y[middle]  # v: right and down
    focal = 49.5 / np.tan(np.radians(35.0))
    sight = np.stack([x - 49.0, y - 35.5, np.full(721, focal)], axis=1)
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    angles = np.degrees(np.arccos(np.clip(sight @ sight[middle], -1, 1)))
    nearest = np.sort(angles[np.isfinite(angles)])[1:7]
    np.testing.assert_allclose(nearest, 5.8, rtol=0.002)
    seen = (x >= 0) & (x <= 98) & (y >= 0) & (y <= 71)
    assert 100 < seen.sum() < 160

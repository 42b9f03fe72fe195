"""States of models: what was saved goes on to the bit, what is damaged or foreign is refused, nothing is forgotten."""

import copy
import sys

import numpy as np
import pytest

from dsnn import DSNN, LGMD1, MODELS, DSNNParams
from dsnn.model import Model
from dsnn.snapshot import PARTS
from tests.helpers.states import unlisted

SHAPE = 40, 56
FORMS = ("native", "reference")


def frames(count=24, seed=0):
    """A picture that shifts by a column a frame, with noise: every layer of every model has something to keep."""
    rng = np.random.default_rng(seed)
    picture = rng.integers(0, 256, (SHAPE[0], 2 * SHAPE[1]), np.uint8)
    return [np.ascontiguousarray(np.roll(picture, i, axis=1)[:, : SHAPE[1]]) for i in range(count)]


def built(name, monkeypatch, form):
    monkeypatch.setenv("DSNN_FORM", form)
    return MODELS[name].build(SHAPE, MODELS[name].robot)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", MODELS)
def test_a_restored_model_goes_on_to_the_bit(name, form, monkeypatch):
    """In a new model, in one that has seen other frames since, and in a deep copy; from any frame on."""
    shown, cut = frames(), 7 + list(MODELS).index(name) % 5
    model = built(name, monkeypatch, form)
    for frame in shown[:cut]:
        model.step(frame)
    state, twin = model.get_state(), copy.deepcopy(model)
    expected = [model.step(frame) for frame in shown[cut:]]
    for frame in frames(5, seed=1):
        model.step(frame)
    for other in (built(name, monkeypatch, form), model):
        other.set_state(state)
        assert other.get_state() == state
        assert [other.step(frame) for frame in shown[cut:]] == expected
    assert [twin.step(frame) for frame in shown[cut:]] == expected


REST = {
    "Gamma": "gain",
    "SmallTargetModel": "_blur _kernel _delays",
    "DSTMD": "_ahead _inside _weights",
    "Model": "shape params form",
    "ReferenceNetwork": "_shape _params _kernels",
    "dsnn.direction.reference.Pathway": "_params _alphas",
    "EMD": "_pass _delay _shifts _h _d",
    "EMDNormalised": "_pass _delay _h _d",
    "Flow": "_dis _flow",
    "LocalMotion": "_q _excitatory _inhibitory _local _offsets _alphas _follow _signals _c _delayed _cells _drive"
    " _product _scratch _window _planes _motion",
    "ThreeArm": "_pass _delay _h _x _delayed",
    "Retina": "_change",
    "States": "_every _floor",
    "Hybrid": "_frames_held",
    "Adaptation": "_hold _t_sfa _k_sp _t_sp",
    "_NumpyLayers": "_params _kernel _grouping _excitation _s _zeros",
    "LGMD2": "_grouping _rises _falls _s _zeros _follow",
    "dsnn.looming.lgmd2.Pathway": "_sigma _centre _kernels _alphas signal _delayed _scratch _zeros _s",
    "LPLC2": "_kernels _neighbours _delay _follow _bias _rows _columns _signals _delayed _cells _drive",
    "LPLC2GF": "_dt _passed _delay _substeps _decay _h _delayed",
    "MLPLC2": "_rows _columns",
    "PONLGMD": "_surround _neighbours _inhibiting _below",
    "SILGMD1": "_gains _kept _spared _blocks _lateral",
    "SILGMD2": "_kept _left _follow",
    "_Pathway": "_kernels _delay _kept _blocks _scratch",
    "OnboardDSNN": "fixed",
    "NumpyOnboard": "_c",
}
"""Class -> attributes that are no state of it: its configuration, what follows from that or from a frame, and arrays
that are in its `States`."""


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", MODELS)
def test_every_attribute_of_a_model_is_in_a_list(name, form, monkeypatch):
    """What a class keeps and no list has would be forgotten."""
    model = built(name, monkeypatch, form)
    model.step(frames(1)[0])
    assert set(unlisted(model, PARTS, REST)) == set()


def test_every_class_of_the_table_is_there():
    for name in PARTS:
        module, _, kind = name.rpartition(".")
        assert hasattr(sys.modules.get(module) or __import__(module, fromlist=[kind]), kind), name


def test_what_is_no_state_of_this_model_is_refused_and_changes_nothing():
    """Cut anywhere, with any byte changed, of another class, shape, parameter, form or format."""
    model = DSNN(SHAPE, DSNNParams.robot())
    for frame in frames(3):
        model.step(frame)
    state = model.get_state()
    cut = [state[:length] for length in (0, 5, 12, 20, 100, len(state) // 2, len(state) - 1)]
    changed = [
        state[:at] + bytes([state[at] ^ 1]) + state[at + 1 :]
        for at in (0, *range(12, 60), len(state) // 2, len(state) - 1)
    ]
    others: list[Model] = [
        LGMD1(SHAPE), DSNN((40, 57), DSNNParams.robot()), DSNN(SHAPE, DSNNParams.robot(t_sp=0.3)),
        DSNN(SHAPE, DSNNParams.robot(), form="reference"),
    ]  # fmt: skip
    for wrong in (*cut, *changed, *(other.get_state() for other in others), b"", "text", None, state + b"x"):
        with pytest.raises(ValueError, match=r"^(the|a) .*must be"):
            model.set_state(wrong)
        assert model.get_state() == state


def test_a_follower_is_neither_saved_nor_restored():
    front, follower = (DSNN(SHAPE, DSNNParams.robot(n_con=n), form="native") for n in (4, 3))
    state = follower.get_state()
    follower.follow(front)
    for call in (follower.get_state, lambda: follower.set_state(state)):
        with pytest.raises(ValueError, match="follows"):
            call()


class Counter(LGMD1):
    """A user's model on one of ours, with state of its own."""

    seen = 0

    def _respond(self, luminance, maps):
        self.seen += 1
        return super()._respond(luminance, maps)


class Saved(Counter):
    """The same with the two methods."""

    def get_state(self):
        return bytes([self.seen]) + super().get_state()

    def set_state(self, state):
        super().set_state(state[1:])
        self.seen = state[0]


def test_a_subclass_brings_the_two_methods_or_is_refused():
    """It may keep what its base does not. Its methods may call those of the base."""
    with pytest.raises(ValueError, match=r"^Counter .*get_state"):
        Counter(SHAPE).get_state()
    model, other = Saved(SHAPE), Saved(SHAPE)
    for frame in frames(4):
        model.step(frame)
    other.set_state(model.get_state())
    assert other.seen == 4
    assert other.step(frames(5)[-1]) == model.step(frames(5)[-1])

"""The network in the robot's arithmetic: C equal to its specification to the bit, its laws, and how far floats are."""

import ctypes
import dataclasses
import subprocess

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from dsnn import OnboardDSNN, OnboardParams, forms, native
from dsnn.onboard.codes import coded, decoded
from dsnn.onboard.fixed import constants
from dsnn.onboard.header import header
from dsnn.onboard.params import largest_change
from tests.conftest import crossing
from tests.helpers.native_cases import COMPILER, NATIVE, STRICT, drawn, every_answer, moving

built = pytest.mark.skipif(bool(native.missing()), reason=f"the native form {native.missing()}")
ROBOT = OnboardParams.presets()
RAM, RING = 256 * 1024, 3 * 2 * 72 * 99
"""Bytes: of the robot's processor (192 kB and 64 kB), and of three frames of YUV422."""


@built
@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 2**31), st.booleans(), st.tuples(st.integers(2, 24), st.integers(2, 30)), st.integers(1, 6))
@example(7, False, (72, 99), 8)  # the robot's size, every pixel flickering: the largest sums, of 16 bits
@example(9, False, (72, 99), 8)  # and of 8
def test_c_is_its_specification_to_the_bit(seed, extreme, shape, count):
    """Over parameters, formats, shapes and sequences, and after a reset."""
    rng = np.random.default_rng(seed)
    params = drawn(OnboardParams, rng, extreme)
    frames, more = (np.rint(moving(rng, count, *shape)).astype(np.uint8) for _ in range(2))
    code, specification = (OnboardDSNN(shape, params, form=form) for form in forms.FORMS)
    assert every_answer(code, frames) == every_answer(specification, frames)
    code.reset()
    specification.reset()
    again = every_answer(code, more)
    assert again == every_answer(specification, more)
    assert again == every_answer(OnboardDSNN(shape, params, form="native"), more), "a reset forgets everything"


@built
@pytest.mark.parametrize("d", [1, 2])
def test_c_is_its_specification_where_most_rows_stand_still(d):
    """It leaves out the rows that the blur of what moves does not reach."""
    frames = np.full((6, 72, 99), 90, np.uint8)
    for t, frame in enumerate(frames):
        frame[30 + 2 * t : 36 + 2 * t, 40:60] = 220
    code, specification = (OnboardDSNN((72, 99), OnboardParams(d=d), form=form) for form in forms.FORMS)
    assert every_answer(code, frames) == every_answer(specification, frames)


@pytest.mark.parametrize("name", ROBOT)
def test_mirrored_clips_give_mirrored_answers_to_the_bit(name):
    """With both directions weighing the same: left and right, up and down."""
    params = dataclasses.replace(ROBOT[name], w_i=1.0)
    noise = np.random.default_rng(5).normal(0, 3, (25, 72, 99))
    frames = np.clip(crossing(count=25) + noise, 0, 255).astype(np.uint8)
    there, across, down = (
        OnboardDSNN((72, 99), params).run(clip) for clip in (frames, frames[:, :, ::-1], frames[:, ::-1])
    )
    np.testing.assert_array_equal(across.hs, -there.hs)
    np.testing.assert_array_equal(across.vs, there.vs)
    np.testing.assert_array_equal(down.hs, there.hs)
    np.testing.assert_array_equal(down.vs, -there.vs)
    np.testing.assert_array_equal(across.hs_spikes, -there.hs_spikes)
    assert name == "grey-levels" or there.hs.max() > 0.2


GOLDEN_BOUNDS = {"lamina16": 0.02, "bits16": 0.01, "bits8": 0.05, "linear8": 0.03, "truncated": 0.06}
"""Of |HS| and |VS|. HS goes with the product of F and D, and changes by at most 1/4 of what its argument does.

16 bits: F and P are known to 1/128 grey level or better, a hundredth of LA at an edge, but cells whose P_e is nearly 0
may fall on either side of 0; allowed is a hundredth of the range. Companded D errs by up to 1/64 of itself at each
frame besides, linear 8-bit D by half of 1/255 of the largest F, a tenth of a usual one. Truncated low-passes lose a
step at each frame where others err by half of one to either side: they fall short, by up to 1/32 a frame over the 7
frames of the slowest low-pass. LA of 8 bits errs by up to half a grey level at either frame of a change, of which
edges have 20 or more: F by up to 1/20, a product by 1/10, HS by a quarter of that, and cells of noise by all of F.
The last two are tried with LA of 16 bits, so that each bound is about one choice.
"""


@pytest.mark.parametrize("name", GOLDEN_BOUNDS)
def test_formats_stay_near_the_golden_vectors(name, golden):
    params, vector = golden
    formats = {
        field: getattr(ROBOT[name], field)
        for field in ("state_bits", "companding", "lamina_bits", "rounding", "f_bits")
    }
    formats["lamina_bits"] = 8 if name == "bits8" else 16
    series = OnboardDSNN(vector["frames"].shape[1:], OnboardParams(**dataclasses.asdict(params), **formats)).run(
        vector["frames"]
    )
    np.testing.assert_allclose(series.hs, vector["hs"], atol=GOLDEN_BOUNDS[name])
    np.testing.assert_allclose(series.vs, vector["vs"], atol=GOLDEN_BOUNDS[name])


def test_eight_spacings_fit_into_the_robot_with_8_bits_and_not_with_16():
    def left(**changes):
        return RAM - RING - constants((72, 99), OnboardParams.robot(**changes)).state_bytes

    assert left(state_bits=16) < 0 < 8 * 1024 < left()
    assert left(state_bits=16, n_con=4) > 8 * 1024
    assert left() == left(lamina_bits=16) + 2 * 72 * 99


@pytest.mark.parametrize("companding", [True, False])
def test_codes_are_in_order_and_hold_the_nearest_value(companding):
    values = decoded(np.arange(256), companding)
    assert (np.diff(values) > 0).all() and values[0] == 0 and values[-1] < 2**15
    np.testing.assert_array_equal(coded(values << 15, companding, True), np.arange(256))
    every = np.arange(int(values[-1]) + 1)
    nearest = decoded(coded(every << 15, companding, False), companding)
    below = decoded(coded(every << 15, companding, True), companding)
    steps = np.diff(values)[np.minimum(np.searchsorted(values, every, "right") - 1, 254)]
    assert (np.abs(nearest - every) <= steps / 2).all()
    assert ((every - below >= 0) & (every - below < steps)).all()


@settings(max_examples=20, deadline=None)
@given(st.floats(0.0, 20.0), st.floats(0.0, 1.0))
def test_spikes_are_those_of_the_equation(k_sp, t_sp):
    """At every |HS| there is in Q15, up to the 256 where the table ends."""
    c = constants((8, 8), OnboardParams(k_sp=k_sp, t_sp=t_sp))
    potential = np.arange(1, 32767) / 32768.0
    counts = np.searchsorted(np.array(c.thresholds), np.arange(1, 32767), side="right")
    exact = k_sp * (potential - t_sp)
    expected = np.where(potential >= t_sp, np.minimum(np.floor(np.exp(exact)), 256), 0)
    clear = np.abs(np.exp(exact) - np.rint(np.exp(exact))) > 1e-9 * np.exp(exact)  # not where floats decide
    np.testing.assert_array_equal(counts[clear], expected[clear])


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 6), st.floats(0.7, 3.0), st.integers(0, 2**31))
def test_no_clip_gives_a_larger_change_than_the_largest(n_p, u, seed):
    params = OnboardParams(n_p=n_p, u=u, dog=False)
    frames = np.random.default_rng(seed).integers(0, 2, (40, 2, 6)).astype(np.uint8) * 255
    model = OnboardDSNN((2, 6), params, form="reference")
    largest = max(np.abs(model.step(frame, maps=True).maps.p).max() for frame in frames)
    assert largest <= largest_change(params) + 0.1  # each residue is rounded to 1/128 grey level or so


def test_the_largest_change_is_reached():
    """Without residue it is one step; a residue takes from what follows."""
    assert largest_change(OnboardParams(n_p=0)) == 255.0
    assert largest_change(OnboardParams()) == pytest.approx(255.0, rel=1e-6)


@built
@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize(
    "changes", [{}, {"state_bits": 16, "n_p": 0, "d": 2, "n_con": 3}, {"companding": False, "lamina_bits": 16}], ids=str
)
def test_the_header_makes_the_same_model(changes, tmp_path):
    """As it is compiled for the robot: constants known to the compiler, the configuration not looked at."""
    params, shape = OnboardParams.robot(**changes), (24, 31)
    (tmp_path / "onboard_config.h").write_text(header(shape, params))
    library = tmp_path / "onboard.so"
    subprocess.run(
        [COMPILER, *STRICT, "-O2", "-shared", "-fPIC", f"-I{NATIVE}", f"-I{tmp_path}",
         '-DONBOARD_CONFIG_HEADER="onboard_config.h"', str(NATIVE / "onboard.c"), "-o", str(library)],
        check=True, timeout=100,
    )  # fmt: skip
    lib = ctypes.CDLL(str(library))
    lib.onboard_size.restype, lib.onboard_make.restype = ctypes.c_size_t, ctypes.c_void_p
    size = lib.onboard_size(None)
    assert size == constants(shape, params).state_bytes
    memory, answer = ctypes.create_string_buffer(size), (ctypes.c_int32 * 4)()
    model = ctypes.c_void_p(lib.onboard_make(memory, ctypes.c_size_t(size), None))
    frames = np.random.default_rng(1).integers(0, 256, (9, *shape)).astype(np.uint8)
    host = OnboardDSNN(shape, params).run(frames)
    for t, frame in enumerate(frames):
        lib.onboard_step(model, ctypes.c_void_p(frame.ctypes.data), answer)
        assert [answer[0], answer[1]] == [host.hs[t] * 32768, host.vs[t] * 32768]
        assert [answer[2], answer[3]] == [host.hs_spikes[t], host.vs_spikes[t]]
    assert f"#define ONBOARD_STATE_BYTES {size}\n" in header(shape, params)


@pytest.mark.parametrize(
    "changes",
    [{"n_p": 2, "u": 0.0}, {"sigma_l": 0.999}, {"tau_s": (10.0, 10_000.0), "fps": 10_000.0}, {"state_bits": 12},
     {"f_bits": 16}, {"rounding": "up"}, {"rectified": False}, {"polarity": "centre"}, {"lowpass": "exact"},
     {"lowpass": "two-tap"}, {"lowpass": "two-tap-fdsr"},
     {"f_bits": 15, "n_p": 4, "u": 0.3, "sigma_l": 0.99}],
    ids=str,
)  # fmt: skip
def test_what_would_overflow_or_has_no_room_is_refused(changes):
    with pytest.raises(ValueError, match=next(iter(changes))):
        OnboardParams(**changes)

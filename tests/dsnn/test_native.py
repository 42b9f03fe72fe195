"""The C form: the reference within its bounds, itself in every build to the bit, and clean under the sanitizers."""

import hashlib
import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from dsnn import DSNN, LGMD1, DSNNParams, Hybrid, forms, native
from dsnn.exponential import exp
from dsnn.filters import blur, gaussian_kernel
from tests.conftest import GOLDEN, ROOT, crossing
from tests.helpers.native_cases import COMPILER, NATIVE, ROBOT_S, SANITIZED, answered, answers, compiled

built = pytest.mark.skipif(bool(native.missing()), reason=f"the native form {native.missing()}")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler")

CHECKSUM = "c6747b3586d3667570fc36c8c319447895e7f9edb1d613f6f41a5a2f0239a904"
"""SHA-256 of the native answers to the golden vectors' frames: potentials, spikes and the last maps, as bytes."""
NEAR = 1e-3
"""Grey levels. Single precision errs by less in P_e and P_i, so farther from 0 both forms see the same sign."""


def near_zero(params: DSNNParams, p: np.ndarray) -> np.ndarray:
    """Where the sign of P_e or of P_i is in doubt: P of (R, C), a mask of that shape."""
    wide = [blur(p.astype(np.float64), gaussian_kernel(sigma)) for sigma in (params.d, 2 * params.d)]
    return np.minimum(*np.abs(wide)) < NEAR


def changing(seed: int, darker: bool, rows: int = 40, columns: int = 50) -> np.ndarray:
    """A pattern that moves rightward while every cell brightens (or darkens) at every frame: no P comes near 0."""
    blocks = np.random.default_rng(seed).uniform(10.0, 24.0, (rows // 4, columns // 4 + 4))
    pattern = blocks.repeat(4, 0).repeat(4, 1)
    steps = [pattern[:, 10 - i : 10 - i + columns] for i in range(10)]
    levels = np.cumsum([np.zeros((rows, columns)), *steps], axis=0)
    return (250.0 - levels if darker else levels).astype(np.float32)


def test_the_digest_is_of_every_c_file():
    """A module that was built from other sources is noticed, whichever file was edited."""
    files = {path.name for ending in ("c", "h") for path in NATIVE.glob(f"*.{ending}")}
    assert sorted(native.binding.SOURCES) == sorted(files)


@built
@pytest.mark.parametrize("darker", [False, True])
@pytest.mark.parametrize(
    "changes",
    [{}, {"d": 2, "n_con": 5}, {"fdsr": False, "n_p": 0},
     {"rectified": False, "polarity": "centre", "lowpass": "exact", "tau_fast": 20},
     {"lowpass": "two-tap", "tau_fast": 20}, {"lowpass": "two-tap-fdsr", "rectified": False, "tau_fast": 20}],
    ids=str,
)  # fmt: skip
def test_forms_agree_where_no_sign_is_in_doubt(changes, darker):
    params, frames = DSNNParams(**changes), changing(7, darker)
    fast, plain = (DSNN(frames.shape[1:], params, form=form) for form in forms.FORMS)
    assert fast.step(frames[0]) == plain.step(frames[0])  # P is 0 there, in both
    for frame in frames[1:]:
        a, b = fast.step(frame, maps=True), plain.step(frame)
        assert not near_zero(params, a.maps.p).any()
        assert a.hs == pytest.approx(b.hs, abs=1e-5) and a.vs == pytest.approx(b.vs, abs=1e-5)
    assert abs(a.hs) > 1e-3, "something was to be agreed on"


@built
def test_the_lgmd1_and_the_hybrid_agree():
    """A square that grows; the gate, the azimuth and the veto too."""
    frames = np.full((30, 72, 98), 240, np.uint8)
    for i, frame in enumerate(frames):
        half = 3 + round(1.12**i)
        frame[max(0, 36 - half) : 36 + half, max(0, 30 - half) : 30 + half] = 20
    for model in (LGMD1, Hybrid):
        fast, plain = (model((72, 98), form=form).run(frames) for form in forms.FORMS)
        for channel in ("hs", "vs", "looming", "azimuth"):
            np.testing.assert_allclose(getattr(fast, channel), getattr(plain, channel), atol=1e-5, err_msg=channel)
        np.testing.assert_array_equal(fast.looming_spikes, plain.looming_spikes)
    assert fast.looming_spikes.any() and fast.azimuth.min() < -0.2


@built
def test_the_golden_answers_have_their_bits():
    """Whatever the compiler and the processor: the next last bit would show."""
    digest = hashlib.sha256()
    for path in GOLDEN:
        with np.load(path, allow_pickle=False) as file:
            frames = file["frames"]
        for params in (DSNNParams(), DSNNParams(d=2, n_con=5, n_p=6)):
            model = DSNN(frames.shape[1:], params, form="native")
            for frame in frames:
                answer = model.step(frame, maps=True)
                digest.update(np.array([answer.hs, answer.vs, answer.hs_spikes, answer.vs_spikes], "<f8").tobytes())
            for layer in (answer.maps.p, answer.maps.la, answer.maps.f_on, answer.maps.f_off):
                digest.update(layer.astype("<f4").tobytes())
    assert digest.hexdigest() == CHECKSUM


@built
@needs_compiler
@pytest.mark.parametrize(
    "options",
    [("-O2", "-DVISION_PLAIN", *ROBOT_S), SANITIZED, (*SANITIZED, *ROBOT_S)],
    ids=["plain", "sanitized", "sanitized-robot"],
)
def test_every_build_answers_with_the_same_bits(options, tmp_path):
    """As the extension module, which has vectors; the sanitizers stop at what C leaves undefined, and at every byte
    read or written beside the memory given."""
    count = int(os.environ.get("COLIAS_FUZZ_CASES", "36"))  # make fuzz: 2,000
    compiled(tmp_path, *options)
    assert answered(tmp_path, count) == answers(count)


@built
@settings(deadline=None, max_examples=500)
@given(st.one_of(st.floats(-720, 720), st.floats(allow_nan=False), st.floats(-1e-300, 1e-300)))
def test_the_exponential_is_its_twin_in_c(x):
    assert native.kernel().lib.vision_exp(x) == exp(x)


@settings(deadline=None)
@given(st.floats(-700, 700))
@example(-371.15333321000196)  # one of the largest errors: 1.1 units
def test_the_exponential_is_within_its_bound(x):
    """Four roundings, summed in the docstring of exp, come to 1.19 units in the last place; it promises 1.25."""
    with localcontext(prec=50):
        true = Decimal(x).exp()
        assert abs(Decimal(exp(x)) - true) <= Decimal("1.25") * Decimal(math.ulp(exp(x)))


def test_the_ends_of_the_exponential():
    assert (exp(0.0), exp(-1e9), exp(-math.inf), exp(1e9), exp(math.inf)) == (1.0, 0.0, 0.0, math.inf, math.inf)
    assert math.isnan(exp(math.nan))


@built
def test_models_in_threads_are_apart():
    """The kernel runs without Python's lock; two models share nothing."""
    clips = [crossing(), crossing(dark=False), crossing(step=2.5), crossing()[:, ::-1]]
    one_by_one = [DSNN(clip.shape[1:], form="native").run(clip).hs for clip in clips]
    with ThreadPoolExecutor(4) as threads:
        together = list(threads.map(lambda clip: DSNN(clip.shape[1:], form="native").run(clip).hs, clips * 5))
    for potentials, expected in zip(together, one_by_one * 5, strict=True):
        np.testing.assert_array_equal(potentials, expected)


UNBUILT = """
import sys
sys.modules["_dsnn_native"] = None
import numpy as np
from dsnn import DSNN, LGMD1, forms
model = DSNN((72, 99))
print(model.form, LGMD1((72, 99)).form, model.run(np.zeros((3, 72, 99), np.uint8)).hs.sum(), bool(forms.note()))
try:
    DSNN((72, 99), form="native")
except forms.FormError:
    print("refused")
"""


def test_without_the_c_form_the_reference_runs_and_says_so():
    done = subprocess.run([sys.executable, "-c", UNBUILT], capture_output=True, text=True, cwd=ROOT, timeout=100)
    assert done.stdout.split() == ["reference", "reference", "0.0", "True", "refused"], done.stderr

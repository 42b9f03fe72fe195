"""Every form of the DSNN against the golden vectors, within the specification's bounds."""

from functools import partial

import numpy as np
import pytest

from dsnn import DSNN, forms, native


@pytest.fixture(params=forms.FORMS)
def form(request):
    if request.param == "native" and native.missing():
        pytest.skip(f"the native form {native.missing()}")
    return partial(DSNN, form=request.param)


def test_agrees_with_the_golden_vectors(form, golden):
    params, vector = golden
    model = form(vector["frames"].shape[1:], params)
    answers = [model.step(frame, maps=True) for frame in vector["frames"]]
    np.testing.assert_allclose([a.hs for a in answers], vector["hs"], atol=1e-3)
    np.testing.assert_allclose([a.vs for a in answers], vector["vs"], atol=1e-3)
    for channel in ("hs", "vs"):
        signs = np.sign([getattr(answer, channel) for answer in answers])  # the vectors count spikes without theirs
        spikes = [getattr(answer, f"{channel}_spikes") for answer in answers]
        np.testing.assert_array_equal(spikes, signs * np.abs(vector[f"{channel}_spikes"]), err_msg=channel)
    last = answers[-1].maps
    for name, layer in (("P", last.p), ("LA", last.la), ("F_on", last.f_on), ("F_off", last.f_off)):
        np.testing.assert_allclose(layer, vector[f"last_{name}"], atol=0.05, err_msg=name)

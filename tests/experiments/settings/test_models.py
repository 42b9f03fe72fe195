"""``--model`` shows a model beside the command's own, ``--only`` just those of ``--model``: one meaning everywhere."""

import pytest

from experiments.base.errors import UsageError
from experiments.settings.models import choose, parse_model, rate_notes, shown_models
from experiments.settings.settings import watchers
from tests.helpers import user_files
from tests.helpers.plans import planned

# --- one meaning, on every command ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "only", "shown"),
    [
        (None, False, ["dsnn"]),
        (["emd"], False, ["dsnn", "emd"]),
        (["emd", "dsnn", "emd"], False, ["dsnn", "emd"]),
        (["emd"], True, ["emd"]),
    ],
)
def test_each_model_is_shown_once(given, only, shown):
    assert shown_models(["dsnn"], given, only) == shown


def test_a_model_s_frame_rate_is_held_against_what_it_is_shown():
    """29.97 frames/s are 30."""
    dsnn, emd, flow = (choose(name) for name in ("dsnn", "emd", "flow"))
    assert rate_notes([(dsnn, 30.0), (emd, 29.97), (flow, 60.0)]) == []
    (note,) = rate_notes([(dsnn, 60.0), (emd, 60.0), (emd, 60.0)])
    assert note.startswith("dsnn and 1 more") and "30" in note and "60" in note
    assert len(rate_notes([(dsnn, 60.0), (emd, 15.0)])) == 2


# --- one model under several settings ---------------------------------------------------------------------------------


def test_one_model_is_shown_under_two_settings(tmp_path):
    """``--set`` is the family's; what is a model's own wins."""
    (tmp_path / "my_model.py").write_text(user_files.MODEL)
    own = f"{tmp_path / 'my_model.py'}:gain=1e-9"
    plan = planned("speed", ["dsnn", "dsnn:n_con=4,tau_s=200,10", own], {"dsnn.n_con": 6})
    networks = {model.label: model.network for model in plan.trials[0].models}
    assert list(networks) == ["dsnn", "dsnn:n_con=4,tau_s=200,10", "gradient:gain=1e-9"]
    plain, changed, gradient = networks.values()
    assert (plain.n_con, changed.n_con, changed.tau_s, gradient.gain) == (6, 4, (200.0, 10.0), 1e-9)
    assert list(plan.resolved["files"]) == [str(tmp_path / "my_model.py")]


TEXTS = {
    "dsnn": ("dsnn", {}),
    "dsnn:w_i=1": ("dsnn", {"w_i": "1"}),
    "dsnn:tau_s=200,10,n_con=4": ("dsnn", {"tau_s": "200,10", "n_con": "4"}),
    "my_model.py:gain=2": ("my_model.py", {"gain": "2"}),
    "a:b/my.model.py": ("a:b/my.model.py", {}),
    "a:b/my.py:gain=2,t_sp=0.1": ("a:b/my.py", {"gain": "2", "t_sp": "0.1"}),
    "C:\\models\\my.py:gain=2": ("C:\\models\\my.py", {"gain": "2"}),
    "m.py:table=other.py": ("m.py", {"table": "other.py"}),
}


@pytest.mark.parametrize("text", TEXTS)
def test_a_text_is_taken_apart(text):
    assert parse_model(text) == TEXTS[text]


def test_off_line_models_keep_their_preset_under_settings():
    plain, changed = watchers(["dsnn", "dsnn:w_i=1"], fps=25.0)
    assert (changed.network.t_sp, changed.network.fps, changed.network.w_i) == (plain.network.t_sp, 25.0, 1.0)
    assert watchers(["dsnn:fps=60"], fps=25.0)[0].network.fps == 60.0
    with pytest.raises(UsageError, match=r"--set dsnn\.n_con=99"):
        watchers(["dsnn:n_con=4"], {"dsnn.n_con": "99"})


# --- grids ------------------------------------------------------------------------------------------------------------

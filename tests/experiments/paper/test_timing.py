"""Models timed side by side."""

from experiments.paper.benchmark.entry import ROUNDS, time_models
from experiments.settings.models import choose
from tests.helpers import user_files


def test_every_round_is_timed_and_a_model_that_raises_has_no_times(tmp_path):
    text = user_files.MODEL.replace("now = luma", "raise ValueError(1)\n        now = luma")
    (tmp_path / "odd.py").write_text(text)
    taken = time_models([choose("emd"), choose(str(tmp_path / "odd.py"))], (24, 32))
    assert set(taken) == {"emd"}
    assert len(taken["emd"]) == ROUNDS and min(taken["emd"]) > 0

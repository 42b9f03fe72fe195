"""What is told of mutants: which test noticed one."""

from tools.mutants import first_failure, pytest

MODULE = """
import pytest
@pytest.mark.parametrize("way", ["to the left - at once", "to the right"])
def test_a_way(way):
    assert way == "to the right", "so - and so"
"""


def test_the_test_that_noticed_is_told_whole_whatever_its_name(tmp_path):
    """An id cut at a space names no test: it would fail without the mutant too, and leave its neighbours out."""
    (tmp_path / "test_ways.py").write_text(MODULE)
    assert pytest(tmp_path, ["-x", "test_ways.py"]).returncode == 1
    by = first_failure(tmp_path)
    assert by == "test_ways.py::test_a_way[to the left - at once]"
    assert pytest(tmp_path, [by]).returncode == 1
    assert pytest(tmp_path, [f"--deselect={by}", "test_ways.py"]).returncode == 0
    assert first_failure(tmp_path) == ""

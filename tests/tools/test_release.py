"""What ``make release`` tries of the page of installation is what that page shows."""

import sys
import tomllib
from pathlib import Path

from tools.release import EXTRA, EXTRA_TRIES, GOLDEN, INSTALL_PAGE, ROOT, Try, outcomes


def test_each_extra_of_the_package_is_on_the_page_and_tried():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    extras = EXTRA.findall(INSTALL_PAGE.read_text())
    assert set(extras) == set(declared) == set(EXTRA_TRIES)
    assert len(set(extras)) == len(extras)


def test_the_golden_vectors_are_there():
    assert (ROOT / GOLDEN).is_file()


def test_a_try_that_goes_wrong_is_told(tmp_path):
    """Wrong are another status, a missing text, and a traceback even where the status is right."""

    programs = {
        "right": ("print('yes')", "ok"), "status": ("import sys; sys.exit(3)", "status 3"),
        "text": ("print('no')", "status 0: no"), "traceback": ("print('yes'); print('Traceback')", "status 0"),
    }  # fmt: skip
    tries = [Try(name, ("python", "-c", text), says="yes") for name, (text, _) in programs.items()]
    results = dict(outcomes(Path(sys.executable).parent, tmp_path / "empty", tries))
    assert all(results[name].startswith(expected) for name, (_, expected) in programs.items()), results

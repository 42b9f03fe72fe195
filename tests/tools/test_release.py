"""What ``make release`` tries of the page of installation is what that page shows."""

import tomllib

from tools.release import EXTRA, EXTRA_TRIES, GOLDEN, INSTALL_PAGE, ROOT


def test_each_extra_of_the_package_is_on_the_page_and_tried():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    extras = EXTRA.findall(INSTALL_PAGE.read_text())
    assert set(extras) == set(declared) == set(EXTRA_TRIES)


def test_the_golden_vectors_are_there():
    assert (ROOT / GOLDEN).is_file()

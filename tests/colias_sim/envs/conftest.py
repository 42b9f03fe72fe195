from collections.abc import Iterator

import pytest

from tests.helpers.envs import OPEN


@pytest.fixture(autouse=True)
def close_envs() -> Iterator[None]:
    """Close the envs that a test made by ``bare``."""
    yield
    while OPEN:
        OPEN.pop().close()

"""The documentation opened from disk in Chromium: its pages fit narrow and wide windows."""

import json

import pytest

from tests.helpers.browser import CHROMIUM, browser
from tests.site import SITE

NARROW, WIDE = 390, 1280
pytestmark = [
    pytest.mark.site,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium: on Debian run 'apt-get install chromium'"),
]


def test_pages_fit_narrow_and_wide_windows(tmp_path):
    """A page that scrolls sideways as a whole has something in it that should scroll, or be smaller, by itself."""
    pages = sorted(path for path in SITE.rglob("*.html") if "_static" not in path.parts)
    # Pages of the API are all alike: those that fit a narrow window fit a wide one.
    alike = SITE / "generated" / "api"
    views = [(page, NARROW) for page in pages] + [(page, WIDE) for page in pages if alike not in page.parents]
    found = {}
    with browser(tmp_path / "profile") as tab:
        for page, width in views:
            tab.show(page.as_uri(), width)
            tab.until(f"location.href === {json.dumps(page.as_uri())} && document.readyState === 'complete'")
            found[page, width] = tab.ask("document.documentElement.scrollWidth")
    assert found and {view: px for view, px in found.items() if px > view[1]} == {}

"""The documentation opened from disk in Chromium: its search finds, and its pages fit narrow and wide windows."""

import html
import json
import re
import subprocess
from pathlib import Path

import pytest

from tests.helpers.browser import CHROMIUM, FLAGS
from tests.site import SITE

NARROW, WIDE = 390, 1280
pytestmark = [
    pytest.mark.site,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium: on Debian run 'apt-get install chromium'"),
]
MEASURE = """<!doctype html><title>widths</title><pre id="found">unfinished</pre><script>
const pages = PAGES, wide = [], frame = document.createElement("iframe");
frame.height = 900;
document.body.append(frame);
async function show(page, width) {
  frame.width = width;
  await new Promise((done) => { frame.onload = done; frame.src = page; });
  const root = frame.contentDocument.documentElement;
  if (root.scrollWidth > width) wide.push(`${page} at ${width}: ${root.scrollWidth} px`);
}
(async () => {
  for (const [page, width] of pages) await show(page, width);
  document.getElementById("found").textContent = JSON.stringify(wide);
})();
</script>"""


def opened(url: str, profile: Path, *flags: str, budget_ms: int = 10_000) -> str:
    """The document after its scripts have run."""
    command = [str(CHROMIUM), *FLAGS, *flags, f"--user-data-dir={profile}", f"--virtual-time-budget={budget_ms}",
               "--dump-dom", url]  # fmt: skip
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=True).stdout


def test_pages_fit_narrow_and_wide_windows(tmp_path):
    """A page that scrolls sideways as a whole has something in it that should scroll, or be smaller, by itself."""
    pages = sorted(str(path.relative_to(SITE)) for path in SITE.rglob("*.html") if "_static" not in path.parts)
    views = [((SITE / page).as_uri(), NARROW) for page in pages]
    # Pages of the API are all alike: those that fit a narrow window fit a wide one.
    views += [((SITE / page).as_uri(), WIDE) for page in pages if not page.startswith("generated/api/")]
    harness = tmp_path / "widths.html"
    harness.write_text(MEASURE.replace("PAGES", json.dumps(views)), encoding="utf-8")
    flags = ("--allow-file-access-from-files", "--disable-web-security")
    page = opened(harness.as_uri(), tmp_path / "profile", *flags, budget_ms=600_000)
    match = re.search(r'<pre id="found">(.*?)</pre>', page)
    assert match is not None
    assert json.loads(html.unescape(match[1])) == []

"""The report's page: every claim has its tile and evidence, links lead somewhere, and its colours can be read."""

import dataclasses
import html
import json
import re
from html.parser import HTMLParser

import pytest

from colias_sim.reference import KNOWN
from experiments.bench.reproduction import report
from experiments.bench.reproduction.page.stored import stored
from experiments.bench.reproduction.plan import FULL
from experiments.bench.reproduction.readings import Evidence, chapters
from experiments.bench.reproduction.reproduce import Reproduction
from experiments.bench.reproduction.table import show_claims
from experiments.bench.stats import stored as stored_verdicts
from experiments.bench.stats.claim import PAPER, claim_ids, words
from experiments.bench.stats.count import MEANINGS, SIGNS, Count
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.store.description import to_json
from experiments.bench.store.files import Files
from experiments.bench.studies import run as study_run
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.replicates import Replicate
from experiments.bench.studies.stored import read
from experiments.studies.fidelity import STUDY as FIDELITY
from experiments.studies.sensitivity import STUDY as SENSITIVITY
from tests.bench.stats.test_replicates import rows_of

COUNTS = (
    Count(40), Count(20, 20), Count(0, 40), Count(3, 2), Count(5), Count(1, random=False),
    Count(0, 0, {"silent model": 40}), Count(0, 5, {"unknown constants": 35}), Count(0, 0, {"not shown": 1}),
)  # fmt: skip
"""One of every kind, and of those without a word some that hold in all, and some of every reason."""


def verdict(claim, count, **more):
    results = ["fails"] * count.fails + ["holds"] * count.holds + list(count.unjudged)
    decided = "0.1 (needs 0.2)" * (results[0] in ("holds", "fails"))
    outcome = Outcome(results[0], "0.1 | measured", decided=decided, n=20)
    place = "" if "not shown" in count.unjudged else "speed"
    return Verdict(claim, words(claim).says, words(claim).source, outcome, count, experiment=place, **more)


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """A reproduction as `reproduce` returns it, without runs, with claims of every count in turn."""
    told = {claim: verdict(claim, COUNTS[place % len(COUNTS)]) for place, claim in enumerate(claim_ids(PAPER))}
    reading_chapters = chapters(Evidence(told, (Replicate((), {}, {}),), (), {}))
    plan = study_run.planned(dataclasses.replace(SENSITIVITY, repeats=5))
    moved, folder = Counts(plan, rows_of(plan.specs)), tmp_path_factory.mktemp("report")
    Files(folder).write_json("sensitivity.json", moved.described())
    behaviour_verdicts = [verdict("B1", Count(0, 1))]
    return Reproduction(
        folder, FULL, 0, list(told.values()), {}, [], [], moved, [], behaviour_verdicts,
        {}, {"versions": {"colias-sim": "0"}}, reading_chapters,
    )  # fmt: skip


class Page(HTMLParser):
    """Elements of a page: (tag, attributes, text up to the next tag)."""

    def __init__(self, text):
        super().__init__()
        self.elements = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append([tag, dict(attrs), ""])

    def handle_data(self, data):
        if self.elements:
            self.elements[-1][2] += data

    def of(self, name):
        """Places of the elements of a class."""
        return [at for at, (_, attrs, _) in enumerate(self.elements) if name in attrs.get("class", "").split()]


@pytest.fixture(scope="module")
def text(result):
    return report.page(result)


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def tiles(page):
    """Claim -> (sign and word of its tile, its class, where it leads)."""
    by_claim = {}
    for at in page.of("tile"):
        _, attrs, _ = page.elements[at]
        claim, word = (page.elements[at + offset][2].strip() for offset in (2, 3))
        by_claim[claim] = (word, attrs["class"], attrs["href"])
    return by_claim


def test_tiles_claims_json_and_terminal_show_the_same_verdicts(result, page, capsys):
    labels = {claim.id: claim.count.label for claim in result.claims}
    assert {claim.count.kind for claim in result.claims} == set(MEANINGS)
    assert {claim: text.partition(" ")[2] for claim, (text, *_) in tiles(page).items() if claim in labels} == labels
    content = json.loads(to_json(stored_verdicts.document(result.claims)))
    assert {claim.id: claim.count.label for claim in stored_verdicts.verdicts(content)} == labels
    show_claims(result.claims, {})
    printed = capsys.readouterr().out
    in_table = dict(re.findall(r"^(C\d+) +(holds|fails|sometimes|not judged|-)  ", printed, re.MULTILINE))
    judged = {claim.id: claim.count for claim in result.claims if claim.experiment}
    assert in_table == {claim: count.label if count.kind != "counted" else "-" for claim, count in judged.items()}
    total = " ".join(printed.partition("\n\n")[2].split("\n\n")[0].split())
    first = re.search(r'<p class="lead">(.*?)</p>', html.unescape(report.page(result)))[1]
    lead = " ".join(re.sub("<[^>]*>", "", first).split())
    assert lead == f"{total}."


def test_every_claim_has_a_tile_that_leads_to_its_evidence(result, page):
    by_claim = tiles(page)
    counts = {claim.id: claim.count for claim in (*result.claims, *result.own_claims)}
    assert list(by_claim) == list(counts)
    cards = {}
    for at in page.of("claim"):  # a folded one has its id inside, so that a link to it unfolds it
        inside = next(attrs for _, attrs, _ in page.elements[at:] if "id" in attrs)
        cards[inside["id"]] = page.elements[at][1]["class"]
    for claim, (text, style, target) in by_claim.items():
        count = counts[claim]
        assert text == f"{SIGNS[count.kind]} {count.label}" and style.split() == ["tile", count.kind]
        assert target == f"#{claim}" and cards[claim].split() == ["claim", count.kind]
    assert list(cards) == list(by_claim)


def test_links_lead_somewhere_and_no_id_comes_twice(text, page):
    ids = [attrs["id"] for _, attrs, _ in page.elements if "id" in attrs]
    assert len(ids) == len(set(ids))
    targets = {attrs["href"] for tag, attrs, _ in page.elements if tag == "a"}
    assert {target[1:] for target in targets if target.startswith("#")} <= set(ids)
    contents = re.search(r'<nav aria-label="Contents">(.*?)</nav>', text, re.DOTALL)[1]
    assert {"claims", "readings", "behaviours", "sensitivity", "robot", "glossary"} <= set(
        re.findall(r'href="#([^"]*)"', contents)
    )
    chapters = [page.elements[at:] for at in page.of("chapter")]
    ids = {next(attrs["id"] for tag, attrs, _ in after if "id" in attrs and tag != "section") for after in chapters}
    assert len(ids) == len(chapters) > 5
    assert ids <= set(re.findall(r'href="#([^"]*)"', contents)), "every chapter is in the contents"


def test_the_page_needs_no_script_and_every_picture_has_words(text, page):
    assert "<script" not in text and "javascript:" not in text
    assert not [name for _, attrs, _ in page.elements for name in attrs if name.startswith("on")]
    assert all(attrs.get("alt") for tag, attrs, _ in page.elements if tag == "img")


@pytest.mark.parametrize("claim", claim_ids(PAPER))
def test_sources_are_the_paper_s_own_numbers(claim, text):
    source = words(claim).source
    assert re.search(r"(Fig|Eq)\. \d", source) and f"The paper ({source})" in text


# Colours.


def luminance(colour):
    """Relative luminance of sRGB, as WCAG 2 defines it."""
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


# Cards.


# What other commands left in the folder.


def test_maps_studies_and_models_claims_in_the_folder_are_shown(result, tmp_path):
    for name in ("a-map", "eyes", "models"):
        (tmp_path / name).mkdir()
    (tmp_path / "a-map" / "map.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    plan = study_run.planned(dataclasses.replace(FIDELITY, repeats=5, replicates=2))
    Files(tmp_path / "eyes").write_json("fidelity.json", Counts(plan, rows_of(plan.specs)).described())
    models = [dataclasses.replace(verdict("B1", Count(0, 1, random=False)), id="LPLC2-1", model="lplc2")]
    content = stored_verdicts.document(models)
    (tmp_path / "models" / "model_claims.json").write_text(to_json(content))
    text = report.page(dataclasses.replace(result, folder=tmp_path))
    assert 'id="figure-map-a-map"' in text and 'href="#maps"' in text
    assert re.search(r'<th class="whole">ov7670, open loop</th><td class="cell holds[^"]*">2 of 2<br>', text)
    assert "How the stimulus moved" in text and 'href="#fidelity"' in text
    assert re.search(r"lplc2</td><td[^>]*>LPLC2-1</td><td[^>]*><span class=\"chip fails\">", text)
    stored_parts = stored(tmp_path)
    assert (len(stored_parts.maps), len(stored_parts.models)) == (1, 1)
    assert read(tmp_path / "models", "model_claims")["claims"] and read(tmp_path, "nothing") is None


# What drew the frames.

(SEEN,) = KNOWN


# Figures.

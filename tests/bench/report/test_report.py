"""The report's page: every claim has its tile and evidence, links lead somewhere, and its colours can be read."""

import dataclasses
import html
import json
import re
from html.parser import HTMLParser
from importlib.resources import files

import pyarrow as pa
import pytest

from colias_sim.reference import KNOWN
from experiments import NAMES
from experiments.bench import registry
from experiments.bench.clips import figure as clips_figure
from experiments.bench.closed_loop.run import Played
from experiments.bench.judging import stored as stored_verdicts
from experiments.bench.judging.claim_files import PAPER, claim_ids
from experiments.bench.judging.claims import bears_on, readings_of_all, words
from experiments.bench.judging.count import MEANINGS, SIGNS, Count
from experiments.bench.judging.paper import cited, numbers
from experiments.bench.judging.scores import Standing
from experiments.bench.judging.verdict import Outcome, Verdict
from experiments.bench.reproduction import report
from experiments.bench.reproduction.page.cards import NOTHING_TRIED, cards
from experiments.bench.reproduction.page.overview import NO_CAUSE, SILENT
from experiments.bench.reproduction.page.stored import stored
from experiments.bench.reproduction.plan import FULL
from experiments.bench.reproduction.readings import Evidence, chapters
from experiments.bench.reproduction.reproduce import Reproduction
from experiments.bench.reproduction.table import show_claims
from experiments.bench.robot.claims import paper_claims as robot_claims
from experiments.bench.robot.plan import plan
from experiments.bench.robot.summary import Report
from experiments.bench.store.description import to_json
from experiments.bench.store.files import Files
from experiments.bench.studies import registry as registry_of_studies
from experiments.bench.studies import run as study_run
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.registry import names as study_names
from experiments.bench.studies.replicates import Replicate
from experiments.bench.studies.stored import read
from experiments.claims.readings import READINGS
from experiments.studies.fidelity import STUDY as FIDELITY
from experiments.studies.sensitivity import STUDY as SENSITIVITY
from tests.bench.judging.test_replicates import rows_of
from tests.helpers.browser import CHROMIUM, browser
from tools.numbers import blocks, kept

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


def test_tiles_claims_json_terminal_and_readme_show_the_same_verdicts(result, page, capsys):
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
    scale = dataclasses.asdict(result.scale)
    results = {"design": {"scale": scale, "seed": 0, "digest": ""}, "measured_with": {"commit": "0"},
               "behaviours": [], "scores": [],
               "claims": [{**kept(claim), "rate": ""} for claim in result.claims]}  # fmt: skip
    readme = blocks(results)["verdicts"]
    rows = dict(re.findall(r"^\| (C\d+) \| .* \| (\w+|-) \| [^|]* \|$", readme, re.MULTILINE))
    assert rows == {claim.id: claim.count.word or "-" for claim in result.claims}
    (total,) = {readme.partition(". A replicate")[0], " ".join(printed.partition("\n\n")[2].split("\n\n")[0].split())}
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


def test_the_first_screen_says_why_claims_do_not_hold(result, text):
    first = text.partition('id="claims"')[0].replace("&#39;", "'")
    for claim in result.claims:
        count, cause = claim.count, words(claim.id).cause or NO_CAUSE
        if "silent model" in count.unjudged:
            assert SILENT in first
        elif "unknown constants" in count.unjudged or (count.fails and count.word != "holds"):
            assert f"</strong>: {cause}</li>" in first, claim.id
        elif "not shown" in count.unjudged:
            assert re.search(rf"Not judged here:</strong>[^.]*\b{claim.id}\b", first)
    assert "6,200" not in first and "What the robot saw" in first, "trials are counted from the runs: here are none"


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


def own_experiment(folder, name):
    """A run of an experiment of one's own, with a figure."""
    run_plan = plan(dataclasses.replace(registry.load("speed"), name=name), ["dsnn"], (), 1, 0)
    (folder / name).mkdir(parents=True)
    (folder / name / "figure.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    return run_plan, Report(folder / name, "speed_cm_s", "spikes", rows_of(run_plan.specs()), [], [], [], "", [], [])


def test_an_own_experiment_may_be_called_like_anything_on_the_page(result, page, tmp_path):
    """As every id that the page has without it, as a chapter of another study, and as a map or a behaviour's figure."""
    taken = {attrs["id"] for _, attrs, _ in page.elements if "id" in attrs}
    taken |= {*study_names(), "map-a", "behave-a"}
    names = sorted(name for name in taken if re.fullmatch(r"[A-Za-z0-9][\w-]*", name))
    assert {"claims", "top", "onboard", "C1"} <= set(names)
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "map.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    runs = [own_experiment(tmp_path, name) for name in names]
    played = Played(runs[0][1].folder.with_name("behave-a"), "colias_sim/Fixation-v0", [Standing("still", {}, [])],
                    pa.table({}), [])  # fmt: skip
    new_page = Page(report.page(dataclasses.replace(result, folder=tmp_path, runs=runs, behaviours=[played])))
    ids = [attrs["id"] for _, attrs, _ in new_page.elements if "id" in attrs]
    assert sorted(page_id for page_id in set(ids) if ids.count(page_id) > 1) == []
    assert {f"experiment-{name}" for name in names} <= set(ids)
    assert sum(attrs.get("class") == "plate" for _, attrs, _ in new_page.elements) == len(names) + 2
    targets = {attrs["href"][1:] for tag, attrs, _ in new_page.elements if tag == "a" and attrs["href"].startswith("#")}
    assert targets <= set(ids)


def test_the_page_needs_no_script_and_every_picture_has_words(text, page):
    assert "<script" not in text and "javascript:" not in text
    assert not [name for _, attrs, _ in page.elements for name in attrs if name.startswith("on")]
    assert all(attrs.get("alt") for tag, attrs, _ in page.elements if tag == "img")
    assert "prefers-color-scheme: dark" in text and "@media print" in text


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium: on Debian run 'apt-get install chromium'")
def test_evidence_is_folded_on_the_screen_and_open_in_print(result, text, tmp_path):
    """On a phone the folded page has a third of its length at most; a link unfolds what it leads to; tiles filter."""
    (tmp_path / "report.html").write_text(text)
    counts = {claim.id: claim.count for claim in (*result.claims, *result.own_claims)}
    seen = "e => e.checkVisibility({contentVisibilityProperty: true})"
    tiles_seen = f"[...document.querySelectorAll('.tile')].filter({seen}).map(e => e.hash.slice(1))"
    with browser(tmp_path / "profile") as tab:
        tab.show((tmp_path / "report.html").as_uri(), 390, 844, phone=True)
        tab.until("document.readyState == 'complete'")
        height = "document.documentElement.scrollHeight"
        folded = tab.ask(height)
        assert tab.ask("document.documentElement.scrollWidth") <= 390
        assert not tab.ask(f"({seen})(document.getElementById('C15'))")
        tab.ask("document.querySelector('a.tile[href=\"#C15\"]').click()")
        assert tab.until(f"({seen})(document.getElementById('C15'))")
        assert tab.ask(tiles_seen) == list(counts)
        tab.ask("document.getElementById('filter-broken').click()")
        broken = [claim for claim, count in counts.items() if count.fails and count.kind not in ("holds", "unjudged")]
        assert tab.ask(tiles_seen) == broken
        tab.ask("document.getElementById('filter-all').click()")
        tab.ask("document.querySelectorAll('details').forEach(e => e.open = true)")
        assert folded <= tab.ask(height) / 3
        tab.ask("document.querySelectorAll('details').forEach(e => e.open = false)")
        tab.call("Emulation.setEmulatedMedia", media="print")
        closed = f"[...document.querySelectorAll('.unfolded')].filter(e => !({seen})(e)).length"
        assert tab.ask(closed) == 0


def test_a_reading_that_all_claims_share_is_told_once_outside_its_chapter(text):
    claims = text[text.index('id="claims"') : text.index('id="readings"')]
    for common in readings_of_all():
        assert claims.count(common.name) == 1
        assert text.count(common.note) == 1


@pytest.mark.parametrize("claim", claim_ids(PAPER))
def test_sources_are_the_paper_s_own_numbers(claim, text):
    source = words(claim).source
    citation = cited(source)
    assert re.search(r"(Fig|Eq)\. \d", citation) and not any(label in citation for label in numbers() if "-" in label)
    assert f"The paper ({citation})" in text and f"({source})" not in text


def test_figures_are_numbered_in_the_paper_s_order():
    """What its text says of single figures: 17 of them, the robot's results last, and the model's diagram third."""
    kinds = [name.split()[0] for name in numbers().values()]
    assert (kinds.count("Fig."), kinds.count("Eq.")) == (17, 16)
    assert cited("robot-sys-ar, robot-sys-trans; dsn (c)") == "Fig. 17, Fig. 16; Fig. 3 (c)"
    assert cited("a dsnn, dsn2017 and my-dsn") == "a dsnn, dsn2017 and my-dsn"


# Colours.

STYLE = files("experiments.bench.reproduction").joinpath("page/style.css").read_text(encoding="utf-8")


def schemes():
    """The named colours of the light and of the dark scheme."""
    light, dark = re.findall(r":root \{(.*?)\}", STYLE, re.DOTALL)
    return {name: dict(re.findall(r"--([\w-]+): (#\w{6})", css)) for name, css in (("light", light), ("dark", dark))}


def luminance(colour):
    """Relative luminance of sRGB, as WCAG 2 defines it."""
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one, other):
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_can_be_read_in_both_schemes(scheme):
    colours = schemes()[scheme]
    assert colours.keys() == schemes()["light"].keys()
    grounds = {
        "plate-text": ("plate",),
        "plate-link": ("plate",),
        **dict.fromkeys(("text", "quiet", "link"), ("ground", "panel")),
    }
    for word in MEANINGS:
        grounds[f"{word}-ink"] = (f"{word}-ground", "ground")
    grounds["text"] += tuple(f"{word}-ground" for word in MEANINGS)
    for ink, backgrounds in grounds.items():
        for ground in backgrounds:
            assert contrast(colours[ink], colours[ground]) >= 4.5, (scheme, ink, ground)


def test_rules_use_named_colours_alone():
    rules = re.sub(r":root \{.*?\}", "", STYLE, flags=re.DOTALL)
    assert not re.findall(r"#[0-9a-fA-F]{3,8}\b|rgba?\(|hsl", rules)
    edges = re.findall(r"^\.(\w+) \{ --ink: .* --edge: (\w+); \}$", STYLE, re.MULTILINE)
    assert [word for word, _ in edges] == list(MEANINGS)
    assert dict(edges)["holds"] not in {edge for word, edge in edges if word != "holds"}, "not by colour alone"


# Cards.


SOMETIMES = Count(3, 2)


def dressed(result, claim, folder, count=SOMETIMES, experiment="speed", **more):
    """The card of one claim that came to a count."""
    claim_verdict = dataclasses.replace(verdict(claim, count), experiment=experiment)
    (card,) = cards(dataclasses.replace(result, claims=[claim_verdict], folder=folder, **more))
    return card


@pytest.mark.parametrize("claim", claim_ids(PAPER))
@pytest.mark.parametrize("count", COUNTS, ids=str)
def test_what_was_tried_stands_where_a_claim_does_not_hold(result, claim, count, tmp_path):
    """Not where its word is that it holds, nor where it held in every replicate, nor where nothing judged it."""
    holds = count.word == "holds" or count.holds == count.replicates
    card = dressed(result, claim, tmp_path, count)
    assert card.tried == ("" if holds else words(claim).tried or NOTHING_TRIED)
    assert dressed(result, claim, tmp_path, count, experiment="").tried == ""


def test_other_detectors_stand_in_the_card_of_c21_alone(result, tmp_path):
    plan = study_run.planned(
        dataclasses.replace(registry_of_studies.find("detectors"), replicates=1, repeats=5, tables=None)
    )
    counts = Counts(plan, rows_of(plan.specs))
    Files(tmp_path).write_json("detectors.json", counts.described())
    models = {model.label for model in plan.models}
    assert all(name in dressed(result, "C21", tmp_path).tried for name in models)
    assert "Held, by detector" not in dressed(result, "C20", tmp_path).tried
    assert not dressed(result, "C21", tmp_path, Count(5)).tried


def test_the_rate_of_trials_is_told_of_claims_about_every_single_one(result, tmp_path):
    about_trials = {claim for claim, declaration in robot_claims().items() if declaration.of_every_trial}
    assert {"C13", "C14"} <= about_trials < set(robot_claims())
    for claim in robot_claims():
        whole = Outcome("fails", "0.3", n=50, broken=4)
        card = dressed(result, claim, tmp_path, pooled={claim: whole})
        assert card.rate.startswith("4 of 50 trials break it, 8.0%") == (claim in about_trials), claim
        assert bool(card.rate) == (claim in about_trials)
        assert not dressed(result, claim, tmp_path).rate, "nothing was put together"
    uncounted = dressed(result, "C13", tmp_path, pooled={"C13": Outcome("holds", "0.3", n=50)})
    assert not uncounted.rate


def test_all_trials_together_are_told_of_several_replicates(result, tmp_path):
    pooled = {"C15": Outcome("fails", "0.3 of all")}
    assert dressed(result, "C15", tmp_path, pooled=pooled).pooled == "fails: 0.3 of all"
    assert dressed(result, "C15", tmp_path, Count(0, 1), pooled=pooled).pooled == ""
    assert dressed(result, "C16", tmp_path, pooled=pooled).pooled == ""


def test_a_mechanism_is_led_to_where_its_experiment_was_run(result, tmp_path):
    for claim in claim_ids(PAPER):
        place, what = words(claim).mechanism
        elsewhere = dressed(result, claim, tmp_path, runs=[], experiment="speed").mechanism
        assert elsewhere[0] == "speed" and "no figure of the mechanism" in elsewhere[1]
        assert dressed(result, claim, tmp_path, runs=[], experiment="").mechanism == ("none", "not judged")
        if place in NAMES:
            run = own_experiment(tmp_path / claim, place)
            assert dressed(result, claim, tmp_path, runs=[run]).mechanism == (place, what)


@pytest.mark.parametrize("claim", claim_ids(PAPER))
def test_other_readings_stand_in_the_cards_of_the_claims_that_they_were_chosen_for(result, claim, tmp_path):
    card = dressed(result, claim, tmp_path)
    of_it = {reading for reading in READINGS if not reading.of_all and claim in bears_on(reading)}
    assert {reading for reading, _ in card.readings} == of_it
    assert all(row.claim == claim and len(row.others) == len(reading.others) for reading, row in card.readings)
    assert set(card.used) == {reading.name for reading in of_it if reading.used}


# What other commands left in the folder.


def test_maps_studies_and_models_claims_in_the_folder_are_shown(result, tmp_path):
    for name in ("a-map", "eyes", "models", "broken"):
        (tmp_path / name).mkdir()
    (tmp_path / "a-map" / "map.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    plan = study_run.planned(dataclasses.replace(FIDELITY, repeats=5, replicates=2))
    Files(tmp_path / "eyes").write_json("fidelity.json", Counts(plan, rows_of(plan.specs)).described())
    models = [dataclasses.replace(verdict("B1", Count(0, 1, random=False)), id="LPLC2-1", model="lplc2")]
    content = stored_verdicts.document(models)
    (tmp_path / "models" / "model_claims.json").write_text(to_json(content))
    (tmp_path / "broken" / "fidelity.json").write_text("{")
    text = report.page(dataclasses.replace(result, folder=tmp_path))
    assert 'id="figure-map-a-map"' in text and 'href="#maps"' in text
    assert re.search(r'<th class="whole">ov7670, open loop</th><td class="cell holds[^"]*">2 of 2<br>', text)
    assert "How the stimulus moved" in text and 'href="#fidelity"' in text
    assert re.search(r"lplc2</td><td[^>]*>LPLC2-1</td><td[^>]*><span class=\"chip fails\">", text)
    stored_parts = stored(tmp_path)
    assert (len(stored_parts.maps), len(stored_parts.models)) == (1, 1)
    assert read(tmp_path / "models", "model_claims")["claims"] and read(tmp_path, "nothing") is None


# What drew the frames.

LLVMPIPE = "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 (Compatibility Profile) Mesa 22.3.6, by egl"
CARD = "NVIDIA GeForce RTX 3060/PCIe/SSE2, OpenGL 4.6.0 NVIDIA 535.183.01, by egl"
(SEEN,) = KNOWN


def drawn_section(result, folder, parts):
    """What the report says of parts that note these renderers and reference frames, without its tags."""
    for name, (renderers, frames) in parts.items():
        (folder / name).mkdir(parents=True)
        entries = {"renderers": renderers, "reference_frames": frames}
        (folder / name / "experiment.json").write_text(json.dumps({k: v for k, v in entries.items() if v is not None}))
    text = report.page(dataclasses.replace(result, folder=folder))
    section = text[text.index("What drew the frames") :].partition("<details")[0]
    return " ".join(re.sub("<[^>]*>", "", section).split())


def test_the_report_names_the_renderer_and_its_reference_frame(result, tmp_path):
    section = drawn_section(result, tmp_path, {"speed": ([LLVMPIPE], [SEEN]), "replicates": ([LLVMPIPE], [SEEN])})
    assert section.count(LLVMPIPE) == 1 and "software" in section and "differ" not in section
    assert f"reference frame {SEEN}, known from {KNOWN[SEEN]}" in section


def test_a_card_s_frames_are_not_called_software_and_an_unknown_hash_is_told(result, tmp_path):
    section = drawn_section(result, tmp_path, {"speed": ([CARD], ["0123456789abcdef"])})
    assert CARD in section and "software" not in section
    assert "reference frame 0123456789ab, not known" in section


@pytest.mark.parametrize(
    "hash_, told",
    [("0123456789ab", "drawn with pixels that differ: 2 reference frames"), (SEEN, "drawn by 2 renderers, with equal")],
)
def test_parts_that_were_drawn_differently_are_told_apart(result, tmp_path, hash_, told):
    parts = {"distance": ([LLVMPIPE], [SEEN]), "speed": ([CARD], [hash_]), "a/map": ([LLVMPIPE], [SEEN])}
    section = drawn_section(result, tmp_path, parts)
    assert section.count(told) == 1
    assert f"a/map, distance: {LLVMPIPE}" in section and f"speed: {CARD}" in section


def test_one_part_that_two_machines_drew_is_told_too(result, tmp_path):
    section = drawn_section(result, tmp_path, {"speed": ([LLVMPIPE, CARD], [SEEN, "0123456789ab"])})
    assert "2 reference frames" in section and LLVMPIPE in section and CARD in section


def test_notes_that_are_not_there_or_damaged_are_left_out(result, tmp_path):
    parts = {"clips": (None, None), "damaged": ([3], "llvmpipe")}
    assert "No part of this reproduction notes what drew its frames." in drawn_section(result, tmp_path, parts)


# Figures.


def test_panels_of_a_row_have_equal_scales_with_all_curves_inside():
    """A weak model beside one at its ceiling: neither is stretched, and neither leaves its panel."""
    rows = [
        {"object": "dark", "speed_unit": "px/s", "model": model, "speed": speed, "grey": grey, "background_speed": -8.0,
         "peak_hs": largest * speed / 120, "trough_hs": 0.0, "peak_vs": 0.0, "trough_vs": 0.0}
        for model, largest in (("dsnn", 0.2), ("dsn2017", 1.0)) for speed in (40.0, 120.0) for grey in (0.0, 255.0)
    ]  # fmt: skip
    drawing = registry.find("clutter-speed").figure
    drawn = clips_figure.draw(drawing, rows, pa.table({}), {"dsnn": 0.16}, "clutter-speed")
    drawn.draw_without_rendering()
    weak, strong = drawn.axes[:2]
    assert weak.get_ylim() == strong.get_ylim()
    for axes in drawn.axes:
        low, high = axes.get_ylim()
        assert low == 0.0 and all(max(line.get_ydata()) <= high for line in axes.lines)

"""Pages: figures, each made by the command that is shown beside it, when the documentation is built."""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

LONGEST_S = 180


@dataclass(frozen=True)
class Entry:
    """A card of the gallery."""

    title: str
    command: str
    """Command of the card. It runs in a folder that the cards before it have left their results in."""
    picture: str
    """The file that it makes, below that folder."""
    words: str
    guide: str
    """The page that says more, and how its link reads: ``PAGE|WORDS``."""


ENTRIES = (
    Entry("Speed", "colias run speed --repeats 3 --out speed", "speed/figure.png",
          "Spikes against the speed of a Colias that crosses 8 cm away. Each dot is a trial.",
          "robot-trials.md|Robot trials"),
    Entry("A trial in one strip", "colias video speed --trial 7 --frames 5 --out strip.png", "strip.png",
          "What the camera saw at five moments of one of these trials, where the robots were, and what HS and VS said.",
          "video.md|Videos and pictures"),
    Entry("Angular approach", "colias run angular-approach --repeats 2 --no-recordings --out approach",
          "approach/figure.png", "Spikes against the angle of the approach: fewest straight ahead.",
          "robot-trials.md|Robot trials"),
    Entry("Excitation and inhibition", "colias run approach-mechanism --repeats 1 --no-recordings --out mechanism",
          "mechanism/figure.png", "Why an approach from the left elicits more spikes than one from the right.",
          "what-the-numbers-mean.md|What the numbers mean"),
    Entry("Two models on the same frames",
          "colias run contrast --model emd --repeats 1 --no-recordings --out contrast",
          "contrast/figure.png", "The DSNN and an array of elementary motion detectors, before shells of all greys.",
          "your-own-model.md|Your own model"),
    Entry("Clips", "colias run clean --no-recordings --out clean", "clean/figure.png",
          "The paper's off-line stimuli on an even ground: translation, looming and recession.",
          "footage.md|Footage"),
    Entry("ON and OFF", "colias run edges --no-recordings --out edges", "edges/figure.png",
          "One edge in view. Blocking the pathway that it drives silences HS.",
          "what-the-numbers-mean.md|What the numbers mean"),
    Entry("A tuning curve", "colias tune --model lgmd1 --only --curve speed --out tuning", "tuning/speed.png",
          "The answer against the speed of what moves.", "your-own-model.md|Your own model"),
    Entry("A map of claims",
          "colias map clean --over dsnn.n_con=4,6,8 --over dsnn.d=1,2 --claims C1,C3 --replicates 1 --out map",
          "map/map.png", "At which connections and sampling distances two claims hold. The defaults have red frames.",
          "maps.md|Maps"),
    Entry("A reflex in the loop", "colias behave optomotor --episodes 3 --no-recordings --out optomotor",
          "optomotor/figure.png", "Headings held against a turning drum by HS, beside baselines.",
          "behaviours-and-training.md|Behaviours and training"),
)  # fmt: skip
HEAD = """# Gallery

Each figure was made by the command below it when these pages were built.
Few repeats keep that short: without `--repeats` a run has those of the paper.

"""


def write(folder: Path) -> None:
    """Run every command of `ENTRIES`, and write its figure and the page into ``folder``."""
    pictures = []
    with tempfile.TemporaryDirectory() as place:
        for number, entry in enumerate(ENTRIES):
            _run(entry, Path(place))
            pictures.append(f"{number}-{Path(entry.picture).name}")
            shutil.copy(Path(place, entry.picture), folder / pictures[-1])
    entries = list(zip(ENTRIES, pictures, strict=True))
    thumbnails = "\n".join(_thumbnail(entry, picture) for entry, picture in entries)
    sections = "\n".join(_section(entry, picture) for entry, picture in entries)
    text = f"{HEAD}::::{{grid}} 2 2 3 3\n:gutter: 2\n\n{thumbnails}::::\n\n{sections}"
    (folder / "index.md").write_text(text, encoding="utf-8")


def _run(entry: Entry, place: Path) -> None:
    program, *arguments = shlex.split(entry.command)
    command = [str(Path(sys.executable).with_name(program)), *arguments]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, timeout=LONGEST_S, check=False)
    if done.returncode:
        raise RuntimeError(f"the gallery's command fails: {entry.command}: {done.stderr.strip()}")
    if not (place / entry.picture).exists():
        raise RuntimeError(f"the gallery's command has left no {entry.picture}: {entry.command}")


def _label(entry: Entry) -> str:
    return f"gallery-{entry.title.lower().replace(' ', '-')}"


def _thumbnail(entry: Entry, picture: str) -> str:
    link = f":link: {_label(entry)}\n:link-type: ref"
    return f":::{{grid-item-card}} {entry.title}\n:img-bottom: {picture}\n:img-alt: {entry.words}\n{link}\n:::\n\n"


def _section(entry: Entry, picture: str) -> str:
    page, words = entry.guide.split("|")
    return (
        f"({_label(entry)})=\n## {entry.title}\n\n{entry.words}\n\n![{entry.words}]({picture})\n\n"
        f"```sh\n{entry.command}\n```\n\nMore: [{words}](../../{page})\n"
    )

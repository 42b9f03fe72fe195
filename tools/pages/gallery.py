"""Pages: figures, each made by the command that is shown beside it, when the documentation is built."""

from __future__ import annotations

import os
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
    """It runs in a folder that the cards before it have left their results in."""
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
    Entry("A tuning curve", "colias tune --model lgmd1 --curve speed --out tuning", "tuning/figure.png",
          "The answer against the speed of what moves.", "your-own-model.md|Your own model"),
    Entry("A map of claims",
          "colias map speed --over experiment.acceleration_cm_s2=10,17 --over dsnn.n_con=4,8 --claims C15 "
          "--repeats 1 --replicates 1 --out map", "map/figure.png",
          "Where in a grid of two parameters claims hold. Here with one trial of each condition.", "maps.md|Maps"),
    Entry("A reflex in the loop", "colias behave optomotor --episodes 3 --no-recordings --out optomotor",
          "optomotor/figure.png", "Headings held against a turning drum by HS, beside baselines.",
          "behaviours-and-training.md|Behaviours and training"),
)  # fmt: skip
HEAD = """# Gallery

Each figure was made by the command below it when these pages were built.
Few repeats keep that short: a run of your own leaves the repeats out, and has the paper's.

"""


def write(folder: Path) -> None:
    """Run every command of `ENTRIES`, and write its figure and the page into ``folder``."""
    cards = []
    with tempfile.TemporaryDirectory() as place:
        for number, entry in enumerate(ENTRIES):
            _run(entry, Path(place))
            picture = f"{number}-{Path(entry.picture).name}"
            shutil.copy(Path(place, entry.picture), folder / picture)
            cards.append(_card(entry, picture))
    (folder / "index.md").write_text(HEAD + "\n".join(cards), encoding="utf-8")


def _run(entry: Entry, place: Path) -> None:
    program, *arguments = shlex.split(entry.command)
    command = [str(Path(sys.executable).with_name(program)), *arguments]
    done = subprocess.run(command, cwd=place, env=os.environ, capture_output=True, text=True, timeout=LONGEST_S)
    if done.returncode:
        raise RuntimeError(f"the gallery's command fails: {entry.command}: {done.stderr.strip()}")
    if not (place / entry.picture).exists():
        raise RuntimeError(f"the gallery's command has left no {entry.picture}: {entry.command}")


def _card(entry: Entry, picture: str) -> str:
    page, words = entry.guide.split("|")
    return (
        f"## {entry.title}\n\n{entry.words}\n\n![{entry.words}]({picture})\n\n```sh\n{entry.command}\n```\n\n"
        f"More: [{words}](../../{page})\n"
    )

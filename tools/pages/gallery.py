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
    """Commands of the card, one a line. They run in a folder that the cards before it have left their results in."""
    picture: str
    """The file that it makes, below that folder."""
    words: str
    guide: str
    """The page that says more, and how its link reads: ``PAGE|WORDS``."""
    script: str = ""
    """A Python file that the command runs: its name is the command's last word."""


LAYERS = """import matplotlib.pyplot as plt

from dsnn import DSNN, DSNNParams
from dsnn.stimuli import stimulus

clip = stimulus("plain", rows=90, columns=160, width=25, height=45)
model = DSNN(clip.shape, DSNNParams.offline())
frames = list(clip)[:31]
for frame in frames:
    maps = model.step(frame.luma, maps=True).maps
layers = {"camera": frames[-1].luma, "retina: change": maps.p, "lamina": maps.la, "ON": maps.f_on, "OFF": maps.f_off}
drawn, axes = plt.subplots(1, 5, figsize=(12, 1.9), layout="constrained")
for panel, (name, layer) in zip(axes, layers.items()):
    signed = name in ("retina: change", "lamina")
    top = abs(layer).max() or 1
    looks = {"cmap": "PuOr_r", "vmin": -top, "vmax": top} if signed else {"cmap": "gray"}
    panel.imshow(layer, **looks)
    panel.set(title=name, xticks=[], yticks=[])
drawn.savefig("layers.png", dpi=110)
"""


ENTRIES = (
    Entry("A trial in motion",
          "colias run speed --repeats 3 --out speed\n"
          "colias video speed --trial 7 --out trial.webp --size 640x360 --fps 10 --speed 0.5", "trial.webp",
          "A Colias crosses the view of another: the arena, the camera, what changed, HS with its threshold, spikes.",
          "video.md|Videos and pictures"),
    Entry("The layers of the network", "python layers.py", "layers.png",
          "One frame of a bar that moves to the right, through retina and lamina to the ON and OFF pathways.",
          "questions/layer-maps.md|Layer maps", LAYERS),
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
    Entry("Before a moving scene",
          "colias run clutter-translation --out clutter\n"
          "colias video clutter --model dsnn --out clutter.webp --size 640x360 --fps 10", "clutter.webp",
          "An object crosses a picture of nature that moves the other way, as footage is shown to the network.",
          "footage.md|Footage"),
    Entry("ON and OFF", "colias run edges --no-recordings --out edges", "edges/figure.png",
          "One edge in view. Blocking the pathway that it drives silences HS.",
          "what-the-numbers-mean.md|What the numbers mean"),
    Entry("A tuning curve", "colias tune --model lgmd1 --only --curve speed --out tuning", "tuning/speed.png",
          "The answer against the speed of what moves.", "your-own-model.md|Your own model"),
    Entry("A map of claims",
          "colias sweep clean --over dsnn.n_con=4,6,8 --over dsnn.d=1,2 --claims C1,C3 --replicates 1 --out map",
          "map/sweep.png", "At which connections and sampling distances two claims hold. Triangles mark the defaults.",
          "maps.md|Maps"),
    Entry("An episode in motion",
          "colias behave avoidance --episodes 1 --no-baselines --out avoidance\n"
          "colias video avoidance --out avoidance.webp --size 640x360 --fps 5 --speed 4", "avoidance.webp",
          "The arena with its obstacles from above, and the robot that avoids them by what it sees.",
          "behaviours-and-training.md|Behaviours and training"),
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
        for entry in ENTRIES:
            _run(entry, Path(place))
            pictures.append(picture_name(entry))
            shutil.copy(Path(place, entry.picture), folder / pictures[-1])
    entries = list(zip(ENTRIES, pictures, strict=True))
    thumbnails = "\n".join(_thumbnail(entry, picture) for entry, picture in entries)
    sections = "\n".join(_section(entry, picture) for entry, picture in entries)
    text = f"{HEAD}::::{{grid}} 2 2 3 3\n:gutter: 2\n\n{thumbnails}::::\n\n{sections}"
    (folder / "index.md").write_text(text, encoding="utf-8")


def picture_name(entry: Entry) -> str:
    """Return the file in the gallery's folder that has a card's picture."""
    return f"{_slug(entry)}{Path(entry.picture).suffix}"


def _slug(entry: Entry) -> str:
    return entry.title.lower().replace(" ", "-")


def _run(entry: Entry, place: Path) -> None:
    if entry.script:
        Path(place, entry.command.split()[-1]).write_text(entry.script, encoding="utf-8")
    for line in entry.command.splitlines():
        program, *arguments = shlex.split(line)
        command = [str(Path(sys.executable).with_name(program)), *arguments]
        done = subprocess.run(
            command, cwd=place, capture_output=True, text=True, timeout=LONGEST_S, check=False,
            env={**os.environ, "MPLBACKEND": "agg"},
        )  # fmt: skip
        if done.returncode:
            raise RuntimeError(f"the gallery's command fails: {line}: {done.stderr.strip()}")
    if not (place / entry.picture).exists():
        raise RuntimeError(f"the gallery's command has left no {entry.picture}: {entry.command}")


def _label(entry: Entry) -> str:
    return f"gallery-{_slug(entry)}"


def _thumbnail(entry: Entry, picture: str) -> str:
    link = f":link: {_label(entry)}\n:link-type: ref"
    return f":::{{grid-item-card}} {entry.title}\n:img-bottom: {picture}\n:img-alt: {entry.words}\n{link}\n:::\n\n"


def _section(entry: Entry, picture: str) -> str:
    page, words = entry.guide.split("|")
    script = f"```python\n{entry.script}```\n\n" if entry.script else ""
    return (
        f"({_label(entry)})=\n## {entry.title}\n\n{entry.words}\n\n![{entry.words}]({picture})\n\n"
        f"{script}```sh\n{entry.command}\n```\n\nMore: [{words}](../../{page})\n"
    )

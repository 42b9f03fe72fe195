"""Uses of a stimulus: experiments, scores, curves and claims, each with the number of its clips."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from experiments import OFFLINE
from experiments.bench import leaderboard, registry
from experiments.bench.sources.clips import Clip, OfflineExperiment
from experiments.bench.tune import FAMILIES
from experiments.claims.model_clips import GROUPS


@dataclass(frozen=True, slots=True)
class Use:
    """A set of clips.

    Attributes
    ----------
    name
        What it is called.
    command
        What shows it.
    page
        The page about that, from the folder of the stimuli's pages.
    clips
        Stimulus -> how many of its clips show it.
    """

    name: str
    command: str
    page: str
    clips: Counter[str]


def uses() -> list[Use]:
    """Return every set of clips that ships."""
    return list(_uses())


def _uses() -> Iterator[Use]:
    for name in OFFLINE:
        experiment = registry.find(name)
        assert isinstance(experiment, OfflineExperiment)
        yield Use(name, f"colias run {name}", f"../experiments/{name}.md", _counted(experiment.clips))
    board = "../commands/leaderboard.md"
    for kind in leaderboard.FILES:
        shown = leaderboard.clip_experiments(kind, ("dsnn",))
        clips = (clip for experiment in shown for clip in experiment.clips)
        yield Use(f"the scores of {kind}", "colias leaderboard", board, _counted(clips))
    for name, family in FAMILIES.items():
        clips = tuple(probe.clip for probe in family.probes)
        yield Use(f"the curve {name}", f"colias tune --curve {name}", "../commands/tune.md", _counted(clips))
    group_clips = tuple(clip for group in GROUPS.values() for clip in group)
    title = "the claims of the looming models' own papers"
    yield Use(title, "colias sweep model-claims", "../commands/sweep.md", _counted(group_clips))


def _counted(clips: Iterable[Clip]) -> Counter[str]:
    return Counter(clip.entry.name for clip in clips)

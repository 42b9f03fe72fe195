"""The public names and where they are defined: read by ``__init__.py`` at run time, by type checkers and by editors."""

from .base.errors import UsageError as UsageError
from .declare.behaviour import Behaviour as Behaviour, Wheels as Wheels
from .declare.claim import Claim as Claim
from .declare.clip import Clip as Clip, ClipFigure as ClipFigure, OfflineExperiment as OfflineExperiment
from .declare.conditions import Condition as Condition, Leg as Leg, Trajectory as Trajectory
from .declare.experiment import (
    Angular as Angular,
    Clutter as Clutter,
    Contrast as Contrast,
    Egomotion as Egomotion,
    Experiment as Experiment,
    General as General,
    Translation as Translation,
)
from .declare.outcome import Check as Check, Outcome as Outcome, decide as decide
from .declare.study import Fit as Fit, Study as Study
from .judge.tests import Score as Score
from .judge.verdict import Verdict as Verdict
from .kinds.api import fit as fit, run as run, sweep as sweep, watch as watch
from .kinds.compare import compare as compare
from .kinds.episodes import score as score
from .kinds.result import Run as Run, load as load, runs as runs
from .kinds.tables import NAMES as NAMES, OFFLINE as OFFLINE
from .show.episodes import RecordRerun as RecordRerun
from .store.provenance import __version__ as __version__

__all__ = [
    "NAMES",
    "OFFLINE",
    "Angular",
    "Behaviour",
    "Check",
    "Claim",
    "Clip",
    "ClipFigure",
    "Clutter",
    "Condition",
    "Contrast",
    "Egomotion",
    "Experiment",
    "Fit",
    "General",
    "Leg",
    "OfflineExperiment",
    "Outcome",
    "RecordRerun",
    "Run",
    "Score",
    "Study",
    "Trajectory",
    "Translation",
    "UsageError",
    "Verdict",
    "Wheels",
    "__version__",
    "compare",
    "decide",
    "fit",
    "load",
    "run",
    "runs",
    "score",
    "sweep",
    "watch",
]

"""The public names and where they are defined: read by ``__init__.py`` at run time, by type checkers and by editors."""

from .bench.api import fit as fit
from .bench.api import run as run
from .bench.api import sweep as sweep
from .bench.behave import score as score
from .bench.compare import compare as compare
from .bench.result import Run as Run
from .bench.result import load as load
from .bench.result import runs as runs
from .bench.run.errors import UsageError as UsageError
from .bench.run.provenance import __version__ as __version__
from .bench.sources.behaviour import Behaviour as Behaviour
from .bench.sources.behaviour import Wheels as Wheels
from .bench.sources.clips import Clip as Clip
from .bench.sources.clips import ClipFigure as ClipFigure
from .bench.sources.clips import OfflineExperiment as OfflineExperiment
from .bench.sources.conditions import Condition as Condition
from .bench.sources.conditions import Leg as Leg
from .bench.sources.conditions import Trajectory as Trajectory
from .bench.sources.episodes import RecordRerun as RecordRerun
from .bench.sources.experiment import Angular as Angular
from .bench.sources.experiment import Clutter as Clutter
from .bench.sources.experiment import Contrast as Contrast
from .bench.sources.experiment import Egomotion as Egomotion
from .bench.sources.experiment import Experiment as Experiment
from .bench.sources.experiment import General as General
from .bench.sources.experiment import Translation as Translation
from .bench.stats.checks import Check as Check
from .bench.stats.checks import decide as decide
from .bench.stats.claim import Claim as Claim
from .bench.stats.tests import Score as Score
from .bench.stats.verdict import Outcome as Outcome
from .bench.stats.verdict import Verdict as Verdict
from .bench.study import Fit as Fit
from .bench.study import Study as Study
from .bench.watch import watch as watch

NAMES: tuple[str, ...]
OFFLINE: tuple[str, ...]

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

"""The public names and where they are defined: read by ``__init__.py`` at run time, by type checkers and by editors."""

from .base.errors import UsageError as UsageError
from .declare.behaviour import Behaviour as Behaviour
from .declare.behaviour import Wheels as Wheels
from .declare.checks import Check as Check
from .declare.checks import decide as decide
from .declare.claim import Claim as Claim
from .declare.clip import Clip as Clip
from .declare.clip import ClipFigure as ClipFigure
from .declare.clip import OfflineExperiment as OfflineExperiment
from .declare.conditions import Condition as Condition
from .declare.conditions import Leg as Leg
from .declare.conditions import Trajectory as Trajectory
from .declare.experiment import Angular as Angular
from .declare.experiment import Clutter as Clutter
from .declare.experiment import Contrast as Contrast
from .declare.experiment import Egomotion as Egomotion
from .declare.experiment import Experiment as Experiment
from .declare.experiment import General as General
from .declare.experiment import Translation as Translation
from .declare.outcome import Outcome as Outcome
from .declare.scenario import Scenario as Scenario
from .declare.scenario import SwarmDesign as SwarmDesign
from .declare.study import Fit as Fit
from .declare.study import Study as Study
from .judge.tests import Score as Score
from .judge.verdict import Verdict as Verdict
from .kinds.api import fit as fit
from .kinds.api import run as run
from .kinds.api import sweep as sweep
from .kinds.api import watch as watch
from .kinds.compare import compare as compare
from .kinds.episodes import score as score
from .kinds.result import Run as Run
from .kinds.result import load as load
from .kinds.result import runs as runs
from .kinds.tables import NAMES as NAMES
from .kinds.tables import OFFLINE as OFFLINE
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
    "Scenario",
    "Score",
    "Study",
    "SwarmDesign",
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

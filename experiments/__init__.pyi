"""The public names with their types, for type checkers and editors; at run time ``__init__.py`` looks them up."""

from experiments.bench.clips.claims import ClipClaim as ClipClaim
from experiments.bench.clips.experiment import Clip as Clip
from experiments.bench.clips.experiment import Figure as Figure
from experiments.bench.clips.experiment import OfflineExperiment as OfflineExperiment
from experiments.bench.closed_loop.behaviour import Behaviour as Behaviour
from experiments.bench.closed_loop.behaviour import Wheels as Wheels
from experiments.bench.engine.errors import UsageError as UsageError
from experiments.bench.judging.checks import Check as Check
from experiments.bench.judging.checks import decide as decide
from experiments.bench.judging.scores import Score as Score
from experiments.bench.judging.verdict import Outcome as Outcome
from experiments.bench.judging.verdict import Verdict as Verdict
from experiments.bench.public.comparison import Comparison as Comparison
from experiments.bench.public.comparison import compare as compare
from experiments.bench.public.episodes import score as score
from experiments.bench.public.footage import Watched as Watched
from experiments.bench.public.footage import watch as watch
from experiments.bench.public.listing import runs as runs
from experiments.bench.public.result import Run as Run
from experiments.bench.public.result import load as load
from experiments.bench.public.run import run as run
from experiments.bench.robot.claims import RobotClaim as Claim
from experiments.bench.robot.designs import Angular as Angular
from experiments.bench.robot.designs import Clutter as Clutter
from experiments.bench.robot.designs import Contrast as Contrast
from experiments.bench.robot.designs import Egomotion as Egomotion
from experiments.bench.robot.designs import General as General
from experiments.bench.robot.designs import Translation as Translation
from experiments.bench.robot.experiment import Condition as Condition
from experiments.bench.robot.experiment import Experiment as Experiment
from experiments.bench.studies.study import Axis as Axis
from experiments.bench.studies.study import Level as Level
from experiments.bench.studies.study import Study as Study

__version__: str
NAMES: tuple[str, ...]
OFFLINE: tuple[str, ...]

__all__ = [
    "NAMES",
    "OFFLINE",
    "Angular",
    "Axis",
    "Behaviour",
    "Check",
    "Claim",
    "Clip",
    "ClipClaim",
    "Clutter",
    "Comparison",
    "Condition",
    "Contrast",
    "Egomotion",
    "Experiment",
    "Figure",
    "General",
    "Level",
    "OfflineExperiment",
    "Outcome",
    "Run",
    "Score",
    "Study",
    "Translation",
    "UsageError",
    "Verdict",
    "Watched",
    "Wheels",
    "__version__",
    "compare",
    "decide",
    "load",
    "run",
    "runs",
    "score",
    "watch",
]

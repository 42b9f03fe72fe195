"""A trial with the robot that was played here, for tests that look at its parts."""

from types import SimpleNamespace

from experiments.show import recording
from experiments.show.play import show, tabulate


class Played:
    """What a trial showed, what is true of its frames, and what its models responded."""

    def __init__(self, trial, *, maps=False, watch=None):
        self.trial, self.maps = trial, maps
        self.showings = show(trial, maps=maps, watch=watch)
        self.record = tabulate(trial, self.showings, 0.0)
        of = {model.label: (model, series) for showing in self.showings for model, series in showing.series()}
        self.answers = [
            SimpleNamespace(**row, series=series, channels=model.channels, thresholds=model.thresholds)
            for row in self.record.rows
            for model, series in [of[row["model"]]]
        ]
        truth = self.showings[0].truth()
        self.columns = SimpleNamespace(**{name: truth[name].to_numpy() for name in truth.columns})
        self.frames = truth.height

    def __getattr__(self, name):
        return self.record.rows[0][name]

    @property
    def media(self):
        return recording.frames(self.showings, {})

    @property
    def recording(self):
        return recording.record(self.trial, self.showings, self.record.rows)

    def equals(self, other):
        """Return whether rows and frames equal those of another trial."""
        return self.record.rows == other.record.rows and self.record.frames.equals(other.record.frames)

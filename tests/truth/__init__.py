"""Laws that hold whatever the bench looks like inside: they read a run's files and an env's infos alone."""

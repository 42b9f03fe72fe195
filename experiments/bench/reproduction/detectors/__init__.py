"""Claim C21, about looming detectors, for each detector and preset in two arenas."""

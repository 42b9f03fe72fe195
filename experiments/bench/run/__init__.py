"""Core of every kind of run: models, settings, users' files, random numbers, errors."""

"""The engine that every kind of run uses: jobs, folders, models, settings, statistics, terminal."""

"""Statistics and verdicts: tests, intervals, checks, claims, and the count of their verdicts over replicates."""

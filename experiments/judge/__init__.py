"""Claims judged on rows: tests, outcomes, verdicts, scores."""

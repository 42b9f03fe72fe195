"""The claims of models' own papers: a file for each model, under its registered name with underscores."""

"""The claims of the models' own papers, on clips."""

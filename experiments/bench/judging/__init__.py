"""The words of the paper's claims, and what their verdicts in several replicates come to."""

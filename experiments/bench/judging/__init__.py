"""The words of the paper's claims, and the counts of their verdicts in several replicates."""

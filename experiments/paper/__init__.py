"""Content: the paper's clips, behaviours, claims, studies and benchmark, and its reproduction."""

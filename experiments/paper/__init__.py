"""Content: the paper's clips, behaviours, claims, studies and boards, and its reproduction."""

"""The claims that are judged: the paper's (C), ours about behaviours (B), and those of other models' own papers.

`clips`, `robot`, `footage` and `behaviours` have their judges, each on its kind of trials; ``claims.toml`` has all
words. `models` has the claims of other models' own papers, and `readings` the readings of the paper that claims were
used to choose.
"""

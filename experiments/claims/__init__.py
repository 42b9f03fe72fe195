"""The claims that are judged: the paper's (C), and ours about behaviours (B), one file each.

A file of this folder is found by its name; adding one edits nothing else. `experiments.claims.readings` has the
readings of the paper that claims were used to choose, and `experiments.claims.of_models` the claims of other models'
own papers.
"""

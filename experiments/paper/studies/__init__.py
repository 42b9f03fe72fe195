"""Studies and fits that ship: claims over a grid of choices, or over a box of them.

A new one is a `experiments.Study` or `experiments.Fit` in a file here, and a line of `STUDIES` or `FITS`. What needs
further columns, tables or claims has a function in `plans`.
"""

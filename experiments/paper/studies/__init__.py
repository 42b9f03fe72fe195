"""The studies and fits that ship: what is varied, which claims and measures, how many replicates.

A new one is a `experiments.Study` or `experiments.Fit` in a file here, and a line of `STUDIES` or `FITS`. What needs
further columns, tables or claims has a function in `plans`.
"""

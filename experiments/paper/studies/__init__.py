"""The studies that ship: what is varied, which claims and measures, how many replicates.

A new one is a `experiments.Study` in a file here, and a line of `STUDIES`. What needs further columns, tables or claims
has a function in `plans`.
"""

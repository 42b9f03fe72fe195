"""Mechanism by which the count of spikes goes with speed and distance as it does: parts of a crossing, judges, the
figure.
"""

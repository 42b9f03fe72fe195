"""Figures over tables, videos, viewers."""

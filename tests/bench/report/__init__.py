"""Tests of figures, and of the report of a reproduction."""

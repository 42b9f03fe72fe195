"""Tests of the documentation as built: make docs."""

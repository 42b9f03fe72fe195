"""Tests of the packages as a whole: imports, start-up, metadata."""

"""Tests of dsnn."""

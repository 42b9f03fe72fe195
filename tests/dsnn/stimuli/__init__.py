"""Tests of dsnn/stimuli."""

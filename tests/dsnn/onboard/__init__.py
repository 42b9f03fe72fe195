"""Tests of dsnn/onboard."""

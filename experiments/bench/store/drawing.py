"""Renderer of a job's frames: noted with every job whose model saw pictures."""

from __future__ import annotations

from dataclasses import replace

from colias_sim import gl
from colias_sim.reference import reference_hash
from experiments.bench.store.rows import TrialRecord


def drawn_here(record: TrialRecord) -> TrialRecord:
    """Return a record that names what draws in this process, and the hash of its reference frame."""
    renderer = gl.renderer()  # empty before anything was drawn, as by a policy that senses the state
    return replace(record, renderer=renderer, pixels=reference_hash() if renderer else "")

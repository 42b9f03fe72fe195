"""The memory that a process may have. The standard library alone: the entry point asks before anything is imported."""

from __future__ import annotations

LEAST_MB = 1200
"""Address space that a process needs (`ulimit -v`). A robot trial was measured to need between 900 and 1,000 MB. With
less, the OpenGL and Arrow libraries end in a segmentation fault, or in an error that names something else."""


def limit_mb() -> float | None:
    """Return the address space that this process may have, in MB; ``None`` where it has no limit."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    soft, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if soft == resource.RLIM_INFINITY else soft / 2**20

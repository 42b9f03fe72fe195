"""A script: the command line, whose ``reproduce --quick`` has one repeat in one replicate."""

from __future__ import annotations

import dataclasses

from experiments.bench.cli import entry

if __name__ == "__main__":
    entry.begin()
    from experiments.bench.reproduction import plan

    plan.QUICK = dataclasses.replace(plan.QUICK, repeats=1, replicates=1)
    entry.run()

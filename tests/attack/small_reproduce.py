"""A script: the command line, whose ``reproduce --quick`` has one repeat at one seed."""

from __future__ import annotations

import dataclasses

from experiments.bench.cli import entry

if __name__ == "__main__":
    entry.begin()
    from experiments.bench.reproduction import plan

    plan.QUICK = dataclasses.replace(plan.QUICK, repeats=1, seeds=1, seed_repeats=1)
    entry.run()

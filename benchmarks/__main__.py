"""``make bench``: every ratio this project states, measured side by side in one run on one thread."""

import cv2
from rich.console import Console
from threadpoolctl import threadpool_limits

from benchmarks import envs, eye, loop, network, swarm

if __name__ == "__main__":  # workers started by spawn read this file too
    console = Console()
    cv2.setNumThreads(1)
    with threadpool_limits(1):
        tables = (network.table, network.rivals, loop.loop_table, eye.table, swarm.table)
        for table in (*tables, envs.single, envs.vector):
            console.print(table())

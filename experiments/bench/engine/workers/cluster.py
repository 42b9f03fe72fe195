"""The workers of a Dask scheduler."""

from __future__ import annotations

import contextlib
import logging
import re
import time
from concurrent.futures import Executor
from typing import Any


class ClusterPool:
    """The workers of a Dask scheduler. Raises ``OSError`` if none answers at ``address``, or none is left."""

    ANSWER_S = 10.0
    """Seconds that a scheduler may take to answer at first."""
    PATIENCE_S = 20.0
    """Seconds that a cluster may be without workers, which it may be replacing, before a run gives up."""

    def __init__(self, address: str) -> None:
        if not re.fullmatch(r"(tcp|tls|ws|wss|ucx)://\S+:\d+", address):
            raise OSError(
                f"--cluster {address}: expected the address of a Dask scheduler, such as tcp://127.0.0.1:8786"
            )
        try:
            from distributed import Client
        except ImportError:
            raise OSError("--cluster needs Dask: install colias-sim[cluster]") from None
        for name in list(logging.root.manager.loggerDict):
            if name.startswith(("distributed", "tornado", "asyncio")):  # a lost connection is pages of traceback there
                logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        self._address = address
        client: Any = Client  # untyped
        try:
            self._client = client(address, timeout=self.ANSWER_S, set_as_default=False)
        except Exception as error:  # of many kinds: unknown host, refused, another protocol, another version
            message = " ".join(str(error).split())
            raise OSError(f"--cluster {address}: no Dask scheduler answers there ({message})") from None
        threads = self._client.nthreads()
        if not threads:
            self._client.close()
            raise OSError(f"--cluster {address}: that scheduler has no workers")
        self.width = sum(threads.values())
        self._seen = time.monotonic()
        self.executor: Executor = self._client.get_executor(pure=False, retries=0)

    def look(self) -> None:
        """Raise ``OSError`` if the scheduler is gone, or has had no worker for `PATIENCE_S`."""
        now = time.monotonic()
        try:
            threads = self._client.nthreads() if self._client.status == "running" else None
        except Exception:  # the connection broke in mid-question, in one of many ways
            threads = None
        if threads is None:
            raise OSError(f"--cluster {self._address}: lost the scheduler")
        if threads:
            self._seen = now
        elif now - self._seen > self.PATIENCE_S:
            raise OSError(f"--cluster {self._address}: the scheduler has lost all its workers")

    def close(self) -> None:
        """Cancel what is under way and leave the cluster."""
        with contextlib.suppress(Exception):
            self.executor.shutdown(wait=False)
        with contextlib.suppress(Exception):
            self._client.close(timeout=2)

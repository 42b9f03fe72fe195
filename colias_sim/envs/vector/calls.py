"""Methods and attributes of many envs at once, as Gymnasium's vector envs have them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt
from gymnasium import error
from gymnasium.vector import VectorEnv

from colias_sim.envs.vector.host import Task
from colias_sim.envs.vector.processes import InProcess, Processes

_OWN = ("reset", "step", "close")


class CallingVectorEnv(VectorEnv[Any, Any, npt.NDArray[Any]]):
    """A vector env that calls methods of its envs, and reads and sets their attributes, wherever they are."""

    _processes: Processes | InProcess
    _tasks: list[Task]

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a vector env cannot be copied or pickled: make another with the same arguments; the same seeds and "
            "actions bring it to the same state"
        )

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Call a method of each env, or read an attribute.

        Parameters
        ----------
        name
            Name of the method or attribute.
        *args, **kwargs
            Arguments of the method. With processes they must pickle.

        Returns
        -------
        tuple
            The return value, or the attribute, of each env; a copy if it comes from another process.

        Raises
        ------
        ValueError
            For arguments and values that do not pickle, and for ``reset``, ``step`` and ``close``, which this class
            has for all envs at once. Everything stays open.
        Exception
            Whatever the method raises, of the first env whose method does. Everything stays open.
        """
        self._check_open()
        if name in _OWN:
            raise ValueError(f"Trying to call function `{name}` with `call`, use `{name}` directly instead.")
        return tuple(self._call("call", [(name, args, kwargs)] * len(self._tasks)))

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Read an attribute of each env, as `call` does; a method is called without arguments.

        Parameters
        ----------
        name
            Name of the attribute.

        Returns
        -------
        tuple
            The attribute of each env; a copy if it comes from another process.

        Raises
        ------
        ValueError, Exception
            As of `call`.
        """
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of each env.

        Parameters
        ----------
        name
            Name of the attribute.
        values
            A list or tuple with a value for each env, or one value for all.

        Raises
        ------
        ValueError
            For a list or tuple of another length, and as of `call`. Everything stays open.
        """
        self._check_open()
        per_env = list(values) if isinstance(values, list | tuple) else [values] * self.num_envs
        if len(per_env) != self.num_envs:
            raise ValueError(
                "Values must be a list or tuple with length equal to the number of environments. "
                f"Got `{len(per_env)}` values for {self.num_envs} environments."
            )
        self._call("assign", [(name, per_env[task.rows]) for task in self._tasks])

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The random number generator of each env; copies if they come from other processes."""
        return self.get_attr("np_random")

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override]
        """The seed of each env."""
        return self.get_attr("np_random_seed")

    def _call(self, method: str, arguments: Sequence[tuple[Any, ...]]) -> list[Any]:
        try:
            results = self._processes.call(method, arguments)
        except BaseException:  # a process died, or Ctrl-C, as in `_ask`
            self.close()
            raise
        for result in results:
            if isinstance(result, Exception):
                raise result
        return [given for result in results if isinstance(result, list) for given in result]

    def _check_open(self) -> None:
        if self.closed:
            raise error.ClosedEnvironmentError("this vector env is closed: make a new one")

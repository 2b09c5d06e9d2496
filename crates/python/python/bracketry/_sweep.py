"""Many runs at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Literal, Protocol, TypeVar

import numpy as np

from ._native import BracketryError

R = TypeVar("R")


class Executor(Protocol):
    """What `concurrent.futures`, Dask's client and their like have in common."""

    def submit(self, fn: Callable[..., Any], /, *args: Any) -> Any:
        """Begins a call; gives a future with `result()` and `cancel()`."""


def sweep(
    function: Callable[..., R],
    cases: Iterable[Any],
    *,
    executor: Executor | None = None,
    seed: int | None = None,
    errors: Literal["raise", "keep"] = "raise",
) -> list[R]:
    """Calls a function for every case and gives the results in the order of the cases.

    Results are the same whichever executor works, and however many workers it has: a random stream belongs to its case.

    Parameters
    ----------
    function
        Called with a case; with ``seed``, with a case and a ``numpy.random.Generator`` of its own. For workers in other
        processes it has to be defined in a module (or, with Dask, anywhere).
    cases
        The cases.
    executor
        Anything with ``submit(function, *arguments)`` whose futures have ``result()``: a
        ``concurrent.futures.ThreadPoolExecutor`` (the work is done without the interpreter's lock) or
        ``ProcessPoolExecutor``, a ``dask.distributed.Client`` … None works in this thread, one case after the other.
    seed
        Seed of the random streams.
    errors
        "keep" puts a :class:`BracketryError` in place of the result of a case that raised it.

    Returns
    -------
    list
        What the function gave, in the order of the cases.

    Raises
    ------
    BracketryError
        Of the first case that raises one, unless they are kept.
    """
    if errors not in ("raise", "keep"):
        raise BracketryError(f'errors is {errors!r}; it can be "raise" or "keep"')
    listed = list(cases)
    streams = [None] * len(listed) if seed is None else np.random.SeedSequence(seed).spawn(len(listed))
    keep = errors == "keep"
    if executor is None:
        return [_call(function, case, stream, keep) for case, stream in zip(listed, streams, strict=True)]
    futures = [executor.submit(_call, function, case, stream, keep) for case, stream in zip(listed, streams, strict=True)]
    try:
        return [future.result() for future in futures]
    except BaseException:
        for future in futures:
            future.cancel()
        raise


def _call(function: Callable[..., Any], case: Any, stream: np.random.SeedSequence | None, keep: bool) -> Any:
    try:
        if stream is None:
            return function(case)
        return function(case, np.random.default_rng(stream))
    except BracketryError as error:
        if keep:
            return error
        raise

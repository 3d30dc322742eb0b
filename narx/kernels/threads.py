"""Threads over sequences: the kernels release the global interpreter lock."""

import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from functools import lru_cache

import torch

_PREFIX = "narx-kernel"


@lru_cache(maxsize=4)
def _pool(n_threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(n_threads, thread_name_prefix=_PREFIX)


if hasattr(os, "register_at_fork"):  # a forked child has the pool, but none of its threads
    os.register_at_fork(after_in_child=_pool.cache_clear)


def in_threads(work: Callable[[int, int], None], n: int, step: int) -> None:
    """Call `work(first, last)` on parts of `range(n)`, in as many threads as torch is allowed.

    Parameters
    ----------
    work : callable
        Processes items `first` to `last`; results must not depend on how the range is split.
    n : int
        Number of items.
    step : int
        Items processed together: parts are multiples of it.

    Raises
    ------
    Exception
        The first part's that raised one, once all parts have ended.
    """
    n_threads = min(torch.get_num_threads(), -(-n // step))
    # work inside a thread of the pool must not wait for other threads of the pool
    if n_threads <= 1 or threading.current_thread().name.startswith(_PREFIX):
        if n:
            work(0, n)
        return
    parts = [_pool(n_threads).submit(work, *part) for part in _parts(n, step, n_threads)]
    wait(parts)  # none runs on after an error of another has been raised
    for part in parts:
        part.result()


def _parts(n: int, step: int, n_parts: int) -> Iterator[tuple[int, int]]:
    steps = -(-n // step)
    for i in range(n_parts):
        first, last = steps * i // n_parts * step, min(steps * (i + 1) // n_parts * step, n)
        if first < last:
            yield first, last

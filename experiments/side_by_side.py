"""Work on several items at once, with the results in order."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

import torch
from threadpoolctl import threadpool_limits

A = TypeVar("A")
T = TypeVar("T")

# each holds a trial of hours at 500 Hz
_MOST_THREADS = 2


def side_by_side(work: Callable[[A], T], items: Iterable[A]) -> Iterator[T]:
    """Call a function on items in two threads, or one where torch is allowed only one.

    The kernels, and numpy on long arrays, release the global interpreter lock. The caller's work
    on a result overlaps with that on the next item.

    Parameters
    ----------
    work : callable
        Called on each item; its exceptions are raised here.
    items : iterable
        Read as needed: at most two more than results were taken.

    Yields
    ------
    object
        Results, in the order of the items.
    """
    n_threads = min(_MOST_THREADS, torch.get_num_threads())
    # a product of two long arrays would wait for the BLAS threads of the other item
    with threadpool_limits(1, user_api="blas"), ThreadPoolExecutor(n_threads) as pool:
        pending: deque[Future[T]] = deque()
        for item in items:
            pending.append(pool.submit(work, item))
            if len(pending) > 1:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()

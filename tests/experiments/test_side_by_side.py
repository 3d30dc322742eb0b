"""Work in threads: order, exceptions, and how far ahead it reads."""

import threading
import time

import pytest
import torch
from threadpoolctl import threadpool_info, threadpool_limits

from narx.experiments.side_by_side import side_by_side

pytestmark = pytest.mark.concurrency


@pytest.fixture(params=[1, 2])
def n_threads(request, monkeypatch):
    monkeypatch.setattr(torch, "get_num_threads", lambda: request.param)
    return request.param


def test_results_come_in_order(n_threads):
    def work(item):
        time.sleep(0.02 if item % 2 == 0 else 0.0)  # later items finish first
        return 10 * item

    assert list(side_by_side(work, range(6))) == [0, 10, 20, 30, 40, 50]
    assert list(side_by_side(work, [])) == []


def test_as_many_at_once_as_torch_is_allowed(n_threads):
    running, most, lock = 0, 0, threading.Lock()

    def work(item):
        nonlocal running, most
        with lock:
            running += 1
            most = max(most, running)
        time.sleep(0.02)
        with lock:
            running -= 1

    list(side_by_side(work, range(6)))
    assert most == n_threads


def test_blas_has_one_thread_meanwhile_and_its_own_again_afterwards(n_threads):
    def blas_threads(_):
        return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}

    with threadpool_limits(3, user_api="blas"):
        assert list(side_by_side(blas_threads, range(2))) == [{1}, {1}]
        assert blas_threads(None) == {3}


def test_at_most_two_items_are_read_ahead(n_threads):
    read = []

    def items():
        for item in range(6):
            read.append(item)
            yield item

    for taken in side_by_side(lambda item: item, items()):
        assert len(read) <= taken + 2


def test_an_exception_of_the_work_is_raised(n_threads):
    def work(item):
        if item == 2:
            raise ValueError("item 2")
        return item

    results = side_by_side(work, range(6))
    assert [next(results), next(results)] == [0, 1]
    with pytest.raises(ValueError, match="item 2"):
        next(results)
